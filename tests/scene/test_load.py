"""What a scene file says is what the Scene holds, exactly."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

import symgen
from symgen.errors import NotSupportedError, SceneError
from symgen.scene.load import load
from symgen.scene.model import JointSpring, Options, Output, Parameter, Scene, Spring
from symgen.scene.outputs import AVAILABLE, CATALOGUE, DEFAULT_OUTPUTS, OF_A_FRAME, parse_outputs
from symgen.scene.request import request

TEXT = """\
name: all_of_it
bodies:
  - {name: a, mass: 1.20, com: [1e-3, .5, -2], inertia: [0.1, 0.2, 0.25, 0.01, 0, -0.001]}
  - {name: b, basic_points: [[0, 0, 1]], unit_vectors: [[0, 3, 4]], mass: 1}
  - {name: c, mass: 1}
joints:
  - {name: j, type: cylindrical, parent: ground, child: a, axis: [0, 0, 2], damping: 0.1, armature: 0.02}
  - {name: k, type: prismatic, parent: a, child: b, axis: [0, -1, 0], limits: {lower: -1, upper: 0.5}}
  - {name: l, type: revolute, parent: b, child: c, axis: [1, 0, 0], origin: {rpy: [0, 0, 1.5707963]}}
forces:
  - {type: spring, name: s, between: [a, ground], points: [[0, 0, 0], [1, 0, 0]], stiffness: 10, damping: 0.1, length: 0.5}
  - {type: joint_spring, name: t, joint: k, stiffness: 2, rest: 0.25}
