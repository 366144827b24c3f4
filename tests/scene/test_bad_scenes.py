"""Every mistake ends in one line that names the file, the place, and what is wrong."""

# ruff: noqa: E501  (one mistake, one row)

from __future__ import annotations

from pathlib import Path

import pytest

from symgen.errors import NotSupportedError, SymgenError
from symgen.scene.load import load

GOOD = """\
name: good
gravity: [0, 0, -9.81]
bodies:
  - {name: link1, mass: 1.2, com: [0.1, 0, 0], inertia: [0.1, 0.2, 0.25, 0, 0, 0]}
  - name: link2
    mass: 0.8
    inertia: {ixx: 0.01, iyy: 0.02, izz: 0.02}
joints:
  - {name: j1, type: revolute, parent: ground, child: link1, axis: [0, 0, 1], origin: {xyz: [0, 0, 0.3]}}
  - name: j2
    type: universal
    parent: link1
    child: link2
    axis: [1, 0, 0]
    axis2: [0, 1, 0]
    damping: 0.1
forces:
  - {type: spring, name: s, between: [link1, ground], points: [[0, 0, 0], [1, 0, 0]], stiffness: 10, length: 0.5}
  - {type: joint_spring, joint: j1, stiffness: 2, rest: 0}
frames:
  - {name: tool, body: link2, origin: {xyz: [0, 0, 1]}}
parameters: [link1.mass]
outputs: [mass_matrix, "frame_pose:tool"]
options: {base_velocity: world}
"""

