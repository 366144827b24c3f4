"""Exact numbers: decimals as rationals, rational unit vectors, rational rotations (theory.md §8).

Nothing here rounds to float. Where a square root or a sine is needed it is taken in integers
or in extended precision, and the result is a rational that lies *exactly* on the sphere or
*exactly* in the rotation group, within 1e-17 of what was described.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import gcd, isqrt, lcm
from typing import Any

from mpmath import MPContext

from symgen.scene.model import IDENTITY3, Matrix3, Vector

MAX_DIGITS = 400
"""Longest number accepted, in characters."""
MAX_EXPONENT = 400
SMALLEST, LARGEST = Fraction(1, 10**300), Fraction(10) ** 300
"""Magnitudes accepted (zero apart): what a double holds, with room for products."""

GRID_BITS = 60
PRECISION_BITS = 256
NEAR_MISS = Fraction(2, 1000)
"""A turn this close to a quarter turn (rad), yet outside ``snap``, was probably rounded by hand: 1.57, 3.14."""

_NUMBER = re.compile(r"([-+]?)(\d*)(?:\.(\d*))?(?:[eE]([-+]?\d+))?", re.ASCII)


def decimal(text: str) -> Fraction:
    """The exact value of a decimal number such as ``-0.1``, ``3``, ``.5`` or ``1e-3``.

    Raises ValueError with a message for the user (without the place).
    """
    match = _NUMBER.fullmatch(text) if len(text) <= MAX_DIGITS else None
    if len(text) > MAX_DIGITS:
        raise ValueError(f"the number {text[:12]}… has {len(text)} characters; at most {MAX_DIGITS} are read")
    if match is None or not (match[2] or match[3]):
        raise ValueError(f"{text!r} is not a decimal number")
    sign, whole, part, exponent = match[1], match[2], match[3] or "", match[4] or "0"
    if len(exponent) > 6 or abs(int(exponent)) > MAX_EXPONENT:
        raise ValueError(f"the exponent of {text} is beyond ±{MAX_EXPONENT}")
    value = Fraction(int(whole + part)) * Fraction(10) ** (int(exponent) - len(part))
    return check_range(-value if sign == "-" else value, text)


def check_range(value: Fraction, text: str = "") -> Fraction:
    """``value``, if a double can hold it; ValueError otherwise."""
    if value and not SMALLEST <= abs(value) <= LARGEST:
        raise ValueError(f"the number {text or 'given'} is outside the range 1e-300 … 1e300")
    return value


def exact_sqrt(x: Fraction) -> Fraction | None:
    """√x if it is rational, else None."""
    top, bottom = isqrt(x.numerator), isqrt(x.denominator)
    if top * top == x.numerator and bottom * bottom == x.denominator:
        return Fraction(top, bottom)
    return None


def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _rows(rows: Sequence[Sequence[Fraction]]) -> Matrix3:
    a, b, c = ((row[0], row[1], row[2]) for row in rows)
    return (a, b, c)


def matvec(m: Matrix3, x: Vector) -> Vector:
    """m x."""
    rows = [sum((a * b for a, b in zip(row, x, strict=True)), Fraction(0)) for row in m]
    return (rows[0], rows[1], rows[2])


def transpose(m: Matrix3) -> Matrix3:
    rows = list(zip(*m, strict=True))
    return (rows[0], rows[1], rows[2])


def matmul(a: Matrix3, b: Matrix3) -> Matrix3:
    """a b."""
    columns = [matvec(a, column) for column in transpose(b)]
    return transpose((columns[0], columns[1], columns[2]))


def unit_vector(v: Vector) -> Vector:
    """A rational point of the unit sphere in the direction of ``v``, within 1e-17 of it.

    Directions whose length is rational stay as they are. For the rest, stereographic projection
    from the point opposite the largest component, on a 2⁻⁶⁰ grid. Parallel vectors give the same
    point and antiparallel ones exactly its negative; a zero component stays zero.
    Raises ValueError for the zero vector.
    """
    if not any(v):
        raise ValueError("the zero vector has no direction")
    scale = lcm(*(x.denominator for x in v))
    whole = [int(x * scale) for x in v]
    divisor = gcd(*whole)
    whole = [x // divisor for x in whole]
    pole = max(range(3), key=lambda i: (abs(whole[i]), -i))
    sign = 1 if whole[pole] > 0 else -1
    whole = [sign * x for x in whole]
    squared = sum(x * x for x in whole)
    length = exact_sqrt(Fraction(squared))
    point = [Fraction(x) / length for x in whole] if length else _stereographic(whole, pole, squared)
    return (sign * point[0], sign * point[1], sign * point[2])


def _stereographic(whole: list[int], pole: int, squared: int) -> list[Fraction]:
    """Round the direction on the plane, where any rational point belongs to a rational point of the sphere."""
    bits = PRECISION_BITS
    bottom = isqrt(squared << 2 * bits) + (whole[pole] << bits)
    plane = [Fraction(round(Fraction(x << (GRID_BITS + bits), bottom)), 1 << GRID_BITS) for x in whole]
    plane[pole] = Fraction(0)
    norm = sum((t * t for t in plane), Fraction(1))
    return [(2 - norm) / norm if i == pole else 2 * t / norm for i, t in enumerate(plane)]


@dataclass(frozen=True)
class Rotation:
    """A mounting rotation made exact."""

    matrix: Matrix3
    """Exactly orthogonal, determinant 1."""
    raw: tuple[tuple[float, float, float], ...]
    """What was described, as floats, before anything was snapped."""
    snapped: float | None = None
    """Angle (rad) by which snapping turned it; None when nothing was snapped."""
    near_misses: tuple[tuple[str, str], ...] = ()
    """(angle as given, value that would snap) of every turn that is close to a quarter turn, yet outside ``snap``."""


Quaternion = tuple[Any, Any, Any, Any]
"""(w, x, y, z)."""


_ONE: Quaternion = (Fraction(1), Fraction(0), Fraction(0), Fraction(0))


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def _matrix(q: Quaternion) -> Any:
    """Rotation matrix of a quaternion (w, x, y, z) of any length but zero."""
    w, x, y, z = q
    n = w * w + x * x + y * y + z * z
    return (
        ((w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n),
        (2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n),
        (2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n),
    )


def rotation_from_quaternion(w: Fraction, x: Fraction, y: Fraction, z: Fraction) -> Matrix3:
    """Exactly orthogonal matrix of a rational quaternion of any length but zero."""
    if not any((w, x, y, z)):
        raise ValueError("the zero quaternion is no rotation")
    matrix: Matrix3 = _matrix((w, x, y, z))
    return matrix


def turn_to(direction: Vector) -> Matrix3:
    """The smallest rotation that takes z to an exact unit vector; exact. Opposite to z: half a turn about x."""
    x, y, z = direction
    if z == -1:
        return rotation_from_quaternion(Fraction(0), Fraction(1), Fraction(0), Fraction(0))
    return rotation_from_quaternion(1 + z, -y, x, Fraction(0))


def roll_pitch_yaw(matrix: Matrix3) -> Vector:
    """URDF's fixed-axis angles (rad) of a rotation, as the decimals of the nearest doubles; roll is 0 at pitch ±π/2."""
    context = _context_of(PRECISION_BITS)
    (r00, r01, _), (r10, r11, _), (r20, r21, r22) = ([_real(context, x) for x in row] for row in matrix)
    level = context.sqrt(r00 * r00 + r10 * r10)
    pitch = context.atan2(-r20, level)
    upright = matrix[0][0] == 0 == matrix[1][0]
    roll = 0 if upright else context.atan2(r21, r22)
    yaw = context.atan2(-r01, r11) if upright else context.atan2(r10, r00)
    angles = [Fraction(repr(float(angle))) for angle in (roll, pitch, yaw)]
    return (angles[0], angles[1], angles[2])


