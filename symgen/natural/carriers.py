"""Which entities carry a body's mass: the best-conditioned W, auxiliary vectors where the joints give too few.

The choice is made in floats; what is chosen is exact. Candidates within a fifth of the best are equal, and the first
of them in listing order wins, so that the choice does not hang on the last bits of a singular value.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from math import frexp, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.algebra import linear
from symgen.natural.entities import Vector
from symgen.natural.layout import Basis, Complex
from symgen.natural.plane import AXES, complement, cross, difference, in_plane, product, turned, vector
from symgen.topology.tree import TreeBody

Array = NDArray[Any]

CONDITION_LIMIT = 100.0
"""A worse W is as good as singular: the reduced mass matrix would lose the square of it in relative accuracy."""
SLACK = 1.2
EXHAUSTIVE = 8
"""Up to so many optional entities every combination is tried; beyond, a pivoted elimination shortlists."""


@dataclass(frozen=True)
class Candidate:
    """A point or vector fixed in the body."""

    kind: str
    local: Vector
    required: bool = False
    """Shared with the parent: it must carry, so that the body's constraints need no row that the parent has."""


@dataclass(frozen=True)
class Carriers:
    chosen: tuple[int, ...]
    """Positions in the list of candidates followed by ``auxiliary``, ascending."""
    auxiliary: tuple[Candidate, ...]
    condition: float


def body_size(body: TreeBody, points: Sequence[Vector], base: Vector) -> float:
    """Largest of the distances of points and centres of mass from the base, and of the radii of gyration; 1 if all
    are zero. (Metres.)"""
    reach = [sqrt(float(product(d, d))) for d in (difference(point, base) for point in points)]
    for part, pose in body.parts:
        if part.mass > 0:
            com = vector(linear.vadd(turned(pose.rotation, part.com), pose.translation))
            arm = difference(com, base)
            reach.append(sqrt(float(product(arm, arm))))
            reach.append(sqrt(abs(float(sum(part.inertia[:3]) / part.mass)) / 2))
    return max(reach, default=0.0) or 1.0


def choose_spatial(body: TreeBody, candidates: Sequence[Candidate]) -> Carriers:
    """Four of the candidates, with as few auxiliary vectors as a condition number below the limit needs."""
    points = [candidate.local for candidate in candidates if candidate.kind == "point"]
    base = base_point(candidates)
    size = body_size(body, points, base)
    pool = _auxiliary_vectors(candidates)
    rows = np.array([_row(candidate, base, size) for candidate in (*candidates, *pool)])
    required = [k for k, candidate in enumerate(candidates) if candidate.required]
    optional = [k for k, candidate in enumerate(candidates) if not candidate.required]
    if len(optional) > EXHAUSTIVE:
        optional = _shortlist(rows, required, optional)
    extra = list(range(len(candidates), len(rows)))
    chosen, condition = _best(rows, required, optional, extra, 4)
    used = [k for k in chosen if k >= len(candidates)]
    place = {k: len(candidates) + n for n, k in enumerate(used)}
    return Carriers(tuple(place.get(k, k) for k in chosen), tuple(pool[k - len(candidates)] for k in used), condition)


def choose_planar(body: TreeBody, basis: Basis, candidates: Sequence[Candidate]) -> Carriers:
    """Two points, the second an auxiliary one (at about the body's size along e1) if the others are too near."""
    base = base_point(candidates)
    size = body_size(body, [candidate.local for candidate in candidates], base)
    length = Fraction(2) ** (frexp(size)[1] - 1)
    spare = Candidate("point", vector(linear.vadd(base, linear.scale(length, basis[0]))))
    rows = np.ones((len(candidates) + 1, 2), dtype=np.complex128)
    for k, candidate in enumerate((*candidates, spare)):
        x, y = in_plane(basis, difference(candidate.local, base))
        rows[k, 1] = complex(x, y) / size
    required = [k for k, candidate in enumerate(candidates) if candidate.required]
    optional = [k for k, candidate in enumerate(candidates) if not candidate.required]
    chosen, condition = _best(rows, required, optional, [len(candidates)], 2)
    return Carriers(chosen, (spare,) if len(candidates) in chosen else (), condition)


def base_point(candidates: Sequence[Candidate]) -> Vector:
    """The point shared with the parent, else the first point: the origin from which a body's edges are drawn."""
    points = [candidate for candidate in candidates if candidate.kind == "point"]
    return next((point.local for point in points if point.required), points[0].local)


def _row(candidate: Candidate, base: Vector, size: float) -> tuple[float, float, float, float]:
    if candidate.kind == "vector":
        x, y, z = candidate.local
        return (0.0, float(x), float(y), float(z))
    x, y, z = difference(candidate.local, base)
    return (1.0, float(x) / size, float(y) / size, float(z) / size)


