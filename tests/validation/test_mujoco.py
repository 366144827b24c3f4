"""The MuJoCo model of a scene: against Pinocchio's on random trees, and as a check of the generated functions."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import symgen
from symgen.algebra.numbers import FloatNumbers, State
from symgen.errors import NotSupportedError, ToolError
from symgen.scene.model import Scene
from symgen.system import System, derive
from symgen.validation import mujoco_model, validate
from symgen.validation.compare import draw, norm
from symgen.validation.functions import Bound
from symgen.validation.mujoco_model import build_mujoco, compare_with_mujoco
from symgen.validation.pinocchio_model import build_pinocchio
from tests.end_to_end.test_random_scenes import CONVENTIONS, EXAMPLES, scene_of

ROWS = ("mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics")
TREES = [
    (tuple(kind for kind in types if kind != "helical"), CONVENTIONS[k % 3], seed)
    for k, (types, _, _, seed) in enumerate(EXAMPLES)
]


@pytest.mark.parametrize(("types", "convention", "seed"), TREES, ids=lambda x: str(x) if isinstance(x, int) else "")
def test_random_trees_like_pinocchio(types: tuple[str, ...], convention: str, seed: int) -> None:
    """Springs, dampers, armature, every joint that both have, every convention; two engines say the same."""
    pytest.importorskip("mujoco")
    pytest.importorskip("pinocchio")
    scene = scene_of(types, convention, "double", seed)
    ours, theirs = draw(build_mujoco(scene), 4, 1), draw(build_pinocchio(scene), 4, 1)
    for name in ROWS:
        found, wanted = getattr(ours, name), getattr(theirs, name)
        assert norm(found - wanted) < 1e-11 * norm(wanted), name


def literal_functions(system: System) -> Any:
    """The definition of each row as a function of arrays of states, one per row."""

    def function(name: str, inputs: tuple[str, ...]) -> Any:
        def call(*states: Any) -> Any:
            rows = []
            for row in zip(*states, strict=True):
                given: dict[str, Any] = {key: part.tolist() for key, part in zip(inputs, row, strict=True)}
                rows.append(np.array(next(iter(system.evaluate(name, FloatNumbers(), State(**given)).values()))))
            return np.array(rows, dtype=float)

        return call

    needs = (("q",), ("q", "v"), ("q", "v", "a"), ("q", "v", "tau"))
    return SimpleNamespace(**{name: function(name, inputs) for name, inputs in zip(ROWS, needs, strict=True)})


def test_the_comparison_passes_and_can_fail() -> None:
    pytest.importorskip("mujoco")
    scene = mimic_scene()
    bound = Bound(literal_functions(derive(scene)), np.zeros(0))
    rows, skipped = compare_with_mujoco(scene, bound, 5, 1)
    assert [row.quantity for row in rows] == list(ROWS)
    assert not skipped
    assert all(row.passed for row in rows)
    heavier = replace(scene, bodies=tuple(replace(b, mass=b.mass * F(1001, 1000)) for b in scene.bodies))
    rows, _ = compare_with_mujoco(heavier, bound, 5, 1)
    assert not any(row.passed for row in rows)


def mimic_scene() -> Scene:
    """A free base with fingers that move together, and a body without mass on the way."""
    builder = symgen.SceneBuilder("hand")
    for name, mass in (("palm", 2), ("left", 1), ("right", 1), ("knuckle", 0)):
        inertia = (0.1, 0.12, 0.13, 0, 0.01, 0) if mass else (0,) * 6
        builder.body(name, mass=mass, com=(0, 0, 0.1 * mass), inertia=inertia)
    builder.joint("base", "floating", "ground", "palm", damping="0.1")
    builder.joint("a", "revolute", "palm", "left", axis=(0, 1, 0), xyz=(0.1, 0, 0), armature="0.2", damping="0.3")
    builder.joint("b", "revolute", "palm", "knuckle", axis=(1, 0, 0), xyz=(-0.1, 0, 0))
    builder.joint("c", "prismatic", "knuckle", "right", axis=(0, 0, 1), armature="0.1")
    builder.joint_spring("a", stiffness=2, rest="0.3", damping="0.1").joint_spring("a", stiffness=1, rest="-0.2")
    builder.spring(("left", "ground"), ((0, 0, "0.2"), (1, 2, 3)), stiffness=3, damping="0.2", length=1)
    scene = builder.build()
    mimic = symgen.scene.model.Mimic("a", F(-2), F(1, 4))
    joints = tuple(replace(joint, mimic=mimic) if joint.name == "c" else joint for joint in scene.joints)
    return replace(scene, joints=joints)


def test_what_mujoco_lacks_is_skipped() -> None:
    pytest.importorskip("mujoco")
    builder = symgen.SceneBuilder("screw").body("nut", mass=1, inertia=(0.1, 0.1, 0.1, 0, 0, 0))
    scene = builder.joint("thread", "helical", "ground", "nut", axis=(0, 0, 1), pitch="0.01").build()
    with pytest.raises(NotSupportedError):
        build_mujoco(scene)
    rows, skipped = compare_with_mujoco(scene, Bound(SimpleNamespace(), np.zeros(0)), 1, 1)
    assert not rows
    assert [skip.reason for skip in skipped] == ["joint 'thread' is helical, which MuJoCo does not have"]


def test_asked_for_by_name_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo is nobody's need: without it a validation runs as ever, and says what to install when it is asked for."""

    def missing(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(mujoco_model.importlib, "import_module", missing)
    scene = mimic_scene()
    with pytest.raises(ToolError, match=r"MuJoCo is not installed: pip install 'symgen\[mjcf\]'"):
        build_mujoco(scene)
    assert "mujoco" not in symgen.validation.PEERS
    with pytest.raises(ToolError, match="unknown simulator mujoko: choose from pinocchio, exudyn, mujoco"):
        validate(scene, against=("mujoko",))


def test_no_log_file_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo warns of singular mass matrices in a file where it runs; not here."""
    pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    builder = symgen.SceneBuilder("feather").body("a", mass=0).body("b", mass=1, inertia=(0.1, 0.1, 0.1, 0, 0, 0))
    builder.joint("j", "revolute", "ground", "a", axis=(0, 0, 1)).joint("k", "revolute", "a", "b", axis=(0, 0, 1))
    peer = build_mujoco(builder.build())
    assert np.linalg.matrix_rank(peer.mass_matrix(np.zeros(2))) == 1
    assert not list(tmp_path.iterdir())
