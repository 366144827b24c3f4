"""A scene over a model: subtrees removed, bodies added, parameters by pattern; every clash is one clear line."""

# ruff: noqa: E501  (one mistake, one row)

from __future__ import annotations

import shutil
from fractions import Fraction
from pathlib import Path

import pytest

import symgen
from symgen.errors import SceneError
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.system import derive

MODEL = """\
<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <link name="lower"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="3"/></inertial></link>
  <link name="left"><inertial><mass value="0.1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <link name="right"><inertial><mass value="0.1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <link name="pad"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/>
    <origin xyz="0 0 1" rpy="0.1 0.2 0.3"/></joint>
  <joint name="grip" type="prismatic"><parent link="lower"/><child link="left"/></joint>
  <joint name="follow" type="prismatic"><parent link="lower"/><child link="right"/><mimic joint="grip"/></joint>
  <joint name="glue" type="fixed"><parent link="right"/><child link="pad"/></joint>
</robot>
"""


def scene_over(folder: Path, more: str) -> Scene:
    (folder / "arm.urdf").write_text(MODEL)
    path = folder / "mine.scene.yaml"
    path.write_text(f"name: mine\nmodel: arm.urdf\n{more}")
    return load(path)


def test_a_subtree_is_removed(tmp_path: Path) -> None:
    scene = scene_over(tmp_path, "remove: [left, right]\n")
    assert [body.name for body in scene.bodies] == ["base", "upper", "lower"]
    assert [joint.name for joint in scene.joints] == ["root_joint", "shoulder", "elbow"]
    assert scene_over(tmp_path, "remove: [lower]\n").bodies[-1].name == "upper"
    assert scene_over(tmp_path, "remove: [right, pad, right]\n").bodies[-1].name == "left"


def test_a_locked_master_may_be_removed(tmp_path: Path) -> None:
    scene = scene_over(tmp_path, "remove: [left]\nlock: {grip: 0.02}\n")
    assert scene.joint("follow").type == "fixed"
    assert scene.joint("follow").origin.translation == (Fraction(1, 50), 0, 0)


def test_a_payload(tmp_path: Path) -> None:
    scene = scene_over(
        tmp_path,
        "bodies: [{name: payload, mass: 3}, {name: bell, mass: 1, com: [0, 0, -1]}]\n"
        "joints:\n"
        "  - {name: held, type: fixed, parent: lower, child: payload, origin: {xyz: [0, 0, 0.5]}}\n"
        "  - {name: swing, type: spherical, parent: payload, child: bell}\n"
        "frames: [{name: tip, body: bell, origin: {xyz: [0, 0, -1]}}]\n"
        "parameters: ['payload.*']\noutputs: [mass_matrix, 'frame_pose:tip']\n",
    )
    assert [p.name for p in scene.parameters] == ["payload.mass", "payload.com", "payload.inertia"]
    tree = derive(scene).tree
    assert [body.name for body in tree.bodies] == ["upper", "lower", "left", "right", "bell"]
    assert [body.name for body, _ in tree.bodies[1].parts] == ["lower", "payload"]


def test_a_model_on_a_rail(tmp_path: Path) -> None:
    """A joint into the model's root takes the place of its weld to ground."""
    scene = scene_over(
        tmp_path,
        "bodies: [{name: cart, mass: 5}]\njoints:\n"
        "  - {name: rail, type: prismatic, parent: ground, child: cart, axis: [1, 0, 0]}\n"
        "  - {name: bolts, type: fixed, parent: cart, child: base}\n",
    )
    assert "root_joint" not in [joint.name for joint in scene.joints]
    tree = derive(scene).tree
    assert [body.name for body in tree.bodies] == ["cart", "upper", "lower", "left", "right"]
    assert not tree.cut_joints


def test_the_builder_takes_a_model_too(tmp_path: Path) -> None:
    scene = scene_over(tmp_path, "base: floating\nremove: [right]\nbodies: [{name: p, mass: 1}]\n"
                       "joints: [{name: h, type: fixed, parent: lower, child: p}]\n")  # fmt: skip
    built = (
        symgen.SceneBuilder("mine")
        .model(tmp_path / "arm.urdf", base="floating", remove=["right"])
        .body("p", 1)
        .joint("h", "fixed", "lower", "p")
        .build()
    )
    assert built.sha256 == scene.sha256


