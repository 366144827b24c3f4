"""Analytic plan of the derivatives of inverse dynamics, in body axes.

Moving joint j by δφ changes the accelerations of everything beyond it by a field a + ẇ × x + w × ẏ (see
`symgen.plans.fields`): with δω, δω̇, δa the changes of the link's own motion as seen in its axes, w = 2δω and
ẇ = δω̇ + ω × δω. The 2 is put into ẏ: composites are made of twice the velocities, and w is δω here. Nothing is
differentiated twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import IDENTITY, ZERO, Vec, cross, matvec, mul, scale, sub, vadd, vsub
from symgen.plans import free
from symgen.plans.composite import composite_inertias, motions, project
from symgen.plans.fields import Field, Wrench, carried_functional, carried_wrench, composites
from symgen.plans.recursive import Motion, link_motions, transmitted_wrenches
from symgen.plans.walk import BALL, FREE, Links, Moving

Scalar = Any
Matrix = list[list[Scalar]]


@dataclass(frozen=True)
class Variation:
    """What moving along one velocity of a joint changes: ``position`` and ``velocity`` fields of the links beyond it,
    and the turn and the shift of its own axes, by which the wrench it transmits turns and shifts."""

    position: Field
    velocity: Field
    turn: Vec = ZERO
    shift: Vec = ZERO


def _u_times(w: Vec, w_rate: Vec, c: Vec) -> Vec:
    """(ω̇̃ + ω̃ω̃) c."""
    return vadd(cross(w_rate, c), cross(w, cross(w, c)))


def variations(
    links: Links, at: Moving, motion_of: Sequence[Motion], v: Sequence[Scalar], gravity: Vec
) -> list[Variation]:
    """One per velocity of the link's joint."""
    link, motion = at.link, motion_of[at.link.index]
    if link.kind == FREE:
        return _free_variations(at, motion, v[link.v : link.v + 6], gravity, links.values.scene.options.base_velocity)
    root = Motion(ZERO, ZERO, (ZERO, ZERO, ZERO), ZERO, tuple(sub(0, g) for g in gravity))
    parent = motion_of[link.parent] if link.parent >= 0 else root
    if link.kind == BALL:
        carried, carried_rate = at.to_link(parent.w), at.to_link(parent.w_rate)
        found = []
        for c in IDENTITY:
            turning = cross(carried, c)
            position = Field(cross(motion.a, c), _u_times(carried, carried_rate, c), turning)
            velocity = Field(ZERO, vadd(turning, cross(motion.w, c)), c)
            found.append(Variation(position, velocity, c))
        return found
    z: Vec = (0, 0, 1)
    turning = cross(motion.w, z)
    psi = scale(2, turning)
    s = tuple(row[2] for row in motion.u)  # z is fixed in the link and in its parent: how it accelerates is one thing
    if at.angular == 0:
        return [Variation(Field(scale(at.linear, s)), Field(scale(at.linear, psi)), ZERO, (0, 0, at.linear))]
    if at.linear == 0:
        return [Variation(Field(cross(motion.a, z), s, turning), Field(ZERO, psi, z), z)]
    # A screw: the acceleration of the origin is carried by the parent, and by its own travel.
    base = at.to_link(vadd(parent.a, matvec(parent.u, at.offset)))
    travel = cross(psi, (0, 0, mul(at.linear, v[link.v])))
    position = Field(vadd(vadd(cross(base, z), scale(at.linear, s)), travel), s, turning)
    return [Variation(position, Field(scale(at.linear, psi), psi, z), z, (0, 0, at.linear))]


def _free_variations(
    at: Moving, motion: Motion, rate: Sequence[Scalar], gravity: Vec, convention: str
) -> list[Variation]:
    """Where a free link is changes nothing, how it is turned does; its velocities enter as their axes say."""
    linear, _ = free.velocity(at, tuple(rate), convention)
    found = []
    for axis in IDENTITY:
        rotating = Field(cross(motion.w, axis)) if convention == "body" else Field()
        found.append(Variation(Field(), rotating))
    for axis in IDENTITY:
        c = at.to_link(axis) if convention == "world" else axis
        turning = cross(motion.w, c)
        if convention == "body":
            weight = at.to_link(tuple(sub(0, g) for g in gravity))
            found.append(Variation(Field(cross(weight, c)), Field(cross(c, linear), turning, c), c))
        elif convention == "mixed":
            found.append(Variation(Field(cross(motion.a, c)), Field(ZERO, turning, c), c))
        else:
            position = Field(cross(motion.a, c), _u_times(motion.w, motion.w_rate, c), turning)
            found.append(Variation(position, Field(ZERO, turning, c), c))
    return found


