"""Vectors and matrices over any number type: tuples of scalars, and plain functions.

A scalar is anything with ``+ - *`` (and ``/`` where a formula divides): float, Fraction,
SymPy expression, CasADi SX, element of GF(p), node of the exact graph. The int 0 is the zero
of every number type; sums skip it, so that structural zeros cost nothing in any of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

Scalar = Any
Vec = tuple[Scalar, ...]
Mat = tuple[Vec, ...]
"""A tuple of rows."""

ZERO: Vec = (0, 0, 0)
IDENTITY: Mat = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def is_zero(x: Scalar) -> bool:
    """True for a structural zero: the int or rational 0, whatever the number type of the rest."""
    return type(x) is int and x == 0


def known_value(x: Scalar) -> int | Fraction | None:
    """The number that a scalar is in every configuration, where it shows: a structural one, a rational, a constant of
    the exact graph."""
    value = getattr(x, "value", x)
    return value if isinstance(value, int | Fraction) else None


def add(x: Scalar, y: Scalar) -> Scalar:
    if type(x) is int and x == 0:  # `is_zero` written out, here and below: these are called millions of times
        return y
    return x if type(y) is int and y == 0 else x + y


def sub(x: Scalar, y: Scalar) -> Scalar:
    if type(y) is int and y == 0:
        return x
    return -y if type(x) is int and x == 0 else x - y


def mul(x: Scalar, y: Scalar) -> Scalar:
    if type(x) is int:
        if x == 0:
            return 0
        if x == 1:
            return y
    if type(y) is int:
        if y == 0:
            return 0
        if y == 1:
            return x
    return x * y


def neg(x: Scalar) -> Scalar:
    return 0 if type(x) is int and x == 0 else -x


def half(x: Scalar) -> Scalar:
    """x / 2, a structural zero staying one, and every int exact."""
    if type(x) is int:
        return Fraction(x, 2) if x else 0
    return x / 2


def total(terms: Iterable[Scalar]) -> Scalar:
    result: Scalar = 0
    for term in terms:
        if type(term) is not int or term != 0:
            result = add(result, term)
    return result


def dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    result: Scalar = 0
    for x, y in zip(a, b, strict=True):
        if (type(x) is int and x == 0) or (type(y) is int and y == 0):
            continue
        result = add(result, mul(x, y))
    return result


def vadd(a: Vec, b: Vec) -> Vec:
    return tuple([add(x, y) for x, y in zip(a, b, strict=True)])


def vsub(a: Vec, b: Vec) -> Vec:
    return tuple([sub(x, y) for x, y in zip(a, b, strict=True)])


def vneg(a: Vec) -> Vec:
    return tuple([sub(0, x) for x in a])


def scale(s: Scalar, a: Vec) -> Vec:
    return tuple([mul(s, x) for x in a])


def cross(a: Vec, b: Vec) -> Vec:
    """a × b."""
    return (
        sub(mul(a[1], b[2]), mul(a[2], b[1])),
        sub(mul(a[2], b[0]), mul(a[0], b[2])),
        sub(mul(a[0], b[1]), mul(a[1], b[0])),
    )


def skew(a: Vec) -> Mat:
    """The matrix ã with ã b = a × b (the paper's D for d, U for u)."""
    return ((0, sub(0, a[2]), a[1]), (a[2], 0, sub(0, a[0])), (sub(0, a[1]), a[0], 0))


def transpose(m: Mat) -> Mat:
    return tuple(zip(*m, strict=True))


def matvec(m: Mat, x: Vec) -> Vec:
    return tuple([dot(row, x) for row in m])


def vecmat(x: Vec, m: Mat) -> Vec:
    """xᵀ m, that is mᵀ x."""
    return tuple([dot(x, column) for column in zip(*m, strict=True)])


def matmul(a: Mat, b: Mat) -> Mat:
    columns = transpose(b)
    return tuple([tuple([dot(row, column) for column in columns]) for row in a])


def madd(a: Mat, b: Mat) -> Mat:
    return tuple(vadd(x, y) for x, y in zip(a, b, strict=True))


def mscale(s: Scalar, a: Mat) -> Mat:
    return tuple(scale(s, row) for row in a)


def outer(a: Vec, b: Vec) -> Mat:
    return tuple(scale(x, b) for x in a)


def symmetric(six: Sequence[Scalar]) -> Mat:
    """(xx, yy, zz, xy, xz, yz) → 3×3."""
    xx, yy, zz, xy, xz, yz = six
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
