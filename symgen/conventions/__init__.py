"""q, v, a and forces carried between symgen and Pinocchio, MuJoCo and ROS.

    to = to_pinocchio(system, model)
    pinocchio.rnea(model, data, to.q(q), to.v(q, v), to.a(q, v, a))
    back = from_pinocchio(system, model)
    tau = back.tau(q_pin, tau_pin)

Joints are matched by name. What differs: the order of joints, quaternions (x y z w or w x y z), the axes of a floating
joint's velocity, (cos, sin) for the angle of Pinocchio's unbounded and planar joints, MuJoCo's ``ref``, and mimic
joints, which have coordinates of their own elsewhere. Every array may be one state (nq,) or many (N, nq).
docs/conventions.md has the same as a table.
"""

from __future__ import annotations

from typing import Any

from symgen.conventions.converter import Converter, Held, between
from symgen.conventions.layouts import mujoco_layout, pinocchio_layout
from symgen.conventions.ros import Base, JointState, from_ros, to_ros
from symgen.system import System

__all__ = [
    "Base", "Converter", "Held", "JointState", "from_mujoco", "from_pinocchio", "from_ros", "to_mujoco",
    "to_pinocchio", "to_ros",
]  # fmt: skip


def to_pinocchio(system: System, model: Any, held: Held | None = None) -> Converter:
    """From symgen to a ``pinocchio.Model`` of the same robot.

    ``held`` gives positions (in Pinocchio's numbers) of joints that the scene locks. Raises SceneError when a joint
    has no counterpart.
    """
    return between(system, pinocchio_layout(model), held, forward=True)


def from_pinocchio(system: System, model: Any) -> Converter:
    """From a ``pinocchio.Model`` to symgen; joints that only the model has are left out."""
    return between(system, pinocchio_layout(model), {}, forward=False)


def to_mujoco(system: System, model: Any, held: Held | None = None) -> Converter:
    """From symgen to a ``mujoco.MjModel`` of the same robot; arguments as in `to_pinocchio`."""
    return between(system, mujoco_layout(model), held, forward=True)


def from_mujoco(system: System, model: Any) -> Converter:
    """From a ``mujoco.MjModel`` to symgen; joints that only the model has are left out."""
    return between(system, mujoco_layout(model), {}, forward=False)