def _relieved(at: Moving, field: Field, convention: str) -> tuple[Field, Vec]:
    """A field less what accelerations of the link's own joint make of it, and these accelerations."""
    if at.link.kind == FREE:
        return Field(w=field.w), free.generalised_force(at, field.a, field.w_rate, convention)
    if at.link.kind == BALL:
        return Field(field.a, ZERO, field.w), field.w_rate
    own = field.w_rate[2] if at.angular != 0 else field.a[2]
    a, w_rate = (vsub(x, (0, 0, mul(part, own))) for x, part in ((field.a, at.linear), (field.w_rate, at.angular)))
    return Field(a, w_rate, field.w), (own,)


@dataclass(frozen=True)
class Derivatives:
    """∂τ/∂q (tangent) and ∂τ/∂v of all joints, without springs and damping, less mass_matrix (without armature) times
    ``undone_by_position`` and ``undone_by_velocity``: accelerations of a joint that alone undo part of the change."""

    by_position: Matrix
    by_velocity: Matrix
    undone_by_position: Matrix
    undone_by_velocity: Matrix


def inverse_dynamics_derivatives(
    links: Links, v: Sequence[Scalar], a: Sequence[Scalar], gravity: Vec, relieved: bool = False
) -> Derivatives:
    """All matrices are nv × nv; entries between branches are structural zeros. What can be undone is taken apart where
    ``relieved``: whoever solves for accelerations need not solve for that."""
    nv, convention = links.nv, links.values.scene.options.base_velocity
    link_motion = link_motions(links, v, a, gravity)
    wrenches = transmitted_wrenches(links, link_motion)
    spins, twice = [scale(2, motion.w) for motion in link_motion], scale(2, tuple(v))
    bodies = composites(links, composite_inertias(links), spins, twice)
    dq, dv, undone_q, undone_v = ([[0] * nv for _ in range(nv)] for _ in range(4))
    fields: list[list[Variation]] = []
    for at in links.moving:
        with links.phase(f"derivatives: fields of {at.link.name}"):
            found = variations(links, at, link_motion, v, gravity)
            for k, variation in enumerate(found if relieved else ()):
                position, own_position = _relieved(at, variation.position, convention)
                velocity, own_velocity = _relieved(at, variation.velocity, convention)
                found[k] = Variation(position, velocity, variation.turn, variation.shift)
                _write(undone_q, at.link.v, at.link.v + k, own_position)
                _write(undone_v, at.link.v, at.link.v + k, own_velocity)
            fields.append(found)
    for at in links.moving:
        with links.phase(f"derivatives: columns and rows of {at.link.name}"):
            body, start = bodies[at.link.index], at.link.v
            for k, variation in enumerate(fields[at.link.index]):
                change = body.wrench(variation.position)
                turned = _turned(variation, change, wrenches[at.link.index])
                _write(dq, start, start + k, _project_turned(at, change, turned, convention))
                _carry_column(links, at, start + k, turned, dq)
                change = body.wrench(variation.velocity)
                _write(dv, start, start + k, project(at, *change, convention))
                _carry_column(links, at, start + k, change, dv)
            if at.link.parent < 0:
                continue
            for k, motion in enumerate(motions(at, convention)):
                for above, functional in carried_functional(links, at, body.functional(*motion), spins, twice):
                    for j, variation in enumerate(fields[above.link.index]):
                        dq[start + k][above.link.v + j] = functional.of(variation.position)
                        dv[start + k][above.link.v + j] = functional.of(variation.velocity)
    return Derivatives(dq, dv, undone_q, undone_v)


def _turned(variation: Variation, change: Wrench, wrench: Wrench) -> Wrench:
    """The change of a transmitted wrench, its own turn and shift with the joint included."""
    force = vadd(change[0], cross(variation.turn, wrench[0]))
    moment = vadd(vadd(change[1], cross(variation.turn, wrench[1])), cross(variation.shift, wrench[0]))
    return force, moment


def _project_turned(at: Moving, fixed: Wrench, turned: Wrench, convention: str) -> Vec:
    """What a change of wrench asks of the joint itself: ``fixed`` where its axes move with the link, ``turned`` where
    they do not."""
    if at.link.kind != FREE:
        return project(at, *fixed, convention)
    force = fixed[0] if convention == "body" else turned[0]
    return project(at, force, turned[1] if convention == "world" else fixed[1], convention)


def _write(matrix: Matrix, row: int, column: int, values: Sequence[Scalar]) -> None:
    for i, value in enumerate(values):
        matrix[row + i][column] = value


def _carry_column(links: Links, at: Moving, column: int, wrench: Wrench, matrix: Matrix) -> None:
    """A change of the transmitted wrench, felt by every joint towards the root."""
    convention = links.values.scene.options.base_velocity
    for above, felt in carried_wrench(links, at, wrench):
        _write(matrix, above.link.v, column, project(above, *felt, convention))
