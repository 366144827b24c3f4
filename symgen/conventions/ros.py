"""States as ROS writes them: joint names and numbers, the base's pose and twist apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from symgen.conventions.converter import Converter
from symgen.conventions.layouts import Follower, Layout, symgen_layout
from symgen.conventions.quaternions import Array
from symgen.conventions.slots import Slot
from symgen.errors import NotSupportedError, SceneError
from symgen.system import System


@dataclass(frozen=True)
class Base:
    """Pose of a floating base in ground, and its twist in base axes (as nav_msgs/Odometry has it)."""

    position: Array
    """m, (3,) or (N, 3)"""
    orientation: Array
    """Quaternion x y z w"""
    linear: Array | None = None
    """m/s"""
    angular: Array | None = None
    """rad/s"""


@dataclass(frozen=True)
class JointState:
    """As sensor_msgs/JointState: one number per name, arrays (n,) or (N, n). Mimic joints are among them."""

    name: tuple[str, ...]
    position: Array
    velocity: Array | None = None
    effort: Array | None = None
    base: Base | None = None


def to_ros(system: System, q: ArrayLike, v: ArrayLike | None = None, tau: ArrayLike | None = None) -> JointState:
    """The state in ROS's terms. A force on the floating base has no place there and is left out.

    Raises NotSupportedError for joints with several coordinates other than one floating base.
    """
    ours, followers = symgen_layout(system)
    layout, names = _layout(ours, followers)
    convert = Converter(ours, layout, followers)
    at = convert.q(q)
    speed = None if v is None else convert.v(q, v)
    force = None if tau is None else convert.tau(q, tau)
    first_q, first_v = layout.nq - len(names), layout.nv - len(names)
    base = None
    if first_q:
        linear, angular = (None, None) if speed is None else (speed[..., :3], speed[..., 3:6])
        base = Base(at[..., :3], at[..., 3:7], linear, angular)
    velocity, effort = (None if x is None else x[..., first_v:] for x in (speed, force))
    return JointState(names, at[..., first_q:], velocity, effort, base)


def from_ros(system: System, state: JointState) -> tuple[Array, Array | None, Array | None]:
    """(q, v, tau); v and tau are None where the state has none. Names that the scene does not have are left out.

    Raises SceneError when the state lacks a joint (a mimic joint may be missing) or the base.
    """
    ours, followers = symgen_layout(system)
    layout, names = _layout(ours, followers)
    places = {name: k for k, name in enumerate(state.name)}
    optional = {follower.name for follower in followers}
    missing = [name for name in names if name not in places and name not in optional]
    if missing:
        raise SceneError(f"the joint state lacks joint {missing[0]!r}")
    if layout.nq > len(names) and state.base is None:
        raise SceneError("the joint state lacks the pose of the base")
    here = tuple(slot for slot in layout.slots if slot.kind == "free" or slot.name in places)
    convert = Converter(Layout(layout.owner, layout.nq, layout.nv, here, layout.neutral), ours, followers)
    base = state.base
    q = _joined(names, places, state.position, None if base is None else (base.position, base.orientation))
    twist = None if base is None or base.linear is None or base.angular is None else (base.linear, base.angular)
    v = tau = None
    if state.velocity is not None and (base is None or twist is not None):
        v = convert.v(q, _joined(names, places, state.velocity, twist))
    if state.effort is not None:
        zero = None if base is None else (np.zeros_like(base.position), np.zeros_like(base.position))
        tau = convert.tau(q, _joined(names, places, state.effort, zero))
    return convert.q(q), v, tau


def _layout(ours: Layout, followers: tuple[Follower, ...]) -> tuple[Layout, tuple[str, ...]]:
    """Base first, then the joints in symgen's order, then the mimic joints; and the joints' names."""
    bases = [slot for slot in ours.slots if slot.kind == "free"]
    joints = [slot.name for slot in ours.slots if slot.common == "1 coordinates"]
    odd = [slot.name for slot in ours.slots if slot not in bases and slot.name not in joints]
    if odd or len(bases) > 1:
        name = odd[0] if odd else bases[1].name
        raise NotSupportedError(f"joint {name!r} has no place in a ROS JointState: it has several coordinates")
    names = (*joints, *(follower.name for follower in followers))
    q, v = 7 * len(bases), 6 * len(bases)
    slots = [Slot(slot.name, "free", 0, 0, axes="body") for slot in bases]
    slots += [Slot(name, "numbers", q + k, v + k) for k, name in enumerate(names)]
    return Layout("the ROS state", q + len(names), v + len(names), tuple(slots), np.zeros(q + len(names))), names


def _joined(names: tuple[str, ...], places: dict[str, int], values: Array, base: tuple[Array, Array] | None) -> Array:
    """One vector in the layout's order; zero for mimic joints that the state lacks."""
    given = np.asarray(values, dtype=float)
    columns = [given[..., places[name]] if name in places else np.zeros(given.shape[:-1]) for name in names]
    joints = np.stack(columns, -1) if columns else np.zeros((*given.shape[:-1], 0))
    return joints if base is None else np.concatenate([*base, joints], -1)