def _auxiliary_vectors(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Directions at right angles to the body's first vector, no further than 37° apart, then the body's axes."""
    given = [candidate.local for candidate in candidates if candidate.kind == "vector"]
    found: list[Vector] = []
    if given:
        e1, e2 = complement(given[0])
        for c, s in ((1, 0), (0, 1), (4, 3), (4, -3), (3, 4), (3, -4)):
            unit = 5 if c and s else 1
            between = linear.vadd(linear.scale(Fraction(c, unit), e1), linear.scale(Fraction(s, unit), e2))
            found.append(vector(between))
    found.extend(axis for axis in AXES if axis not in found)
    return [Candidate("vector", local) for local in found]


def _shortlist(rows: Array, required: Sequence[int], optional: Sequence[int]) -> list[int]:
    """The optional rows that a pivoted Gram–Schmidt elimination after the required ones picks."""
    left = rows.copy()
    picked: list[int] = []
    for step in range(4):
        if step < len(required):
            pivot = required[step]
        else:
            norms = np.linalg.norm(left[list(optional)], axis=1)
            if norms.max() < 1 / CONDITION_LIMIT:
                break
            pivot = optional[int(np.argmax(norms > norms.max() / SLACK))]
            picked.append(pivot)
        direction = left[pivot] / np.linalg.norm(left[pivot])
        left -= np.outer(left @ direction, direction)
    return sorted(picked)


def _sets(
    required: Sequence[int], optional: Sequence[int], extra: Sequence[int], count: int, auxiliaries: int
) -> Iterator[tuple[int, ...]]:
    rest = count - len(required) - auxiliaries
    for some in combinations(optional, rest):
        for added in combinations(extra, auxiliaries):
            yield tuple(sorted((*required, *some))) + added


def _best(
    rows: Array, required: Sequence[int], optional: Sequence[int], extra: Sequence[int], count: int
) -> tuple[tuple[int, ...], float]:
    """The best-conditioned set of ``count`` rows with as few of the extra rows as the limit allows."""
    for auxiliaries in range(count - len(required) + 1):
        if count - len(required) - auxiliaries > len(optional):
            continue
        sets = list(_sets(required, optional, extra, count, auxiliaries))
        if not sets:
            continue
        values = np.linalg.svd(rows[np.array(sets)], compute_uv=False)
        conditions = values[:, 0] / np.maximum(values[:, count - 1], 1e-300)
        best = float(conditions.min())
        if best <= CONDITION_LIMIT:
            first = int(np.argmax(conditions <= SLACK * best))
            return sets[first], float(conditions[first])
    raise ArithmeticError("no independent carriers")  # a point and three axes always are


def invert_spatial(kinds: Sequence[str], locals_: Sequence[Vector], base: int) -> tuple[linear.Mat, linear.Mat]:
    """W and its exact inverse for four carriers, ``base`` one of the points.

    With the edges E (vectors, and points minus the base point) the body's axes are E⁻¹ times the edges and its
    origin is the base point minus its coordinates times the axes.
    """
    zero, one = Fraction(0), Fraction(1)
    rows = tuple(((one if kind == "point" else zero), *local) for kind, local in zip(kinds, locals_, strict=True))
    others = [k for k in range(4) if k != base]
    edges = [difference(locals_[k], locals_[base]) if kinds[k] == "point" else locals_[k] for k in others]
    adjugate = [cross(edges[1], edges[2]), cross(edges[2], edges[0]), cross(edges[0], edges[1])]
    over = 1 / product(edges[0], adjugate[0])
    axes: list[list[Fraction]] = []
    for m in range(3):
        row = [zero] * 4
        for n, k in enumerate(others):
            row[k] = adjugate[n][m] * over if adjugate[n][m] else zero
            if row[k] and kinds[k] == "point":
                row[base] -= row[k]
        axes.append(row)
    origin = [zero] * 4
    for k in range(4):
        shift = product(locals_[base], (axes[0][k], axes[1][k], axes[2][k]))
        origin[k] = one - shift if k == base else -shift
    return rows, (tuple(origin), *(tuple(row) for row in axes))


def invert_planar(first: Complex, second: Complex) -> tuple[linear.Mat, linear.Mat]:
    """W = [1 x_k] and its inverse [[x₂, −x₁], [−1, 1]] / (x₂ − x₁), Complex entries."""
    dx, dy = second[0] - first[0], second[1] - first[1]
    square = dx * dx + dy * dy
    over: Complex = (dx / square, -dy / square)
    one: Complex = (Fraction(1), Fraction(0))
    x1, x2 = complex_product(first, over), complex_product(second, over)
    inverse = ((x2, (-x1[0], -x1[1])), ((-over[0], -over[1]), over))
    return ((one, first), (one, second)), inverse


def complex_product(a: Complex, b: Complex) -> Complex:
    if not a[1] and not b[1]:
        return (a[0] * b[0], Fraction(0))
    return (a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0])