def _context(*angles: Fraction) -> Any:
    """Extended precision enough for angles of this size."""
    size = max(abs(a.numerator).bit_length() - a.denominator.bit_length() for a in angles)
    return _context_of(PRECISION_BITS + max(size, 0))


@lru_cache(maxsize=8)
def _context_of(bits: int) -> Any:
    context = MPContext()
    context.prec = bits
    return context


def _real(context: Any, x: Fraction) -> Any:
    return context.mpf(x.numerator) / x.denominator


def _on_grid(context: Any, q: Quaternion) -> Quaternion:
    """Each component to the 2⁻⁶⁰ grid; an exact zero stays zero."""
    w, x, y, z = (Fraction(int(context.nint(context.ldexp(part, GRID_BITS))), 1 << GRID_BITS) for part in q)
    return (w, x, y, z)


def _quarter(context: Any, angle: Fraction) -> tuple[int, Any]:
    """(k, |angle − k π/2|) for the nearest quarter turn."""
    turns = int(context.nint(_real(context, angle) / (context.pi / 2)))
    return turns, abs(_real(context, angle) - turns * context.pi / 2)


def _quarter_turn(axis: int, turns: int) -> Matrix3:
    """The signed permutation of ``turns`` quarter turns about a coordinate axis."""
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[turns % 4]
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rows = [[Fraction(0)] * 3 for _ in range(3)]
    rows[axis][axis] = Fraction(1)
    rows[i][i], rows[i][j], rows[j][i], rows[j][j] = Fraction(c), Fraction(-s), Fraction(s), Fraction(c)
    return _rows(rows)