parameters: [gravity, a.inertia, j.damping, k.armature, s.length, t.rest, t.stiffness]
"""  # noqa: E501


def write(folder: Path, text: str, name: str = "x.scene.yaml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return load(write(tmp_path, TEXT))


def test_numbers_are_exact(scene: Scene) -> None:
    a = scene.body("a")
    assert a.mass == Fraction(6, 5)
    assert a.com == (Fraction(1, 1000), Fraction(1, 2), Fraction(-2))
    assert a.inertia == tuple(Fraction(t) for t in ("0.1", "0.2", "0.25", "0.01", "0", "-0.001"))
    assert scene.body("b").unit_vectors == ((Fraction(0), Fraction(3, 5), Fraction(4, 5)),)
    assert scene.gravity == (0, 0, Fraction(-981, 100))
    assert scene.joint("j").axis == (0, 0, 1)
    assert scene.joint("k").limits == (("lower", -1.0), ("upper", 0.5))


def test_every_number_of_the_scene_is_a_fraction(scene: Scene) -> None:
    def check(value: object) -> None:
        assert not isinstance(value, int) or isinstance(value, bool), value
        for item in value if isinstance(value, tuple) else vars(value).values() if hasattr(value, "__dict__") else ():
            check(item)

    for item in (*scene.bodies, *scene.joints, *scene.forces, scene.gravity):
        check(item)


def test_forces(scene: Scene) -> None:
    spring, twist = scene.forces
    assert isinstance(spring, Spring) and spring.length == Fraction(1, 2) and spring.between == ("a", "ground")
    assert isinstance(twist, JointSpring) and twist.rest == Fraction(1, 4)


def test_parameters_have_places_and_units(scene: Scene) -> None:
    assert [(p.name, p.start, p.size, p.unit) for p in scene.parameters] == [
        ("gravity", 0, 3, "m/s^2"),
        ("a.inertia", 3, 6, "kg.m^2"),
        ("j.damping", 9, 1, "N.m.s/rad or N.s/m"),
        ("k.armature", 10, 1, "kg"),
        ("s.length", 11, 1, "m"),
        ("t.rest", 12, 1, "m"),
        ("t.stiffness", 13, 1, "N/m"),
    ]
    assert scene.parameters[4] == Parameter("s.length", (Fraction(1, 2),), "m", 11)


def test_snapping_is_told_and_the_raw_rotation_kept(scene: Scene) -> None:
    assert scene.joint("l").origin.rotation == ((0, -1, 0), (1, 0, 0), (0, 0, 1))
    assert scene.notes[0] == "rotations snapped to exact quarter turns: joint 'l' (2.7e-08 rad)"
    raw = scene.raw["l"]
    assert isinstance(raw, tuple) and raw[0][0] == pytest.approx(2.6794897e-8)
    assert set(scene.raw) == {"l"}


def test_a_near_miss_is_told_with_the_value_that_would_snap(tmp_path: Path) -> None:
    scene = load(write(tmp_path, TEXT.replace("1.5707963", "1.5708")))
    assert "joint 'l': the angle 1.5708 is near a quarter turn" in scene.notes[0]
    assert "1.5707963267948966 would make it exact" in scene.notes[0]
    assert load(write(tmp_path, TEXT.replace("1.5707963", "1.5708") + "options: {snap: 1e-5}\n")).raw


def test_defaults(tmp_path: Path) -> None:
    text = "name: x\nbodies: [{name: a}]\njoints: [{name: j, type: spherical, parent: ground, child: a}]\n"
    scene = load(write(tmp_path, text))
    assert scene.options == Options()
    assert scene.body("a").mass == 0 and scene.body("a").inertia == (0,) * 6
    assert scene.source == "x.scene.yaml"
    assert any("moves nothing that has mass" in note for note in scene.notes)


def test_the_names_that_yaml_would_turn_into_booleans_are_names(tmp_path: Path) -> None:
    text = "name: on\nbodies: [{name: no}]\njoints: [{name: y, type: spherical, parent: ground, child: no}]\n"
    assert load(write(tmp_path, text)).body("no").name == "no"


# -- locks ---------------------------------------------------------------------------------------------------------

LOCKS = {
    "lock: {j: [1.5707963267948966, 0.5], l: 0}": ("j", ((0, -1, 0), (1, 0, 0), (0, 0, 1)), (0, 0, "0.5")),
    "lock: {k: 0.3}": ("k", ((1, 0, 0), (0, 1, 0), (0, 0, 1)), (0, "-0.3", 0)),
    "lock: {l: -1.5707963267948966}": ("l", ((0, 0, -1), (1, 0, 0), (0, -1, 0)), (0, 0, 0)),
}


@pytest.mark.parametrize("line", LOCKS)
def test_a_locked_joint_is_fixed_at_its_position(line: str, tmp_path: Path) -> None:
    name, rotation, translation = LOCKS[line]
    text = "\n".join(row for row in TEXT.splitlines() if "parameters" not in row)
    joint = load(write(tmp_path, f"{text}\n{line}\n")).joint(name)
    assert joint.type == "fixed" and joint.axis is None and joint.damping == 0
    assert joint.origin.rotation == rotation
    assert joint.origin.translation == tuple(Fraction(t) for t in translation)


def test_a_force_on_a_locked_joint_is_left_out(tmp_path: Path) -> None:
    text = "\n".join(row for row in TEXT.splitlines() if "parameters" not in row)
    scene = load(write(tmp_path, f"{text}\nlock: {{k: 0}}\n"))
    assert [force.name for force in scene.forces] == ["s"]
    assert "1 of the forces left out: the joints they act on are locked" in scene.notes
    assert load(write(tmp_path, f"{text}\nlock: {{k: 0, j: [0, 0]}}\n")).forces == ()


def test_every_joint_type_can_be_locked(tmp_path: Path) -> None:
    fields = {
        "revolute": "axis: [1, 2, 3]", "continuous": "axis: [1, 2, 3]", "prismatic": "axis: [1, 2, 3]",
        "helical": "axis: [1, 2, 3], pitch: 0.1", "cylindrical": "axis: [1, 2, 3]",
        "universal": "axis: [1, 2, 3], axis2: [3, 1, 0]", "planar": "", "spherical": "", "floating": "",
    }  # fmt: skip
    sizes = {"cylindrical": 2, "universal": 2, "planar": 3, "spherical": 4, "floating": 7}
    for kind, extra in fields.items():
        position = [0.1 * (i + 1) for i in range(sizes.get(kind, 1))]
        text = (
            "name: x\nbodies: [{name: a, mass: 1}, {name: b, mass: 1}]\njoints:\n"
            f"  - {{name: j, type: {kind}, parent: ground, child: a{', ' if extra else ''}{extra}}}\n"
            "  - {name: k, type: prismatic, parent: a, child: b, axis: [1, 0, 0]}\n"
            f"lock: {{j: {position if len(position) > 1 else position[0]}}}\n"
        )
        r = load(write(tmp_path, text)).joint("j").origin.rotation
        gram = [[sum(a * b for a, b in zip(u, w, strict=True)) for w in r] for u in r]
        assert gram == [[1, 0, 0], [0, 1, 0], [0, 0, 1]], kind


# -- loops ---------------------------------------------------------------------------------------------------------

LOOP = """\
name: loop
bodies: [{name: a, mass: 1}, {name: b, mass: 1}, {name: c, mass: 1}]
joints:
  - {name: j, type: revolute, axis: [0, 1, 0], parent: ground, child: a}
  - {name: k, type: revolute, axis: [0, 1, 0], parent: ground, child: b}
  - {name: l, type: revolute, axis: [0, 1, 0], parent: a, child: c}
  - {name: m, type: revolute, axis: [0, 1, 0], parent: b, child: c}
