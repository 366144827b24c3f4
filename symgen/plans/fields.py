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
from functools import cached_property
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
    neg,
    outer,
    scale,
    skew,
    symmetric,
    vadd,
    vecmat,
    vneg,
)
from symgen.plans.inertia import Inertia, moment_of_inertia
from symgen.plans.walk import Links, Moving

Scalar = Any
Wrench = tuple[Vec, Vec]
"""(force, moment about the link's origin), link axes."""


def joined(x: Wrench, y: Wrench) -> Wrench:
    """Two wrenches on one link."""
    return vadd(x[0], y[0]), vadd(x[1], y[1])


def _rigid(inertia: Inertia) -> Mat:
    """Rows of force and moment, columns of a and ẇ: [m 1, −h̃; h̃, tr Σ − Σ]."""
    m, h, turning = inertia.mass, skew(inertia.first), moment_of_inertia(inertia)
    mass: Mat = ((m, 0, 0), (0, m, 0), (0, 0, m))
    forces = tuple((*row, *vneg(moment)) for row, moment in zip(mass, h, strict=True))
    return forces + tuple((*row, *own) for row, own in zip(h, turning, strict=True))


def field_wrench(inertia: Inertia, w: Vec, v: Vec) -> Wrench:
    """Of the field v + w × x: m v + w × h, (tr Σ − Σ) w + h × v."""
    found = matvec(_rigid(inertia), (*v, *w))
    return found[:3], found[3:]


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
        return dot((*self.force, *self.moment, *self.flow), (*field.a, *field.w_rate, *field.w))


@dataclass(frozen=True)
class Composite:
    """A link with everything beyond it: inertia, ∫ρẏ and ∫ρẏxᵀ about its origin, link axes."""

    inertia: Inertia
    flow: Vec
    stream: Mat

    @cached_property
    def _matrix(self) -> Mat:
        """Wrenches of fields: `_rigid`, and for w the columns of ∫ρẏ and B = ∫ρẏxᵀ: w × ∫ρẏ, (tr B − B) w."""
        b = self.stream
        xx, yy, zz = b[0][0], b[1][1], b[2][2]
        spin = (
            (add(yy, zz), neg(b[0][1]), neg(b[0][2])),
            (neg(b[1][0]), add(xx, zz), neg(b[1][2])),
            (neg(b[2][0]), neg(b[2][1]), add(xx, yy)),
        )
        further = (*(vneg(row) for row in skew(self.flow)), *spin)
        return tuple((*row, *more) for row, more in zip(_rigid(self.inertia), further, strict=True))

    def wrench(self, field: Field) -> Wrench:
        """f = m a + ẇ × h + w × ∫ρẏ; n = h × a + I ẇ + (tr B − B) w."""
        found = matvec(self._matrix, (*field.a, *field.w_rate, *field.w))
        return found[:3], found[3:]

    def functional(self, w: Vec, v: Vec) -> Functional:
        """What a joint with motion subspace (w, v) feels of a field: w · n + v · f."""
        found = vecmat((*v, *w), self._matrix)
        return Functional(found[:3], found[3:6], found[6:])


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
