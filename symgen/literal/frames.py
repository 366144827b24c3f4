"""Frames, centre of mass and momentum in ground axes: the definitions of these catalogue rows, over any number type.

A body is carried by its frame's origin and its three axes (natural coordinates with W = 1; theory, §2): the field of
velocities or accelerations over it is linear in the values there, and its mass matrix is the pseudo-inertia P. So
momenta are P-weighted sums over the four, of the rates that R gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from symgen.algebra.linear import (
    ZERO,
    Mat,
    Vec,
    add,
    cross,
    is_zero,
    known_value,
    scale,
    total,
    transpose,
    vadd,
    vsub,
)
from symgen.errors import SceneError
from symgen.natural.mass import pseudo_inertia
from symgen.velocity import kinematics as motion

if TYPE_CHECKING:
    from symgen.literal.equations import Literal

Scalar = Any
Field = tuple[Vec, Vec, Vec, Vec]
"""A field over a body at its origin and its three axes (derivatives of natural coordinates), ground axes."""


def carriers(literal: Literal, body: int) -> Field:
    """The body's origin and axes themselves."""
    pose = literal.at.poses[body]
    x, y, z = transpose(pose.rotation)
    return pose.origin, x, y, z


def velocity_field(literal: Literal, body: int, twist: motion.Twist) -> Field:
    """R v at the carriers: ṙ and ω × each axis."""
    _, x, y, z = carriers(literal, body)
    return twist.linear, cross(twist.angular, x), cross(twist.angular, y), cross(twist.angular, z)


def pseudo(literal: Literal, body: int) -> Mat:
    """P of a moving body with all that is welded to it, about its frame's origin."""
    known = literal.pseudo_inertias
    if body not in known:
        found = literal.tree.bodies[body]
        known[body] = pseudo_inertia(found.parts, literal.values, found.welds)
    return known[body]


def weigh(p: Mat, field: Field) -> Field:
    """P times a field: what the mass makes of it at the carriers."""
    rows = []
    for row in p:
        value: Vec = ZERO
        for entry, rate in zip(row, field, strict=True):
            value = vadd(value, scale(entry, rate))
        rows.append(value)
    return rows[0], rows[1], rows[2], rows[3]


def resultant(places: Field, weighed: Field) -> tuple[Vec, Vec]:
    """Sum of a weighed field over a body and its moment about the ground's origin: Σ x_α × y_α."""
    moment: Vec = ZERO
    for place, value in zip(places, weighed, strict=True):
        moment = vadd(moment, cross(place, value))
    return weighed[0], moment


# --- mass --------------------------------------------------------------------------------------------------------


def total_mass(literal: Literal) -> Scalar:
    """Mass of all moving bodies. Raises SceneError where they have none."""
    mass = total(pseudo(literal, body.index)[0][0] for body in literal.tree.bodies)
    if known_value(mass) == 0:
        scene = literal.values.scene
        raise SceneError("no moving body has mass, so that there is no centre of mass", scene.source or scene.name)
    return mass


def center_of_mass(literal: Literal) -> Vec:
    """Centre of mass of all moving bodies (3, m), ground axes. Raises SceneError where they have no mass."""
    first: Vec = ZERO
    for body in literal.tree.bodies:
        row = pseudo(literal, body.index)[0]
        for entry, carrier in zip(row, carriers(literal, body.index), strict=True):
            first = vadd(first, scale(entry, carrier))
    mass = total_mass(literal)
    return tuple(0 if is_zero(x) else x / mass for x in first)


def momentum_of(literal: Literal, v: Sequence[Scalar]) -> Vec:
    """Linear momentum and angular momentum about the centre of mass (6) at joint velocities v, ground axes."""
    twists = motion.twists(literal.at, v)
    linear, angular = ZERO, ZERO
    for body in literal.tree.bodies:
        field = velocity_field(literal, body.index, twists[body.index])
        force, moment = resultant(carriers(literal, body.index), weigh(pseudo(literal, body.index), field))
        linear, angular = vadd(linear, force), vadd(angular, moment)
    return (*linear, *vsub(angular, cross(center_of_mass(literal), linear)))


def momentum(literal: Literal) -> Vec:
    """Momentum (6) at the state's velocities."""
    return momentum_of(literal, literal.state.v)


def momentum_matrix(literal: Literal) -> Mat:
    """A (6, nv) with momentum = A v."""
    return _by_columns(literal, momentum_of)


def _by_columns(literal: Literal, times: Any) -> Mat:
    nv = literal.tree.nv
    columns = [times(literal, [1 if i == j else 0 for i in range(nv)]) for j in range(nv)]
    return tuple(tuple(column[i] for column in columns) for i in range(6))


# --- frames -----------------------------------------------------------------------------------------------------


def place(literal: Literal, frame: str) -> tuple[int, Vec]:
    """The tree body a frame is fixed in (−1: ground) and its origin in ground axes."""
    home, _, translation = literal.values.frame(literal.tree, frame)
    return home, literal.at.pose(home).point(translation)


def twist_of(literal: Literal, frame: str, v: Sequence[Scalar]) -> Vec:
    """Velocity of a frame's origin, then angular velocity (6), ground axes, at joint velocities v."""
    home, origin = place(literal, frame)
    if home < 0:
        return (0,) * 6
    twists = motion.twists(literal.at, v)
    return (*motion.point_velocity(literal.at, twists, home, origin), *twists[home].angular)


def frame_velocity(literal: Literal, frame: str) -> Vec:
    """Twist (6) at the state's velocities."""
    return twist_of(literal, frame, literal.state.v)


def frame_jacobian(literal: Literal, frame: str) -> Mat:
    """J (6, nv) with frame_velocity = J v: v + w × d and w of every column of the joints on the path."""
    home, origin = place(literal, frame)
    rows: list[list[Scalar]] = [[0] * literal.tree.nv for _ in range(6)]
    linear = motion.point_columns(literal.at, home, origin)
    for j in literal.tree.path(home):
        for k, column in enumerate(literal.at.motions[j].columns):
            index = literal.tree.bodies[j].v + k
            for i in range(3):
                rows[i][index] = linear[index][i]
                rows[3 + i][index] = add(rows[3 + i][index], column.w[i])
    return tuple(tuple(row) for row in rows)


def frame_bias_acceleration(literal: Literal, frame: str) -> Vec:
    """Acceleration of a frame's origin and angular acceleration (6) when θ̈ = 0: J̇ v, ground axes."""
    home, origin = place(literal, frame)
    if home < 0:
        return (0,) * 6
    bias = motion.bias_accelerations(literal.at, literal.twists, literal.state.v)
    return (*motion.point_bias(literal.at, literal.twists, bias, home, origin), *bias[home].angular)
