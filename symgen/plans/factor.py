"""Solving mass_matrix · x = b by LᵀDL with the tree's sparsity (no fill-in), or by articulated bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import (
    ZERO,
    Mat,
    Vec,
    add,
    cross,
    dot,
    is_zero,
    known_value,
    madd,
    matmul,
    matvec,
    mul,
    outer,
    scale,
    skew,
    sub,
    symmetric,
    transpose,
    vadd,
)
from symgen.errors import SceneError
from symgen.plans import free, recursive
from symgen.plans.fields import Wrench
from symgen.plans.inertia import Inertia, moment_of_inertia
from symgen.plans.walk import BALL, FREE, SLIDE, Links, Moving

Scalar = Any


def reciprocal(links: Links, k: int, pivot: Scalar) -> Scalar:
    """1 / pivot of velocity k. Raises SceneError when the pivot is a constant that is not positive: whatever else
    moves, nothing with inertia moves with that velocity."""
    known = known_value(pivot)
    if known is not None and known <= 0:
        joint = next(body.joint for body in links.tree.bodies if body.v <= k < body.v + body.nv)
        scene = links.values.scene
        raise SceneError(
            f"the mass matrix is singular: no inertia moves with velocity {k} (joint '{joint.name}'); give the bodies "
            "beyond it mass and inertia, or the joint an armature",
            scene.source or scene.name,
        )
    return Fraction(1) / pivot if isinstance(pivot, int) else 1 / pivot


@dataclass(frozen=True)
class Factored:
    """M = LᵀDL, L unit lower triangular with the sparsity of M (Featherstone 2005: along a tree nothing fills in)."""

    inverse: tuple[Scalar, ...]
    """Of D: the reciprocals of the pivots."""
    pivots: tuple[Scalar, ...]
    """D; all positive exactly when M is positive definite."""
    rows: tuple[dict[int, Scalar], ...]
    """L below its diagonal: row k, {column: entry}, columns descending."""

    def solve(self, b: Sequence[Scalar]) -> list[Scalar]:
        """x with M x = b."""
        x = list(b)
        for k in reversed(range(len(x))):
            for i, ratio in self.rows[k].items():
                x[i] = sub(x[i], mul(ratio, x[k]))
        x = [mul(inverse, value) for inverse, value in zip(self.inverse, x, strict=True)]
        for k, row in enumerate(self.rows):
            for i, ratio in row.items():
                x[k] = sub(x[k], mul(ratio, x[i]))
        return x

    def inverse_matrix(self) -> list[list[Scalar]]:
        """M⁻¹ = L⁻¹ D⁻¹ L⁻ᵀ, full symmetric: columns of L⁻ᵀ, then the upper half of L⁻¹ D⁻¹ times them."""
        n = len(self.rows)
        found: list[list[Scalar]] = [[0] * n for _ in range(n)]
        for j in range(n):
            x: list[Scalar] = [0] * n
            x[j] = 1
            for k in reversed(range(j + 1)):
                for i, ratio in self.rows[k].items():
                    x[i] = sub(x[i], mul(ratio, x[k]))
            # Rows up to j are final; those beyond it are this column's mirror images, found with their own columns.
            for k in range(j + 1):
                x[k] = mul(self.inverse[k], x[k])
                for i, ratio in self.rows[k].items():
                    x[k] = sub(x[k], mul(ratio, x[i]))
                found[k][j] = found[j][k] = x[k]
        return found


def factor(links: Links, matrix: Sequence[Sequence[Scalar]]) -> Factored:
    """LᵀDL of a positive definite matrix. Entries that are structurally zero stay so where nothing fills them in."""
    n = len(matrix)
    h = [list(row) for row in matrix]
    rows: list[dict[int, Scalar]] = [{} for _ in range(n)]
    pivots, inverse = list[Scalar]([0] * n), list[Scalar]([0] * n)
    for k in reversed(range(n)):
        pivots[k] = h[k][k]
        inverse[k] = reciprocal(links, k, pivots[k])
        below = [i for i in reversed(range(k)) if not is_zero(h[k][i])]
        for place, i in enumerate(below):
            ratio = rows[k][i] = mul(h[k][i], inverse[k])
            for j in below[place:]:
                h[i][j] = sub(h[i][j], mul(ratio, h[k][j]))
    return Factored(tuple(inverse), tuple(pivots), tuple(rows))


class Articulated:
    """Inertia of a link with everything beyond it, joints free: [moment; force] = [J, B; Bᵀ, M][ω̇; a] + p."""

    def __init__(self, inertia: Inertia) -> None:
        m = inertia.mass
        self.j: Mat = moment_of_inertia(inertia)
        self.b: Mat = skew(inertia.first)
        self.m: Mat = ((m, 0, 0), (0, m, 0), (0, 0, m))
        self.moment: Vec = ZERO
        self.force: Vec = ZERO

    def join(self, other: Articulated) -> None:
        self.j, self.b, self.m = madd(self.j, other.j), madd(self.b, other.b), madd(self.m, other.m)
        self.moment, self.force = vadd(self.moment, other.moment), vadd(self.force, other.force)

    def column(self, w: Vec, v: Vec) -> tuple[Vec, Vec]:
        """(moment, force) of the unit motion (w, v)."""
        moment = vadd(matvec(self.j, w), matvec(self.b, v))
        return moment, vadd(matvec(transpose(self.b), w), matvec(self.m, v))

    def eliminate(self, moment: Vec, force: Vec, inverse: Scalar, done: Sequence[tuple[str, int]]) -> None:
        """Subtract U Uᵀ/D. Rows and columns of the freed direction become zero exactly (``done``)."""
        self.j = _minus_outer(self.j, scale(inverse, moment), moment)
        self.b = _minus_outer(self.b, scale(inverse, moment), force)
        self.m = _minus_outer(self.m, scale(inverse, force), force)
        for part, k in done:
            if part == "angular":
                self.j = _clear(_clear_row(self.j, k), k)
                self.b = _clear_row(self.b, k)
            else:
                self.m = _clear(_clear_row(self.m, k), k)
                self.b = _clear(self.b, k)

    def to_parent(self, at: Moving, further: Vec = ZERO) -> Articulated:
        """Turned to the parent's axes and shifted to its origin; ``further``: another force that the link's origin
        takes, parent's axes."""
        result = Articulated(Inertia())
        r = skew(at.offset)
        m = _symmetric_to_parent(at, self.m)
        b = at.matrix_to_parent(self.b)
        moved = madd(b, matmul(r, m))
        cross_term = matmul(r, transpose(moved))
        back = transpose(matmul(r, transpose(b)))
        result.m, result.b = m, moved
        result.j = _symmetrise(madd(_symmetric_to_parent(at, self.j), madd(cross_term, back)))
        result.force, result.moment = at.wrench_to_parent(self.force, self.moment, further)
        return result


