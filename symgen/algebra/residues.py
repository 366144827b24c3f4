"""Many points of prime fields at once: arrays of residues, each with a prime of its own below 2³¹.

For ranks and for rational numbers found from their residues, where a point at a time would take too long. Products fit
64 bits. cos and sin are as in `symgen.algebra.field`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.algebra.field import NotInField

Ints = NDArray[np.int64]
LARGEST = 2**31 - 1


def inverses(x: Ints, p: Ints) -> Ints:
    """x⁻¹ mod p, entry by entry. Raises NotInField where x is 0."""
    if not np.all(x):
        raise NotInField("division by zero in GF(p)")
    return np.array([pow(a, -1, b) for a, b in zip(x.tolist(), p.tolist(), strict=True)], dtype=np.int64)


class Residues:
    """One scalar at many points: element i is x[i] mod p[i]."""

    __slots__ = ("p", "x")

    def __init__(self, x: Ints, p: Ints) -> None:
        self.x = x
        self.p = p

    def _value(self, other: Any) -> Ints | int:
        if type(other) is Residues:
            return other.x
        if isinstance(other, int) and abs(other) <= LARGEST:
            return other
        return reduced(Fraction(other), self.p)

    def __add__(self, other: Any) -> Residues:
        return Residues((self.x + self._value(other)) % self.p, self.p)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Residues:
        return Residues((self.x - self._value(other)) % self.p, self.p)

    def __rsub__(self, other: Any) -> Residues:
        return Residues((self._value(other) - self.x) % self.p, self.p)

    def __mul__(self, other: Any) -> Residues:
        return Residues(self.x * self._value(other) % self.p, self.p)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Residues:
        if type(other) is int and other == 2:
            return Residues(np.where(self.x & 1, self.x + self.p, self.x) >> 1, self.p)
        divisor = np.broadcast_to(np.asarray(self._value(other)), self.x.shape) % self.p
        return Residues(self.x * inverses(divisor, self.p) % self.p, self.p)

    def __rtruediv__(self, other: Any) -> Residues:
        return Residues(self._value(other) * inverses(self.x, self.p) % self.p, self.p)

    def __neg__(self) -> Residues:
        return Residues(-self.x % self.p, self.p)


def reduced(value: Fraction, p: Ints) -> Ints:
    """A rational modulo every prime. Raises NotInField where its denominator is 0."""
    kinds, place = np.unique(p, return_inverse=True)
    found = []
    for prime in kinds.tolist():
        if value.denominator % prime == 0:
            raise NotInField("division by zero in GF(p)")
        found.append(value.numerator * pow(value.denominator, -1, prime) % prime)
    return np.array(found, dtype=np.int64)[place.reshape(p.shape)]


@dataclass(frozen=True)
class ResidueNumbers:
    """The number type: ``p`` holds the prime of every point."""

    p: Ints
    seed: int
    _known: dict[tuple[int, int], Residues] = field(default_factory=dict, compare=False, repr=False)

    def const(self, value: Fraction | int) -> Residues:
        key = (value.numerator, value.denominator)
        if key not in self._known:
            self._known[key] = Residues(reduced(Fraction(value), self.p), self.p)
        return self._known[key]

    def _random(self, x: Ints) -> Ints:
        """A pseudo-random residue for every residue (splitmix64 of it and the seed)."""
        z = x.astype(np.uint64) + np.uint64(self.seed * 0x9E3779B97F4A7C15 % 2**64)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return ((z ^ (z >> np.uint64(31))) % self.p.astype(np.uint64)).astype(np.int64)

    def _circle(self, x: Residues) -> tuple[Ints, Ints, Ints]:
        """1 / (1 + t²), 1 − t² and ± 2t."""
        lower = x.x <= self.p - x.x
        t = self._random(np.where(lower, x.x, self.p - x.x))
        t = np.where(x.x == 0, 0, t)
        square = t * t % self.p
        twice = np.where(lower, 2 * t, -2 * t) % self.p
        return inverses((1 + square) % self.p, self.p), (1 - square) % self.p, twice

    def cos(self, x: Residues) -> Residues:
        over, numerator, _ = self._circle(x)
        return Residues(numerator * over % self.p, self.p)

    def sin(self, x: Residues) -> Residues:
        over, _, numerator = self._circle(x)
        return Residues(numerator * over % self.p, self.p)

    def _none(self, x: Residues) -> Residues:
        raise NotImplementedError("residues of many points have no roots")

    sqrt = cos_sqrt = sinc_sqrt = sinc3_sqrt = _none
