"""Random trees through load, generate, compile, and against Pinocchio; both parsers are on the way."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

import symgen
from symgen.scene.outputs import AVAILABLE
from symgen.scene.request import request
from symgen.validation.pinocchio_model import build_pinocchio
from tests.robustness.agreement import CORE, awkward_states, check, compiled
from tests.robustness.random_trees import URDF_TYPES, Made, trees

pytest.importorskip("pinocchio")

LATER = ("center_of_mass", "momentum", "momentum_matrix", "mass_matrix_inverse", "joint_wrenches", "regressor",
         "inverse_dynamics_derivatives", "forward_dynamics_derivatives", "kinetic_energy", "gravity_force",
         "frame_pose:b0", "frame_jacobian:b0", "frame_velocity:b0", "frame_bias_acceleration:b0")  # fmt: skip
"""Further rows, of which every example has a few."""

seeds = st.integers(0, 2**32 - 1)
EXPLORE = "SYMGEN_EXPLORE" in os.environ
"""Other examples at every run, to look for what the fixed ones do not show."""


def examples(count: int) -> settings:
    health = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example]
    return settings(
        max_examples=count, deadline=None, derandomize=not EXPLORE, database=None, suppress_health_check=health
    )


def load(text: str, name: str) -> symgen.Scene:
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_text(text, encoding="utf-8")
        return symgen.load(path)


def compare_scene(made: Made, rows: tuple[str, ...], seed: int) -> None:
    rows = tuple(row for row in rows if row.partition(":")[0] in AVAILABLE)
    text = made.yaml([*CORE, *rows])
    note(text)
    scene = load(text, "random.scene.yaml")
    with TemporaryDirectory() as folder:
        check(scene, Path(folder), seed, rows)


def compare_readers(made: Made, seed: int) -> None:
    """The same mechanism as a scene and as URDF: both as Pinocchio has it, and each other's numbers."""
    model, text = made.urdf(), made.yaml(CORE)
    note(model)
    scene = load(text, "random.scene.yaml")
    read = load(model, "random.urdf")
    with TemporaryDirectory() as folder:
        ours = check(scene, Path(folder) / "scene", seed)
        read = request(read, ours.scene.outputs, targets=("c",))
        theirs = compiled(replace(read, name="other"), Path(folder) / "model")
        q, v = order(scene, read)
        for s in awkward_states(ours.peer.mechanism, seed):
            M = ours.functions.mass_matrix(s.q)[np.ix_(v, v)]
            np.testing.assert_allclose(theirs.mass_matrix(s.q[q]), M, rtol=0, atol=1e-13 * np.max(np.abs(M)))
            h, terms = ours.functions.bias_force(s.q, s.v)[v], ours.terms(M, s)
            np.testing.assert_allclose(theirs.bias_force(s.q[q], s.v[v]), h, rtol=0, atol=1e-12 * terms)


def order(scene: symgen.Scene, other: symgen.Scene) -> tuple[list[int], list[int]]:
    """Where the coordinates of ``other`` are among those of ``scene``, by the names of the joints.

    A floating joint of a URDF file leads from ground here, so that bodies may come in another order.
    """
    places = {body.joint.name: body for body in symgen.derive(scene).tree.bodies}
    q: list[int] = []
    v: list[int] = []
    for body in symgen.derive(other).tree.bodies:
        here = places[body.joint.name]
        assert (body.joint.type, body.coupling) == (here.joint.type, here.coupling)
        if body.coupling is None:
            q += range(here.q, here.q + here.nq)
            v += range(here.v, here.v + here.nv)
    return q, v


@examples(5)
@given(trees(1, 7), st.tuples(st.sampled_from(LATER)), seeds)
def test_small_trees(made: Made, rows: tuple[str, ...], seed: int) -> None:
    compare_scene(made, rows, seed)


@examples(3)
@given(trees(2, 6, URDF_TYPES), seeds)
def test_both_readers(made: Made, seed: int) -> None:
    compare_readers(made, seed)


@pytest.mark.slow
@examples(40)
@given(trees(1, 8), st.lists(st.sampled_from(LATER), unique=True, max_size=3).map(tuple), seeds)
def test_more_small_trees(made: Made, rows: tuple[str, ...], seed: int) -> None:
    compare_scene(made, rows, seed)


@pytest.mark.slow
@examples(10)
@given(trees(20, 40), seeds)
def test_large_trees(made: Made, seed: int) -> None:
    compare_scene(made, (), seed)


@pytest.mark.slow
@examples(20)
@given(trees(1, 15, URDF_TYPES), seeds)
def test_more_of_both_readers(made: Made, seed: int) -> None:
    compare_readers(made, seed)


CHAIN = """\
name: chain
bodies:
  - {name: b0, mass: 1, com: [0, 0, 0.5], inertia: [0.5, 0.6, 0.7, 0, 0, 0]}
  - {name: b1, mass: MASS, com: [0, 0.3, 0], inertia: [0.5, 0.6, 0.7, 0, 0, 0]}
joints:
  - {name: j0, type: spherical, parent: ground, child: b0}
  - {name: j1, type: revolute, parent: b0, child: b1, axis: [1, 0, 0], origin: {xyz: [0, 0, 1]}}
outputs: [mass_matrix, bias_force, inverse_dynamics, forward_dynamics, gravity_force]
options: {targets: [c]}
"""


def test_the_comparison_can_fail(tmp_path: Path) -> None:
    """A mass that is off by a part in 1e10 is seen, row by row."""
    right, wrong = (load(CHAIN.replace("MASS", mass), "chain.scene.yaml") for mass in ("1", "1.0000000001"))
    good = check(right, tmp_path, 1, ("gravity_force",))
    bad = replace(good, peer=build_pinocchio(wrong))
    states, rng = awkward_states(good.peer.mechanism, 1), np.random.default_rng(1)
    with pytest.raises(AssertionError, match="mass_matrix: off by"):
        bad.core(states[1], rng)
    with pytest.raises(AssertionError, match="gravity_force"):
        bad.row("gravity_force", states[1:2])


def test_the_comparison_of_accelerations_can_fail(tmp_path: Path) -> None:
    good = check(load(CHAIN.replace("MASS", "1"), "chain.scene.yaml"), tmp_path, 1)
    exact = good.functions

    class Shifted:
        """The same functions, with accelerations that are off by a part in 1e9."""

        def __getattr__(self, name: str) -> Any:
            function = getattr(exact, name)
            return (lambda *q: function(*q) * (1 + 1e-9)) if name == "forward_dynamics" else function

        def __contains__(self, name: str) -> bool:
            return name in exact

    with pytest.raises(AssertionError, match="forward_dynamics: off by"):
        replace(good, functions=Shifted()).core(awkward_states(good.peer.mechanism, 1)[1], np.random.default_rng(1))
