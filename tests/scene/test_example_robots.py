"""Every robot of the package example-robot-data: it loads, or it is known why not; its links are where others put
them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from symgen.errors import SceneError
from symgen.scene.load import load
from symgen.scene.model import GROUND, Body, Joint, Scene, Vector
from symgen.system import derive
from tests.scene.robots import robots

Array = NDArray[np.float64]

REFUSED = {
    "alex_description/urdf/alex_psyonic_hands.urdf": "'Left_index_q2' mimics 'index_q1', but there is no such joint",
    "hector_description/robots/quadrotor_base.urdf": "no joint can move",
    "iris_description/robots/iris_simple.urdf": "no joint can move",
    "ur_description/urdf/ur3.urdf": "the robot has no link",
}
"""Files that do not describe a mechanism by themselves, and what is said of them."""
PSYONIC = "alex_description/urdf/alex_psyonic_hands.urdf"
HELPED = {
    PSYONIC: "remove: [LeftPsyonicAbilityBaseLink, RightPsyonicAbilityBaseLink]",
    "hector_description/robots/quadrotor_base.urdf": "base: floating",
    "iris_description/robots/iris_simple.urdf": "base: floating",
}
"""What a scene over the model says to have it nevertheless."""

if not robots():
    pytest.skip("example-robot-data is not installed", allow_module_level=True)


@pytest.mark.parametrize("name", robots())
def test_it_loads_or_it_is_known_why_not(name: str) -> None:
    if name in REFUSED:
        with pytest.raises(SceneError, match=REFUSED[name]):
            load(robots()[name])
        return
    scene = load(robots()[name])
    assert len([note for note in scene.notes if note.startswith("not modelled: ")]) <= 1
    assert all(note.isprintable() for note in scene.notes)


@pytest.mark.parametrize("name", HELPED)
def test_a_scene_helps_where_the_file_alone_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "helped.scene.yaml"
    path.write_text(f"name: helped\nmodel: {robots()[name]}\n{HELPED[name]}\n")
    assert derive(load(path)).tree.nv > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in robots() if name not in REFUSED])
def test_pinocchio_reads_the_same(name: str) -> None:
    """The pose of every link and the inertia of every moving group, at a random position of every joint."""
    pin = pytest.importorskip("pinocchio")
    scene = load(robots()[name])
    assert derive(scene).tree.nv == len({j.name for j in scene.joints if j.type != "fixed" and not j.mimic})
    model = pin.buildModelFromUrdf(str(robots()[name]))
    data = model.createData()
    angles = dict(zip(list(model.names)[1:], np.random.default_rng(5).uniform(-2, 2, model.njoints - 1), strict=True))
    q = pin.neutral(model)
    for k, joint in enumerate(list(model.joints)[1:], start=1):
        x = angles[model.names[k]]
        q[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(x), np.sin(x)] if joint.nq == 2 else [x]
    pin.framesForwardKinematics(model, data, q)
    lumped = [pin.Inertia.Zero() for _ in model.joints]
    for body, (rotation, translation) in poses(scene, angles).items():
        if body == GROUND:
            continue
        index = model.getFrameId(body.replace("ground_", "ground"), pin.FrameType.BODY)
        assert np.abs(data.oMf[index].rotation - rotation).max() < 1e-6, body  # a snap moves that much at most
        assert np.abs(data.oMf[index].translation - translation).max() < 1e-5, body
        frame = model.frames[index]
        if frame.parentJoint:
            lumped[frame.parentJoint] += frame.placement.act(inertia(pin, scene.body(body)))
    for ours, theirs in zip(lumped[1:], list(model.inertias)[1:], strict=True):
        assert ours.mass == pytest.approx(theirs.mass, rel=1e-12)
        assert np.abs(ours.lever - theirs.lever).max() < 1e-9
        assert np.abs(ours.inertia - theirs.inertia).max() < 1e-5  # as above


def inertia(pin: Any, body: Body) -> Any:
    ixx, iyy, izz, ixy, ixz, iyz = (float(x) for x in body.inertia)
    found = pin.Inertia.Zero()  # field by field, because the constructor refuses what published files contain
    found.mass, found.lever = float(body.mass), floats(body.com)
    found.inertia = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return found


def poses(scene: Scene, angles: Mapping[str, float]) -> dict[str, tuple[Array, Array]]:
    """Rotation and position of every body, joints of one freedom at ``angles``; floats."""
    found: dict[str, tuple[Array, Array]] = {GROUND: (np.eye(3), np.zeros(3))}
    outgoing: dict[str, list[Joint]] = {}
    for joint in scene.joints:
        outgoing.setdefault(joint.parent, []).append(joint)
    stack = [GROUND]
    while stack:
        for joint in outgoing.get(stack.pop(), []):
            rotation, translation = found[joint.parent]
            translation = translation + rotation @ floats(joint.origin.translation)
            rotation = rotation @ np.array([floats(row) for row in joint.origin.rotation])
            if joint.axis is not None:
                axis, x = floats(joint.axis), angles[joint.name]
                if joint.type == "prismatic":
                    translation = translation + rotation @ axis * x
                else:
                    rotation = rotation @ turn(axis, x)
            found[joint.child] = (rotation, translation)
            stack.append(joint.child)
    return found


def turn(axis: Array, angle: float) -> Array:
    """Rodrigues."""
    skew: Any = np.cross(np.eye(3), axis)
    return np.asarray(np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew)


def floats(values: Vector) -> Array:
    return np.array([float(x) for x in values])
