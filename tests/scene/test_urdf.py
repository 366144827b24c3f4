"""URDF: what is read is exact, what is not read is said, what is wrong names file, line and element."""

# ruff: noqa: E501  (one mistake, one row)

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from symgen.errors import NotSupportedError, SymgenError
from symgen.scene.exact import matmul, matvec, transpose, unit_vector
from symgen.scene.load import load
from symgen.scene.lock import joint_transform
from symgen.scene.model import IDENTITY3, Mimic, Scene, Transform
from symgen.scene.mounts import compose
from tests.scene.robots import PANDA, UR5, robot
from tools.seeds import ROBOT as GOOD


def write(folder: Path, text: str, name: str = "two.urdf") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_what_is_read(tmp_path: Path) -> None:
    scene = load(write(tmp_path, GOOD))
    assert scene.name == "two" and scene.source == "two.urdf"
    assert [(j.name, j.type, j.parent, j.child) for j in scene.joints] == [
        ("root_joint", "fixed", "ground", "base"),
        ("turn", "revolute", "base", "arm 1"),
        ("slide", "prismatic", "arm 1", "slider"),
    ]
    turn = scene.joint("turn")
    assert turn.axis == (0, 0, 1) and turn.damping == Fraction(1, 2)
    assert turn.limits == (("lower", -1.0), ("upper", 1.0), ("velocity", 2.0), ("effort", 5.0))
    assert scene.joint("slide").axis == (1, 0, 0)
    arm = scene.body("arm 1")
    assert arm.mass == 2 and arm.com == (Fraction(1, 10), 0, 0)
    assert arm.inertia == tuple(Fraction(t) for t in ("0.2", "0.1", "0.25", "-0.01", "0", "0"))  # turned a quarter
    assert scene.body("slider").mass == Fraction(1, 10)


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    notes = load(write(tmp_path, GOOD)).notes
    assert notes[1] == "not modelled: 1 collision, 1 friction, 1 material, 1 transmission, 1 visual"
    assert notes[0].startswith("rotations snapped to exact quarter turns: inertia of link 'arm 1'")
    assert len(notes) == 2


def test_an_inertia_no_body_can_have_is_noted(tmp_path: Path) -> None:
    notes = load(write(tmp_path, GOOD.replace('izz="0.25"', 'izz="0.35"'))).notes
    said = "inertias that no rigid body has, used as given: an inertia that violates the triangle inequality: arm 1"
    assert said in notes


def test_an_inertia_is_turned_exactly(tmp_path: Path) -> None:
    scene = load(write(tmp_path, GOOD.replace("0 0 1.5707963267948966", "0.3 -0.4 0.5")))
    got = scene.body("arm 1").inertia
    cr, sr, cp, sp, cy, sy = np.cos(0.3), np.sin(0.3), np.cos(-0.4), np.sin(-0.4), np.cos(0.5), np.sin(0.5)
    rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    rotation = rz @ ry @ rx
    wanted = rotation @ np.array([[0.1, 0.01, 0], [0.01, 0.2, 0], [0, 0, 0.25]]) @ rotation.T
    matrix = np.array([[got[0], got[3], got[4]], [got[3], got[1], got[5]], [got[4], got[5], got[2]]], dtype=float)
    assert np.abs(matrix - wanted).max() < 1e-16
    assert sum(got[:3]) == Fraction("0.55")  # the trace is kept exactly


