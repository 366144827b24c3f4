"""Frames by one walk from the frame to the root, in the axes of each link on the way.

The walk carries the frame's place and motion as seen from the link; a step adds the link's own joint and turns all of
it to the parent's axes. Nothing that is not on the way is computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import IDENTITY, ZERO, Mat, Vec, cross, matvec, mul, scale, sub, transpose, vadd, vsub
from symgen.plans import free
from symgen.plans.walk import BALL, FREE, SLIDE, Links, Moving

Scalar = Any


@dataclass(frozen=True)
class Place:
    """A frame: the last link of its body, and its origin in that link's axes. ``at`` is None in ground."""

    at: Moving | None
    origin: Vec


def place(links: Links, frame: str) -> Place:
    """Where a body's or a scene's frame is."""
    home, _, translation = links.values.frame(links.tree, frame)
    at = next((at for at in links.moving if at.link.body == home and at.link.carries), None)
    return Place(at, translation if at is None else to_link_frame(links, at, translation))


def to_link_frame(links: Links, at: Moving, local: Vec) -> Vec:
    """A point of the body's frame in the axes of its last link."""
    axes, shift = links.values.matrix(at.link.axes), links.values.vector(at.link.shift)
    return matvec(transpose(axes), vsub(local, shift))


@dataclass(frozen=True)
class Seen:
    """The frame from a link: place p, velocity u and acceleration c of its origin, angular velocity w and its rate."""

    p: Vec
    u: Vec = ZERO
    w: Vec = ZERO
    c: Vec = ZERO
    w_rate: Vec = ZERO


def _turning(seen: Seen, s: Vec) -> Seen:
    """Seen from axes in which the link turns with s (its rate zero)."""
    u = vadd(seen.u, cross(s, seen.p))
    c = vadd(seen.c, cross(s, vadd(seen.u, u)))
    return Seen(seen.p, u, vadd(seen.w, s), c, vadd(seen.w_rate, cross(s, seen.w)))


def _step(links: Links, at: Moving, seen: Seen, v: Sequence[Scalar]) -> Seen:
    """The link's own motion added; still in link axes."""
    rate = tuple(v[at.link.v : at.link.v + at.link.nv])
    if at.link.kind == FREE:
        convention = links.values.scene.options.base_velocity
        linear, w = free.velocity(at, rate, convention)
        acceleration, w_rate = free.acceleration(at, linear, w, (0,) * 6, convention)
        seen = _turning(seen, w)
        c = vadd(vadd(seen.c, acceleration), cross(w_rate, seen.p))
        return Seen(seen.p, vadd(seen.u, linear), seen.w, c, vadd(seen.w_rate, w_rate))
    if at.link.kind == BALL:
        return _turning(seen, rate)
    if at.link.kind != SLIDE:
        seen = _turning(seen, (0, 0, mul(at.angular, rate[0])))
    return Seen(seen.p, vadd(seen.u, (0, 0, mul(at.linear, rate[0]))), seen.w, seen.c, seen.w_rate)


def _up(at: Moving, seen: Seen, second: bool) -> Seen:
    """The same in the parent's axes, from the parent's origin."""
    p, u, w = vadd(at.offset, at.to_parent(seen.p)), at.to_parent(seen.u), at.to_parent(seen.w)
    return Seen(p, u, w, at.to_parent(seen.c), at.to_parent(seen.w_rate)) if second else Seen(p, u, w)


def _walk(links: Links, frame: str, v: Sequence[Scalar], second: bool) -> Seen:
    start = place(links, frame)
    seen = Seen(start.origin)
    if start.at is None:
        return seen
    for at in (start.at, *links.ancestors(start.at)):
        with links.phase(f"frame seen from the parent of {at.link.name}"):
            moved = _step(links, at, seen, v)
            seen = _up(at, moved if second else Seen(moved.p, moved.u, moved.w), second)
    return seen


def frame_velocity(links: Links, frame: str, v: Sequence[Scalar]) -> Vec:
    """Velocity of the frame's origin, then angular velocity (6), ground axes."""
    seen = _walk(links, frame, v, second=False)
    return (*seen.u, *seen.w)


def frame_bias_acceleration(links: Links, frame: str, v: Sequence[Scalar]) -> Vec:
    """Acceleration of the frame's origin and angular acceleration (6) when all joint accelerations are zero."""
    seen = _walk(links, frame, v, second=True)
    return (*seen.c, *seen.w_rate)


# --- rotations to ground ----------------------------------------------------------------------------------------


def ground_axes(at: Moving, parent: Mat) -> Mat:
    """Columns of a link's axes in ground axes, from its parent's columns."""
    if at.whole is not None:
        return tuple(_combined(parent, column) for column in transpose(at.whole))
    x, y, z = (_combined(parent, column) for column in transpose(at.turn))
    if at.link.kind == SLIDE:
        return (x, y, z)
    c, s = at.c, at.s
    return (vadd(scale(c, x), scale(s, y)), vsub(scale(c, y), scale(s, x)), z)


def _combined(columns: Mat, weights: Vec) -> Vec:
    found: Vec = ZERO
    for column, weight in zip(columns, weights, strict=True):
        found = vadd(found, scale(weight, column))
    return found


def in_ground(columns: Mat, x: Vec) -> Vec:
    """A vector of link axes in ground axes."""
    return _combined(columns, x)


def rotations(links: Links, wanted: Sequence[Moving]) -> dict[int, Mat]:
    """Columns of the axes of these links, parents before children among them, in ground axes."""
    found: dict[int, Mat] = {}
    for at in wanted:
        with links.phase(f"axes: {at.link.name}"):
            found[at.link.index] = ground_axes(at, found.get(at.link.parent, IDENTITY))
    return found


def frame_jacobian(links: Links, frame: str) -> list[list[Scalar]]:
    """J (6, joint velocities): per joint on the way, the frame's motion in link axes, turned to ground."""
    rows: list[list[Scalar]] = [[0] * links.nv for _ in range(6)]
    start = place(links, frame)
    if start.at is None:
        return rows
    path = (start.at, *links.ancestors(start.at))
    axes, p = rotations(links, tuple(reversed(path))), start.origin
    for at in path:
        with links.phase(f"columns of {at.link.name}"):
            for k, (linear, angular) in enumerate(_columns(links, at, axes[at.link.index], p)):
                for i in range(3):
                    rows[i][at.link.v + k], rows[3 + i][at.link.v + k] = linear[i], angular[i]
            p = vadd(at.offset, at.to_parent(p))
    return rows


def _columns(links: Links, at: Moving, axes: Mat, p: Vec) -> list[tuple[Vec, Vec]]:
    """(linear, angular) of every velocity of a link, ground axes; p is the frame's place in link axes."""
    if at.link.kind not in (BALL, FREE):
        z, turned = axes[2], (mul(at.angular, sub(0, p[1])), mul(at.angular, p[0]), at.linear)
        return [(in_ground(axes, turned), scale(at.angular, z))]
    convention = links.values.scene.options.base_velocity
    if at.link.kind == FREE and convention == "world":
        arm = in_ground(axes, p)
        return [(axis, ZERO) for axis in IDENTITY] + [(cross(axis, arm), axis) for axis in IDENTITY]
    own = [(in_ground(axes, cross(axis, p)), column) for axis, column in zip(IDENTITY, axes, strict=True)]
    if at.link.kind == BALL:
        return own
    return [(axis, ZERO) for axis in (axes if convention == "body" else IDENTITY)] + own
