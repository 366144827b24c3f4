"""Identities and finite differences: true for the derived functions, false for spoilt ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction as F
from functools import cache
from typing import Any

import numpy as np
import pytest

from symgen.scene.model import JointSpring, Scene
from symgen.validation.differences import check_differences, derivative
from symgen.validation.functions import bind
from symgen.validation.mechanism import build_mechanism
from symgen.validation.result import Row, Skip
from tests.validation.changed import Changed, Without
from tests.validation.derived_functions import DerivedFunctions
from tests.validation.scenes import single


@cache
def scene() -> Scene:
    """A spherical joint and a geared, sprung and damped revolute."""
    plain = single("spherical")
    joints = (plain.joints[0], replace(plain.joints[1], damping=F(1, 5), armature=F(1, 10)))
    return replace(plain, joints=joints, forces=(JointSpring("j2", F(3), F(1, 10), F(1, 2)),))


@cache
def functions() -> DerivedFunctions:
    return DerivedFunctions(scene())


def check(spoilt: Any) -> tuple[dict[str, Row], list[Skip]]:
    rows, skipped = check_differences(build_mechanism(scene()), bind(spoilt, scene()), 7)
    return {row.quantity: row for row in rows}, skipped


def test_right_functions_pass() -> None:
    rows, skipped = check(functions())
    assert not skipped
    assert [row for row in rows.values() if not row.passed] == []
    assert len(rows) == 15


def at(index: tuple[int, ...], amount: float) -> Callable[..., Any]:
    def change(result: Any, *_arguments: Any) -> Any:
        spoilt = np.array(result, dtype=float)
        spoilt[index] += amount
        return spoilt

    return change


SPOILT: tuple[tuple[str, Callable[..., Any], str], ...] = (
    ("integrate", lambda q, q0, v, dt: q0 + (q - q0) * (1 + 1e-7), "d/dt integrate(q, v, t) = G(q) v"),
    ("integrate", lambda q, *_: q * (1 + 1e-9), "| |quaternion| − 1 | after 0.7 s"),
    ("velocity_transformation", at((4, 1), 1e-6), "R v = dx/dt along the motion"),
    ("velocity_transformation", lambda R, *_: R * [1, 1, 1, 0], "degrees of freedom − rank R"),
    ("constraints", at((0,), 1e-10), "Ψ(x) = 0"),
    ("constraint_jacobian", at((0, 0), 1e-9), "Ψ_q R = 0"),
    ("constraint_jacobian", lambda J, *_: J[1:], "nullity Ψ_q − degrees of freedom"),
    ("velocity_transformation_rate", at((5, 2), 1e-6), "Ṙ = dR/dt along the motion"),
    ("natural_bias_acceleration", at((2,), 1e-9), "natural_bias_acceleration = Ṙ v"),
    ("natural_mass_matrix", at((1, 1), 1e-9), "mass_matrix = RᵀMR + armature"),
    ("mass_matrix", at((3, 3), -0.1), "mass_matrix = RᵀMR + armature"),
    ("coriolis_matrix", lambda C, *_: C.T, "bias_force = C v + gravity + passive"),
    ("coriolis_matrix", at((0, 1), 1e-6), "Ṁ − 2C is skew"),
    ("bias_force", at((1,), 1e-9), "bias_force = C v + gravity + passive"),
    ("inverse_dynamics", at((1,), 1e-9), "inverse_dynamics = M a + bias_force"),
    ("gravity_force", at((0,), 1e-6), "gravity + springs = ∂V"),
    ("potential_energy", lambda V, *_: V * (1 + 1e-6), "gravity + springs = ∂V"),
    ("forward_dynamics", at((2,), 1e-5), "d(T + V)/dt = power of loads − dissipation"),
    ("passive_force", lambda f, q, v: f * 0.999, "d(T + V)/dt = power of loads − dissipation"),
)


@pytest.mark.parametrize(("name", "change", "seen"), SPOILT, ids=[f"{row[0]}-{row[2]}" for row in SPOILT])
def test_spoilt_functions_fail(name: str, change: Callable[..., Any], seen: str) -> None:
    rows, _skipped = check(Changed(functions(), name, change))
    assert not rows[seen].passed


def test_missing_functions_are_named() -> None:
    _rows, skipped = check(Without(functions(), "coriolis_matrix"))
    assert [skip.check for skip in skipped] == ["Ṁ − 2C", "bias_force"]
    assert "coriolis_matrix" in skipped[0].reason


def test_derivative_reaches_its_stated_accuracy() -> None:
    found = derivative(lambda t: np.array([np.sin(3 * t + 1), np.exp(t), 5.0]))
    np.testing.assert_allclose(found, [3 * np.cos(1), 1.0, 0.0], atol=1e-12)
