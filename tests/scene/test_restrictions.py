"""What a scene leaves out, and the scene without each restriction."""

from __future__ import annotations

from pathlib import Path

from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request
from symgen.scene.restrictions import restrictions, with_inertial_parameters
from tests.scene.test_overlay import scene_over


def test_each_restriction_has_its_scene(tmp_path: Path) -> None:
    scene = scene_over(tmp_path, "remove: [pad]\nlock: {shoulder: 0.5}\n")
    locked, removed, constant = restrictions(request(scene, parse_outputs("gravity_force"), precision="float"))
    assert [row.label for row in (locked, removed, constant)] == [
        "lock shoulder = 0.5", "remove pad", "30 inertial parameters constant",
    ]  # fmt: skip
    assert isinstance(locked.scene, Scene) and locked.scene.joint("shoulder").type == "revolute"
    assert isinstance(removed.scene, Scene) and removed.scene.bodies[-1].name == "pad"
    assert removed.scene.joint("shoulder").type == "fixed"
    for row in (locked, removed, constant):
        assert row.scene and row.scene.outputs[0].name == "gravity_force" and row.scene.options.precision == "float"


def test_where_there_is_no_scene_without_it(tmp_path: Path) -> None:
    """The gripper's second finger has nothing to mimic when its master is gone, so it must be locked."""
    locked, removed, _ = restrictions(scene_over(tmp_path, "remove: [left]\nlock: {grip: 0.02}\n"))
    assert (
        locked.scene is None and "no scene without it: mine.scene.yaml:3: remove: joint 'follow' mimics" in locked.why
    )
    assert removed.scene is not None


def test_parameters_that_are_there_already_stay_first(tmp_path: Path) -> None:
    scene = scene_over(tmp_path, "parameters: [gravity, lower.mass]\n")
    names = [parameter.name for parameter in with_inertial_parameters(scene)]
    assert names[:3] == ["gravity", "lower.mass", "upper.mass"] and len(set(names)) == len(names)
    assert "pad.mass" not in names and "base.mass" not in names
    starts = [parameter.start for parameter in with_inertial_parameters(scene)]
    assert starts[:4] == [0, 3, 4, 5]


def test_a_model_alone_is_restricted_by_its_constants_only(tmp_path: Path) -> None:
    scene_over(tmp_path, "")
    (row,) = restrictions(load(tmp_path / "arm.urdf"))
    assert row.label == "40 inertial parameters constant"
