"""How a joint's numbers are written: to a common spelling, and from it.

The common spelling is symgen's, with a free joint's velocity as in ``base_velocity: mixed`` (linear in ground axes,
angular in the child's).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symgen.conventions.quaternions import Array, product, rotated, rotated_back

XYZW, WXYZ = (0, 1, 2, 3), (3, 0, 1, 2)
"""Where x y z w stand in a quaternion."""


@dataclass(frozen=True)
class Slot:
    """How one side writes one joint.

    ``kind``: numbers (``size`` coordinates whose rates are the velocities), circle (cos, sin of one angle), plane
    (x, y, cos, sin; velocity in the child's axes), ball, free. Lengths in q and v follow from it.
    """

    name: str
    kind: str
    q: int
    v: int
    size: int = 1
    offset: float = 0.0
    """A number here is that much more than symgen's."""
    order: tuple[int, ...] = XYZW
    axes: str = "mixed"
    """Of a free joint's velocity: world, body or mixed, as in ``base_velocity``."""
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    quaternion: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)
    """Pose in ground of the frame that a free joint's position counts from."""

    @property
    def nq(self) -> int:
        return {"numbers": self.size, "circle": 2, "plane": 4, "ball": 4, "free": 7}[self.kind]

    @property
    def nv(self) -> int:
        return {"numbers": self.size, "circle": 1, "plane": 3, "ball": 3, "free": 6}[self.kind]

    @property
    def common(self) -> str:
        """What both sides must agree on: the kind without its spelling."""
        numbers = {"numbers": self.size, "circle": 1, "plane": 3}
        return f"{numbers[self.kind]} coordinates" if self.kind in numbers else self.kind


def read_q(slot: Slot, q: Array) -> Array:
    part = q[..., slot.q : slot.q + slot.nq]
    match slot.kind:
        case "circle":
            return np.arctan2(part[..., 1], part[..., 0])[..., None]
        case "plane":
            return np.concatenate([part[..., :2], np.arctan2(part[..., 3], part[..., 2])[..., None]], -1)
        case "ball":
            return part[..., np.argsort(slot.order)]
        case "free":
            turn = np.asarray(slot.quaternion)
            place = rotated(turn, part[..., :3]) + np.asarray(slot.position)
            return np.concatenate([place, product(turn, part[..., 3:][..., np.argsort(slot.order)])], -1)
    return part - slot.offset


def write_q(slot: Slot, common: Array) -> Array:
    match slot.kind:
        case "circle":
            return np.concatenate([np.cos(common), np.sin(common)], -1)
        case "plane":
            return np.concatenate([common[..., :2], np.cos(common[..., 2:]), np.sin(common[..., 2:])], -1)
        case "ball":
            return common[..., slot.order]
        case "free":
            turn = np.asarray(slot.quaternion)
            place = rotated_back(turn, common[..., :3] - np.asarray(slot.position))
            back = np.concatenate([-turn[:3], turn[3:]])
            return np.concatenate([place, product(back, common[..., 3:])[..., slot.order]], -1)
    return common + slot.offset


def _turn(slot: Slot, q: Array) -> Array:
    """Quaternion that takes a velocity's linear part from the child's axes to the common ones."""
    if slot.kind == "free":
        return q[..., 3:]
    half = q[..., 2:] / 2
    return np.concatenate([np.zeros_like(half), np.zeros_like(half), np.sin(half), np.cos(half)], -1)


def _spin(slot: Slot, common: Array) -> Array:
    """Angular velocity in the child's axes, from a velocity in the common spelling."""
    if slot.kind == "free":
        return common[..., 3:]
    return np.concatenate([np.zeros_like(common[..., :2]), common[..., 2:]], -1)


def _linear(slot: Slot, part: Array) -> Array:
    """The linear part as three components."""
    return part[..., :3] if slot.kind == "free" else np.concatenate([part[..., :2], np.zeros_like(part[..., :1])], -1)


def _with_linear(slot: Slot, part: Array, linear: Array) -> Array:
    n = 3 if slot.kind == "free" else 2
    return np.concatenate([linear[..., :n], part[..., n:]], -1)


def _child_axes(slot: Slot) -> bool:
    return slot.kind == "plane" or (slot.kind == "free" and slot.axes == "body")


def _ground_spin(slot: Slot) -> bool:
    return slot.kind == "free" and slot.axes == "world"


def read_v(slot: Slot, q: Array, part: Array) -> Array:
    """Velocity (or force: all these maps are orthogonal) to the common spelling; ``q`` in the common spelling."""
    if _child_axes(slot):
        part = _with_linear(slot, part, rotated(_turn(slot, q), _linear(slot, part)))
    if _ground_spin(slot):
        part = np.concatenate([part[..., :3], rotated_back(q[..., 3:], part[..., 3:])], -1)
    return part


def write_v(slot: Slot, q: Array, common: Array) -> Array:
    if _ground_spin(slot):
        return np.concatenate([common[..., :3], rotated(q[..., 3:], common[..., 3:])], -1)
    if _child_axes(slot):
        return _with_linear(slot, common, rotated_back(_turn(slot, q), _linear(slot, common)))
    return common


def read_a(slot: Slot, q: Array, v: Array, part: Array) -> Array:
    """v in the common spelling. d/dt (R u) = R (u̇ + ω × u), with u and ω in the child's axes."""
    if _child_axes(slot):
        own = _linear(slot, write_v(slot, q, v))
        part = _with_linear(slot, part, _linear(slot, part) + np.cross(_spin(slot, v), own))
    return read_v(slot, q, part)  # and d/dt (Rᵀ ω) = Rᵀ ω̇


def write_a(slot: Slot, q: Array, v: Array, common: Array) -> Array:
    part = write_v(slot, q, common)
    if _child_axes(slot):
        own = _linear(slot, write_v(slot, q, v))
        part = _with_linear(slot, part, _linear(slot, part) - np.cross(_spin(slot, v), own))
    return part
