"""Acceleration-like fields of links, and what composite bodies make of them: the mechanism behind the columns and rows
of RᵀMṘ and of the derivatives of inverse dynamics.

Such a field is a + ẇ × x + w × ẏ about a link's origin: x the place, ẏ the velocity, both relative to the origin. The
wrench that it asks of a composite body is linear in (a, ẇ, w), with coefficients m, h, Σ, ∫ρẏ and ∫ρẏxᵀ. So a column
is one wrench carried to the root, and a row is one functional of fields carried to the root; no field is carried
outward (compare Singh, Russell & Wensing 2022, who do the same with spatial vectors in ground axes).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import (
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
from symgen.plans.inertia import Inertia, moment_of_inertia
from symgen.plans.walk import Links, Moving

Scalar = Any
Wrench = tuple[Vec, Vec]
"""(force, moment about the link's origin), link axes."""


def joined(x: Wrench, y: Wrench) -> Wrench:
    """Two wrenches on one link."""
    return vadd(x[0], y[0]), vadd(x[1], y[1])


def field_wrench(inertia: Inertia, w: Vec, v: Vec) -> Wrench:
    """Of the field v + w × x: m v + w × h, (tr Σ − Σ) w + h × v."""
    force = vadd(scale(inertia.mass, v), cross(w, inertia.first))
    return force, vadd(matvec(moment_of_inertia(inertia), w), cross(inertia.first, v))


@dataclass(frozen=True)
class Field:
    """a + ẇ × x + w × ẏ."""

    a: Vec = ZERO
    w_rate: Vec = ZERO
    w: Vec = ZERO


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
        force, moment = field_wrench(self.inertia, field.w_rate, field.a)
        return vadd(force, cross(field.w, self.flow)), vadd(moment, matvec(self._spin(), field.w))

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
        force, moment = field_wrench(self.inertia, w, v)
        return Functional(force, moment, vadd(vecmat(w, self._spin()), cross(self.flow, v)))


def relative_velocity(at: Moving, parent_w: Vec, v: Sequence[Scalar]) -> Vec:
    """Velocity of a link's origin relative to its parent's origin, parent's axes."""
    u = cross(parent_w, at.offset)
    if at.linear != 0:
        u = vadd(u, at.to_parent((0, 0, mul(at.linear, v[at.link.v]))))
    return u


def composites(links: Links, inertias: Sequence[Inertia], spins: Sequence[Vec], v: Sequence[Scalar]) -> list[Composite]:
    """Composite ``inertias`` with their velocity moments, from the leaves. ``spins``: ω of every link, link axes."""
    start = [
        (cross(w, inertia.first), matmul(skew(w), symmetric(inertia.second)))
        for w, inertia in zip(spins, links.inertias, strict=True)
    ]
    found = list(start)

    def step(at: Moving, here: tuple[Vec, Mat]) -> tuple[Vec, Mat]:
        found[at.link.index] = here
        if at.link.parent < 0:
            return here
        u = relative_velocity(at, spins[at.link.parent], v)
        inertia, flow = inertias[at.link.index], at.to_parent(here[0])
        moved = vadd(at.to_parent(inertia.first), scale(inertia.mass, at.offset))
        stream = madd(at.matrix_to_parent(here[1]), madd(outer(u, moved), outer(flow, at.offset)))
        return vadd(flow, scale(inertia.mass, u)), stream

    links.inward("velocity moments", start, step, lambda x, y: (vadd(x[0], y[0]), madd(x[1], y[1])))
    return [Composite(inertia, flow, stream) for inertia, (flow, stream) in zip(inertias, found, strict=True)]


def carried_wrench(links: Links, at: Moving, wrench: Wrench) -> Iterator[tuple[Moving, Wrench]]:
    """A wrench on a link, as every link towards the root transmits it, nearest first."""
    here = at
    for above in links.ancestors(at):
        wrench = here.wrench_to_parent(*wrench)
        yield above, wrench
        here = above


def carried_functional(
    links: Links, at: Moving, functional: Functional, spins: Sequence[Vec], v: Sequence[Scalar]
) -> Iterator[tuple[Moving, Functional]]:
    """A functional of a link's fields, as one of the fields of every link towards the root, nearest first."""
    here = at
    for above in links.ancestors(at):
        u = relative_velocity(here, spins[above.link.index], v)
        force, moment = here.wrench_to_parent(functional.force, functional.moment)
        functional = Functional(force, moment, vadd(here.to_parent(functional.flow), cross(u, force)))
        yield above, functional
        here = above
