"""The variational step and the momenta that it is made of: what it keeps, where other steps lose it."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symgen.generate import generate
from symgen.scene.builder import SceneBuilder
from symgen.scene.canonical import with_hash
from symgen.scene.model import Scene
from symgen.simulate import Model
from symgen.validation.work_precision.energies import long_run
from tests.simulate.steps import Array, asked, ball, state, stepping


def weightless(scene: Scene) -> Scene:
    return with_hash(replace(scene, gravity=(Fraction(0),) * 3))


TUMBLING = np.array([0.1, 0.2, 0.3, 1.0, -0.5, 0.7, 0.6, -0.8, 1.2])


def test_energy_stays_where_quaternions_turn() -> None:
    """Two bodies on a ball joint tumble weightlessly: the implicit midpoint rule in (q, v) drifts, this does not."""
    model = Model(weightless(ball()), ("variational", "implicit_midpoint"))
    start = model.start(None, TUMBLING)
    kept, lost = (long_run(model, name, start, 0.02, 200_000) for name in ("variational", "implicit_midpoint"))
    assert kept.bounded and kept.last < 2e-4, kept
    assert not lost.bounded and lost.last > 20 * kept.last


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    "base_velocity", ["world", pytest.param("body", marks=SLOW), pytest.param("mixed", marks=SLOW)]
)
def test_momentum_is_kept_to_rounding(base_velocity: str, tmp_path: Path) -> None:
    """The discrete action does not change when everything is moved or turned, so linear and angular momentum stay."""
    rows = ("step:variational", "momentum", "center_of_mass")
    f = generate(weightless(asked(ball(base_velocity), *rows, targets=("c",))), tmp_path / "code").load()

    def momenta(q: Array, v: Array) -> Array:
        """Linear, and angular about the origin (the centre of mass itself moves by steps)."""
        found = f.momentum(q, v)
        return np.concatenate([found[:3], found[3:] + np.cross(f.center_of_mass(q), found[:3])])

    q, v = np.array([0.0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1]), TUMBLING
    first = momenta(q, v)
    for _ in range(400):
        q, v = f.step_variational(q, v, np.zeros(9), 0.03)
    assert np.abs(momenta(q, v) - first).max() < 1e-12
    assert abs(np.linalg.norm(q[3:7]) - 1.0) < 1e-14


def test_it_is_symmetric_in_time_and_takes_forces(tmp_path: Path) -> None:
    artifact = stepping(ball(), tmp_path / "code", "variational", "lie", targets=("c",))
    f, (q, v, tau) = artifact.load(), state(artifact.manifest)
    there = f.step_variational(q, v, tau, 0.02)
    back = f.step_variational(*there, tau, -0.02)
    assert np.abs(back[0] - q).max() < 1e-13 and np.abs(back[1] - v).max() < 1e-12
    still = f.step_variational(q, v, tau, 0.0)
    assert np.abs(still[0] - q).max() < 1e-15 and np.abs(still[1] - v).max() < 1e-14
    pushed, other = f.step_variational(q, v, 50 * tau, 1e-3)[1], f.step_lie(q, v, 50 * tau, 1e-3)[1]
    assert np.abs(pushed - other).max() < 1e-4 < np.abs(pushed - f.step_variational(q, v, tau, 1e-3)[1]).max()


def test_it_takes_stiff_springs_in_long_steps(tmp_path: Path) -> None:
    scene = SceneBuilder("stiff", gravity=(0, 0, 0)).body("mass", mass=1)
    scene.joint("slide", "prismatic", "ground", "mass", axis=(1, 0, 0), damping=1000)
    scene.joint_spring("slide", stiffness=1e6)
    f = stepping(scene.build(), tmp_path / "code", "variational", targets=("c",)).load()
    q, v = np.array([0.01]), np.zeros(1)
    for _ in range(200):
        q, v = f.step_variational(q, v, np.array([1e4]), 0.005)
    assert abs(q[0] - 0.01) < 1e-6


@pytest.mark.parametrize(
    "scene",
    [ball("world"), "gripper", *(pytest.param(x, marks=SLOW) for x in (ball("body"), ball("mixed"), "furuta"))],
)
def test_momenta_are_what_they_say(scene: Scene | str, tmp_path: Path) -> None:
    """P = M v, and its rate without tau is Cᵀ v − gravity − passive."""
    rows = ("joint_momentum", "mass_matrix", "coriolis_matrix", "gravity_force", "passive_force")
    artifact = generate(asked(scene, *rows, targets=("c",)), tmp_path / "code")
    f, (q, v, _) = artifact.load(), state(artifact.manifest)
    momenta, rates = f.joint_momentum(q, v)
    passive = f.passive_force(q, v) if "passive_force" in [row["name"] for row in artifact.manifest["functions"]] else 0
    right = f.coriolis_matrix(q, v).T @ v - f.gravity_force(q) - passive
    assert np.abs(momenta - f.mass_matrix(q) @ v).max() < 1e-13 * (1 + np.abs(momenta).max())
    assert np.abs(rates - right).max() < 1e-12 * (1 + np.abs(right).max())


def test_it_is_symplectic(tmp_path: Path) -> None:
    """The derivative A of the map (q, P) → (q, P) of a step has Aᵀ J A = J; the midpoint rule in (q, v) has not."""
    rows = ("step:variational", "step:implicit_midpoint", "mass_matrix")
    f = generate(asked("double_pendulum", *rows, targets=("c",)), tmp_path / "code").load()

    def defect(step: Any) -> float:
        def move(x: Array) -> Array:
            q, v = step(x[:2], np.linalg.solve(f.mass_matrix(x[:2]), x[2:]), np.zeros(2), 0.02)
            return np.concatenate([q, f.mass_matrix(q) @ v])

        start = np.concatenate([(q := np.array([0.9, 0.4])), f.mass_matrix(q) @ np.array([1.0, -2.0])])
        by = 1e-3 * np.eye(4)
        columns = [8.0 * (move(start + u) - move(start - u)) - (move(start + 2 * u) - move(start - 2 * u)) for u in by]
        derivative = np.array(columns).T / 12e-3
        form = np.kron(np.array([[0.0, 1.0], [-1.0, 0.0]]), np.eye(2))
        return float(np.abs(derivative.T @ form @ derivative - form).max())

    assert defect(f.step_variational) < 1e-11
    assert defect(f.step_implicit_midpoint) > 1e-5
