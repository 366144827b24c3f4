"""A scene written in Python is the scene a file describes."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symgen.errors import SceneError
from symgen.scene.builder import SceneBuilder, exact
from symgen.scene.load import load

TEXT = """\
name: both
gravity: [0, 0, -9.81]
bodies:
  - {name: a, mass: 1.2, com: [0.1, 0, 0], inertia: {ixx: 0.1, iyy: 0.1, izz: 0.1}, basic_points: [[0, 0, 1]], unit_vectors: [[1, 1, 0]]}
  - {name: b, mass: 0.3}
  - {name: c, mass: 1}
joints:
  - {name: j, type: universal, parent: ground, child: a, axis: [1, 0, 0], axis2: [0, 1, 1], origin: {xyz: [0, 0, 1], rpy: [0.1, 0.2, 0.3]}, damping: 0.1, armature: 0.01, limits: {lower: -1, upper: 1}}
  - {name: k, type: helical, parent: a, child: b, axis: [0, 0, 1], pitch: 0.01}
  - {name: l, type: prismatic, parent: a, child: c, axis: [0, 0, 1]}
forces:
  - {type: spring, name: s, between: [b, ground], points: [[0, 0, 0], [1, 0, 0]], stiffness: 10, damping: 0.1, length: 0.5}
  - {type: joint_spring, joint: k, stiffness: 2, rest: 0.1}
frames: [{name: tool, body: b, origin: {xyz: [0, 0, 1]}}]
parameters: [b.mass, s.length]
outputs: [mass_matrix, "frame_pose:tool", {name: both_of, of: [gravity_force, bias_force]}]
options: {precision: float, snap: 1e-5, targets: [c]}
lock: {l: 0.25}
"""  # noqa: E501


def builder() -> SceneBuilder:
    return (
        SceneBuilder("both", gravity=(0, 0, -9.81))
        .body("a", "1.2", np.array([0.1, 0, 0]), {"ixx": 0.1, "iyy": 0.1, "izz": 0.1}, [(0, 0, 1)], [(1, 1, 0)])
        .body("b", Fraction(3, 10))
        .body("c", np.int64(1))
        .joint(
            "j", "universal", "ground", "a", axis=(1, 0, 0), axis2=(0, 2, 2), xyz=(0, 0, 1), rpy=(0.1, 0.2, 0.3),
            damping=Decimal("0.1"), armature=0.01, limits={"lower": -1, "upper": 1},
        )
        .joint("k", "helical", "a", "b", axis=(0, 0, 1), pitch=0.01)
        .joint("l", "prismatic", "a", "c", axis=(0, 0, 1))
        .spring(("b", "ground"), ((0, 0, 0), (1, 0, 0)), stiffness=10, damping=0.1, length=0.5, name="s")
        .joint_spring("k", stiffness=2, rest=0.1)
        .frame("tool", "b", (0, 0, 1))
        .parameters("b.mass", "s.length")
        .outputs("mass_matrix", "frame_pose:tool", both_of=["gravity_force", "bias_force"])
        .options(precision="float", snap=1e-5, targets=("c",))
        .lock(l=0.25)
    )  # fmt: skip


def test_the_builder_makes_the_scene_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "both.scene.yaml"
    path.write_text(TEXT)
    scene, built = load(path), builder().build()
    assert built.sha256 == scene.sha256
    assert (built.bodies, built.joints, built.forces) == (scene.bodies, scene.joints, scene.forces)
    assert built.parameters == scene.parameters


@pytest.mark.parametrize(
    ("value", "number"),
    [(0.1, Fraction(1, 10)), (np.float64(0.1), Fraction(1, 10)), (np.float32(0.1), Fraction(1, 10)), (3, Fraction(3)),
     (" 1e-3 ", Fraction(1, 1000)), (Decimal("0.30"), Fraction(3, 10)), (Fraction(1, 3), Fraction(1, 3))],
)  # fmt: skip
def test_numbers(value: Any, number: Fraction) -> None:
    assert exact(value) == number


@pytest.mark.parametrize(
    ("part", "text"),
    [
        (lambda b: b.body("d", float("nan")), "scene 'both': bodies[3].mass: 'nan' is not a decimal number"),
        (lambda b: b.body("d", True), "bodies[3].mass: a number is wanted, not True"),
        (lambda b: b.body("d", 1, (0, 0)), "bodies[3].com: has 2 entries; 3 are wanted"),
        (lambda b: b.body("d", 1, 3), "bodies[3].com: a list of numbers is wanted, not 3"),
        (lambda b: b.body("d", -1), "bodies[3].mass: is -1; it cannot be negative"),
        (lambda b: b.body("d", 1, (0, 0, 0), (1, 1, 3, 0, 0, 0)), "violates the triangle inequality"),
        (lambda b: b.body("a"), "bodies[3].name: the name 'a' is taken by another body"),
        (lambda b: b.body("no good"), "'no good' is no identifier"),
        (lambda b: b.body(7), "bodies[3].name: a text is wanted here, not 7"),
        (lambda b: b.body("d", 1), "body 'd' is not connected to ground"),
        (lambda b: b.joint("m", "hinge", "a", "b"), "joints[3].type: the text 'hinge' is not known"),
        (lambda b: b.joint("m", "revolute", "a", "b"), "revolute joint 'm' needs 'axis'"),
        (lambda b: b.outputs("mass"), "unknown output 'mass'; did you mean"),
        (lambda b: b.parameters("x.mass"), "unknown parameter 'x.mass'"),
        (lambda b: b.options(speed=1), "options.speed: unknown key 'speed'"),
        (lambda b: b.lock(z=1), "there is no joint 'z'"),
    ],
)
def test_mistakes_in_python_read_like_those_in_files(part: Any, text: str) -> None:
    with pytest.raises(SceneError) as caught:
        part(builder()).build()
    message = str(caught.value)
    assert text in message, message
    assert message.isprintable() and message.startswith("scene 'both'")
