"""MJCF files: what is read of them, against MuJoCo; what is refused, and how."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path

import pytest

from symgen.cli import run
from symgen.errors import SceneError, ToolError
from symgen.scene import mjcf_process
from symgen.scene.load import load
from symgen.scene.model import JointSpring, Scene
from tests.scene.mjcf_peer import check, differences, mixed, peer

pytest.importorskip("mujoco")

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """``write(text)``: an MJCF file with this text inside <mujoco>; with ``whole=True`` the text alone."""

    def make(text: str, name: str = "m.xml", whole: bool = False, attributes: str = "") -> Path:
        path = tmp_path / name
        path.write_text(text if whole else f"<mujoco {attributes}>{text}</mujoco>", encoding="utf-8")
        return path

    return make


EVERYTHING = """
<compiler angle="degree"/>
<option gravity="0.1 -0.2 -9.8"/>
<default>
  <joint damping="0.1"/>
  <default class="strong"><joint armature="0.05" damping="0.2" frictionloss="0.3"/></default>
</default>
<asset><mesh name="part" vertex="0 0 0  1 0 0  0 2 0  0 0 3"/></asset>
<worldbody>
  <geom type="plane" size="1 1 1"/>
  <light/><camera/>
  <body name="base" pos="0 0 1" euler="0 90 30">
    <freejoint name="root"/>
    <geom size="0.1" mass="1" pos="0.1 0.2 0.3"/>
    <geom type="mesh" mesh="part" density="2"/>
    <body name="arm" pos="0.1 0.2 0.3" quat="1 0.1 0.2 0.3" childclass="strong">
      <joint name="lift" axis="0 1 0" pos="0 0.1 0.2" ref="30" stiffness="2" springref="10" range="-10 20"/>
      <joint name="push" type="slide" axis="1 1 0" ref="0.5" range="-1 2" actuatorfrcrange="-7 7"/>
      <joint axis="0 0.6 0.8" pos="0.3 0 0"/>
      <inertial mass="1" pos="1 2 3" fullinertia="1 1.1 1.2 0.1 0.2 0.3"/>
      <site name="tip" pos="0.1 0 0"/><site pos="1 0 0"/><site name="base"/>
      <body pos="0 0 0.5">
        <joint name="wrist" type="ball" pos="0.1 0 0.2" stiffness="3" springref="0"/>
        <inertial mass="2" pos="0.1 0 0" quat="1 0.2 0 0.1" diaginertia="0.1 0.2 0.25"/>
        <body name="ground" pos="1 0 0" gravcomp="1"><geom size="0.1"/></body>
      </body>
    </body>
    <frame euler="10 20 30" pos="1 0 0">
      <body name="wheel" pos="0 0.5 0"><joint name="spin" axis="0 0 1" pos="0 0 0.7"/><geom size="0.2"/></body>
    </frame>
  </body>
  <body name="crane" pos="2 0 0"><geom size="0.1"/>
    <body name="jib" pos="0 0 1"><joint name="swing" axis="0 0 -2" stiffness="1"/><geom type="box" size="1 2 3"/></body>
  </body>
  <body name="target" mocap="true"><geom size="0.1"/></body>
</worldbody>
<tendon><fixed name="cable"><joint joint="lift" coef="1"/></fixed></tendon>
<equality><joint joint1="swing" joint2="spin" polycoef="0 2 0 0 0"/></equality>
<actuator>
  <motor joint="lift" gear="3" armature="0.2" damping="0.01"/><motor joint="lift" armature="0.4"/>
  <motor tendon="cable"/>
