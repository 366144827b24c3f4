"""The same-state comparison: it passes what is right and fails what is spoilt, by how little."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction as F
from typing import Any

import numpy as np
import pytest

from symgen.scene.model import Parameter, Scene
from symgen.validation import validate
from symgen.validation.compare import compare_with_pinocchio, snapping_rows
from symgen.validation.functions import bind
from symgen.validation.result import Row
from tests.validation.changed import Changed, Without
from tests.validation.derived_functions import DerivedFunctions
from tests.validation.peer_functions import PeerFunctions
from tests.validation.scenes import floating_tree, single, sprung

pytest.importorskip("pinocchio")


def rows_of(scene: Scene, functions: Any, states: int = 20) -> dict[str, Row]:
    rows, _skipped = compare_with_pinocchio(scene, bind(functions, scene), states, 1)
    return {row.quantity: row for row in rows}


def bump(relative: float) -> Callable[..., Any]:
    """Spoils one entry of one state."""

    def change(result: Any, *_arguments: Any) -> Any:
        spoilt = np.array(result)
        spoilt[(-1,) + (0,) * (spoilt.ndim - 1)] += relative * np.abs(spoilt[-1]).max()
        return spoilt

    return change


def test_right_functions_pass() -> None:
    rows = rows_of(sprung(), PeerFunctions(sprung()))
    assert all(row.passed for row in rows.values())
    assert {"mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics", "kinetic_energy"} <= set(rows)


@pytest.mark.parametrize("name", ["mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics"])
def test_one_entry_of_one_state_is_seen(name: str) -> None:
    scene = sprung()
    good = PeerFunctions(scene)
    rows = rows_of(scene, Changed(good, name, bump(1e-10)))
    assert [row.quantity for row in rows.values() if not row.passed] == [name]
    assert rows[name].value == pytest.approx(1e-10, rel=0.1)
    assert rows_of(scene, Changed(good, name, bump(1e-14)))[name].passed


def test_nan_is_a_failure_that_says_where() -> None:
    scene = single("revolute")

    def spoil(result: Any, *_arguments: Any) -> Any:
        spoilt = np.array(result)
        spoilt[3] = np.nan
        return spoilt

    row = rows_of(scene, Changed(PeerFunctions(scene), "mass_matrix", spoil))["mass_matrix"]
    assert not row.passed
    assert "1 of 20 states" in row.note


def test_wrong_base_velocity_convention_is_seen() -> None:
    rows = rows_of(floating_tree("world"), PeerFunctions(floating_tree("body")))
    assert not rows["mass_matrix"].passed
    assert not rows["bias_force"].passed


def test_rotor_about_the_vertical_has_no_bias_to_divide_by() -> None:
    """A force that is zero but for rounding is measured against the terms it is summed from."""
    scene = single("revolute")
    flat = replace(scene, gravity=(F(0), F(0), F(0)), bodies=scene.bodies[:1], joints=scene.joints[:1])

    def rounding(result: Any, *_arguments: Any) -> Any:
        return np.array(result) + 1e-19

    rows = rows_of(flat, Changed(PeerFunctions(flat), "bias_force", rounding))
    assert rows["bias_force"].passed
    assert "cancels" in rows["bias_force"].note


def test_missing_functions_are_named() -> None:
    scene = single("revolute")
    functions = bind(Without(PeerFunctions(scene), "mass_matrix"), scene)
    _rows, skipped = compare_with_pinocchio(scene, functions, 5, 1)
    assert ["mass_matrix" in skip.check for skip in skipped] == [True]


class OfParameters:
    """PeerFunctions with a run-time argument p = [b1.mass]."""

    def __init__(self, scene: Scene, deaf: bool = False) -> None:
        self._scene, self._deaf = scene, deaf

    def __getattr__(self, name: str) -> Any:
        if name not in PeerFunctions.NAMES:
            raise AttributeError(name)

        def call(*arguments: Any, p: Any) -> Any:
            mass = self._scene.body("b1").mass if self._deaf else F(float(p[0]))
            bodies = tuple(replace(b, mass=mass) if b.name == "b1" else b for b in self._scene.bodies)
            return getattr(PeerFunctions(replace(self._scene, bodies=bodies)), name)(*arguments)

        return call


@pytest.mark.parametrize("deaf", [False, True])
def test_parameters_are_varied(deaf: bool) -> None:
    scene = single("revolute")
    scene = replace(scene, parameters=(Parameter("b1.mass", (scene.body("b1").mass,), "kg", 0),))
    result = validate(scene, against=("pinocchio",), states=10, functions=OfParameters(scene, deaf))
    rows = {row.quantity: row for row in result.rows}
    assert rows["mass_matrix"].passed
    assert rows["mass_matrix, other parameters"].passed is not deaf


def test_snapping_is_reported() -> None:
    scene = single("revolute")
    turned = np.array([[float(x) for x in row] for row in scene.joints[0].origin.rotation])
    assert snapping_rows(scene, 1) == []
    row = snapping_rows(replace(scene, raw={"j2": turned.tolist()}), 1)[0]
    assert row.value > 1e-3
    assert "1 mounting rotation" in row.note


def test_inertias_that_no_body_has_are_compared_too() -> None:
    """URDF files hold them; Pinocchio's constructor refuses them."""
    scene = single("revolute")
    bodies = (replace(scene.bodies[0], inertia=(F(1), F(-1, 2), F(1, 5), F(0), F(0), F(0))), *scene.bodies[1:])
    rows = rows_of(replace(scene, bodies=bodies), DerivedFunctions(replace(scene, bodies=bodies)), 3)
    assert all(row.passed for row in rows.values())
    assert not rows_of(replace(scene, bodies=bodies), PeerFunctions(scene), 3)["mass_matrix"].passed
