"""A mass matrix that is singular to working precision has no inverse: NaN, in every plan, and nowhere else."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symgen.accuracy.variants import Compiled, Variant, compile_variant, plans_of
from symgen.algebra.numbers import FloatNumbers
from symgen.errors import SceneError
from symgen.plans import singular
from symgen.plans.build import build
from symgen.plans.families import Family
from symgen.plans.singular import margins
from symgen.program.evaluate import evaluate_all
from symgen.scene.builder import SceneBuilder
from symgen.scene.canonical import with_hash
from symgen.scene.load import load
from symgen.scene.model import Output, Scene
from symgen.system import System, derive
from symgen.validation.hard.scenes import X, Y, Z, chain, elbow, wrist


def made(scene: Scene, row: str = "forward_dynamics", precision: str = "double") -> System:
    options = replace(scene.options, precision=precision)
    return derive(with_hash(replace(scene, outputs=(Output(row, (row,)),), options=options)))


def every_plan(scene: Scene, row: str, precision: str, folder: Path) -> list[Compiled]:
    system = made(scene, row, precision)
    output = system.output(row)
    return [
        compiled
        for number, family in enumerate(plans_of(system, output)[::3])
        for compiled in compile_variant(
            system, (output,), Variant(precision, family=family), folder / f"{precision}{number}"
        )
    ]


def inputs(q: np.ndarray) -> dict[str, np.ndarray]:
    return {"q": q, "v": 0 * q, "tau": np.eye(q.shape[1])[[0] * len(q)]}


@pytest.mark.parametrize("row", ["forward_dynamics", "mass_matrix_inverse", "forward_dynamics_derivatives"])
@pytest.mark.parametrize("precision", ["double", "float"])
def test_rounding_errors_are_no_pivots(row: str, precision: str, tmp_path: Path) -> None:
    """Lengths that no double holds: the last pivot comes out as a rounding error."""
    singular, bent = np.array([[0.2, 0.0], [1.1, np.pi], [0.3, 1e-9]]), np.array([[0.2, 0.5], [1.1, -2.0]])
    for compiled in every_plan(elbow("0.3", "0.7"), row, precision, tmp_path):
        assert np.isnan(compiled.call(inputs(singular))).all(), compiled.plan
        assert np.isfinite(compiled.call(inputs(bent))).all(), compiled.plan


def test_gimbal_lock_ends_in_nan_and_what_is_near_it_does_not(tmp_path: Path) -> None:
    angles = np.array([0.0, np.pi, 1e-6, 1e-4, 1.0])
    q = np.stack([np.full(5, 0.3), angles, np.full(5, 0.4)], axis=1)
    for compiled in every_plan(wrist(), "forward_dynamics", "double", tmp_path):
        found = np.isfinite(compiled.call(inputs(q))).all(axis=1)
        assert found.tolist() == [False, False, True, True, True], compiled.plan


@pytest.mark.parametrize("length", [F(1, 10**6), F(10**6)])
def test_the_margin_follows_lengths(length: F, tmp_path: Path) -> None:
    for compiled in every_plan(elbow(length, 2 * length), "forward_dynamics", "double", tmp_path):
        found = compiled.call(inputs(np.array([[0.2, 1e-3], [0.2, 0.0]])))
        assert np.isfinite(found[0]).all() and np.isnan(found[1]).all()


def test_the_margin_follows_displacements_and_parameters(tmp_path: Path) -> None:
    """A point on a massless arm is regular at every distance but zero, and with any mass."""
    built = SceneBuilder("arm").body("arm").body("bob", 1).parameters("bob.mass")
    built.joint("shoulder", "revolute", "ground", "arm", axis=Y)
    system = made(built.joint("reach", "prismatic", "arm", "bob", axis=X).build())
    assert margins(system.lowered).needed == (True, False)
    (compiled,) = compile_variant(system, system.scene.outputs, Variant(), tmp_path / "f")
    q = np.array([[0.2, reach] for reach in (1e-9, 1.0, 1e9, 0.0)])
    for mass in (1e-12, 1.0, 1e12):
        found = np.isfinite(compiled.call({**inputs(q), "p": np.full((4, 1), mass)})).all(axis=1)
        assert found.tolist() == [True, True, True, False], mass


def test_two_joints_that_do_the_same_are_refused() -> None:
    built = SceneBuilder("twice").body("upper").body("lower", 1, (1, 0, 0))
    built.joint("a", "revolute", "ground", "upper", axis=Y).joint("b", "revolute", "upper", "lower", axis=Y)
    with pytest.raises(SceneError, match="singular"):
        made(built.build()).program("forward_dynamics")


def test_a_pivot_with_inertia_of_its_own_needs_no_margin() -> None:
    for name in ("panda", "ur5", "fig1", "fig2", "spherical_pendulum", "double_pendulum", "gripper", "payload"):
        assert not any(margins(made(load(f"examples/{name}.scene.yaml")).lowered).needed), name
    assert not any(margins(made(chain(200)).lowered).needed)
    assert not any(margins(made(elbow(1, 1, F(1, 10))).lowered).needed)
    assert sum(margins(made(wrist()).lowered).needed) == 2
    assert sum(margins(made(chain(50), precision="float").lowered).needed) > 10


def test_a_margin_costs_one_subtraction() -> None:
    system = made(elbow(1, 1))
    program = system.program("forward_dynamics")
    (guard,) = program.guards
    step = program.instructions[guard]
    margin = program.instructions[step.args[1]].value
    assert step.op == "sub" and isinstance(margin, F) and 1e-16 < margin < 1e-12
    assert sum(guard in other.args for other in program.instructions) == 0


class Arrays(FloatNumbers):
    """NumPy arrays, as wide as compiled code is."""

    def __init__(self, kind: type) -> None:
        self.kind = kind

    def const(self, value: F | int) -> Any:
        return self.kind(float(value))

    def cos(self, x: Any) -> Any:
        return np.cos(x)

    def sin(self, x: Any) -> Any:
        return np.sin(x)


def answered(scene: Scene, q: np.ndarray, precision: str) -> int:
    """States at which some plan gives an answer."""
    system, kind = made(scene, precision=precision), {"double": np.float64, "float": np.float32}[precision]
    columns = {name: list(values.T.astype(kind)) for name, values in inputs(q).items()}
    found = np.zeros(len(q), dtype=bool)
    for family in (Family(), Family(articulated=True), Family(merged=True), Family(literal=True, regrouped=False)):
        program = build(system.lowered, system.natural, system.output("forward_dynamics"), family)
        with np.errstate(all="ignore"):
            values = evaluate_all(program, Arrays(kind), columns)
        found |= np.all([np.broadcast_to(values[guard], (len(q),)) > 0 for guard in program.guards], axis=0)
    return int(found.sum())


def singular_scenes(seed: int) -> Iterator[tuple[Scene, np.ndarray]]:
    """Mechanisms of random size with massless links in line, and states at which they are singular."""
    rng = random.Random(seed)
    a, b, c = (F(rng.randrange(1, 1000), rng.choice((7, 10, 333))) for _ in range(3))
    any_angle = np.array([[rng.uniform(-3, 3), 0.0, rng.uniform(-3, 3)] for _ in range(50)])
    yield elbow(a, b), any_angle[:, :2]
    for axes, moment in (((Y, Y, Y), (0, 0, -c)), ((Z, Y, Z), (c, 0, a))):
        built = SceneBuilder("three").body("a").body("b").body("c", 1, moment, (F(1, 10), F(1, 9), F(1, 8), 0, 0, 0))
        place = (0, 0, 0) if axes[0] == Z else (0, 0, -a)
        built.joint("i", "revolute", "ground", "a", axis=axes[0]).joint(
            "j", "revolute", "a", "b", axis=axes[1], xyz=place
        )
        place = (0, 0, 0) if axes[0] == Z else (0, 0, -b)
        yield built.joint("k", "revolute", "b", "c", axis=axes[2], xyz=place).build(), any_angle


@pytest.mark.parametrize("precision", ["double", "float"])
def test_no_singular_state_has_an_answer_whatever_the_lengths(precision: str) -> None:
    for seed in range(5):
        for scene, q in singular_scenes(seed):
            assert answered(scene, q, precision) == 0, (seed, scene.name)


def test_without_a_margin_they_have_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(singular, "SAFETY", 0.0)
    assert sum(answered(scene, q, "double") > 0 for seed in range(5) for scene, q in singular_scenes(seed)) > 8
