"""Composite plan of the Coriolis matrix C = RᵀMṘ, and of gravity, momenta and energies, in body axes.

Column j of Ṙ is, on every body beyond joint j, the field v̇ + ẇ × d + w × ḋ (theory, §3): what composite bodies make of
such fields is in `symgen.plans.field_matrices`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import IDENTITY, ZERO, Vec, add, cross, dot, scale, sub, vadd, vneg
from symgen.plans import free
from symgen.plans.composite import motions, project
from symgen.plans.field_matrices import Columns, bodies
from symgen.plans.fields import Field, Wrench, field_wrench, joined
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


def _own_fields(at: Moving, velocity: Velocity, convention: str) -> list[Field]:
    """The columns of Ṙ of a link's joint, as fields about its own origin."""
    if at.link.kind != FREE:
        return [Field(cross(velocity.w, v), cross(velocity.w, w), w) for w, v in motions(at, convention)]
    turning = [cross(velocity.w, axis) for axis in IDENTITY]
    linear = [Field(rate) if convention == "body" else Field() for rate in turning]
    if convention == "world":
        return linear + [Field(w=at.to_link(axis)) for axis in IDENTITY]
    return linear + [Field(w_rate=rate, w=axis) for axis, rate in zip(IDENTITY, turning, strict=True)]


def coriolis_matrix(links: Links, v: Sequence[Scalar]) -> list[list[Scalar]]:
    """RᵀMṘ, dense rows; entries between branches are structural zeros."""
    convention = links.values.scene.options.base_velocity
    velocities = link_velocities(links, v)
    fields = [_own_fields(at, velocities[at.link.index], convention) for at in links.moving]
    moving = bodies(links, [velocity.w for velocity in velocities], v)
    return moving.matrices("Coriolis matrix: columns and rows", [Columns(fields)])[0]


def joint_momentum(links: Links, v: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
    """RᵀMR v and ṘᵀMR v, without armature: momenta (p, l about the link's origin) accumulated from the leaves. A column
    of Ṙ, the field a + ẇ × x + w × ẏ, feels of them a · p + ẇ · l − w · (v × p), v the origin's velocity."""
    convention = links.values.scene.options.base_velocity
    velocities = link_velocities(links, v)
    own = [field_wrench(inertia, at.w, at.v) for inertia, at in zip(links.inertias, velocities, strict=True)]
    momenta: list[Scalar] = [0] * links.nv
    rates: list[Scalar] = [0] * links.nv

    def step(at: Moving, here: Wrench) -> Wrench:
        p, spin = here
        velocity, start = velocities[at.link.index], at.link.v
        flow = cross(p, velocity.v)
        momenta[start : start + at.link.nv] = project(at, p, spin, convention)
        rates[start : start + at.link.nv] = [
            dot((*field.a, *field.w_rate, *field.w), (*p, *spin, *flow))
            for field in _own_fields(at, velocity, convention)
        ]
        return at.wrench_to_parent(p, spin) if at.link.parent >= 0 else here

    links.inward("momentum", own, step, joined)
    return momenta, rates


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
        p, spin = field_wrench(inertia, at.w, at.v)
        twice = add(twice, add(dot(at.v, p), dot(at.w, spin)))
    return twice
