"""Solving mass_matrix · x = b by LᵀDL with the tree's sparsity (no fill-in), or by articulated bodies."""

from __future__ import annotations

from collections.abc import Sequence
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
from symgen.plans import free
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


def velocity_parents(links: Links) -> list[int]:
    """For every joint velocity the one before it on the way to the root (−1 at the root): the tree of LᵀDL."""
    found = [-1] * links.tree.nv
    for at in links.moving:
        parent = links.moving[at.link.parent].link if at.link.parent >= 0 else None
        before = parent.v + parent.nv - 1 if parent else -1
        for k in range(at.link.nv):
            found[at.link.v + k] = before
            before = at.link.v + k
    return found


def solve_ltdl(
    links: Links, mass_matrix: Sequence[Sequence[Scalar]], b: Sequence[Scalar]
) -> tuple[list[Scalar], list[Scalar]]:
    """x and the pivots, which are positive exactly when the mass matrix is positive definite.

    M = LᵀDL, L unit lower triangular with the sparsity of the tree (Featherstone 2005).
    """
    parents = velocity_parents(links)
    h = [list(row) for row in mass_matrix]
    x, pivots = list(b), [mass_matrix[i][i] for i in range(len(parents))]
    inverse: list[Scalar] = [0] * len(parents)
    factor: list[dict[int, Scalar]] = [{} for _ in parents]
    with links.phase("factor: LᵀDL and inward solve"):
        for k in reversed(range(len(parents))):
            pivots[k] = h[k][k]
            inverse[k] = reciprocal(links, k, pivots[k])
            i = parents[k]
            while i >= 0:
                ratio = mul(h[k][i], inverse[k])
                factor[k][i] = ratio
                j = i
                while j >= 0:
                    h[i][j] = sub(h[i][j], mul(ratio, h[k][j]))
                    j = parents[j]
                x[i] = sub(x[i], mul(ratio, x[k]))
                i = parents[i]
    with links.phase("solve: outward"):
        for k in range(len(parents)):
            x[k] = mul(x[k], inverse[k])
            for i, ratio in factor[k].items():
                x[k] = sub(x[k], mul(ratio, x[i]))
    return x, pivots


class _Articulated:
    """Inertia of a link with everything beyond it, joints free: [moment; force] = [J, B; Bᵀ, M][ω̇; a] + p."""

    def __init__(self, inertia: Inertia) -> None:
        m = inertia.mass
        self.j: Mat = moment_of_inertia(inertia)
        self.b: Mat = skew(inertia.first)
        self.m: Mat = ((m, 0, 0), (0, m, 0), (0, 0, m))
        self.moment: Vec = ZERO
        self.force: Vec = ZERO

    def join(self, other: _Articulated) -> None:
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

    def to_parent(self, at: Moving) -> _Articulated:
        """Turned to the parent's axes and shifted to its origin."""
        result = _Articulated(Inertia())
        r = skew(at.offset)
        m = _symmetric_to_parent(at, self.m)
        b = at.matrix_to_parent(self.b)
        moved = madd(b, matmul(r, m))
        cross_term = matmul(r, transpose(moved))
        back = transpose(matmul(r, transpose(b)))
        result.m, result.b = m, moved
        result.j = _symmetrise(madd(_symmetric_to_parent(at, self.j), madd(cross_term, back)))
        result.force, result.moment = at.wrench_to_parent(self.force, self.moment)
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


def solve_articulated(
    links: Links, armature: Sequence[Scalar], b: Sequence[Scalar]
) -> tuple[list[Scalar], list[Scalar]]:
    """x and the pivots, by articulated bodies without forming the mass matrix (Featherstone 2008, ch. 7, applied
    to mass_matrix · x = b: no velocity terms)."""
    convention = links.values.scene.options.base_velocity
    nv = links.tree.nv
    rest, pivots, inverse = list(b), [0] * nv, [0] * nv
    columns: list[tuple[Vec, Vec]] = [(ZERO, ZERO)] * nv
    arrived = [_Articulated(inertia) for inertia in links.inertias]
    for at in links.moving:
        if at.link.kind == FREE:
            start = at.link.v
            force, moment = free.wrench(at, tuple(b[start : start + 6]), convention)
            rest[start : start + 6] = [*force, *moment]
    for at in reversed(links.moving):
        body = arrived[at.link.index]
        with links.phase(f"articulated inertia: {at.link.name}"):
            motions = _axis_motions(at)
            for k in reversed(range(len(motions))):
                i, (w, v, done) = at.link.v + k, motions[k]
                moment, force = columns[i] = body.column(w, v)
                extra = armature[i]
                pivots[i] = add(add(dot(w, moment), dot(v, force)), extra)
                inverse[i] = reciprocal(links, i, pivots[i])
                rest[i] = sub(rest[i], add(dot(w, body.moment), dot(v, body.force)))
                last = at.link.parent < 0 and k == 0
                if not last:
                    body.eliminate(moment, force, inverse[i], done if is_zero(extra) else ())
                    ratio = mul(rest[i], inverse[i])
                    body.moment = vadd(body.moment, scale(ratio, moment))
                    body.force = vadd(body.force, scale(ratio, force))
            if at.link.parent >= 0:
                arrived[at.link.parent].join(body.to_parent(at))

    x: list[Scalar] = [0] * nv

    def step(at: Moving, parent: tuple[Vec, Vec]) -> tuple[Vec, Vec]:
        w_rate = at.to_link(parent[0])
        a = at.to_link(vadd(parent[1], cross(parent[0], at.offset)))
        for k, (w, v, _) in enumerate(_axis_motions(at)):
            i = at.link.v + k
            moment, force = columns[i]
            x[i] = mul(inverse[i], sub(rest[i], add(dot(moment, w_rate), dot(force, a))))
            w_rate, a = vadd(w_rate, scale(x[i], w)), vadd(a, scale(x[i], v))
        if at.link.kind == FREE:
            x[at.link.v : at.link.v + 6] = free.generalised_force(at, a, w_rate, convention)
        return w_rate, a

    links.outward("acceleration", (ZERO, ZERO), step)
    return x, pivots