CLASHES: dict[str, tuple[str, str]] = {
    "remove what is not there": ("remove: [lefty]", ":3: remove[0]: there is no body 'lefty'; did you mean 'left'?"),
    "remove all": ("remove: [base]", "remove: nothing of the model is left"),
    "remove all that moves": ("remove: [upper]", "no joint can move"),
    "remove its own": ("remove: [p]\nbodies: [{name: p}]\njoints: [{name: h, type: fixed, parent: upper, child: p}]",
                       "body 'p' is one of this scene's own; take it from 'bodies'"),
    "remove a master": ("remove: [left]", "joint 'follow' mimics 'grip', which is removed; lock 'grip' at a position, or "
                        "remove 'right' too"),
    "frame on what is removed": ("remove: [right]\nframes: [{name: f, body: pad}]",
                                 ":4: frames[0].body: body 'pad' is removed with 'right' (see 'remove')"),
    "joint on what is removed": ("remove: [right]\nbodies: [{name: p}]\njoints: [{name: h, type: fixed, parent: right, child: p}]",
                                 "joints[0].parent: body 'right' is removed (see 'remove')"),
    "spring on what is removed": ("remove: [right]\nforces: [{type: spring, between: [ground, pad], points: [[0,0,0],[0,0,1]]}]",
                                  "forces[0].between[1]: body 'pad' is removed with 'right'"),
    "joint spring on what is removed": ("remove: [right]\nforces: [{type: joint_spring, joint: follow}]",
                                        "forces[0].joint: joint 'follow' is removed with 'right'"),
    "output of what is removed": ("remove: [right]\noutputs: ['frame_pose:pad']", "outputs[0]: body 'pad' is removed with"),
    "output, combined": ("remove: [right]\noutputs: [{name: a, of: ['frame_pose:pad']}]", "outputs[0]: body 'pad' is removed"),
    "parameter of what is removed": ("remove: [right]\nparameters: [right.mass]", "parameters[0]: body 'right' is removed"),
    "parameter of a joint removed": ("remove: [right]\nparameters: [glue.xyz]", "parameters[0]: joint 'glue' is removed with"),
    "body of a link's name": ("bodies: [{name: lower, mass: 1}]", "bodies[0].name: arm.urdf has a body 'lower' already; choose"),
    "joint of a joint's name": ("bodies: [{name: p}]\njoints: [{name: elbow, type: fixed, parent: lower, child: p}]",
                                ":4: joints[0].name: arm.urdf has a joint 'elbow' already; choose another name"),
    "strict with its own": ("bodies: [{name: p, mass: 1, inertia: [1, 1, 3, 0, 0, 0]}]\n"
                            "joints: [{name: h, type: fixed, parent: lower, child: p}]",
                            ":3: bodies[0].inertia: body 'p' has an inertia that violates the triangle inequality"),
    "loose body": ("bodies: [{name: p, mass: 1}]", ":3: bodies[0]: body 'p' is not connected to ground"),
    "unknown parent": ("bodies: [{name: p}]\njoints: [{name: h, type: fixed, parent: lowr, child: p}]",
                       "joints[0].parent: joint 'h': there is no body 'lowr'; did you mean 'lower'?"),
    "two bases": ("base: floating\nbodies: [{name: p, mass: 1}]\njoints:\n"
                  "  - {name: r, type: prismatic, parent: ground, child: p, axis: [1, 0, 0]}\n"
                  "  - {name: h, type: fixed, parent: p, child: base}",
                  ":7: joints[1].child: 'base', the root of the model, has a floating joint already"),
    "root on its own hand": ("bodies: [{name: p, mass: 1}]\njoints:\n  - {name: r, type: fixed, parent: left, child: p}\n"
                             "  - {name: h, type: fixed, parent: p, child: base}", "is not connected to ground"),
    "pattern of nothing": ("parameters: ['lowr.*']", "no parameter matches 'lowr.*'; did you mean 'lower'?"),
    "pattern of no field": ("parameters: ['upper.colou*']", "'upper' matches has mass, com, inertia"),
    "twice": ("parameters: ['lower.*', lower.mass]", "'lower.mass' is listed twice (it is one of 'lower.*')"),
}  # fmt: skip


@pytest.mark.parametrize("clash", CLASHES)
def test_clash(clash: str, tmp_path: Path) -> None:
    more, fragment = CLASHES[clash]
    with pytest.raises(SceneError) as caught:
        scene_over(tmp_path, more + "\n")
    text = str(caught.value)
    assert fragment in text, text
    assert text.isprintable() and text.startswith(("mine.scene.yaml", "arm.urdf"))


# -- parameters ----------------------------------------------------------------------------------------------------


def test_patterns_expand_in_the_order_of_what_is_available(tmp_path: Path) -> None:
    scene = scene_over(tmp_path, "parameters: [gravity, lower.mass, '*.mass', 'elbow.[xr]*']\n")
    assert [p.name for p in scene.parameters] == [
        "gravity", "lower.mass", "upper.mass", "left.mass", "right.mass", "pad.mass", "elbow.xyz", "elbow.rpy",
    ]  # fmt: skip
    assert [p.start for p in scene.parameters] == [0, 3, 4, 5, 6, 7, 8, 11]


def test_places_of_joints_and_springs(tmp_path: Path) -> None:
    scene = scene_over(
        tmp_path,
        "forces: [{type: spring, name: s, between: [ground, lower], points: [[1, 0, 0], [0, 0, 2]], stiffness: 1}]\n"
        "parameters: [elbow.xyz, elbow.rpy, elbow.offset, grip.offset, glue.rpy, s.point1, s.point2]\n",
    )
    found = {p.name: (tuple(float(x) for x in p.default), p.unit) for p in scene.parameters}
    assert found == {
        "elbow.xyz": ((0, 0, 1), "m"), "elbow.rpy": ((0.1, 0.2, 0.3), "rad"), "elbow.offset": ((0,), "rad"),
        "grip.offset": ((0,), "m"), "glue.rpy": ((0, 0, 0), "rad"),
        "s.point1": ((1, 0, 0), "m"), "s.point2": ((0, 0, 2), "m"),
    }  # fmt: skip


@pytest.mark.parametrize("wrong", ["glue.offset", "glue.damping", "swing.offset"])
def test_what_has_no_such_parameter(wrong: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"has no parameter|unknown parameter"):
        scene_over(tmp_path, f"parameters: [{wrong}]\n")


def test_a_scene_is_made_again_from_elsewhere(tmp_path: Path) -> None:
    first = scene_over(tmp_path, "remove: [right]\n")
    other = tmp_path / "other"
    other.mkdir()
    for name in ("arm.urdf", "mine.scene.yaml"):
        shutil.copy(tmp_path / name, other / name)
    assert load(other / "mine.scene.yaml").sha256 == first.sha256
