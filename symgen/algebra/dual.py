"""Dual numbers x + ε d, ε² = 0, over any number type: exact first derivatives by running a derivation once.

They nest: dual numbers over dual numbers give second derivatives. They are how derivatives are *defined* here; what is
emitted is computed otherwise and held to them.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symgen.algebra.field import FieldNumbers, Residue
from symgen.algebra.field_dual import FieldDual, FieldDualNumbers
from symgen.algebra.linear import add, mul, neg, sub
from symgen.algebra.numbers import Numbers

Scalar = Any


class Dual:
    """x + ε d. A structural zero d (int 0) costs nothing."""

    __slots__ = ("d", "x")

    def __init__(self, x: Scalar, d: Scalar = 0) -> None:
        self.x = x
        self.d = d

    def __add__(self, other: Scalar) -> Dual:
        x, d = parts(other)
        return Dual(add(self.x, x), add(self.d, d))

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Dual:
        x, d = parts(other)
        return Dual(sub(self.x, x), sub(self.d, d))

    def __rsub__(self, other: Scalar) -> Dual:
        x, d = parts(other)
        return Dual(sub(x, self.x), sub(d, self.d))

    def __mul__(self, other: Scalar) -> Dual:
        x, d = parts(other)
        return Dual(mul(self.x, x), add(mul(self.d, x), mul(self.x, d)))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Dual:
        x, d = parts(other)
        ratio = self.x / x
        change = sub(self.d, mul(ratio, d))
        return Dual(ratio, change if type(change) is int and change == 0 else change / x)

    def __rtruediv__(self, other: Scalar) -> Dual:
        return Dual(*parts(other)) / self

    def __neg__(self) -> Dual:
        return Dual(neg(self.x), neg(self.d))

    def __repr__(self) -> str:
        return f"{self.x} + ε {self.d}"


def parts(value: Scalar) -> tuple[Scalar, Scalar]:
    """(x, d) of a dual number, or of a plain one, whose d is 0."""
    if type(value) is FieldDual:
        return Residue(value.x, value.p), Residue(value.d, value.p)
    return (value.x, value.d) if type(value) is Dual else (value, 0)


def change_of(value: Scalar) -> Scalar:
    return parts(value)[1]


@dataclass(frozen=True)
class DualNumbers:
    """Dual numbers over another number type."""

    numbers: Numbers

    def const(self, value: Fraction | int) -> Dual:
        return Dual(self.numbers.const(value))

    def sqrt(self, x: Scalar) -> Dual:
        value, change = parts(x)
        root = self.numbers.sqrt(value)
        return Dual(root, 0 if type(change) is int and change == 0 else change / (2 * root))

    def cos(self, x: Scalar) -> Dual:
        value, change = parts(x)
        return Dual(self.numbers.cos(value), neg(mul(self.numbers.sin(value), change)))

    def sin(self, x: Scalar) -> Dual:
        value, change = parts(x)
        return Dual(self.numbers.sin(value), mul(self.numbers.cos(value), change))

    def _constant_only(self, name: str, x: Scalar) -> Dual:
        value, change = parts(x)
        if not (type(change) is int and change == 0):
            raise NotImplementedError(f"{name} is not differentiated")
        return Dual(getattr(self.numbers, name)(value))

    def cos_sqrt(self, x: Scalar) -> Dual:
        return self._constant_only("cos_sqrt", x)

    def sinc_sqrt(self, x: Scalar) -> Dual:
        return self._constant_only("sinc_sqrt", x)

    def sinc3_sqrt(self, x: Scalar) -> Dual:
        return self._constant_only("sinc3_sqrt", x)


def dual_numbers(numbers: Numbers) -> DualNumbers | FieldDualNumbers:
    """Dual numbers over a number type: those of their own over GF(p)."""
    return FieldDualNumbers(numbers) if isinstance(numbers, FieldNumbers) else DualNumbers(numbers)


def dual(numbers: DualNumbers | FieldDualNumbers, x: Scalar, d: Scalar = 0) -> Scalar:
    """x + ε d of scalars of the number type below; structural zeros and ones may be among them."""
    if isinstance(numbers, DualNumbers):
        return Dual(x, d)
    const, p = numbers.numbers.const, numbers.numbers.p
    value, change = (part if type(part) is Residue else const(part) for part in (x, d))
    return FieldDual(value.x, change.x, p)