# id: (text to replace, its replacement, what the message says)
EDITS: dict[str, tuple[str, str, str]] = {
    # shape
    "unknown key": ("mass: 0.8", "mas: 0.8", ":6: bodies[1].mas: unknown key 'mas'; did you mean 'mass'?"),
    "unknown top key": ("gravity:", "gravitation:", ":2: gravitation: unknown key 'gravitation'; did you mean 'gravity'?"),
    "unknown option": ("base_velocity:", "base_speed:", "options.base_speed: unknown key 'base_speed'"),
    "unknown origin key": ("{xyz: [0, 0, 0.3]}", "{pos: [0, 0, 0.3]}", "joints[0].origin.pos: unknown key 'pos'"),
    "no name": ("name: good\n", "", ":1: the scene needs 'name'"),
    "body without name": ("- name: link2\n    mass", "- mass", "bodies[1]: body needs 'name'"),
    "missing axis": (" axis: [0, 0, 1],", "", ":9: joints[0]: revolute joint 'j1' needs 'axis'"),
    "missing axis2": ("    axis2: [0, 1, 0]\n", "", ":10: joints[1]: universal joint 'j2' needs 'axis2'"),
    "misspelt required": ("    type: universal", "    typ: universal", "unknown key 'typ'; did you mean 'type'?"),
    "missing child": ("    child: link2\n", "", "joint 'j2' needs 'child'"),
    "missing pitch": ("revolute", "helical", "helical joint 'j1' needs 'pitch'"),
    "field of another type": ("type: universal", "type: revolute", "a revolute joint has no 'axis2'"),
    "damping on fixed": (
        "    type: universal\n    parent: link1\n    child: link2\n    axis: [1, 0, 0]\n    axis2: [0, 1, 0]",
        "    type: fixed\n    parent: link1\n    child: link2", "a fixed joint has no 'damping'"),
    "friction": ("damping: 0.1", "friction: 0.1", ":16: joints[1].friction: friction is not modelled"),
    "unknown joint type": ("revolute", "revolut", "joints[0].type: the text 'revolut' is not known; did you mean 'revolute'?"),
    "unknown force type": ("type: spring", "type: rubber", "forces[0].type: the text 'rubber' is not known"),
    "spring without points": ("points: [[0, 0, 0], [1, 0, 0]], ", "", "spring force 's' needs 'points'"),
    "joint spring with length": ("rest: 0", "length: 0", "a joint_spring force has no 'length'"),
    "bad option value": ("world", "ground", "options.base_velocity: the text 'ground' is not known; known: world, body, mixed"),
    "mass is a text": ("mass: 1.2", "mass: heavy", ":4: bodies[0].mass: a number is wanted here, not the text 'heavy'"),
    "mass in quotes": ("mass: 1.2", "mass: '1.2'", "not the text '1.2' (remove the quotes?)"),
    "mass is a list": ("mass: 1.2", "mass: [1.2]", "a number is wanted here, not a list"),
    "mass is true": ("mass: 1.2", "mass: true", "a number is wanted here, not true"),
    "mass is empty": ("mass: 0.8", "mass:", "a number is wanted here, not nothing"),
    "bodies is a mapping": ("bodies:\n  - {name: link1,", "bodies:\n  {name: link1,", "not valid YAML"),
    "body is a text": ("  - {name: tool, body: link2, origin: {xyz: [0, 0, 1]}}", "  - tool",
                       "frames[0]: a mapping is wanted here, not the text 'tool'"),
    "short vector": ("com: [0.1, 0, 0]", "com: [0.1, 0]", "bodies[0].com: has 2 entries; 3 are wanted"),
    "long inertia": ("0.25, 0, 0, 0]", "0.25, 0, 0, 0, 0]", "has 7 entries; 6 are wanted [ixx, iyy, izz, ixy, ixz, iyz]"),
    "unknown inertia entry": ("izz: 0.02", "izx: 0.02", "unknown key 'izx'"),
    "no outputs": ('[mass_matrix, "frame_pose:tool"]', "[]", "outputs: is empty"),
    "name is no identifier": ("name: good", "name: 2-good", ":1: name: '2-good' is no identifier"),
    "name is a number": ("name: good", "name: 12", "a text is wanted here, not the number 12"),
    "hostile body name": ("name: link2", "name: 'x; system(\"rm\")'", "is no identifier"),
    "name too long": ("name: good", "name: " + "g" * 80, "is longer than 60 characters"),
    "scene called main": ("name: good", "name: main", "a scene cannot be called 'main'"),
    "remove without model": ("gravity:", "remove: [link2]\ngravity:", "remove: goes with 'model' only; leave the bodies out instead"),
    "base without model": ("gravity:", "base: floating\ngravity:", "base: goes with 'model' only"),
    "snap too large": ("base_velocity: world", "snap: 0.5", "options.snap: is 0.5; at most 0.01 is wanted"),
    # numbers
    "nan": ("mass: 1.2", "mass: .nan", "not '.nan' (numbers must be finite)"),
    "inf": ("mass: 1.2", "mass: -.inf", "(numbers must be finite)"),
    "NaN word": ("mass: 1.2", "mass: NaN", "(numbers must be finite)"),
    "huge exponent": ("mass: 1.2", "mass: 1e999999999", ":4: bodies[0].mass: the exponent of 1e999999999 is beyond ±400"),
    "small exponent": ("mass: 1.2", "mass: 1e-99999", "is beyond ±400"),
    "beyond a double": ("mass: 1.2", "mass: 1e350", "the number 1e350 is outside the range 1e-300 … 1e300"),
    "endless digits": ("mass: 1.2", "mass: 0." + "3" * 5000, "has 5002 characters; at most 400 are read"),
    "two points": ("mass: 1.2", "mass: 1.2.3", "'1.2.3' is not a decimal number"),
    "octal": ("mass: 1.2", "mass: 010", "drop the leading zero of 010"),
    "hexadecimal": ("mass: 1.2", "mass: 0x10", "not the text '0x10' (not a decimal number)"),
    "comma for point": ("mass: 0.8", "mass: 0,8", "a number is wanted here, not the text '0,8'"),
    # physics
    "negative mass": ("mass: 1.2", "mass: -1.2", ":4: bodies[0].mass: is -1.2; it cannot be negative"),
    "negative damping": ("damping: 0.1", "damping: -1", "joints[1].damping: is -1; it cannot be negative"),
    "negative armature": ("damping: 0.1", "armature: -1", "it cannot be negative"),
    "negative stiffness": ("stiffness: 10", "stiffness: -10", "forces[0].stiffness: is -10; it cannot be negative"),
    "negative length": ("length: 0.5", "length: -0.5", "it cannot be negative"),
    "triangle inequality": ("[0.1, 0.2, 0.25,", "[0.1, 0.2, 0.31,",
                            ":4: bodies[0].inertia: body 'link1' has an inertia that violates the triangle inequality"),
    "not semidefinite": ("0.25, 0, 0, 0]", "0.25, 0.3, 0, 0]", "not positive semidefinite"),
    "negative inertia": ("[0.1, 0.2, 0.25,", "[-0.1, 0.2, 0.25,", "not positive semidefinite"),
    "inertia without mass": ("mass: 0.8", "mass: 0", "body 'link2' has inertia but no mass"),
    "zero axis": ("axis: [0, 0, 1]", "axis: [0, 0, 0]", "joints[0].axis: is zero; a direction is wanted"),
    "zero unit vector": ("mass: 0.8", "unit_vectors: [[0, 0, 0]]", "bodies[1].unit_vectors[0]: is zero"),
    "parallel axes": ("axis2: [0, 1, 0]", "axis2: [-2, 0, 0]", ":15: joints[1].axis2: joint 'j2' has parallel axes"),
    "pitch zero": ("type: revolute,", "type: helical, pitch: 0,", "joints[0].pitch: joint 'j1' has pitch 0; that is a revolute"),
    # graph
    "unknown parent": ("parent: link1", "parent: lnk1", ":12: joints[1].parent: joint 'j2': there is no body 'lnk1'; did you mean 'link1'?"),
    "unknown child": ("child: link2", "child: arm", "joints[1].child: joint 'j2': there is no body 'arm'"),
    "self joint": ("parent: link1", "parent: link2", "joint 'j2' connects 'link2' to itself"),
    "ground as child": ("parent: link1\n    child: link2", "parent: link2\n    child: ground",
                        "has 'ground' as its child; swap parent and child"),
    "reversed joint": ("parent: link1\n    child: link2", "parent: link2\n    child: link1",
                       ":10: joints[1]: joint 'j2' points toward ground: 'link1' is nearer to it than 'link2'; swap"),
    "disconnected body": ("joints:\n", "  - {name: lost, mass: 1}\njoints:\n", ":8: bodies[2]: body 'lost' is not connected to ground"),
    "floating on a body": ("type: universal\n    parent: link1\n    child: link2\n    axis: [1, 0, 0]\n    axis2: [0, 1, 0]",
                           "type: floating\n    parent: link1\n    child: link2", "joint 'j2' is floating, so its parent must be 'ground'"),
    "cut in a tree": ("damping: 0.1", "cut: true", "joints[1].cut: joint 'j2' cannot be cut: it lies on no closed loop"),
    "body twice": ("name: link2", "name: link1", ":5: bodies[1].name: the name 'link1' is taken by another body"),
    "joint named like a body": ("name: j2", "name: link2", "joints[1].name: the name 'link2' is taken by a body"),
    "frame named like a joint": ("name: tool", "name: j1", "frames[0].name: the name 'j1' is taken by a joint"),
    "force named like a joint": ("name: s,", "name: j1,", "forces[0].name: the name 'j1' is taken by a joint"),
    "body named ground": ("name: link2", "name: ground", "the name 'ground' is reserved"),
    # forces, frames, requests
    "spring to nowhere": ("between: [link1, ground]", "between: [link3, ground]",
                          ":18: forces[0].between[0]: there is no body 'link3'"),
    "spring with itself": ("between: [link1, ground]", "between: [link1, link1]", "the spring connects 'link1' to itself"),
    "spring of three": ("between: [link1, ground]", "between: [link1, ground, link2]", "has 3 entries; 2 are wanted"),
    "spring on unknown joint": ("joint: j1", "joint: j9", "forces[1].joint: there is no joint 'j9'; known: j1, j2"),
    "spring on a ball joint": ("type: revolute, parent: ground, child: link1, axis: [0, 0, 1]",
                               "type: spherical, parent: ground, child: link1", "a spherical joint has no coordinate for a joint spring"),
    "frame on nothing": ("body: link2", "body: link7", "frames[0].body: there is no body 'link7'; did you mean 'link"),
    "unknown output": ("[mass_matrix,", "[mass_matrx,", ":23: outputs[0]: unknown output 'mass_matrx'; did you mean 'mass_matrix'?"),
    "output not there yet": ("[mass_matrix,", "[closure,", "outputs[0]: closure is not available yet"),
    "output twice": ("[mass_matrix,", "[mass_matrix, mass_matrix,", "outputs[1]: the output 'mass_matrix' is asked for twice"),
    "frame output without frame": ("frame_pose:tool", "frame_pose", "frame_pose needs a frame: frame_pose:NAME"),
    "frame output, unknown frame": ("frame_pose:tool", "frame_pose:tol", "unknown frame 'tol' in frame_pose; did you mean 'tool'?"),
    "frame for a plain output": ("[mass_matrix,", "['mass_matrix:tool',", "mass_matrix takes no frame"),
    "combined under a row's name": ("[mass_matrix,", "[{name: bias_force, of: [mass_matrix, bias_force]},",
                                    "'bias_force' is the name of a catalogue function"),
    "combined with a repetition": ("[mass_matrix,", "[{name: both, of: [mass_matrix, mass_matrix]},", "'mass_matrix' is listed twice"),
    "combined that clashes": ("[mass_matrix,", "[{name: both, of: [inverse_dynamics, forward_dynamics]},", "cannot share a function"),
    "combined like a batch": ("[mass_matrix,", "[{name: mass_matrix_batch, of: [mass_matrix, bias_force]},", "ends like a form"),
    "combined without rows": ("[mass_matrix,", "[{name: both},", "outputs[0]: output 'both' needs 'of'"),
    "combined like a frame's": ("[mass_matrix,", "[{name: frame_pose_tool, of: [mass_matrix, bias_force]},", "would both be the function frame_pose_tool"),
    "unknown parameter": ("link1.mass", "link9.mass", ":22: parameters[0]: unknown parameter 'link9.mass'; did you mean 'link"),
    "unknown parameter field": ("link1.mass", "link1.colour", "'link1' has no parameter 'colour'; it has mass, com, inertia"),
    "parameter twice": ("[link1.mass]", "[link1.mass, link1.mass]", "parameters[1]: the parameter 'link1.mass' is listed twice"),
    "lock of nothing": ("gravity:", "lock: {j7: 0}\ngravity:", "lock.j7: there is no joint 'j7'; known: j1, j2"),
    "lock with too few numbers": ("gravity:", "lock: {j2: 0}\ngravity:", "joint 'j2' is universal: 2 numbers are wanted, 1 given"),
    "everything locked": ("gravity:", "lock: {j1: 0, j2: [0, 0]}\ngravity:", "joints: no joint can move"),
    # YAML
    "duplicate key": ("mass: 1.2,", "mass: 1.2, mass: 2,", ":4: bodies[0]: the key 'mass' is given twice"),
    "anchor": ("mass: 1.2", "mass: &m 1.2", "the anchor &m is not read"),
    "alias": ("mass: 0.8", "mass: *m", "the alias *m is not read"),
    "tag": ("mass: 1.2", "mass: !!float 1.2", ":4: bodies[0].mass: the YAML tag tag:yaml.org,2002:float is not read"),
    "python tag": ("mass: 1.2", "mass: !!python/object/apply:os.system ['true']", "the YAML tag"),
    "merge key": ("mass: 0.8", "<<: {mass: 0.8}", ":6: bodies[1]: the merge key << is not read"),
    "two documents": ("gravity:", "---\ngravity:", "a second YAML document starts here"),
    "tab": ("    mass: 0.8", "\tmass: 0.8", "not valid YAML"),
    "tab before a list": ("bodies:\n  - {name: link1,", "bodies:\n\t- {name: link1,", "a tab is used for indentation"),
    "unclosed": ("[0, 0, -9.81]", "[0, 0, -9.81", "not valid YAML"),
    "list as key": ("mass: 0.8", "[a, b]: 0.8", "a key must be a plain word"),
    "control character": ("name: good", "name: go\x00od", ":1: contains the control character U+0000"),
}  # fmt: skip