def _half_turn(context: Any, axis: int, angle: Fraction) -> Quaternion:
    q: list[Any] = [context.cos(_real(context, angle) / 2), 0, 0, 0]
    q[1 + axis] = context.sin(_real(context, angle) / 2)
    return (q[0], q[1], q[2], q[3])


def rotation_from_rpy(rpy: Sequence[Fraction], snap: Fraction = Fraction(1, 10**6)) -> Rotation:
    """R = Rz(yaw) Ry(pitch) Rx(roll), URDF's fixed-axis angles in radians, exactly orthogonal.

    A turn within ``snap`` (rad) of a multiple of π/2 is that multiple, and a whole rotation within
    ``snap`` of one of the 24 signed permutations is that permutation. Each turn that remains is that
    of a rational quaternion on a 2⁻⁶⁰ grid, rounded before they are multiplied, so that entries of R
    that are zero by structure are exactly zero.
    """
    roll, pitch, yaw = rpy
    return _rotation(roll, pitch, yaw, snap)


@lru_cache(maxsize=1024)
def _rotation(roll: Fraction, pitch: Fraction, yaw: Fraction, snap: Fraction) -> Rotation:
    if not (roll or pitch or yaw):
        return Rotation(IDENTITY3, _floats(IDENTITY3))
    context = _context(roll, pitch, yaw)
    exact, rest = IDENTITY3, _ONE  # R so far = exact · rest
    misses: list[tuple[str, str]] = []
    snapped = False
    for axis, angle in ((2, yaw), (1, pitch), (0, roll)):
        turns, off = _quarter(context, angle)
        if off <= _real(context, snap):
            snapped = snapped or angle != 0
            turn = _quarter_turn(axis, turns)
            exact = matmul(exact, turn)
            rest = (rest[0], *matvec(transpose(turn), (rest[1], rest[2], rest[3])))
        else:
            rest = _product(rest, _on_grid(context, _half_turn(context, axis, angle)))
            if turns and off <= _real(context, NEAR_MISS):
                misses.append((repr(float(angle)), repr(float(turns * context.pi / 2))))
    matrix = matmul(exact, _matrix(rest))
    nearest = nearest_signed_permutation(matrix)
    # ‖R − P‖² = 8 sin²(angle/2), which is 2·angle² for the small angles of interest
    if nearest is not None and nearest != matrix and _distance_squared(matrix, nearest) <= 2 * snap * snap:
        matrix, snapped, misses = nearest, True, []
    if not snapped:
        return Rotation(matrix, _floats(matrix), None, tuple(misses))
    described = _described(context, roll, pitch, yaw)
    moved = _distance_squared([[_real(context, x) for x in row] for row in matrix], described)
    return Rotation(matrix, _floats(described), float(2 * context.asin(context.sqrt(moved / 8))), tuple(misses))


def _described(context: Any, roll: Fraction, pitch: Fraction, yaw: Fraction) -> Any:
    """The rotation as it was given, in extended precision."""
    turns = [_half_turn(context, axis, angle) for axis, angle in ((2, yaw), (1, pitch), (0, roll))]
    return _matrix(_product(_product(turns[0], turns[1]), turns[2]))


def _floats(matrix: Any) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(row[0]), float(row[1]), float(row[2])) for row in matrix)


def _distance_squared(a: Any, b: Any) -> Any:
    return sum((x - y) ** 2 for r, s in zip(a, b, strict=True) for x, y in zip(r, s, strict=True))


def nearest_signed_permutation(matrix: Matrix3) -> Matrix3 | None:
    """The signed permutation each of whose entries is the nearest integer; None if that is not one."""
    rows = [[Fraction(round(x)) for x in row] for row in matrix]
    candidate = _rows(rows)
    return candidate if matmul(candidate, transpose(candidate)) == IDENTITY3 else None


def rotation_about(axis: Vector, angle: Fraction, snap: Fraction = Fraction(1, 10**6)) -> Matrix3:
    """Rodrigues: c·1 + (1−c) u uᵀ + s ũ about an exact unit vector, with c² + s² = 1 exactly.

    An angle (rad) within ``snap`` of a multiple of π/2 is that multiple.
    """
    context = _context(angle)
    turns, off = _quarter(context, angle)
    if off <= _real(context, snap):
        cosine, sine = (Fraction(x) for x in ((1, 0), (0, 1), (-1, 0), (0, -1))[turns % 4])
    else:
        c, s = _on_grid(context, _half_turn(context, 0, angle))[:2]
        cosine, sine = (c * c - s * s) / (c * c + s * s), 2 * c * s / (c * c + s * s)
    x, y, z = axis
    skew = ((0, -z, y), (z, 0, -x), (-y, x, 0))
    rows = [
        [(cosine if i == j else 0) + (1 - cosine) * axis[i] * axis[j] + sine * skew[i][j] for j in range(3)]
        for i in range(3)
    ]
    return _rows(rows)
