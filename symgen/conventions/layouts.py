"""Where each side has a robot's joints in its q and v."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symgen.conventions.quaternions import Array, of_rotation
from symgen.conventions.slots import WXYZ, Slot
from symgen.errors import NotSupportedError
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.mjcf_names import body_names, joint_names
from symgen.system import System


@dataclass(frozen=True)
class Follower:
    """A mimic joint: its position is multiplier · (position of ``master``) + offset."""

    name: str
    master: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Layout:
    """How one side writes a state."""

    owner: str
    nq: int
    nv: int
    slots: tuple[Slot, ...]
    neutral: Array
    """q where nothing else says it: joints that are held."""


def symgen_layout(system: System) -> tuple[Layout, tuple[Follower, ...]]:
    """The independent joints, and the mimic joints."""
    slots: list[Slot] = []
    followers: list[Follower] = []
    masters = {body.q: body.joint.name for body in system.tree.bodies if body.coupling is None}
    for body in system.tree.bodies:
        name, kind = body.joint.name, body.joint.type
        if body.coupling is not None:
            numbers = (float(body.coupling.multiplier), float(body.coupling.offset))
            followers.append(Follower(name, masters[body.q], *numbers))
        elif kind in ("spherical", "floating"):
            slot = Slot(name, "ball" if kind == "spherical" else "free", body.q, body.v)
            slots.append(slot if kind == "spherical" else _base(slot, system, body.joint.origin))
        else:
            slots.append(Slot(name, "numbers", body.q, body.v, JOINT_TYPES[kind].nq))
    layout = Layout("symgen", system.tree.nq, system.tree.nv, tuple(slots), np.zeros(system.tree.nq))
    return layout, tuple(followers)


def _base(slot: Slot, system: System, origin: Any) -> Slot:
    rotation = np.array([[float(x) for x in row] for row in origin.rotation])
    position = tuple(float(x) for x in origin.translation)
    axes = system.scene.options.base_velocity
    return replace(slot, axes=axes, position=position, quaternion=tuple(of_rotation(rotation).tolist()))


def pinocchio_layout(model: Any) -> Layout:
    """The joints of a ``pinocchio.Model``; its own mimic joints have no coordinates."""
    slots: list[Slot] = []
    for index in range(1, model.njoints):
        joint, name = model.joints[index], str(model.names[index])
        kind = str(joint.shortname())
        slot = Slot(name, "numbers", joint.idx_q, joint.idx_v, joint.nv)
        if "Mimic" in kind:  # moved by its master there too
            continue
        if "RUB" in kind or "RevoluteUnbounded" in kind:
            slot = replace(slot, kind="circle")
        elif kind == "JointModelPlanar":
            slot = replace(slot, kind="plane")
        elif kind == "JointModelSpherical":
            slot = replace(slot, kind="ball")
        elif kind == "JointModelFreeFlyer":
            home = model.jointPlacements[index]
            turn = tuple(of_rotation(np.array(home.rotation)).tolist())
            slot = replace(slot, kind="free", axes="body", position=tuple(home.translation), quaternion=turn)
        elif joint.nq != joint.nv:
            raise NotSupportedError(f"joint {name!r} of the Pinocchio model is a {kind}, which symgen does not have")
        slots.append(slot)
    return Layout("the Pinocchio model", model.nq, model.nv, tuple(slots), np.zeros(model.nq))


MUJOCO_KINDS = ("free", "ball", "slide", "hinge")


def mujoco_layout(model: Any) -> Layout:
    """The joints of a ``mujoco.MjModel``, by the names that symgen's reader gives them."""
    bodies = body_names([model.body(i).name for i in range(model.nbody)])
    kinds = [MUJOCO_KINDS[kind] for kind in model.jnt_type]
    owners = [bodies[body] for body in model.jnt_bodyid]
    names = joint_names([model.joint(i).name for i in range(model.njnt)], kinds, owners)
    slots: list[Slot] = []
    for i, (name, kind) in enumerate(zip(names, kinds, strict=True)):
        q, v = int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i])
        if kind in ("free", "ball"):
            slots.append(Slot(name, kind, q, v, order=WXYZ))
        else:
            slots.append(Slot(name, "numbers", q, v, offset=float(model.qpos0[q])))
    return Layout("the MuJoCo model", model.nq, model.nv, tuple(slots), np.array(model.qpos0))