def _minus_outer(m: Mat, x: Vec, y: Vec) -> Mat:
    return tuple(
        tuple(sub(a, b) for a, b in zip(row, other, strict=True)) for row, other in zip(m, outer(x, y), strict=True)
    )


def _clear_row(m: Mat, k: int) -> Mat:
    return tuple(ZERO if i == k else row for i, row in enumerate(m))


def _clear(m: Mat, k: int) -> Mat:
    return tuple(tuple(0 if j == k else x for j, x in enumerate(row)) for row in m)


def _symmetrise(m: Mat) -> Mat:
    """The upper triangle on both sides: the matrix is symmetric, so that nothing is computed twice."""
    return tuple(tuple(m[min(i, j)][max(i, j)] for j in range(3)) for i in range(3))


def _symmetric_to_parent(at: Moving, m: Mat) -> Mat:
    return symmetric(at.second_to_parent((m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])))


def _axis_motions(at: Moving) -> list[tuple[Vec, Vec, tuple[tuple[str, int], ...]]]:
    """(w, v) of every velocity of a joint in link axes, and the direction that is free afterwards (if it is one of
    the six)."""
    unit = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    if at.link.kind == FREE:
        linear = [(ZERO, axis, (("linear", k),)) for k, axis in enumerate(unit)]
        return [*linear, *((axis, ZERO, (("angular", k),)) for k, axis in enumerate(unit))]
    if at.link.kind == BALL:
        return [(axis, ZERO, (("angular", k),)) for k, axis in enumerate(unit)]
    if at.link.kind == SLIDE:
        return [(ZERO, unit[2], (("linear", 2),))]
    free_direction = (("angular", 2),) if at.linear == 0 else ()
    return [((0, 0, 1), (0, 0, at.linear), free_direction)]


@dataclass(frozen=True)
class Freed:
    """A velocity of a joint after its elimination: the (moment, force) that its unit motion takes, and its pivot."""

    moment: Vec
    force: Vec
    pivot: Scalar
    inverse: Scalar
    rest: Scalar