"""


def test_a_cycle_is_not_a_mistake(tmp_path: Path) -> None:
    assert len(load(write(tmp_path, LOOP)).joints) == 4
    scene = load(write(tmp_path, LOOP.replace("b, child: c", "b, child: c, cut: true")))
    assert [joint.cut for joint in scene.joints] == [False, False, False, True]


def test_one_cut_too_many(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be cut"):
        load(write(tmp_path, LOOP.replace(": c}", ": c, cut: true}")))


# -- hash ----------------------------------------------------------------------------------------------------------


def test_the_hash_is_of_the_meaning(tmp_path: Path, scene: Scene) -> None:
    same = TEXT.replace("mass: 1.20, com: [1e-3, .5, -2]", "com: [0.001, 0.50, -2.0], mass: 12e-1").replace(
        "axis: [0, 0, 2]", "axis: [0, 0, 1]"
    )
    assert load(write(tmp_path, "# a comment\n" + same, "other.scene.yaml")).sha256 == scene.sha256
    for old, new in (
        ("1.20", "1.21"),
        ("damping: 0.1,", "damping: 0.2,"),
        ("all_of_it", "other"),
        ("k.armature, ", ""),
    ):
        assert load(write(tmp_path, TEXT.replace(old, new, 1))).sha256 != scene.sha256


def test_the_hash_does_not_depend_on_the_run(tmp_path: Path, scene: Scene) -> None:
    path = write(tmp_path, TEXT)
    code = f"import symgen; print(symgen.load({str(path)!r}).sha256)"
    root = str(Path(symgen.__file__).resolve().parents[1])
    environment = {"PYTHONHASHSEED": "7", "PYTHONPATH": root}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == scene.sha256


# -- outputs -------------------------------------------------------------------------------------------------------


def test_the_catalogue_is_whole() -> None:
    assert set(CATALOGUE) >= AVAILABLE >= {row for output in DEFAULT_OUTPUTS for row in output.of}
    assert len(DEFAULT_OUTPUTS) == 17  # what an empty list stands for does not grow with the catalogue
    assert not {row for output in DEFAULT_OUTPUTS for row in output.of} & OF_A_FRAME


def test_outputs_on_the_command_line() -> None:
    assert parse_outputs("mass_matrix, dynamics=mass_matrix+bias_force,frame_pose:tool") == (
        Output("mass_matrix", ("mass_matrix",)),
        Output("dynamics", ("mass_matrix", "bias_force")),
        Output("frame_pose:tool", ("frame_pose:tool",)),
    )
    for text in ("", "a,,b", "a=", "=a", "a=b+", "1a=b"):
        with pytest.raises(SceneError):
            parse_outputs(text)


def test_asking_something_else(scene: Scene) -> None:
    other = request(scene, parse_outputs("mass_matrix"), precision="float", targets=("c",))
    assert other.outputs[0].name == "mass_matrix" and other.options.precision == "float"
    assert other.sha256 != scene.sha256
    assert request(scene) == scene
    with pytest.raises(SceneError, match="unknown output 'mas_matrix'"):
        request(scene, parse_outputs("mas_matrix"))


# -- what is no scene ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text", "error", "message"),
    [
        ("a.xml", "<sdf/>", NotSupportedError, "SDF files are not read"),
        (
            "a.urdf.xacro",
            "<robot><xacro:r/></robot>",
            SceneError,
            "a.urdf.xacro:1: <xacro:r> is a macro; expand",
        ),
        ("a.urdf", "<robot xmlns:xacro='x'/>", SceneError, "no link; its xacro source was expanded without a call"),
        ("a.urdf", "name: x", SceneError, "a.urdf: is not XML"),
        ("a.sdf", "x", NotSupportedError, ".sdf files are not read"),
        ("a.scene.yaml", "<robot name='r'/>", SceneError, "the robot has no link"),
    ],
)
def test_other_files(name: str, text: str, error: type[Exception], message: str, tmp_path: Path) -> None:
    with pytest.raises(error) as caught:
        load(write(tmp_path, text, name))
    assert message in str(caught.value)
    assert str(caught.value).startswith("a.")


def test_a_byte_order_mark_and_windows_lines(tmp_path: Path, scene: Scene) -> None:
    path = tmp_path / "dos.scene.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    assert load(path).sha256 == scene.sha256


def test_an_unknown_target_is_refused() -> None:
    scene = load("examples/pendulum.scene.yaml")
    with pytest.raises(SceneError, match="unknown target 'fortran'; known: c, casadi, cuda"):
        request(scene, targets=("c", "fortran"))
    with pytest.raises(SceneError, match="no target"):
        request(scene, targets=())
