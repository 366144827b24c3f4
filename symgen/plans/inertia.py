"""Inertia of elementary links, and the regrouping that moves what a joint cannot feel to its parent.

A rigid inertia is kept as (mass m, first moment h = ∫ρx, second moment Σ = ∫ρxxᵀ) about the link's origin, in link
axes: the entries of the pseudo-inertia P (theory, §2). Rotation and shift act on them with fewest operations, and
the moment of momentum rate follows from Σ and the matrix ω̇̃ + ω̃ω̃ that also gives the forces.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import (
    ZERO,
    Mat,
    Vec,
    add,
    dot,
    is_zero,
    matmul,
    matvec,
    mul,
    scale,
    sub,
    symmetric,
    transpose,
    vadd,
)
from symgen.natural.mass import pseudo_inertia
from symgen.plans.links import BALL, FREE, SLIDE, TURN, Link
from symgen.topology.tree import Tree
from symgen.velocity.values import Values

Scalar = Any
Six = tuple[Scalar, ...]
"""(xx, yy, zz, xy, xz, yz)."""
NO_MOMENT: Six = (0,) * 6


@dataclass(frozen=True)
class Inertia:
    mass: Scalar = 0
    first: Vec = ZERO
    second: Six = NO_MOMENT
    polar: Scalar = None
    """Σ_xx + Σ_yy where it is known without them: turning about z does not change it, so along parallel axes the
    moment of inertia about them needs no rotation at all. None: add the two."""

    @property
    def about_z(self) -> Scalar:
        """I_zz = Σ_xx + Σ_yy."""
        return add(self.second[0], self.second[1]) if self.polar is None else self.polar

    def plus(self, other: Inertia) -> Inertia:
        known = self.polar is not None or other.polar is not None
        return Inertia(
            add(self.mass, other.mass),
            vadd(self.first, other.first),
            vadd(self.second, other.second),
            add(self.about_z, other.about_z) if known else None,
        )


def moment_of_inertia(inertia: Inertia) -> Mat:
    """I = tr(Σ) 1 − Σ about the link's origin."""
    xx, yy, zz, xy, xz, yz = inertia.second
    return symmetric((add(yy, zz), add(xx, zz), inertia.about_z, sub(0, xy), sub(0, xz), sub(0, yz)))


def signed_permutation(m: Mat) -> bool:
    """True when a rotation only permutes axes and flips signs."""
    return all(sum(1 for x in row if x != 0) == 1 for row in m)


def rotate_second(turn: Mat, second: Six) -> Six:
    """Σ ↦ K Σ Kᵀ."""
    full = symmetric(second)
    if signed_permutation(turn):
        source = [next((j, row[j]) for j in range(3) if row[j] != 0) for row in turn]

        def entry(i: int, j: int) -> Scalar:
            (a, sa), (b, sb) = source[i], source[j]
            return mul(mul(sa, sb), full[a][b])

    else:
        product = matmul(turn, full)

        def entry(i: int, j: int) -> Scalar:
            return dot(product[i], turn[j])

    return (entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2))


def turn_vector(c: Scalar, s: Scalar, x: Vec) -> Vec:
    """A vector turned about z by the angle of (c, s)."""
    return (sub(mul(c, x[0]), mul(s, x[1])), add(mul(s, x[0]), mul(c, x[1])), x[2])


def turn_back(c: Scalar, s: Scalar, x: Vec) -> Vec:
    """A vector turned back about z by the angle of (c, s)."""
    return (add(mul(c, x[0]), mul(s, x[1])), sub(mul(c, x[1]), mul(s, x[0])), x[2])


def turn_second(c: Scalar, s: Scalar, second: Six) -> Six:
    """Σ turned about z by the angle of (c, s): with u = c(Σxx − Σyy) − 2sΣxy, ten operations and a plane rotation."""
    if is_zero(s):
        return second
    xx, yy, zz, xy, xz, yz = second
    u = sub(mul(c, sub(xx, yy)), mul(s, mul(2, xy)))
    return (
        add(yy, mul(c, u)),
        sub(xx, mul(c, u)),
        zz,
        add(xy, mul(s, u)),
        sub(mul(c, xz), mul(s, yz)),
        add(mul(s, xz), mul(c, yz)),
    )


def turn_matrix(c: Scalar, s: Scalar, m: Mat) -> Mat:
    """A matrix turned about z on both sides: as `turn_second`, what is antisymmetric about z staying as it is."""
    if is_zero(s):
        return m
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = m
    u = sub(mul(c, sub(xx, yy)), mul(s, add(xy, yx)))
    (xz, yz, _), (zx, zy, _) = turn_vector(c, s, (xz, yz, 0)), turn_vector(c, s, (zx, zy, 0))
    along, across = mul(c, u), mul(s, u)
    return (add(yy, along), add(xy, across), xz), (add(yx, across), sub(xx, along), yz), (zx, zy, zz)


