"""Composite plan of the Coriolis matrix C = RᵀMṘ, and of gravity and energies, in body axes.

Column j of Ṙ is, on every body beyond joint j, the field v̇ + ẇ × d + w × ḋ (theory, §3). Its wrench on a composite
body is linear in (v̇, ẇ, w) with coefficients m, h, Σ and the mass-weighted velocities ∫ρẏ and ∫ρẏdᵀ, ẏ being the
velocity relative to the link's origin: those are accumulated from the leaves once, and serve every column.
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
    outer,
    scale,
    skew,
    sub,
    symmetric,
    vadd,
    vneg,
    vsub,
)
from symgen.plans import free
from symgen.plans.composite import project, unit_motions
from symgen.plans.inertia import Inertia, moment_of_inertia
from symgen.plans.walk import BALL, FREE, Links, Moving

Scalar = Any


@dataclass(frozen=True)
class Velocity:
    """ω and the origin's velocity, link axes."""

    w: Vec
    v: Vec


def link_velocities(links: Links, v: Sequence[Scalar]) -> list[Velocity]:
    convention = links.values.scene.options.base_velocity

    def step(at: Moving, parent: Velocity) -> Velocity:
        rate = tuple(v[at.link.v : at.link.v + at.link.nv])
        if at.link.kind == FREE:
            linear, w = free.velocity(at, rate, convention)
            return Velocity(w, linear)
        carried = at.to_link(parent.w)
        origin = at.to_link(vadd(parent.v, cross(parent.w, at.offset)))
        if at.link.kind == BALL:
            return Velocity(vadd(carried, rate), origin)
        turn, slide = (0, 0, at.angular), (0, 0, at.linear)
        return Velocity(vadd(carried, scale(rate[0], turn)), vadd(origin, scale(rate[0], slide)))

    return links.outward("velocity", Velocity(ZERO, ZERO), step)


@dataclass(frozen=True)
class Streaming:
    """Composite inertia with its velocity moments about the link's origin: ``first_rate`` = ∫ρẋ and
    ``second_rate`` = ∫ρẋdᵀ, ẋ the velocity in space."""

    inertia: Inertia
    first_rate: Vec
    second_rate: Mat

    def join(self, other: Streaming) -> Streaming:
        return Streaming(
            self.inertia.plus(other.inertia),
            vadd(self.first_rate, other.first_rate),
            madd(self.second_rate, other.second_rate),
        )


@dataclass(frozen=True)
class Field:
    """The acceleration field of one column seen from a link: w, ẇ, and its value a at the link's origin."""

    w: Vec
    w_rate: Vec
    a: Vec


def _streaming(links: Links, velocities: Sequence[Velocity]) -> list[Streaming]:
    def own(at: Moving) -> Streaming:
        inertia, velocity = links.inertias[at.link.index], velocities[at.link.index]
        spinning = matmul(skew(velocity.w), symmetric(inertia.second))
        return Streaming(
            inertia,
            vadd(scale(inertia.mass, velocity.v), cross(velocity.w, inertia.first)),
            madd(outer(velocity.v, inertia.first), spinning),
        )

    start = [own(at) for at in links.moving]
    found = list(start)

    def step(at: Moving, here: Streaming) -> Streaming:
        found[at.link.index] = here
        if at.link.parent < 0:
            return here
        first_rate = at.to_parent(here.first_rate)
        second_rate = madd(at.matrix_to_parent(here.second_rate), outer(first_rate, at.offset))
        return Streaming(at.inertia_to_parent(here.inertia), first_rate, second_rate)

    links.inward("composite inertia and momentum", start, step, lambda mine, theirs: mine.join(theirs))
    return found


def _field_wrench(composite: Streaming, velocity: Velocity, field: Field) -> tuple[Vec, Vec]:
    """f = m a + ẇ × h + w × ∫ρẏ;  n = h × a + I ẇ + (tr B − B) w, B = ∫ρẏdᵀ."""
    h, m = composite.inertia.first, composite.inertia.mass
    relative = vsub(composite.first_rate, scale(m, velocity.v))
    b = tuple(vsub(row, scale(x, h)) for row, x in zip(composite.second_rate, velocity.v, strict=True))
    trace = add(add(b[0][0], b[1][1]), b[2][2])
    force = vadd(scale(m, field.a), vadd(cross(field.w_rate, h), cross(field.w, relative)))
    moment = vadd(cross(h, field.a), matvec(moment_of_inertia(composite.inertia), field.w_rate))
    return force, vadd(moment, vsub(scale(trace, field.w), matvec(b, field.w)))


def _own_fields(at: Moving, velocity: Velocity, convention: str) -> list[Field]:
    """The columns of a link's joint at its own origin: (w, ẇ, v̇) in link axes."""
    if at.link.kind != FREE:
        return [Field(w, cross(velocity.w, w), cross(velocity.w, v)) for w, v in unit_motions(at)]
    turning = [cross(velocity.w, axis) for axis in IDENTITY]
    linear = [Field(ZERO, ZERO, rate if convention == "body" else ZERO) for rate in turning]
    if convention == "world":
        return linear + [Field(at.to_link(axis), ZERO, ZERO) for axis in IDENTITY]
    return linear + [Field(axis, rate, ZERO) for axis, rate in zip(IDENTITY, turning, strict=True)]