</actuator>
<sensor><touch site="tip"/></sensor>
<keyframe><key qpos="0 0 0 1 0 0 0 0 0 0 1 0 0 0 0 0"/></keyframe>
"""


def everything(write: Write) -> Path:
    pytest.importorskip("mujoco", minversion="3.7")  # actuators that reflect inertia
    # MuJoCo would compensate gravity and hold the ball joint: neither is modelled, so neither is compared.
    return write(EVERYTHING.replace('gravcomp="1"', "").replace('stiffness="3"', ""), attributes='model="every thing"')


def test_everything_against_mujoco(write: Write) -> None:
    path = everything(write)
    scene = check(path)
    model = peer(path)
    for convention in ("body", "mixed"):
        other = replace(scene, options=replace(scene.options, base_velocity=convention))
        assert max(differences(other, model, 1).values()) < 1e-12
    # and the comparison can fail
    for body in ("arm", "ground_2"):
        heavier = tuple(replace(b, mass=b.mass * F(1001, 1000)) if b.name == body else b for b in scene.bodies)
        assert min(differences(mixed(replace(scene, bodies=heavier)), model, 1).values()) > 1e-9


def test_names_numbers_and_notes(write: Write) -> None:
    pytest.importorskip("mujoco", minversion="3.7")
    scene = load(write(EVERYTHING, attributes='model="every thing"'))
    assert scene.name == "every_thing"
    assert scene.options.base_velocity == "world"
    assert scene.gravity == (F(1, 10), F(-1, 5), F(-49, 5))
    chain = [(j.name, j.type, j.parent, j.child) for j in scene.joints]
    assert chain == [
        ("root", "floating", "ground", "base"),
        ("lift", "revolute", "base", "arm_lift"),
        ("push", "prismatic", "arm_lift", "arm_push"),
        ("arm_hinge", "revolute", "arm_push", "arm_hinge"),
        ("arm_mount", "fixed", "arm_hinge", "arm"),
        ("wrist", "spherical", "arm", "body_3_wrist"),
        ("body_3_mount", "fixed", "body_3_wrist", "body_3"),
        ("ground_2_weld", "fixed", "body_3", "ground_2"),
        ("spin", "revolute", "base", "wheel"),  # turning about its axis, the anchor on it says nothing
        ("crane_weld", "fixed", "ground", "crane"),
        ("swing", "revolute", "crane", "jib"),
        ("target_weld", "fixed", "ground", "target"),
    ]
    arm = scene.body("arm")
    assert (arm.mass, arm.com) == (1, (1, 2, 3))
    assert arm.inertia == (F(1), F(11, 10), F(6, 5), F(1, 10), F(1, 5), F(3, 10))  # as written
    assert all(scene.body(name).mass == 0 for name in ("arm_lift", "arm_push", "arm_hinge"))
    lift = scene.joint("lift")
    # Its anchor lies 0.2 along z and, which moves nothing, 0.1 along its own axis.
    assert lift.axis == (0, 1, 0)
    assert float(lift.armature) == pytest.approx(0.05 + 9 * 0.2 + 0.4)
    assert float(lift.damping) == pytest.approx(0.2 + 9 * 0.01)
    assert dict(lift.limits) == pytest.approx({"lower": -0.6981317007977318, "upper": -0.17453292519943295})
    assert dict(scene.joint("push").limits) == {"lower": -1.5, "upper": 1.5, "effort": 7.0}
    assert scene.joint("swing").axis == (0, 0, -1)
    springs = [force for force in scene.forces if isinstance(force, JointSpring)]
    assert [(s.name, s.joint, s.stiffness) for s in springs] == [
        ("lift_spring", "lift", 2),
        ("swing_spring", "swing", 1),
    ]
    assert float(springs[0].rest) == pytest.approx(-0.3490658503988659)
    assert [(f.name, f.body) for f in scene.frames] == [("tip", "arm")]
    assert scene.notes == (
        "not modelled: 3 actuator, 1 ball or free joint's stiffness, 1 camera, 6 dof with friction loss, "
        "1 equality constraint, 8 geom, 1 gravity-compensated body, 1 keyframe, 1 light, 1 mocap body held in place, "
        "1 sensor, 1 site whose name a body has, 1 site without a name, 1 tendon "
        "(linear couplings of joints among the constraints: 1; a scene can have them as mimic)",
        "positions count from MuJoCo's ref, q = qpos - ref, in joint 'lift' (0.523599), 'push' (0.5)",
        "body 'ground' is called 'ground_2' here: 'ground' is the fixed world",
        "the model's name 'every thing' became 'every_thing'",
    )


CHAIN = """
<worldbody><body name="cart"><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
<joint name="x" type="slide" axis="1 0 0"/><joint name="turn" axis="0 0 1" pos="0.5 0 0"/>
<joint name="z" type="slide" axis="0 0 1"/><joint name="b" type="ball"/></body></worldbody>
"""


def test_the_last_joint_may_bring_the_frame_back(write: Write) -> None:
    """A slide serves anywhere, so no fixed joint is needed after one; a ball joint is where it is."""
    path = write(CHAIN)
    scene = check(path)
    assert [joint.type for joint in scene.joints] == ["prismatic", "revolute", "prismatic", "spherical"]
    assert [joint.child for joint in scene.joints] == ["cart_x", "cart_turn", "cart_z", "cart"]
    scene = check(write(CHAIN.replace('<joint name="b" type="ball"/>', "")))
    assert [joint.type for joint in scene.joints] == ["prismatic", "revolute", "prismatic"]
    assert scene.joints[-1].child == "cart"


def test_disabled_parts_of_physics(write: Write) -> None:
    text = '<option gravity="0 0 -5"><flag gravity="disable" spring="disable" damper="disable"/></option>'
    text += (
        '<worldbody><body><joint name="j" stiffness="2" damping="3"/><geom size="0.1" pos="1 0 0"/></body></worldbody>'
    )
    scene = check(write(text))
    assert scene.gravity == (0, 0, 0)
    assert not scene.forces
    assert scene.joint("j").damping == 0
    assert scene.name == "m"
    assert scene.notes == ("not modelled: 1 geom",)


# -- files beside it -------------------------------------------------------------------------------------------------


def meshed(inertial: str, geom: str = "") -> str:
    return (
        '<compiler meshdir="meshes"/><asset><mesh name="shell" file="shell.stl"/><material name="m" texture="t"/>'
        '<texture name="t" type="2d" file="wood.png"/></asset><worldbody><body name="stand">'
        '<geom type="mesh" mesh="shell"/><body name="link"><joint name="j"/>'
        f'{inertial}<geom type="mesh" mesh="shell" material="m" {geom}/><geom size="0.1" material="m"/></body></body>'
        "</worldbody>"
    )


def test_missing_files_that_inertia_does_not_need(write: Write) -> None:
    scene = load(write(meshed('<inertial mass="2" pos="0 0 1" diaginertia="0.1 0.1 0.1"/>')))
    assert scene.body("link").mass == 2
    assert load(write(meshed("", 'mass="0"'))).body("link").mass == pytest.approx(4188.79e-3, rel=1e-4)


def test_a_missing_mesh_that_inertia_needs(write: Write) -> None:
    with pytest.raises(SceneError) as error:
        load(write(meshed("")))
    assert str(error.value) == (
        "m.xml: the mesh file 'shell.stl' cannot be read, and the inertia of body 'link' comes from it; "
        "write an <inertial> there"
    )


def test_included_files(write: Write, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    body = '<mujocoinclude><body name="in"><joint name="j"/><geom size="0.1"/></body></mujocoinclude>'
    write(body, "parts/part.xml", whole=True)
    path = write('<worldbody><include file="parts/part.xml"/></worldbody>')
    assert load(path).joints[0].child == "in"
    with pytest.raises(SceneError, match=r"^part.xml: is a part that an MJCF model includes; give the model$"):
        load(tmp_path / "parts" / "part.xml")


# -- scenes over a model ---------------------------------------------------------------------------------------------


ARM = """
<worldbody>
<body name="table"><geom size="0.1"/></body>
<body name="foot" pos="0 0 1" euler="0 0 90"><geom size="0.1" mass="3"/>
<body name="leg" pos="0 0 1"><joint name="knee" axis="0 1 0" ref="0.25"/><geom size="0.1" mass="2" pos="0 0 0.5"/>
<body name="hand" pos="0 0 1"><joint name="grip" type="slide" axis="1 0 0"/><geom size="0.1" mass="1"/></body>
</body></body></worldbody>
"""


def over(write: Write, more: str, name: str = "s.scene.yaml") -> Scene:
    return load(write(f"name: over\nmodel: m.xml\n{more}\n", name, whole=True))


def test_a_scene_over_a_model(write: Write) -> None:
    write(ARM)
    scene = over(write, "gravity: [0, 0, -3]\nlock: {grip: 0.5}\nparameters: [leg.mass]\noutputs: [mass_matrix]")
    assert scene.gravity == (0, 0, -3)
    assert scene.joint("grip").type == "fixed"
    assert scene.parameters[0].default == (2,)
    scene = over(write, "base: floating")
    assert [(j.name, j.type, j.child) for j in scene.joints][:2] == [
        ("table_weld", "fixed", "table"), ("floating_base", "floating", "foot"),
    ]  # fmt: skip
    assert scene.raw == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            '<body name="a"><joint/><geom size="1"/></body>',
            "m.xml: base: floating needs a root body without joints; 'a'",
        ),
        (
            '<body><body><joint/><geom size="1"/></body></body><body><joint/><geom size="1"/></body>',
            "m.xml: base: floating needs one root body; the model has 2 bodies on the world that move or carry",
        ),
    ],
)
def test_no_body_to_float(write: Write, text: str, message: str) -> None:
    write(f"<worldbody>{text}</worldbody>")
    with pytest.raises(SceneError) as error:
        over(write, "base: floating")
    assert str(error.value).startswith(message)


def test_a_free_root_stays_as_it_is(write: Write) -> None:
    write('<worldbody><body name="a"><freejoint/><geom size="1"/></body></worldbody>')
    scene = over(write, "base: floating")
    assert [(joint.name, joint.type) for joint in scene.joints] == [("a_free", "floating")]


# -- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<worldbody><body/>", "m.xml:1: not valid XML: mismatched tag"),
        ('<worldbody><body pos="1 2"/></worldbody>', "m.xml: MuJoCo: attribute 'pos' does not have enough data "),
        ("<robots/>", "m.xml: MuJoCo: Schema violation: unrecognized element Element 'robots', line 1"),
        ('<worldbody><include file="no.xml"/></worldbody>', "m.xml: MuJoCo: Error opening file 'no.xml'"),
        ('<worldbody><body name="a"><joint/></body></worldbody>', "m.xml: MuJoCo: mass and inertia of moving bodies "),
        ("", "m.xml: joints: no joint can move"),
        ("<worldbody><body><geom size='1'/></body></worldbody>", "m.xml: joints: no joint can move"),
    ],
)
def test_refused(write: Write, text: str, message: str) -> None:
    with pytest.raises(SceneError) as error:
        load(write(text))
    assert str(error.value).startswith(message)
    assert str(error.value).isprintable()


def test_entities_never_reach_mujoco(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mjcf_process, "CHILD", "nothing to run")
    path = write('<!DOCTYPE m [<!ENTITY a "aaaa">]><mujoco model="&a;"/>', whole=True)
    with pytest.raises(SceneError, match="XML entities"):
        load(path)


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("import time; time.sleep(60)", "MuJoCo's reader is not done with it after 0 s"),
        ("while True: pass", "MuJoCo's reader is not done with it after 0 s"),
        ("import os; os.kill(os.getpid(), 11)", "MuJoCo's reader broke down on it (SIGSEGV)"),
        ("raise SystemError('out of luck')", "MuJoCo's reader failed: SystemError: out of luck"),
        ("", "MuJoCo's reader failed: it ended without a word"),
    ],
)
def test_a_reader_that_fails(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, program: str, message: str
) -> None:
    child = tmp_path / "child.py"
    child.write_text(program)
    monkeypatch.setattr(mjcf_process, "CHILD", child)
    monkeypatch.setattr(mjcf_process, "GRACE", 1)
    with pytest.raises(SceneError) as error:
        mjcf_process.compile_mjcf(write(ARM), "m.xml", seconds=0)
    assert str(error.value) == f"m.xml: {message}"


def test_without_mujoco(write: Write, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(ARM)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ToolError):
        load(path)
    assert run(["show", str(path)]) == 2
    said = capsys.readouterr().err
    assert said == (
        "symgen: m.xml: MJCF files are read with MuJoCo, which is not installed: pip install 'symgen[mjcf]'\n"
    )