def shift(inertia: Inertia, offset: Vec) -> Inertia:
    """The same inertia about a point ``offset`` behind its origin (x ↦ x + offset)."""
    h, r, m = inertia.first, offset, inertia.mass
    moved = vadd(h, scale(m, r))
    # Σ + r hᵀ + h rᵀ + m r rᵀ, written as r hᵀ + (h + m r) rᵀ.
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    second = tuple(
        add(old, add(mul(r[i], h[j]), mul(moved[i], r[j]))) if i != j else add(old, mul(r[i], add(h[i], moved[i])))
        for old, (i, j) in zip(inertia.second, pairs, strict=True)
    )
    polar = inertia.polar
    if polar is not None:
        polar = add(polar, add(mul(r[0], add(h[0], moved[0])), mul(r[1], add(h[1], moved[1]))))
    return Inertia(m, moved, second, polar)


def link_inertias(tree: Tree, links: Sequence[Link], values: Values) -> list[Inertia]:
    """Each link's own inertia in its own axes: pseudo-inertia of the body, moved into link axes."""
    found = []
    for link in links:
        if not link.carries:
            found.append(Inertia())
            continue
        p = pseudo_inertia(tree.bodies[link.body].parts, values, tree.bodies[link.body].welds)
        body = Inertia(p[0][0], tuple(p[0][1:]), (p[1][1], p[2][2], p[3][3], p[1][2], p[1][3], p[2][3]))
        back = transpose(link.axes)
        about = shift(body, values.vector(scale(-1, link.shift)))
        turn = values.matrix(back)
        found.append(Inertia(about.mass, matvec(turn, about.first), rotate_second(turn, about.second)))
    return found


@dataclass(frozen=True)
class Grouped:
    """Inertia of every link in its own axes, of ground in ground axes, and point masses at the origins of links, each
    fixed in the link's parent (by link, none where zero)."""

    links: list[Inertia]
    ground: Inertia
    tips: Mapping[int, Scalar]


def regroup(links: Sequence[Link], inertias: Sequence[Inertia], values: Values, tips: Collection[int] = ()) -> Grouped:
    """Move to the parent what a joint cannot feel (base parameters, exactly).

    A turning joint feels neither mass nor moments on its axis (m, h_z, Σ_zz), a slide not the rotational inertia
    (Σ), a ball joint not the mass at its centre. What ends in ground is felt by nothing, but has potential energy.
    For the links in ``tips``, which needs constant inertias, a component of the first moment becomes a point mass at
    the origin of a child where that is possible: the acceleration there is needed anyway.
    """
    kept, ground, masses = list(inertias), Inertia(), dict[int, Scalar]()
    limits = _masses_beyond(links, inertias) if tips else []
    children: dict[int, list[Link]] = {index: [] for index in tips}
    for link in links:
        if link.parent in children:
            children[link.parent].append(link)
    for link in reversed(links):
        own = kept[link.index]
        for child in children.get(link.index, ()):
            tip = _tip(link, child, own, limits[link.index])
            if tip != 0:
                masses[child.index] = tip
                own = own.plus(shift(Inertia(-tip), child.offset))
        kept[link.index] = own
        if link.kind == TURN:
            moved = Inertia(own.mass, (0, 0, own.first[2]), (0, 0, own.second[2], 0, 0, 0))
            rest = Inertia(0, (*own.first[:2], 0), (*own.second[:2], 0, *own.second[3:]))
        elif link.kind == SLIDE:
            moved, rest = Inertia(0, ZERO, own.second), Inertia(own.mass, own.first, NO_MOMENT)
        elif link.kind == BALL:
            moved, rest = Inertia(own.mass), Inertia(0, own.first, own.second)
        else:
            continue
        kept[link.index] = rest
        turn, offset = values.matrix(link.turn), values.vector(link.offset)
        turned = Inertia(moved.mass, matvec(turn, moved.first), rotate_second(turn, moved.second))
        if link.parent >= 0:
            kept[link.parent] = kept[link.parent].plus(shift(turned, offset))
        else:
            ground = ground.plus(shift(turned, offset))
    return Grouped(kept, ground, masses)


def _masses_beyond(links: Sequence[Link], inertias: Sequence[Inertia]) -> list[Scalar]:
    """Mass of every link and all links beyond it."""
    found = [inertia.mass for inertia in inertias]
    for link in reversed(links):
        if link.parent >= 0:
            found[link.parent] += found[link.index]
    return found


def _tip(link: Link, child: Link, own: Inertia, limit: Scalar) -> Scalar:
    """The point mass at the child's origin that takes a component of the first moment h off the link, or 0.

    It must make h sparser, the child's origin must stay where it is, and no mass may be larger than what is there:
    what is added here is taken off elsewhere, and large opposite masses would cost digits.
    """
    if link.kind not in (TURN, FREE) or child.kind not in (TURN, BALL):
        return 0
    felt = range(2) if link.kind == TURN else range(3)
    options = []
    for i in felt:
        if child.offset[i] != 0 and own.first[i] != 0:
            tip = Fraction(own.first[i]) / child.offset[i]
            left = sum(1 for j in felt if own.first[j] - tip * child.offset[j] != 0)
            options.append((left, abs(tip), tip))
    present = sum(1 for j in felt if own.first[j] != 0)
    options = [option for option in options if option[0] < present and option[1] <= limit]
    return min(options)[2] if options else 0
