"""Converters alone: there and back, batches, ROS states, and what they refuse. No engine is needed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from symgen.conventions import JointState, from_pinocchio, from_ros, to_pinocchio, to_ros
from symgen.conventions.quaternions import of_rotation, product, rotated, rotated_back
from symgen.errors import NotSupportedError, SceneError
from symgen.scene.load import load
from symgen.system import System, derive
from tests.conventions.robots import URDF, branched_scene
from tests.states import random_states

CONVENTIONS = ("world", "body", "mixed")

KINDS = {
    "plane": ("JointModelPlanar", 4, 3), "ball": ("JointModelSpherical", 4, 3), "turn": ("JointModelRUBZ", 2, 1),
    "slide": ("JointModelPX", 1, 1), "cross": ("JointModelUniversal", 2, 2), "sleeve": ("JointModelComposite", 2, 2),
    "root_joint": ("JointModelFreeFlyer", 7, 6),
}  # fmt: skip


def stand_in(names: tuple[str, ...] = tuple(KINDS)) -> Any:
    """Something with the parts of a Pinocchio model that say where its coordinates are."""
    joints, q, v = [None], 0, 0
    for name in names:
        kind, nq, nv = KINDS[name]
        joints.append(SimpleNamespace(shortname=lambda kind=kind: kind, idx_q=q, idx_v=v, nq=nq, nv=nv))
        q, v = q + nq, v + nv
    home = SimpleNamespace(rotation=np.eye(3), translation=np.zeros(3))
    return SimpleNamespace(
        njoints=len(joints), joints=joints, names=["universe", *names], nq=q, nv=v, jointPlacements=[home] * len(joints)
    )


def system_in(convention: str) -> System:
    scene = branched_scene()
    return derive(replace(scene, options=replace(scene.options, base_velocity=convention)))


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_there_and_back(convention: str) -> None:
    system, model = system_in(convention), stand_in()
    to, back = to_pinocchio(system, model), from_pinocchio(system, model)
    q, v, a = random_states(system, 6)
    tau = np.random.default_rng(3).normal(size=v.shape)
    at, speed, rate, force = to.q(q), to.v(q, v), to.a(q, v, a), to.tau(q, tau)
    assert at.shape == (6, model.nq)
    assert speed.shape == (6, model.nv)
    assert np.allclose(back.q(at), q, atol=1e-14)
    assert np.allclose(back.v(at, speed), v, atol=1e-14)
    assert np.allclose(back.a(at, speed, rate), a, atol=1e-13)
    assert np.allclose(back.tau(at, force), tau, atol=1e-14)
    assert np.allclose(np.sum(force * speed, -1), np.sum(tau * v, -1))  # the same power
    for k in range(6):  # one state at a time says the same
        assert np.array_equal(to.q(q[k]), at[k])
        assert np.allclose(to.a(q[k], v[k], a[k]), rate[k], atol=1e-15)


def test_more_axes_of_batches() -> None:
    system, model = system_in("world"), stand_in()
    to = to_pinocchio(system, model)
    q, v, _ = random_states(system, 6)
    assert np.array_equal(to.v(q.reshape(2, 3, -1), v.reshape(2, 3, -1)).reshape(6, -1), to.v(q, v))


def test_the_base_velocities_on_a_card() -> None:
    """The table of docs/conventions.md, on a base that is turned a quarter about z."""
    q = np.zeros(system_in("world").tree.nq)
    found = {}
    for convention in CONVENTIONS:
        scene = branched_scene()
        joints = tuple(replace(j, origin=type(j.origin)()) if j.name == "base" else j for j in scene.joints)
        options = replace(scene.options, base_velocity=convention)
        system = derive(replace(scene, joints=joints, options=options))
        base = next(body for body in system.tree.bodies if body.joint.name == "base")
        q[:] = 0.0
        for body in system.tree.bodies:
            if body.nq > body.nv:
                q[body.q + body.nq - 1] = 1.0
        q[base.q + 5 : base.q + 7] = np.sqrt(0.5)
        v = np.zeros(system.tree.nv)
        v[base.v], v[base.v + 3] = 1.0, 1.0
        found[convention] = to_pinocchio(system, stand_in()).v(q, v)[-6:]
    assert np.allclose(found["world"], [0, -1, 0, 0, -1, 0])
    assert np.allclose(found["body"], [1, 0, 0, 1, 0, 0])
    assert np.allclose(found["mixed"], [0, -1, 0, 1, 0, 0])


# -- joints that only one side has -----------------------------------------------------------------------------------


def test_what_is_refused() -> None:
    system = system_in("world")
    with pytest.raises(SceneError, match="joint 'ball' has no counterpart in the Pinocchio model: its joints are"):
        to_pinocchio(system, stand_in(tuple(name for name in KINDS if name != "ball")))
    model = stand_in()
    model.names = [{"ball": "slide", "slide": "ball"}.get(name, name) for name in model.names]
    with pytest.raises(SceneError, match="joint 'ball' has ball here and 1 coordinates in the Pinocchio model"):
        to_pinocchio(system, model)
    with pytest.raises(SceneError, match=r"q of symgen has 20 numbers, not the shape \(3,\)"):
        to_pinocchio(system, stand_in()).q([1, 2, 3])


def test_held_joints(tmp_path: Path) -> None:
    """A joint that the scene locks stands where held says, and is left out on the way back."""
    scene = branched_scene()
    slide = scene.joint("slide")
    joints = tuple(replace(j, type="fixed", axis=None) if j is slide else j for j in scene.joints)
    system, model = derive(replace(scene, joints=joints)), stand_in()
    with pytest.raises(SceneError, match="joint 'slide' of the Pinocchio model is not in the scene: say with held"):
        to_pinocchio(system, model)
    to = to_pinocchio(system, model, held={"slide": 0.25})
    q, v, _ = random_states(system, 2)
    place = model.joints[model.names.index("slide")]
    assert (to.q(q)[:, place.idx_q] == 0.25).all()
    assert (to.v(q, v)[:, place.idx_v] == 0).all()
    assert np.allclose(from_pinocchio(system, model).q(to.q(q)), q)


# -- mimic joints and ROS --------------------------------------------------------------------------------------------


@pytest.fixture
def robot(tmp_path: Path) -> System:
    (tmp_path / "r.urdf").write_text(URDF)
    (tmp_path / "s.yaml").write_text("name: s\nmodel: r.urdf\nbase: floating\n")
    return derive(load(tmp_path / "s.yaml"))


def test_ros_there_and_back(robot: System) -> None:
    q, v, _ = random_states(robot, 4)
    tau = np.random.default_rng(3).normal(size=v.shape)
    tau[:, :6] = 0.0  # a JointState has no place for a force on the base
    state = to_ros(robot, q, v, tau)
    assert state.name == ("zeta", "zulu", "alpha", "gamma", "beta")
    assert state.base is not None
    assert np.array_equal(state.base.position, q[:, :3])
    assert np.array_equal(state.base.orientation, q[:, 3:7])
    assert np.allclose(state.position[:, 4], -2 * state.position[:, 2] + 0.25)
    assert state.velocity is not None
    assert np.allclose(state.velocity[:, 4], -2 * state.velocity[:, 2])
    for given in (state, shuffled(state), without(state, "beta")):
        back = from_ros(robot, given)
        for found, wanted in zip(back, (q, v, tau), strict=True):
            assert found is not None
            assert np.allclose(found, wanted, atol=1e-14)
    assert from_ros(robot, to_ros(robot, q[0]))[1:] == (None, None)


def shuffled(state: JointState) -> JointState:
    """Another order, and a joint that nobody knows."""
    order = [3, 0, 4, 2, 1]
    more = np.ones((len(state.position), 1))
    parts = [
        None if x is None else np.hstack([x[:, order], more]) for x in (state.position, state.velocity, state.effort)
    ]
    assert parts[0] is not None
    return JointState((*(state.name[k] for k in order), "lid"), parts[0], parts[1], parts[2], state.base)


def without(state: JointState, name: str) -> JointState:
    kept = [k for k, other in enumerate(state.name) if other != name]
    parts = [None if x is None else x[:, kept] for x in (state.position, state.velocity, state.effort)]
    assert parts[0] is not None
    return JointState(tuple(state.name[k] for k in kept), parts[0], parts[1], parts[2], state.base)


def test_a_force_on_a_mimic_joint_acts_on_its_master(robot: System) -> None:
    q, _, _ = random_states(robot, 1)
    state = to_ros(robot, q[0])
    effort = np.array([0.0, 0.0, 10.0, 0.0, 1.0])  # alpha, beta
    _, _, tau = from_ros(robot, replace(state, effort=effort))
    assert tau is not None
    alpha = next(body for body in robot.tree.bodies if body.joint.name == "alpha")
    assert tau[alpha.v] == 10.0 - 2.0


def test_ros_refuses(robot: System) -> None:
    q, _, _ = random_states(robot, 1)
    state = to_ros(robot, q[0])
    with pytest.raises(SceneError, match="the joint state lacks joint 'zulu'"):
        from_ros(robot, JointState(("zeta", "alpha"), np.zeros(2), base=state.base))
    with pytest.raises(SceneError, match="lacks the pose of the base"):
        from_ros(robot, replace(state, base=None))
    with pytest.raises(NotSupportedError, match="joint 'sleeve' has no place in a ROS JointState"):
        to_ros(system_in("world"), np.zeros(20))


def test_quaternions() -> None:
    rng = np.random.default_rng(0)
    for q, r, u in zip(rng.normal(size=(20, 4)), rng.normal(size=(20, 4)), rng.normal(size=(20, 3)), strict=True):
        assert np.allclose(rotated(product(q, r), u), rotated(q, rotated(r, u)))
        assert np.allclose(rotated_back(q, rotated(q, u)), u)
        matrix = np.stack([rotated(q, e) for e in np.eye(3)], -1)
        found = of_rotation(matrix)
        assert np.allclose(found * np.sign(found @ q), q / np.linalg.norm(q))
