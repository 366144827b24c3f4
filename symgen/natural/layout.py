"""The natural coordinates of a mechanism as data: entities, who carries which mass, constraints."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

from symgen.algebra.numbers import Numbers, Scalar
from symgen.natural.entities import Entity, Vector

Basis = tuple[Vector, Vector, Vector]
"""(e1, e2, n): exact, orthonormal, e1 × e2 = n."""
Complex = tuple[Fraction, Fraction]
"""Real and imaginary part."""


class Term(NamedTuple):
    """coefficient · Π x[factors] · (cos or sin of x[angle])."""

    coefficient: Fraction
    factors: tuple[int, ...]
    """None, one or two offsets in x."""
    turn: tuple[str, int] | None = None
    """(``cos`` or ``sin``, offset of the angle in x); helical joints only."""


@dataclass(frozen=True)
class Constraint:
    """One row of Ψ(x) = 0: a sum of terms, at most quadratic in points and vectors."""

    name: str
    """What it says, in the labels of the entities: ``link1: (r3-r2)·u2``."""
    kind: str
    """``length`` or ``angle`` (rigid body), ``tie`` (an entity beyond the four carriers), ``joint``."""
    body: int
    """The tree body whose rigidity or incoming joint it states."""
    terms: tuple[Term, ...]


@dataclass(frozen=True)
class NaturalCoordinates:
    """Basic points and unit vectors of a tree, the bodies' mass carriers, and their constraints.

    The coordinates x stack the moving entities in listing order, `size` rows each, in ground axes
    (in planar scenes: components along e1 and e2 of ``plane``).
    """

    plane: Basis | None
    """Planar scenes: the plane (e1, e2) and its normal n in ground axes; None in space."""
    body_planes: tuple[Basis, ...]
    """Planar scenes: per body, a basis of its own of the same plane, in body axes (same n); else empty."""
    entities: tuple[Entity, ...]
    """All of them in listing order, ground-fixed ones (``start`` None) included."""
    nn: int
    members: tuple[tuple[int, ...], ...]
    """Per body: the points and vectors fixed in it."""
    joints: tuple[tuple[int, ...], ...]
    """Per body: the entities of its incoming joint, in the order of the joint's row in `sharing`."""
    carriers: tuple[tuple[int, ...], ...]
    """Per body: the four (planar: two) entities that carry its mass; they include those shared with its parent."""
    W: tuple[Any, ...]
    """Per body 4×4, rows (1, x) for a point and (0, u) for a vector, body axes; planar 2×2, rows (1, x), Complex."""
    W_inverse: tuple[Any, ...]
    conditions: tuple[float, ...]
    """Per body: 2-norm condition number of W, lengths measured from the body's base point in units of its size."""
    constraints: tuple[Constraint, ...] = ()

    @property
    def nc(self) -> int:
        return len(self.constraints)

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """Indices of the entities that are coordinates."""
        return tuple(k for k, entity in enumerate(self.entities) if entity.start is not None)


def constant(value: Fraction | int, numbers: Numbers | None) -> Scalar:
    """An exact constant as a scalar; 0 and 1 stay the ints that linear algebra skips. Without a number
    type constants stay rationals (ints, floats, residues and SymPy expressions mix with those)."""
    if value == 0:
        return 0
    if value == 1:
        return 1
    return value if numbers is None else numbers.const(value)


def constants(values: tuple[Fraction, ...], numbers: Numbers | None) -> tuple[Scalar, ...]:
    return tuple(constant(value, numbers) for value in values)


def base_carrier(natural: NaturalCoordinates, body: int) -> int:
    """Which of the body's carriers (0 … 3) its edges start from: the point shared with the parent, else the first."""
    points = [
        (natural.entities[k].home == body, n)
        for n, k in enumerate(natural.carriers[body])
        if natural.entities[k].kind == "point"
    ]
    return min(points)[1]