def eliminated(
    links: Links, at: Moving, body: Articulated, armature: Sequence[Scalar], b: Sequence[Scalar]
) -> list[Freed]:
    """Free the joint of a link of everything that ``body`` holds, velocity by velocity. ``armature`` and ``b``: of the
    joint's velocities. What is left in ``body`` is for the parent."""
    motions = _axis_motions(at)
    found: list[Freed] = []
    for k in reversed(range(len(motions))):
        w, v, done = motions[k]
        moment, force = body.column(w, v)
        pivot = add(add(dot(w, moment), dot(v, force)), armature[k])
        inverse = reciprocal(links, at.link.v + k, pivot)
        rest = sub(b[k], add(dot(w, body.moment), dot(v, body.force)))
        found.append(Freed(moment, force, pivot, inverse, rest))
        last = at.link.parent < 0 and k == 0
        if not last:
            body.eliminate(moment, force, inverse, done if is_zero(armature[k]) else ())
            ratio = mul(rest, inverse)
            body.moment = vadd(body.moment, scale(ratio, moment))
            body.force = vadd(body.force, scale(ratio, force))
    return found[::-1]


def accelerated(at: Moving, parent: tuple[Vec, Vec], freed: Sequence[Freed]) -> tuple[list[Scalar], Vec, Vec]:
    """Accelerations of a joint in link axes, and the link's own (angular, of its origin), from its parent's."""
    w_rate = at.to_link(parent[0])
    a = at.to_link(vadd(parent[1], cross(parent[0], at.offset)))
    x: list[Scalar] = []
    for (w, v, _), row in zip(_axis_motions(at), freed, strict=True):
        x.append(mul(row.inverse, sub(row.rest, add(dot(row.moment, w_rate), dot(row.force, a)))))
        w_rate, a = vadd(w_rate, scale(x[-1], w)), vadd(a, scale(x[-1], v))
    return x, w_rate, a


@dataclass(frozen=True)
class Load:
    """Forces of a motion without joint accelerations; the joints' share of them is C·v + gravity_force. Asked for link
    by link, so that they need not wait in registers."""

    links: Links
    motions: Sequence[recursive.Motion]

    def wrench(self, at: Moving) -> Wrench:
        """(force, moment) that the link's own motion takes about its origin, link axes."""
        return recursive.own_wrench(self.links, self.motions, at)

    def tip(self, at: Moving) -> Vec:
        """Force that the parent's point mass at the link's origin takes, parent's axes."""
        return recursive.tip_force(self.links, self.motions, at)


def motion_load(links: Links, v: Sequence[Scalar], gravity: Vec) -> Load:
    """The load of the velocities v, with weight."""
    return Load(links, recursive.link_motions(links, v, [0] * links.nv, gravity))


def solve_articulated(
    links: Links, armature: Sequence[Scalar], b: Sequence[Scalar], load: Load | None = None
) -> tuple[list[Scalar], list[Scalar]]:
    """x and the pivots of mass_matrix · x = b less what ``load`` asks of the joints, by articulated bodies without
    forming the mass matrix (Featherstone 2008, ch. 7; velocity terms come with the load)."""
    convention = links.values.scene.options.base_velocity
    rest, x, pivots = list(b), list[Scalar]([0] * links.nv), list[Scalar]([0] * links.nv)
    arrived = [Articulated(inertia) for inertia in links.inertias]
    freed: dict[int, list[Freed]] = {}
    for at in links.moving:
        if at.link.kind == FREE:
            start = at.link.v
            force, moment = free.wrench(at, tuple(b[start : start + 6]), convention)
            rest[start : start + 6] = [*force, *moment]
    for at in reversed(links.moving):
        body, own = arrived[at.link.index], slice(at.link.v, at.link.v + at.link.nv)
        if load:
            force, moment = load.wrench(at)
            body.force, body.moment = vadd(body.force, force), vadd(body.moment, moment)
        with links.phase(f"articulated inertia: {at.link.name}"):
            freed[at.link.index] = eliminated(links, at, body, armature[own], rest[own])
            pivots[own] = [row.pivot for row in freed[at.link.index]]
            if at.link.parent >= 0:
                arrived[at.link.parent].join(body.to_parent(at, load.tip(at) if load else ZERO))

    def step(at: Moving, parent: tuple[Vec, Vec]) -> tuple[Vec, Vec]:
        own = slice(at.link.v, at.link.v + at.link.nv)
        x[own], w_rate, a = accelerated(at, parent, freed[at.link.index])
        if at.link.kind == FREE:
            x[own] = free.generalised_force(at, a, w_rate, convention)
        return w_rate, a

    links.outward("acceleration", (ZERO, ZERO), step)
    return x, pivots
