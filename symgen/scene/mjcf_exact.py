"""MuJoCo's doubles made exact: rotations that are orthogonal rationals, numbers without the dust of rounding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import asin, sqrt

from symgen.scene.exact import NEAR_MISS, matmul, rotation_from_quaternion
from symgen.scene.mjcf_process import CompiledBody
from symgen.scene.model import Matrix3, Vector
from symgen.scene.mounts import Floats3
from symgen.scene.urdf import Inertia, turn_inertia

Quaternion = tuple[Fraction, Fraction, Fraction, Fraction]

DUST = Fraction(1, 10**15)
"""Relative size of what rounding leaves where a zero should be."""

ROUNDING = 1e-14
"""Angles (rad) below this are the rounding of MuJoCo's quaternions, not a change of the file's rotation."""

FINE = Fraction(1, 10**13)
"""Snap angle for principal axes of inertia: rounding only."""

SAME = Fraction(1, 10**9)

SMALLEST_SCALAR = 0.1
"""Of the rest's quaternion: half turns about an axis are another quarter turn's smaller rests."""


def _quarter_turns() -> tuple[tuple[Quaternion, Matrix3], ...]:
    """The 24 rotations that are signed permutations: integer quaternions with one, two or four entries ±1."""
    found: dict[Matrix3, Quaternion] = {}
    for parts in sorted(product((1, 0, -1), repeat=4), key=lambda p: (sum(map(abs, p)), [-x for x in p])):
        if sum(map(abs, parts)) in (1, 2, 4):
            w, x, y, z = (Fraction(part) for part in parts)
            found.setdefault(rotation_from_quaternion(w, x, y, z), (w, x, y, z))
    return tuple((quaternion, matrix) for matrix, quaternion in found.items())


QUARTER_TURNS = _quarter_turns()


@dataclass(frozen=True)
class Turn:
    """A rotation made exact, by how much that turned it, and how far from a quarter turn it is if that is little."""

    matrix: Matrix3
    raw: Floats3
    """What was described, as floats."""
    snapped: float = 0.0
    """rad"""
    near: float = 0.0
    """rad; 0 unless it is close to a quarter turn yet not snapped to it."""


def exact_turn(quaternion: Sequence[Fraction], snap: Fraction) -> Turn:
    """The rotation of a quaternion (w, x, y, z), exactly orthogonal.

    It is a quarter turn followed by a rest; parts of the rest within ``snap`` (rad) of zero become zero, so a rotation
    near a signed permutation is that, and one about a coordinate axis stays about it. ValueError for zero.
    """
    w, x, y, z = quaternion
    raw = _floats(rotation_from_quaternion(w, x, y, z))
    best, near = 0, 0.0
    chosen: tuple[Quaternion, Matrix3] | None = None
    dropped: tuple[float, ...] = ()
    for turn, matrix in QUARTER_TURNS:
        rest = _rest(turn, (w, x, y, z))
        scalar, *axis = _sizes(rest)
        axis.sort()
        if scalar < SMALLEST_SCALAR:
            continue
        small = axis if _angle(axis) <= snap else axis[:2] if _angle(axis[:2]) <= snap else []
        if len(small) > best:
            best, chosen, dropped = len(small), (rest, matrix), tuple(small)
        if _angle(axis) <= NEAR_MISS:
            near = _angle(axis)
    if chosen is None:
        return Turn(rotation_from_quaternion(w, x, y, z), raw, 0.0, near)
    rest, matrix = chosen
    a, b, c, d = (part if size > max(dropped) else Fraction(0) for part, size in zip(rest, _sizes(rest), strict=True))
    exact = matmul(matrix, rotation_from_quaternion(a, b, c, d))
    return Turn(exact, raw, _angle(dropped), 0.0 if best == 3 else near)


def _rest(turn: Quaternion, q: Quaternion) -> Quaternion:
    """conj(turn) ∘ q."""
    a, b, c, d = turn
    w, x, y, z = q
    return (
        a * w + b * x + c * y + d * z,
        a * x - b * w - c * z + d * y,
        a * y + b * z - c * w - d * x,
        a * z - b * y + c * x - d * w,
    )


def _sizes(q: Quaternion) -> tuple[float, ...]:
    """|component| of the unit quaternion."""
    parts = [float(part) for part in q]
    length = sqrt(sum(part * part for part in parts))
    return tuple(abs(part) / length for part in parts)


def _angle(sizes: Sequence[float]) -> float:
    return 2 * asin(min(1.0, sqrt(sum(size * size for size in sizes))))


def _floats(matrix: Matrix3) -> Floats3:
    return tuple((float(row[0]), float(row[1]), float(row[2])) for row in matrix)


def settled(values: Sequence[Fraction], size: Fraction) -> Vector:
    """The vector, with components that are nothing but rounding beside lengths of ``size`` made zero."""
    x, y, z = (value if abs(value) > DUST * size else Fraction(0) for value in values)
    return (x, y, z)


def exact_inertia(body: CompiledBody) -> Inertia:
    """About the centre of mass, body axes: the file's own six numbers, or R diag(moments) Rᵀ."""
    one, two, three = body.moments
    zero = Fraction(0)
    turned = turn_inertia(
        exact_turn(body.axes, FINE).matrix, ((one, zero, zero), (zero, two, zero), (zero, zero, three))
    )
    size = max(body.moments)
    if body.full and max(abs(a - b) for a, b in zip(turned, body.full, strict=True)) <= SAME * size:
        ixx, iyy, izz, ixy, ixz, iyz = body.full
        return (ixx, iyy, izz, ixy, ixz, iyz)
    return (*turned[:3], *settled(turned[3:], size))