MISTAKES: dict[str, tuple[str, str, str]] = {
    "no such link": ('child link="slider"', 'child link="slidr"', ":22: joint 'slide': there is no link 'slidr'; did you mean 'slider'?"),
    "joint type": ('"prismatic"', '"prismatc"', "unknown joint type 'prismatc'; did you mean 'prismatic'?"),
    "no type": (' type="prismatic"', "", "unknown joint type ''"),
    "floating on a link that moves": ('"prismatic"', '"floating"', "joint 'slide': is floating, so it can start at the root link (or what is fixed to it) only; 'arm 1' moves by joint 'turn'"),
    "mimic of nothing": ('mimic joint="turn"', 'mimic joint="trn"', ":22: joint 'slide': joint 'slide' mimics 'trn', but there is no such joint; did you mean 'turn'?"),
    "mimic without joint": ('mimic joint="turn"', 'mimic', "<mimic> needs the attribute 'joint'"),
    "mimic of itself": ('mimic joint="turn"', 'mimic joint="slide"', ":22: joint 'slide': joint 'slide' mimics itself"),
    "mimic that is planar": ('"prismatic"', '"planar"', "joint 'slide' is planar; only revolute, continuous, prismatic joints can mimic"),
    "mimic of a fixed joint": ('"revolute"', '"fixed"', "joint 'slide' mimics 'turn', which is fixed: lock it at a position instead"),
    "mimic of a planar joint": ('"revolute"', '"planar"', "mimics 'turn', which is planar; only revolute"),
    "mimic that stands still": ('mimic joint="turn"', 'mimic joint="turn" multiplier="0"', "with the multiplier 0, so it does not move"),
    "mimic of no number": ('mimic joint="turn"', 'mimic joint="turn" offset="x"', "offset of <mimic>: 'x' is not a decimal number"),
    "no child": ('<child link="slider"/>', "", "needs <child link="),
    "zero axis": ("0 0 2", "0 0 0", ":15: joint 'turn': the axis is zero"),
    "short axis": ("0 0 2", "0 2", "xyz='0 2' has 2 numbers; 3 are wanted"),
    "nan": ('value="2"', 'value="nan"', ":5: link 'arm 1': value of <mass>: 'nan' is not a decimal number"),
    "huge": ('value="2"', 'value="1e999"', "the exponent of 1e999 is beyond"),
    "negative mass": ('value="2"', 'value="-2"', "two.urdf:5: link 'arm 1': body 'arm 1' has the negative mass -2"),
    "no mass value": ('value="2"', "", "<mass> needs the attribute 'value'"),
    "no mass": ('<mass value="2"/>', "", "<inertial> needs <mass>"),
    "no ixx": ('ixx="0.1" ', "", "<inertia> needs the attribute 'ixx'"),
    "negative damping": ('damping="0.5"', 'damping="-0.5"', "joint 'turn' has the negative damping"),
    "link twice": ('name="slider"', 'name="base"', "the name is taken by another link (line 4)"),
    "joint twice": ('name="slide"', 'name="turn"', "the name is taken by another joint (line 15)"),
    "no name": (' name="base"', "", "a link needs a name"),
    "empty name": ('name="base"', 'name=" "', "cannot be a name"),
    "two parents": ('<child link="slider"/>', '<child link="arm 1"/>', "link 'arm 1' is already the child of joint 'turn'"),
    "circle": ('child link="slider"', 'child link="base"', "is not connected"),
    "two roots": ("  <transmission", '  <link name="far"/><transmission', "link 'far': is not connected"),
    "wrong root": ("<robot", "<model", "not valid XML"),
    "unclosed": ("</robot>", "", "not valid XML"),
    "xacro": ("  <transmission", "  <xacro:include/><transmission", "<xacro:include> is a macro; expand the file first: xacro two.urdf > model.urdf (pip install xacro)"),
    "xacro in a link": ("<collision/>", "<xacro:box/>", ":12: <xacro:box> is a macro; expand"),
    "xacro in an inertia": ('<mass value="2"/>', "<xacro:m/>", ":8: <xacro:m> is a macro; expand"),
    "xacro expression": ('value="2"', 'value="${m}"', "value of <mass>: '${m}' is not a decimal number; expand the file first"),
    "xacro vector": ("0 0 2", "0 0 ${pi / 2}", "is not a decimal number; expand the file first"),
    "entity": ('<?xml version="1.0"?>', '<!DOCTYPE r [<!ENTITY a "b">]>', "declares XML entities"),
    "bomb": ('<?xml version="1.0"?>', '<!DOCTYPE r [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]>', "declares XML entities"),
    "external": ('<?xml version="1.0"?>', '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]>', "declares XML entities"),
    "encoding": ('version="1.0"', 'version="1.0" encoding="nonsense"', "not valid XML"),
    "deep": ("  <transmission", "<a>" * 100 + "</a>" * 100 + "  <transmission", "nested more than 60 deep"),
    "not a robot": ("<?xml", "<html/><?xml", "not valid XML"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake(mistake: str, tmp_path: Path) -> None:
    old, new, fragment = MISTAKES[mistake]
    assert old in GOOD
    with pytest.raises(SymgenError) as caught:
        load(write(tmp_path, GOOD.replace(old, new, 1)))
    text = str(caught.value)
    assert fragment in text, text
    assert text.startswith("two.urdf") and text.isprintable()


def test_a_circle_of_joints(tmp_path: Path) -> None:
    text = (
        '<robot name="r"><link name="a"/><link name="b"/>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
        '<joint name="k" type="continuous"><parent link="b"/><child link="a"/></joint></robot>'
    )
    with pytest.raises(SymgenError, match="go round in a circle"):
        load(write(tmp_path, text))


def test_hostile_names_load_and_stay_out_of_messages(tmp_path: Path) -> None:
    hostile = "x; */ system(&quot;rm&quot;) %s {0}"
    scene = load(write(tmp_path, GOOD.replace("arm 1", hostile).replace('"two"', '"int main(){}"')))
    assert scene.name == "int_main_"
    assert any("the robot's name 'int main(){}' became 'int_main_'" in note for note in scene.notes)


# -- joints of several freedoms, odd names, what xacro leaves --------------------------------------------------------

INERTIAL = '<inertial><mass value="2"/><inertia ixx="0.1" iyy="0.2" izz="0.25"/></inertial>'
FREE = f"""\
<robot name="free" xmlns:xacro="http://wiki.ros.org/xacro">
  <link name="ground"/><link name="stand"/><link name="trunk">{INERTIAL}</link><link name="leg">{INERTIAL}</link>
  <joint name="feet" type="fixed"><parent link="ground"/><child link="stand"/><origin xyz="0 0 1"/></joint>
  <joint name="free" type="floating"><parent link="stand"/><child link="trunk"/><origin xyz="1 0 0"/></joint>
  <joint name="hip" type="planar"><parent link="trunk"/><child link="leg"/><origin xyz="0 1 0"/><axis xyz="1 2 2"/>
    <limit lower="-inf" upper="2" effort="3" velocity="INF"/></joint>
</robot>
"""


def test_a_floating_joint_starts_at_ground(tmp_path: Path) -> None:
    scene = load(write(tmp_path, FREE, "free.urdf"))
    joint = scene.joint("free")
    assert (joint.type, joint.parent, joint.child) == ("floating", "ground", "trunk")
    assert joint.origin.translation == (1, 0, 1)
    assert scene.joint("root_joint").child == "ground_"
    assert "link 'ground' is called 'ground_' here: 'ground' is the fixed world" in scene.notes


def test_a_base_that_floats_already(tmp_path: Path) -> None:
    write(tmp_path, FREE, "free.urdf")
    scene = load(write(tmp_path, "name: mine\nmodel: free.urdf\nbase: floating\n", "mine.scene.yaml"))
    assert [joint.name for joint in scene.joints if joint.type == "floating"] == ["free"]
    assert scene.joint("root_joint").type == "fixed"
    assert "base: floating is what the model has already: joint 'free'" in scene.notes


def test_a_planar_joint_moves_in_the_plane_across_its_axis(tmp_path: Path) -> None:
    scene = load(write(tmp_path, FREE, "free.urdf"))
    joint, weld = scene.joint("hip"), scene.joint("hip_weld")
    assert (joint.type, joint.child, joint.axis) == ("planar", "hip_plane", None)
    assert (weld.parent, weld.child) == ("hip_plane", "leg")
    assert joint.limits == (("upper", 2.0), ("effort", 3.0))
    assert compose(joint.origin, weld.origin) == Transform(translation=(Fraction(0), Fraction(1), Fraction(0)))
    normal = (Fraction(1, 3), Fraction(2, 3), Fraction(2, 3))
    moved = compose(
        joint.origin,
        compose(joint_transform(joint, (Fraction(3), Fraction(-2), Fraction(1)), Fraction(0)), weld.origin),
    )
    assert sum(a * b for a, b in zip(moved.translation, normal, strict=True)) == Fraction(2, 3)  # that of the origin
    assert matvec(moved.rotation, normal) == normal
    assert any(a != b for a, b in zip(moved.rotation[0], (1, 0, 0), strict=True))


@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -2", "1 0 0", "0 -1 0", "1 -1 0.5"])
def test_the_plane_of_any_normal(axis: str, tmp_path: Path) -> None:
    scene = load(write(tmp_path, FREE.replace("1 2 2", axis), "free.urdf"))
    rotation = scene.joint("hip").origin.rotation
    assert tuple(row[2] for row in rotation) == unit_vector(tuple(Fraction(x) for x in axis.split()))  # type: ignore[arg-type]
    assert matmul(rotation, transpose(rotation)) == IDENTITY3
    assert ("hip_plane" in [body.name for body in scene.bodies]) == (axis != "0 0 1")


# -- a scene that refers to a model --------------------------------------------------------------------------------


def scene_with(folder: Path, more: str) -> Scene:
    write(folder, GOOD)
    return load(write(folder, f"name: mine\nmodel: two.urdf\n{more}", "mine.scene.yaml"))


def test_a_model_in_a_scene(tmp_path: Path) -> None:
    scene = scene_with(
        tmp_path,
        "gravity: [0, 0, -1.62]\nframes: [{name: tip, body: slider}]\n"
        "forces: [{type: joint_spring, joint: slide, stiffness: 5}]\n"
        "parameters: ['arm 1.mass', turn.damping]\noutputs: [mass_matrix, 'frame_pose:arm 1']\n",
    )
    assert scene.name == "mine" and scene.gravity[2] == Fraction(-162, 100)
    assert [p.name for p in scene.parameters] == ["arm 1.mass", "turn.damping"]
    assert scene.outputs[1].of == ("frame_pose:arm 1",)


def test_a_floating_base(tmp_path: Path) -> None:
    joint = scene_with(tmp_path, "base: floating\n").joints[0]
    assert (joint.name, joint.type, joint.parent, joint.child) == ("floating_base", "floating", "ground", "base")


def test_a_locked_joint_of_a_model(tmp_path: Path) -> None:
    scene = scene_with(tmp_path, "base: floating\nlock: {turn: 0.25}\n")
    assert scene.joint("turn").type == "fixed"
    slide = scene.joint("slide")  # which mimics it
    assert (slide.type, slide.mimic, slide.origin.translation) == ("fixed", None, (Fraction(1, 4), 0, 0))
    assert not any("beyond" in note for note in scene.notes)


def test_a_joint_locked_beyond_its_limits_is_noted(tmp_path: Path) -> None:
    scene = scene_with(tmp_path, "base: floating\nlock: {turn: 1.5}\n")
    assert "locked beyond their limits: turn (1.5, not in [-1, 1])" in scene.notes


def test_fixed_joints_are_not_suggested(tmp_path: Path) -> None:
    write(tmp_path, GOOD.replace('"prismatic"', '"fixed"').replace('<mimic joint="turn"/>', ""))
    with pytest.raises(SymgenError) as caught:
        load(write(tmp_path, "name: mine\nmodel: two.urdf\nlock: {slid: 0}\n", "mine.scene.yaml"))
    assert "there is no joint 'slid'; known: turn" in str(caught.value)


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ("lock: {slid: 0}", "mine.scene.yaml:3: lock.slid: there is no joint 'slid'; did you mean 'slide'?"),
        ("forces: [{type: joint_spring, joint: x}]", "mine.scene.yaml:3: forces[0].joint: there is no joint 'x'"),
        ("frames: [{name: base, body: slider}]", "frames[0].name: the name 'base' is taken by a body"),
        ("lock: {slide: 0}", "joint 'slide' mimics 'turn'; lock that one, and this one goes with it"),
        ("parameters: [base.mass]", "'base.mass' has no effect: 'base' does not move"),
        (
            "lock: {turn: 0}",
            "no joint can move (every one is fixed): nothing to derive; 'base: floating' in a scene over",
        ),
    ],
)
def test_mistakes_in_a_scene_with_a_model(more: str, text: str, tmp_path: Path) -> None:
    with pytest.raises(SymgenError) as caught:
        scene_with(tmp_path, more)
    assert text in str(caught.value)


