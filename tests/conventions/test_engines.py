"""Converters against the engines themselves: dynamics, integration and accelerations agree through them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import symgen
from symgen.conventions import Converter, from_mujoco, from_pinocchio, to_mujoco, to_pinocchio
from symgen.scene.load import load
from symgen.system import System, derive
from tests.conventions.robots import MJCF, URDF, branched_scene
from tests.states import ours, random_states

Array = NDArray[np.float64]
CONVENTIONS = ("world", "body", "mixed")


def in_convention(scene: symgen.Scene, convention: str) -> System:
    return derive(replace(scene, options=replace(scene.options, base_velocity=convention)))


# -- Pinocchio -------------------------------------------------------------------------------------------------------


def pinocchio_of(scene: symgen.Scene) -> Any:
    """The branched scene by hand, joints in another order, with every joint type that Pinocchio writes its own way."""
    pin = pytest.importorskip("pinocchio")
    kinds = {
        "base": pin.JointModelFreeFlyer(),
        "turn": pin.JointModelRUBY(),
        "slide": pin.JointModelPX(),
        "plane": pin.JointModelPlanar(),
        "ball": pin.JointModelSpherical(),
        "cross": composite(pin, pin.JointModelRX(), pin.JointModelRY()),
        "sleeve": composite(pin, pin.JointModelRZ(), pin.JointModelPZ()),
    }
    model, indices = pin.Model(), {"ground": 0}
    for name in ("base", "plane", "ball", "slide", "cross", "turn", "sleeve"):
        joint = scene.joint(name)
        body = scene.body(joint.child)
        index = model.addJoint(indices[joint.parent], kinds[name], se3(pin, joint.origin), name)
        xx, yy, zz, xy, xz, yz = (float(x) for x in body.inertia)
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        model.appendBodyToJoint(index, pin.Inertia(float(body.mass), vector(body.com), inertia), pin.SE3.Identity())
        indices[joint.child] = index
    model.gravity.linear = vector(scene.gravity)
    return model


def composite(pin: Any, *parts: Any) -> Any:
    joint = pin.JointModelComposite()
    for part in parts:
        joint.addJoint(part)
    return joint


def vector(values: Any) -> Array:
    return np.array([float(x) for x in values])


def se3(pin: Any, origin: Any) -> Any:
    return pin.SE3(np.array([[float(x) for x in row] for row in origin.rotation]), vector(origin.translation))


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_every_joint_type_of_pinocchio(convention: str) -> None:
    pin = pytest.importorskip("pinocchio")
    scene = branched_scene()
    system, model = in_convention(scene, convention), pinocchio_of(scene)
    data = model.createData()

    def inverse(q: Array, v: Array, a: Array) -> Array:
        return np.array(pin.rnea(model, data, q, v, a))

    same_dynamics(system, to_pinocchio(system, model), from_pinocchio(system, model), inverse)
    consistent(system, to_pinocchio(system, model), lambda a, b: np.array(pin.difference(model, a, b)))


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("with_mimic", [False, True])
def test_a_floating_branched_urdf(tmp_path: Path, convention: str, with_mimic: bool) -> None:
    """Pinocchio's own reader sorts joints, calls the base root_joint, and makes (cos, sin) of continuous joints; a
    mimic joint has coordinates of its own there unless it is asked to have none."""
    pin = pytest.importorskip("pinocchio")
    path = tmp_path / "r.urdf"
    path.write_text(URDF)
    (tmp_path / "s.yaml").write_text("name: s\nmodel: r.urdf\nbase: floating\n")
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer(), with_mimic)
    data = model.createData()
    system = in_convention(load(tmp_path / "s.yaml"), convention)
    to, back = to_pinocchio(system, model), from_pinocchio(system, model)
    assert model.nv - system.tree.nv == (0 if with_mimic else 1)
    assert [slot.name for slot in to.target.slots][1:] != [body.joint.name for body in system.tree.bodies][1:]

    def inverse(q: Array, v: Array, a: Array) -> Array:
        return np.array(pin.rnea(model, data, q, v, a))

    if not with_mimic:
        same_dynamics(system, to, back, inverse)
    consistent(system, to, lambda a, b: np.array(pin.difference(model, a, b)))


# -- MuJoCo ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_mujoco(tmp_path: Path, convention: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    path = tmp_path / "r.xml"
    path.write_text(MJCF)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    system = in_convention(load(path), convention)

    def inverse(q: Array, v: Array, a: Array) -> Array:
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_inverse(model, data)
        return np.array(data.qfrc_inverse)

    def difference(a: Array, b: Array) -> Array:
        found = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, found, 1.0, a, b)
        return found

    to, back = to_mujoco(system, model), from_mujoco(system, model)
    same_dynamics(system, to, back, inverse)
    consistent(system, to, difference)


def test_positions_count_from_ref(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    path = tmp_path / "r.xml"
    path.write_text(MJCF)
    model = mujoco.MjModel.from_xml_path(str(path))
    system = derive(load(path))
    q = from_mujoco(system, model).q(model.qpos0)
    knee = next(body for body in system.tree.bodies if body.joint.name == "knee")
    assert model.qpos0[model.joint("knee").qposadr[0]] == 0.5
    assert q[knee.q] == 0.0


# -- what both are held to -------------------------------------------------------------------------------------------


def same_dynamics(
    system: System, to: Converter, back: Converter, inverse: Callable[[Array, Array, Array], Array]
) -> None:
    """inverse_dynamics is the engine's, and M = SᵀM_engine S with the columns of S from the converter."""
    for q, v, a in zip(*random_states(system, 3), strict=True):
        at = to.q(q)
        theirs = back.tau(at, inverse(at, to.v(q, v), to.a(q, v, a)))
        found = ours(system, "inverse_dynamics", q=q, v=v, a=a)
        assert np.abs(found - theirs).max() < 1e-12 * np.abs(theirs).max()
        S = np.stack([to.v(q, e) for e in np.eye(len(v))], -1)
        zero = np.zeros(len(at) and to.target.nv)
        rest = inverse(at, zero, zero)
        columns = np.stack([inverse(at, zero, e) - rest for e in np.eye(to.target.nv)], -1)
        M = ours(system, "mass_matrix", q=q)
        assert np.abs(S.T @ columns @ S - M).max() < 1e-11 * np.abs(M).max()


def consistent(system: System, to: Converter, difference: Callable[[Array, Array], Array]) -> None:
    """v is the rate of q and a that of v, as the engine subtracts positions; central differences."""
    h = 1e-5
    for q, v, a in zip(*random_states(system, 3), strict=True):
        before, after = (ours(system, "integrate", q=q, v=v, dt=dt) for dt in (-h, h))
        rate = difference(to.q(before), to.q(after)) / (2 * h)
        assert np.abs(rate - to.v(q, v)).max() < 1e-8
        speeds = [to.v(at, v + dt * a) for at, dt in ((before, -h), (after, h))]
        assert np.abs((speeds[1] - speeds[0]) / (2 * h) - to.a(q, v, a)).max() < 1e-7
