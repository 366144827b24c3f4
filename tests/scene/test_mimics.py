"""Joints that mimic others: in YAML, in Python, locked, hashed; what is no coupling is refused."""

# ruff: noqa: E501  (one mistake, one row)

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import symgen
from symgen.errors import SceneError
from symgen.scene.load import load
from symgen.scene.model import Mimic, Scene
from symgen.system import derive

TEXT = """\
name: hand
bodies: [{name: a, mass: 1}, {name: b, mass: 1, com: [0, 0, 1]}, {name: c, mass: 1, com: [1, 0, 0]}, {name: d, mass: 1}]
joints:
  - {name: j, type: revolute, axis: [0, 1, 0], parent: ground, child: a}
  - {name: k, type: prismatic, axis: [1, 0, 0], parent: a, child: b, mimic: {joint: j, multiplier: 0.5, offset: 0.25}}
  - {name: l, type: revolute, axis: [0, 0, 1], parent: a, child: c, mimic: {joint: k, multiplier: -2}}
  - {name: m, type: planar, parent: a, child: d}
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "hand.scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return load(write(tmp_path, TEXT))


def test_what_is_read(scene: Scene) -> None:
    assert scene.joint("k").mimic == Mimic("j", Fraction(1, 2), Fraction(1, 4))
    assert scene.joint("l").mimic == Mimic("k", Fraction(-2), Fraction(0))
    assert scene.joint("j").mimic is None


def test_coordinates_are_the_masters(scene: Scene) -> None:
    tree = derive(scene).tree
    assert (tree.nq, tree.nv) == (4, 4)
    places = {body.joint.name: (body.q, body.v) for body in tree.bodies}
    assert places["k"] == places["l"] == places["j"]


def test_the_builder_makes_the_same(scene: Scene) -> None:
    built = (
        symgen.SceneBuilder("hand")
        .body("a", 1)
        .body("b", 1, com=(0, 0, 1))
        .body("c", 1, com=(1, 0, 0))
        .body("d", 1)
        .joint("j", "revolute", "ground", "a", axis=(0, 1, 0))
        .joint("k", "prismatic", "a", "b", axis=(1, 0, 0), mimic={"joint": "j", "multiplier": 0.5, "offset": "0.25"})
        .joint("l", "revolute", "a", "c", axis=(0, 0, 1), mimic={"joint": "k", "multiplier": -2})
        .joint("m", "planar", "a", "d")
        .build()
    )
    assert replace(built, source=scene.source) == scene and built.sha256 == scene.sha256
    with pytest.raises(SceneError, match=r"joints\[0\].mimic.offset"):
        symgen.SceneBuilder("x").joint("j", "revolute", "ground", "a", mimic={"joint": "k", "offset": "?"})


def test_a_coupling_is_part_of_the_hash(tmp_path: Path, scene: Scene) -> None:
    hashes = {scene.sha256}
    for old, new in (("offset: 0.25", "offset: 0.5"), ("{joint: k, multiplier: -2}", "{joint: j, multiplier: -2}")):
        hashes.add(load(write(tmp_path, TEXT.replace(old, new))).sha256)
    hashes.add(load(write(tmp_path, TEXT.replace(", mimic: {joint: k, multiplier: -2}", ""))).sha256)
    assert len(hashes) == 4


def test_followers_are_locked_with_their_master(tmp_path: Path) -> None:
    scene = load(write(tmp_path, TEXT + "lock: {j: 1}\n"))
    assert [joint.type for joint in scene.joints] == ["fixed", "fixed", "fixed", "planar"]
    assert scene.joint("k").origin.translation == (Fraction(3, 4), 0, 0)
    alone = load(write(tmp_path, TEXT.replace(", mimic: {joint: k, multiplier: -2}", "") + "lock: {l: -1.5}\n"))
    assert scene.joint("l").origin == alone.joint("l").origin


ARM = "  - {name: j, type: revolute, axis: [0, 1, 0], parent: ground, child: a}\n"
MISTAKES: dict[str, tuple[str, str, str]] = {
    "unknown": ("joint: k,", "joint: kk,", ":6: joints[2].mimic: joint 'l' mimics 'kk', but there is no such joint"),
    "itself": ("joint: k,", "joint: l,", "joint 'l' mimics itself"),
    "circle": ("parent: ground, child: a}", "parent: ground, child: a, mimic: {joint: l}}", "in a circle: j → l → k → j"),
    "of many freedoms": ("joint: k,", "joint: m,", "mimics 'm', which is planar; only revolute, continuous, prismatic"),
    "with many freedoms": ("child: d}", "child: d, mimic: {joint: j}}", "joints[3].mimic: a planar joint has no 'mimic'"),
    "helical": ("type: revolute, axis: [0, 0, 1]", "type: helical, pitch: 1, axis: [0, 0, 1]", "a helical joint has no 'mimic'"),
    "zero": ("multiplier: -2", "multiplier: 0", "mimics 'k' with the multiplier 0, so it does not move"),
    "no joint": ("joint: k, ", "", "joints[2].mimic: mimic needs 'joint'"),
    "a key more": ("joint: k,", "joint: k, gear: 2,", "unknown key 'gear'"),
    "no number": ("multiplier: -2", "multiplier: fast", "a number is wanted here, not the text 'fast'"),
    "fixed": ("type: revolute, axis: [0, 1, 0], parent: ground", "type: fixed, parent: ground", "which is fixed: lock it"),
    "locked follower": ("joints:", "lock: {l: 0}\njoints:", "joint 'l' mimics 'k'; lock that one, and this one goes"),
    "cut": ("child: c, mimic", "child: c, cut: true, mimic", "cannot be cut: it lies on no closed loop"),
    "cut of a loop": (ARM, ARM + "  - {name: n, type: spherical, parent: b, child: c}\n",
                      "joint 'l' is coupled across a closed loop, which may be cut at 'l': mark another of its joints, such as 'n'"),
    "across the cut": (ARM + "  - {name: k, type: prismatic, axis: [1, 0, 0], parent: a, child: b,",
                       ARM + "  - {name: n, type: spherical, parent: ground, child: b}\n"
                       "  - {name: k, type: prismatic, axis: [1, 0, 0], parent: a, child: b, cut: true,",
                       "joint 'k' cannot be coupled across a cut: 'k' is cut and has no coordinate"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake(mistake: str, tmp_path: Path) -> None:
    old, new, fragment = MISTAKES[mistake]
    assert old in TEXT
    with pytest.raises(SceneError) as caught:
        load(write(tmp_path, TEXT.replace(old, new, 1)))
    text = str(caught.value)
    assert fragment in text, text
    assert text.isprintable()


def test_limits_and_couplings_are_in_the_manifest(tmp_path: Path) -> None:
    text = TEXT.replace("child: a}", "child: a, limits: {lower: -1, effort: 5}}") + "outputs: [kinetic_energy]\n"
    joints = symgen.generate(write(tmp_path, text), tmp_path / "out").manifest["joints"]
    assert joints[0] == {"name": "j", "type": "revolute", "q": [0, 1], "v": [0, 1],
                         "limits": {"lower": -1.0, "effort": 5.0}}  # fmt: skip
    assert joints[1]["mimic"] == {"joint": "j", "multiplier": 0.5, "offset": 0.25} and joints[1]["q"] == [0, 1]
    assert "limits" not in joints[1] and "mimic" not in joints[3]