def test_a_mistake_in_the_model_names_the_model(tmp_path: Path) -> None:
    write(tmp_path, GOOD.replace('value="2"', 'value="two"'))
    with pytest.raises(
        SymgenError, match=r"^two\.urdf:5: link 'arm 1': value of <mass>: 'two' is not a decimal number"
    ):
        load(write(tmp_path, "name: mine\nmodel: two.urdf\n", "mine.scene.yaml"))


def test_a_model_that_is_not_read_yet(tmp_path: Path) -> None:
    write(tmp_path, "<sdf/>", "m.xml")
    with pytest.raises(NotSupportedError, match="SDF"):
        load(write(tmp_path, "name: mine\nmodel: m.xml\n", "mine.scene.yaml"))


# -- real robots ---------------------------------------------------------------------------------------------------


def test_ur5() -> None:
    scene = load(robot(UR5))
    assert scene.name == "ur5" and len(scene.bodies) == 11
    assert [j.name for j in scene.joints if j.type == "revolute"] == [
        "shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint",
    ]  # fmt: skip
    assert {"shoulder_lift_joint", "wrist_1_joint"} <= set(scene.raw)
    assert scene.joint("shoulder_lift_joint").origin.rotation == ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
    assert scene.joint("root_joint").child == "world"


def test_panda() -> None:
    scene = load(robot(PANDA))
    kinds = [j.type for j in scene.joints]
    assert (kinds.count("revolute"), kinds.count("prismatic")) == (7, 2)
    assert scene.joint("panda_finger_joint2").mimic == Mimic("panda_finger_joint1", Fraction(1), Fraction(0))
    turned = scene.joint("panda_hand_joint").origin.rotation
    assert float(turned[0][0]) == float(turned[0][1]) == pytest.approx(0.5**0.5, abs=1e-16)
