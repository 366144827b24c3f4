"""The shipped scenes: they load, they are what their names say, and the robots are those of their makers."""

from __future__ import annotations

import json
from fractions import Fraction
from importlib import resources
from pathlib import Path

import jsonschema
import pytest
import yaml

from symgen.scene.exact import cross
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.load import load
from symgen.scene.model import Scene
from tests.scene.robots import PANDA, UR5, robot

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SIZES = {
    "fig1": (4, 4), "fig2": (11, 10), "pendulum": (1, 1), "double_pendulum": (2, 2), "cart_pole": (2, 2),
    "furuta": (2, 2), "spherical_pendulum": (4, 3), "spinning_top": (4, 3), "free_body": (7, 6),
    "universal_shaft": (3, 3),
    "screw_drive": (1, 1), "slope_body": (3, 3), "four_bar": (4, 4), "ur5": (6, 6), "panda": (7, 7),
    "gripper": (2, 2), "payload": (3, 3),
}  # fmt: skip
"""Scene: nq, nv (of the joints as listed, loops not closed)."""


def example(name: str) -> Scene:
    return load(EXAMPLES / f"{name}.scene.yaml")


def test_every_example_is_listed() -> None:
    assert {path.name.removesuffix(".scene.yaml") for path in EXAMPLES.glob("*.scene.yaml")} == set(SIZES)


@pytest.mark.parametrize("name", SIZES)
def test_an_example_loads(name: str) -> None:
    scene = example(name)
    assert scene.name == name
    kinds = [JOINT_TYPES[joint.type] for joint in scene.joints if joint.mimic is None]
    assert (sum(k.nq for k in kinds), sum(k.nv for k in kinds)) == SIZES[name]
    assert not [note for note in scene.notes if not note.startswith(("rotations snapped", "not modelled"))]
    assert scene.outputs or name == "four_bar"


@pytest.mark.parametrize("name", SIZES)
def test_the_schema_holds_for_any_validator(name: str) -> None:
    """Editors validate with plain YAML numbers; they must agree with the loader."""
    text = resources.files("symgen.scene").joinpath("schemas/scene.schema.json").read_text(encoding="utf-8")
    validator = jsonschema.Draft202012Validator(json.loads(text))
    validator.check_schema(json.loads(text))
    data = yaml.safe_load((EXAMPLES / f"{name}.scene.yaml").read_text(encoding="utf-8"))
    validator.validate(data)
    with pytest.raises(jsonschema.ValidationError):
        validator.validate({**data, "gravitation": 9.81})


def test_the_papers_first_system() -> None:
    scene = example("fig1")
    assert [(j.name, j.type) for j in scene.joints] == [
        ("j1", "revolute"), ("j2", "revolute"), ("j3", "prismatic"), ("j5", "revolute"),
    ]  # fmt: skip
    assert [j.parent for j in scene.joints] == ["ground", "body1", "body2", "body3"]
    assert len(scene.body("body4").basic_points) == len(scene.body("body4").unit_vectors) == 1


def test_the_papers_second_system() -> None:
    scene = example("fig2")
    assert [(j.name, j.type, j.parent, j.child) for j in scene.joints] == [
        ("j1", "floating", "ground", "body1"), ("j2", "revolute", "body1", "body2"),
        ("j3", "revolute", "body2", "body3"), ("j4", "prismatic", "body3", "body4"),
        ("j7", "revolute", "body1", "body5"),
    ]  # fmt: skip
    assert scene.body("body1").com == (0, 0, 0)


@pytest.mark.parametrize("name", ["fig1", "fig2"])
def test_the_papers_systems_are_generic(name: str) -> None:
    """No axis along a coordinate, no two parallel, no rotation with a zero."""
    scene = example(name)
    axes = [joint.axis for joint in scene.joints if joint.axis is not None]
    assert all(0 not in axis for axis in axes)
    assert all(any(cross(a, b)) for i, a in enumerate(axes) for b in axes[:i])
    for joint in scene.joints:
        assert joint.type == "floating" or 0 not in [x for row in joint.origin.rotation for x in row]


def same_mechanism(scene: Scene, model: Scene, tolerance: Fraction) -> None:
    """Every body and joint of ``scene`` is in ``model`` with the same numbers."""
    for body in scene.bodies:
        other = model.body(body.name)
        assert (body.mass, body.com) == (other.mass, other.com)
        assert all(abs(a - b) <= tolerance for a, b in zip(body.inertia, other.inertia, strict=True))
    for joint in scene.joints:
        if joint.name in [j.name for j in model.joints]:
            other_joint = model.joint(joint.name)
            assert (joint.type, joint.child, joint.axis) == (other_joint.type, other_joint.child, other_joint.axis)
            assert joint.damping == other_joint.damping
            if joint.name != "panda_hand_joint":  # the published file goes by way of an empty link
                assert joint.origin == other_joint.origin
            assert joint.parent in (other_joint.parent, "ground", "panda_link7")


def test_the_ur5_is_the_published_one() -> None:
    model = load(robot(UR5))
    scene = example("ur5")
    same_mechanism(scene, model, Fraction(0))
    left_out = {body.name for body in model.bodies} - {body.name for body in scene.bodies}
    assert left_out == {"world", "base", "base_link", "ee_link", "tool0"}  # empty, or fixed to the ground
    assert scene.frames[0].origin == model.joint("wrist_3_link-tool0_fixed_joint").origin


def test_the_panda_is_the_published_one(tmp_path: Path) -> None:
    text = f"name: panda\nmodel: {robot(PANDA)}\nlock: {{panda_finger_joint1: 0}}\n"
    path = tmp_path / "panda.scene.yaml"
    path.write_text(text)
    model, scene = load(path), example("panda")
    same_mechanism(scene, model, Fraction(1, 10**20))  # the file says 2.3749999999999997e-06
    hand, flange = model.joint("panda_hand_joint").origin, model.joint("panda_joint8").origin
    assert scene.joint("panda_hand_joint").origin.rotation == hand.rotation
    assert scene.joint("panda_hand_joint").origin.translation == flange.translation
    left_out = {body.name for body in model.bodies} - {body.name for body in scene.bodies}
    assert left_out == {"panda_link0", "panda_link8", "panda_hand_tcp"}
