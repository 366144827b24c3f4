"""The URDF reader against another one: where every link is, and what it weighs."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from symgen.scene.load import load
from symgen.scene.lock import joint_transform
from symgen.scene.model import GROUND, IDENTITY3, Matrix3, Scene, Transform
from symgen.scene.mounts import compose
from tests.scene.robots import PANDA, UR5, robot

pin: Any = pytest.importorskip("pinocchio")


def floats(rotation: Matrix3) -> NDArray[np.float64]:
    return np.array([[float(x) for x in row] for row in rotation])


def poses(scene: Scene, q: dict[str, Fraction]) -> dict[str, Transform]:
    """Pose of every body in ground axes, joints at ``q``: exact."""
    found, waiting = {GROUND: Transform()}, list(scene.joints)
    while waiting:
        joint = waiting.pop(0)
        if joint.parent not in found:
            waiting.append(joint)
            continue
        turned = joint_transform(joint, [q[joint.name]], Fraction(0)) if joint.name in q else Transform(IDENTITY3)
        found[joint.child] = compose(compose(found[joint.parent], joint.origin), turned)
    return found


@pytest.mark.parametrize("path", [UR5, PANDA])
def test_links_are_where_pinocchio_has_them(path: str) -> None:
    file = robot(path)
    check(load(file), file)


def test_turned_mounts_and_inertias(tmp_path: Path) -> None:
    file = tmp_path / "r.urdf"
    inertial = (
        '<inertial><origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/><mass value="2"/>'
        '<inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="-0.02" iyz="0.03"/></inertial>'
    )
    file.write_text(
        f'<robot name="r"><link name="a"/><link name="b">{inertial}</link><link name="c">{inertial}</link>'
        '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="1 2 3" rpy="0.1 -1.2 2.3"/>'
        '<axis xyz="1 -2 0.5"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        '<joint name="k" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="3 1 2" rpy="-2.1 0.2 0.7"/>'
        '<axis xyz="0.3 0.1 -1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    check(load(file), file)


def check(scene: Scene, file: Path) -> None:
    model = pin.buildModelFromUrdf(str(file))
    data = model.createData()
    moving = list(model.names)[1:]
    positions = np.random.default_rng(3).uniform(-2, 2, model.nq)
    q = {name: Fraction(str(round(x, 3))) for name, x in zip(moving, positions, strict=True)}
    exact = poses(scene, q)
    pin.framesForwardKinematics(model, data, np.array([float(q[name]) for name in moving]))
    for body in scene.bodies:
        index = model.getFrameId(body.name, pin.FrameType.BODY)
        pose = exact[body.name]
        assert np.abs(data.oMf[index].rotation - floats(pose.rotation)).max() < 1e-10  # the file's π/2 has 12 digits
        assert np.abs(data.oMf[index].translation - [float(x) for x in pose.translation]).max() < 1e-10
    for k, name in enumerate(moving, start=1):
        lumped = pin.Inertia.Zero()
        for body in welded(scene, scene.joint(name).child):
            index = model.getFrameId(body, pin.FrameType.BODY)
            lumped += model.frames[index].placement.act(inertia(scene, body))
        assert model.inertias[k].mass == pytest.approx(lumped.mass, abs=1e-15)
        assert np.abs(model.inertias[k].lever - lumped.lever).max() < 1e-12
        assert np.abs(model.inertias[k].inertia - lumped.inertia).max() < 1e-12


def welded(scene: Scene, name: str) -> list[str]:
    """``name`` and every body that hangs on it by fixed joints."""
    found = [name]
    for body in found:
        found.extend(joint.child for joint in scene.joints if joint.type == "fixed" and joint.parent == body)
    return found


def inertia(scene: Scene, name: str) -> Any:
    body = scene.body(name)
    ixx, iyy, izz, ixy, ixz, iyz = (float(x) for x in body.inertia)
    matrix = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return pin.Inertia(float(body.mass), np.array([float(x) for x in body.com]), matrix)