def message(path: Path) -> str:
    with pytest.raises(SymgenError) as caught:
        load(path)
    text = str(caught.value)
    assert caught.value.exit_status == 2
    assert text.isprintable() and len(text) < 400, repr(text)  # one line, fit for a terminal
    assert text.startswith(path.name)
    return text


def test_the_scene_without_mistake_loads(tmp_path: Path) -> None:
    path = tmp_path / "good.scene.yaml"
    path.write_text(GOOD)
    assert load(path).name == "good"


@pytest.mark.parametrize("mistake", EDITS)
def test_mistake(mistake: str, tmp_path: Path) -> None:
    old, new, fragment = EDITS[mistake]
    assert old in GOOD
    path = tmp_path / "bad.scene.yaml"
    path.write_text(GOOD.replace(old, new, 1), encoding="utf-8")
    text = message(path)
    assert fragment in text, text


# id: (bytes of the file, what the message says)
FILES: dict[str, tuple[bytes, str]] = {
    "empty": (b"", "is empty"),
    "blank": (b"\n# nothing\n", "is empty"),
    "a list": (b"- 1\n- 2\n", "a scene is a mapping that starts with 'name: \u2026', not a list"),
    "a text": (b"hello", "a scene is a mapping"),
    "not UTF-8": (b"name: x\nbodies: \xff\xfe\n", ":2: is not UTF-8 text"),
    "too deep": (b"name: " + b"[" * 500 + b"]" * 500, "nested more than 20 deep"),
    "bomb": (b"a: &a [x,x]\nb: &b [*a,*a]\nc: [*b,*b]\n", ":1: a: the anchor &a is not read"),
    "too large": (b"name: x\n#" + b"-" * 5_000_001, "is larger than 5 MB"),
    "binary": (bytes(range(256)), "is not UTF-8"),
    "fixed joints only": (
        b"name: x\nbodies: [{name: a, mass: 1}]\njoints: [{name: j, type: fixed, parent: ground, child: a}]",
        "joints: no joint can move",
    ),
    "island": (
        b"name: x\nbodies: [{name: a}, {name: b}, {name: c}]\njoints:\n"
        b"  - {name: j, type: spherical, parent: ground, child: a}\n"
        b"  - {name: k, type: spherical, parent: b, child: c}\n  - {name: l, type: spherical, parent: c, child: b}\n",
        "body 'b' is not connected to ground",
    ),
    "two parents": (
        b"name: x\nbodies: [{name: a}, {name: b}, {name: c}]\njoints:\n"
        b"  - {name: j, type: spherical, parent: ground, child: a}\n"
        b"  - {name: k, type: spherical, parent: a, child: b}\n  - {name: l, type: spherical, parent: c, child: b}\n",
        ":6: joints[2]: joint 'l' points toward ground: 'b' is nearer to it than 'c'; swap parent and child",
    ),
    "spring that does nothing": (
        b"name: x\nbodies: [{name: a, mass: 1}, {name: b, mass: 1}]\njoints:\n"
        b"  - {name: j, type: fixed, parent: ground, child: a}\n"
        b"  - {name: k, type: prismatic, axis: [1, 0, 0], parent: a, child: b}\n"
        b"forces: [{type: spring, between: [a, ground], points: [[0, 0, 0], [1, 0, 0]], stiffness: 1}]",
        ":6: forces[0]: can do nothing: what it acts on cannot move",
    ),
    "spring on a fixed joint": (
        b"name: x\nbodies: [{name: a, mass: 1}, {name: b, mass: 1}]\njoints:\n"
        b"  - {name: j, type: fixed, parent: ground, child: a}\n"
        b"  - {name: k, type: prismatic, axis: [1, 0, 0], parent: a, child: b}\n"
        b"forces: [{type: joint_spring, joint: j, stiffness: 1}]",
        ":6: forces[0]: can do nothing: what it acts on cannot move",
    ),
    "no joints": (b"name: x\nbodies: [{name: a}]\n", "the scene needs 'joints'"),
    "model is missing": (b"name: x\nmodel: none.urdf\n", ":2: model: none.urdf: no such file"),
    "model is a scene": (b"name: x\nmodel: other.scene.yaml\n", "is a scene; 'model' names a URDF file"),
    "model is a folder": (b"name: x\nmodel: .\n", "is a folder"),
    "parameter of ground": (
        b"name: x\nbodies: [{name: a, mass: 1}, {name: b, mass: 1}]\njoints:\n"
        b"  - {name: j, type: fixed, parent: ground, child: a}\n"
        b"  - {name: k, type: prismatic, axis: [1, 0, 0], parent: a, child: b}\nparameters: [a.mass]\n",
        "'a.mass' has no effect: 'a' does not move",
    ),
}


@pytest.mark.parametrize("case", FILES)
def test_file(case: str, tmp_path: Path) -> None:
    data, fragment = FILES[case]
    path = tmp_path / "bad.scene.yaml"
    path.write_bytes(data)
    text = message(path)
    assert fragment in text, text


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    assert "no such file" in message(tmp_path / "none.scene.yaml")


def test_a_folder(tmp_path: Path) -> None:
    assert "is a folder" in message(tmp_path)


def test_a_file_without_permission(tmp_path: Path) -> None:
    path = tmp_path / "locked.scene.yaml"
    path.write_text(GOOD)
    path.chmod(0)
    try:
        path.read_bytes()
    except PermissionError:
        assert "cannot be read" in message(path)
    else:
        pytest.skip("this user may read everything")


def test_what_is_not_available_yet_is_said_to_be_so(tmp_path: Path) -> None:
    path = tmp_path / "bad.scene.yaml"
    path.write_text(GOOD.replace("[mass_matrix,", "[closure_jacobian,"))
    with pytest.raises(NotSupportedError, match="closure_jacobian is not available yet"):
        load(path)


def test_at_least_forty_different_mistakes() -> None:
    fragments = {fragment for _, _, fragment in EDITS.values()}
    assert len(fragments) >= 40