def coriolis_matrix(links: Links, v: Sequence[Scalar]) -> list[list[Scalar]]:
    """RᵀMṘ, dense rows."""
    nv, convention = links.nv, links.values.scene.options.base_velocity
    velocities = link_velocities(links, v)
    composites = _streaming(links, velocities)
    c: list[list[Scalar]] = [[0] * nv for _ in range(nv)]
    children: list[list[int]] = [[] for _ in links.moving]
    for at in links.moving:
        if at.link.parent >= 0:
            children[at.link.parent].append(at.link.index)

    def write(at: Moving, j: int, wrench: tuple[Vec, Vec]) -> None:
        for i, value in enumerate(project(at, *wrench, convention)):
            c[at.link.v + i][j] = value

    for at in links.moving:
        with links.phase(f"Coriolis matrix: columns of {at.link.name}"):
            for k, field in enumerate(_own_fields(at, velocities[at.link.index], convention)):
                j = at.link.v + k
                wrench = _field_wrench(composites[at.link.index], velocities[at.link.index], field)
                write(at, j, wrench)
                here = at
                for above in links.ancestors(at):
                    wrench = here.wrench_to_parent(*wrench)
                    write(above, j, wrench)
                    here = above
                stack = [(index, field) for index in children[at.link.index]]
                while stack:
                    index, seen = stack.pop()
                    below = links.moving[index]
                    before, after = velocities[below.link.parent], velocities[index]
                    moved = _seen_from(below, seen, before, after)
                    write(below, j, _field_wrench(composites[index], after, moved))
                    stack.extend((child, moved) for child in children[index])
    return c


def _seen_from(at: Moving, field: Field, before: Velocity, after: Velocity) -> Field:
    """A field of the parent's axes and origin, seen from a link: a moves by ẇ × r + w × (v − v_parent)."""
    w, w_rate = at.to_link(field.w), at.to_link(field.w_rate)
    a = at.to_link(vadd(field.a, cross(field.w_rate, at.offset)))
    gained = vsub(after.v, at.to_link(before.v))
    return Field(w, w_rate, vadd(a, cross(w, gained)))


def gravity_force(links: Links, gravity: Vec) -> list[Scalar]:
    """−RᵀQ: first moments accumulated from the leaves, against gravity seen from each link."""
    convention = links.values.scene.options.base_velocity
    weights = links.outward("gravity in link axes", vneg(gravity), lambda at, g: at.to_link(g))
    moments = first_moments(links)
    found: list[Scalar] = [0] * links.nv
    for at, a in zip(links.moving, weights, strict=True):
        mass, h = moments[at.link.index]
        with links.phase(f"gravity: {at.link.name}"):
            wrench = (scale(mass, a), cross(h, a))
            found[at.link.v : at.link.v + at.link.nv] = project(at, *wrench, convention)
    return found


def first_moments(links: Links) -> list[tuple[Scalar, Vec]]:
    """Mass and first moment of each link with everything beyond it, about the link's origin, link axes."""
    start = [(inertia.mass, inertia.first) for inertia in links.inertias]
    found = list(start)

    def step(at: Moving, here: tuple[Scalar, Vec]) -> tuple[Scalar, Vec]:
        found[at.link.index] = here
        return _moment_to_parent(at, here) if at.link.parent >= 0 else here

    links.inward("first moment", start, step, lambda x, y: (add(x[0], y[0]), vadd(x[1], y[1])))
    return found


def _moment_to_parent(at: Moving, here: tuple[Scalar, Vec]) -> tuple[Scalar, Vec]:
    mass, h = here
    return mass, vadd(at.to_parent(h), scale(mass, at.offset))


def gravity_energy(links: Links, gravity: Vec) -> Scalar:
    """−g · ∫ρr, zero at the ground origin."""
    moments = first_moments(links)
    total: Vec = links.ground.first
    for at in links.moving:
        if at.link.parent < 0:
            total = vadd(total, _moment_to_parent(at, moments[at.link.index])[1])
    return sub(0, dot(gravity, total))


def twice_kinetic_energy(links: Links, v: Sequence[Scalar]) -> Scalar:
    """Σ (v·p + ω·l) with p = m v + ω × h and l = I ω + h × v, without armature."""
    velocities = link_velocities(links, v)
    twice: Scalar = 0
    for inertia, at in zip(links.inertias, velocities, strict=True):
        p = vadd(scale(inertia.mass, at.v), cross(at.w, inertia.first))
        spin = vadd(matvec(moment_of_inertia(inertia), at.w), cross(inertia.first, at.v))
        twice = add(twice, add(dot(at.v, p), dot(at.w, spin)))
    return twice
