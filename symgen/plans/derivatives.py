"""Analytic plan of the derivatives of inverse dynamics, in body axes.

Moving joint j by δφ changes the accelerations of everything beyond it by a field a + ẇ × x + w × ẏ about the link's
origin (x place, ẏ velocity relative to the origin): with δω, δω̇, δa the changes of the link's own motion as seen in
its axes, w = 2δω and ẇ = δω̇ + ω × δω. The force that such a field asks of a composite body is linear in (a, ẇ, w)
with coefficients m, h, Σ, ∫ρẏ and ∫ρẏxᵀ. So one column of the derivative is one wrench carried to the root, and one row
is one functional of fields carried to the root; nothing is differentiated twice, and no field is carried outward
(compare Singh, Russell & Wensing 2022, who do the same with spatial vectors in ground axes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import (
    IDENTITY,
    ZERO,
    Mat,
    Vec,
    add,
    cross,
    dot,
    madd,
    matmul,
    matvec,
    mul,
    outer,
    scale,
    skew,
    sub,
    symmetric,
    vadd,
    vecmat,
)
from symgen.plans import free
from symgen.plans.composite import composite_inertias
from symgen.plans.inertia import Inertia, moment_of_inertia
from symgen.plans.recursive import Motion, link_motions, transmitted_wrenches
from symgen.plans.walk import BALL, FREE, Links, Moving

Scalar = Any
Matrix = list[list[Scalar]]
Wrench = tuple[Vec, Vec]
"""(force, moment about the link's origin), link axes."""


@dataclass(frozen=True)
class Field:
    """Change of acceleration a + ẇ × x + w × ẏ."""

    a: Vec = ZERO
    w_rate: Vec = ZERO
    w: Vec = ZERO


@dataclass(frozen=True)
class Variation:
    """What moving along one velocity of a joint changes: ``position`` and ``velocity`` fields of the links beyond it,
    and the turn and the shift of its own axes, by which the wrench it transmits turns and shifts."""

    position: Field
    velocity: Field
    turn: Vec = ZERO
    shift: Vec = ZERO


@dataclass(frozen=True)
class Functional:
    """A linear functional of fields: force · a + moment · ẇ + flow · w. Force and moment are a column of the mass
    matrix."""

    force: Vec
    moment: Vec
    flow: Vec

    def of(self, field: Field) -> Scalar:
        return add(add(dot(self.force, field.a), dot(self.moment, field.w_rate)), dot(self.flow, field.w))


@dataclass(frozen=True)
class Composite:
    """A link with everything beyond it: inertia, ∫ρẏ and ∫ρẏxᵀ about its origin, link axes."""

    inertia: Inertia
    flow: Vec
    stream: Mat

    def wrench(self, field: Field) -> Wrench:
        """f = m a + ẇ × h + w × ∫ρẏ; n = h × a + I ẇ + (tr B − B) w, B = ∫ρẏxᵀ."""
        h = self.inertia.first
        force = vadd(scale(self.inertia.mass, field.a), vadd(cross(field.w_rate, h), cross(field.w, self.flow)))
        turned = matvec(moment_of_inertia(self.inertia), field.w_rate)
        return force, vadd(vadd(cross(h, field.a), turned), matvec(self._spin(), field.w))

    def _spin(self) -> Mat:
        """tr B − B."""
        b = self.stream
        xx, yy, zz = b[0][0], b[1][1], b[2][2]
        return (
            (add(yy, zz), sub(0, b[0][1]), sub(0, b[0][2])),
            (sub(0, b[1][0]), add(xx, zz), sub(0, b[1][2])),
            (sub(0, b[2][0]), sub(0, b[2][1]), add(xx, yy)),
        )

    def functional(self, w: Vec, v: Vec) -> Functional:
        """What a joint with motion subspace (w, v) feels of a field: w · n + v · f."""
        h = self.inertia.first
        force = vadd(scale(self.inertia.mass, v), cross(w, h))
        moment = vadd(matvec(moment_of_inertia(self.inertia), w), cross(h, v))
        return Functional(force, moment, vadd(vecmat(w, self._spin()), cross(self.flow, v)))


def _relative_velocity(at: Moving, parent_w: Vec, rate: Sequence[Scalar]) -> Vec:
    """Velocity of a link's origin relative to its parent's origin, parent's axes."""
    u = cross(parent_w, at.offset)
    if at.linear != 0:
        u = vadd(u, at.to_parent((0, 0, mul(at.linear, rate[0]))))
    return u


def composites(links: Links, motions: Sequence[Motion], v: Sequence[Scalar]) -> list[Composite]:
    """Composite inertias with their velocity moments, from the leaves."""
    inertias = composite_inertias(links)
    start = [
        (cross(motion.w, inertia.first), matmul(skew(motion.w), symmetric(inertia.second)))
        for motion, inertia in zip(motions, links.inertias, strict=True)
    ]
    found = list(start)

    def step(at: Moving, here: tuple[Vec, Mat]) -> tuple[Vec, Mat]:
        found[at.link.index] = here
        if at.link.parent < 0:
            return here
        u = _relative_velocity(at, motions[at.link.parent].w, v[at.link.v : at.link.v + at.link.nv])
        inertia, flow = inertias[at.link.index], at.to_parent(here[0])
        moved = vadd(at.to_parent(inertia.first), scale(inertia.mass, at.offset))
        stream = madd(at.matrix_to_parent(here[1]), madd(outer(u, moved), outer(flow, at.offset)))
        return vadd(flow, scale(inertia.mass, u)), stream

    links.inward("velocity moments", start, step, lambda x, y: (vadd(x[0], y[0]), madd(x[1], y[1])))
    return [Composite(inertia, flow, stream) for inertia, (flow, stream) in zip(inertias, found, strict=True)]


def _u_times(w: Vec, w_rate: Vec, c: Vec) -> Vec:
    """(ω̇̃ + ω̃ω̃) c."""
    return vadd(cross(w_rate, c), cross(w, cross(w, c)))


def variations(
    links: Links, at: Moving, motions: Sequence[Motion], v: Sequence[Scalar], gravity: Vec
) -> list[Variation]:
    """One per velocity of the link's joint."""
    link, motion = at.link, motions[at.link.index]
    if link.kind == FREE:
        return _free_variations(at, motion, v[link.v : link.v + 6], gravity, links.values.scene.options.base_velocity)
    root = Motion(ZERO, ZERO, (ZERO, ZERO, ZERO), ZERO, tuple(sub(0, g) for g in gravity))
    parent = motions[link.parent] if link.parent >= 0 else root
    carried, carried_rate = at.to_link(parent.w), at.to_link(parent.w_rate)
    if link.kind == BALL:
        found = []
        for c in IDENTITY:
            turning = cross(carried, c)
            position = Field(cross(motion.a, c), _u_times(carried, carried_rate, c), scale(2, turning))
            velocity = Field(ZERO, vadd(turning, cross(motion.w, c)), scale(2, c))
            found.append(Variation(position, velocity, c))
        return found
    z: Vec = (0, 0, 1)
    psi = scale(2, cross(motion.w, z))
    s = _u_times(carried, carried_rate, z)
    if at.angular == 0:
        return [Variation(Field(scale(at.linear, s)), Field(scale(at.linear, psi)), ZERO, (0, 0, at.linear))]
    if at.linear == 0:
        return [Variation(Field(cross(motion.a, z), s, psi), Field(ZERO, psi, (0, 0, 2)), z)]
    # A screw: the acceleration of the origin is carried by the parent, and by its own travel.
    base = at.to_link(vadd(parent.a, matvec(parent.u, at.offset)))
    travel = cross(psi, (0, 0, mul(at.linear, v[link.v])))
    position = Field(vadd(vadd(cross(base, z), scale(at.linear, s)), travel), s, psi)
    return [Variation(position, Field(scale(at.linear, psi), psi, (0, 0, 2)), z, (0, 0, at.linear))]


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
            found.append(Variation(Field(cross(weight, c)), Field(cross(c, linear), turning, scale(2, c)), c))
        elif convention == "mixed":
            found.append(Variation(Field(cross(motion.a, c)), Field(ZERO, turning, scale(2, c)), c))
        else:
            position = Field(cross(motion.a, c), _u_times(motion.w, motion.w_rate, c), scale(2, turning))
            found.append(Variation(position, Field(ZERO, turning, scale(2, c)), c))
    return found


def _own_motions(at: Moving, convention: str) -> list[tuple[Vec, Vec]]:
    """(w, v) of every velocity of a joint, link axes."""
    if at.link.kind == FREE:
        linear = IDENTITY if convention == "body" else tuple(at.to_link(axis) for axis in IDENTITY)
        angular = tuple(at.to_link(axis) for axis in IDENTITY) if convention == "world" else IDENTITY
        return [*((ZERO, axis) for axis in linear), *((axis, ZERO) for axis in angular)]
    if at.link.kind == BALL:
        return [(axis, ZERO) for axis in IDENTITY]
    return [((0, 0, at.angular), (0, 0, at.linear))]


def _turned(at: Moving, variation: Variation, change: Wrench, wrench: Wrench) -> Wrench:
    """The change of a transmitted wrench, its own turn and shift with the joint included."""
    force = vadd(change[0], cross(variation.turn, wrench[0]))
    moment = vadd(vadd(change[1], cross(variation.turn, wrench[1])), cross(variation.shift, wrench[0]))
    return force, moment


def _own_force(at: Moving, fixed: Wrench, turned: Wrench, convention: str) -> Vec:
    """What a change of wrench asks of the joint itself: ``fixed`` where its axes move with the link, ``turned`` where
    they do not."""
    if at.link.kind == BALL:
        return fixed[1]
    if at.link.kind == FREE:
        linear = fixed[0] if convention == "body" else at.to_parent(turned[0])
        angular = at.to_parent(turned[1]) if convention == "world" else fixed[1]
        return (*linear, *angular)
    return (add(mul(at.angular, fixed[1][2]), mul(at.linear, fixed[0][2])),)


def _project(at: Moving, wrench: Wrench, convention: str) -> Vec:
    return _own_force(at, wrench, wrench, convention)


@dataclass(frozen=True)
class Derivatives:
    """∂τ/∂q (tangent) and ∂τ/∂v of all joints, without springs and damping."""

    by_position: Matrix
    by_velocity: Matrix


def inverse_dynamics_derivatives(links: Links, v: Sequence[Scalar], a: Sequence[Scalar], gravity: Vec) -> Derivatives:
    """Both matrices (nv × nv); entries between branches are structural zeros."""
    nv, convention = links.nv, links.values.scene.options.base_velocity
    motions = link_motions(links, v, a, gravity)
    wrenches = transmitted_wrenches(links, motions)
    bodies = composites(links, motions, v)
    dq: Matrix = [[0] * nv for _ in range(nv)]
    dv: Matrix = [[0] * nv for _ in range(nv)]
    fields: list[list[Variation]] = []
    for at in links.moving:
        with links.phase(f"derivatives: fields of {at.link.name}"):
            fields.append(variations(links, at, motions, v, gravity))
    for at in links.moving:
        with links.phase(f"derivatives: columns and rows of {at.link.name}"):
            body, start = bodies[at.link.index], at.link.v
            for k, variation in enumerate(fields[at.link.index]):
                change = body.wrench(variation.position)
                turned = _turned(at, variation, change, wrenches[at.link.index])
                _write(dq, start, start + k, _own_force(at, change, turned, convention))
                _carry_column(links, at, start + k, turned, dq)
                change = body.wrench(variation.velocity)
                _write(dv, start, start + k, _project(at, change, convention))
                _carry_column(links, at, start + k, change, dv)
            for k, (w, u) in enumerate(_own_motions(at, convention)):
                _carry_row(links, at, start + k, body.functional(w, u), fields, motions, v, (dq, dv))
    return Derivatives(dq, dv)


def _write(matrix: Matrix, row: int, column: int, values: Sequence[Scalar]) -> None:
    for i, value in enumerate(values):
        matrix[row + i][column] = value


def _carry_column(links: Links, at: Moving, column: int, wrench: Wrench, matrix: Matrix) -> None:
    """A change of the transmitted wrench, felt by every joint towards the root."""
    convention, here = links.values.scene.options.base_velocity, at
    for above in links.ancestors(at):
        wrench = here.wrench_to_parent(*wrench)
        _write(matrix, above.link.v, column, _project(above, wrench, convention))
        here = above


def _carry_row(
    links: Links,
    at: Moving,
    row: int,
    functional: Functional,
    fields: Sequence[Sequence[Variation]],
    motions: Sequence[Motion],
    v: Sequence[Scalar],
    matrices: tuple[Matrix, Matrix],
) -> None:
    """A joint's functional, applied to the fields of every joint towards the root."""
    dq, dv = matrices
    here = at
    for above in links.ancestors(at):
        u = _relative_velocity(here, motions[above.link.index].w, v[here.link.v : here.link.v + here.link.nv])
        force, moment = here.wrench_to_parent(functional.force, functional.moment)
        functional = Functional(force, moment, vadd(here.to_parent(functional.flow), cross(u, force)))
        for k, variation in enumerate(fields[above.link.index]):
            dq[row][above.link.v + k] = functional.of(variation.position)
            dv[row][above.link.v + k] = functional.of(variation.velocity)
        here = above
