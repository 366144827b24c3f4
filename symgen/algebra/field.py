"""The prime field GF(p): where identities are decided exactly (verification, §1).

Elements know their prime. cos and sin of an element are a point of the unit circle that is a fixed
pseudo-random function of the element, odd and even as they should be: two formulas that use the same
angle get the same point, and nothing else is assumed of it. The entire functions of `Numbers` are
pseudo-random likewise, and so is the root of what is no square in the field: an identity that holds with any
symbol in the place of a root holds with the root.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from fractions import Fraction

MERSENNE_61 = 2**61 - 1


class NotInField(ArithmeticError):
    """A division by zero: the point must be drawn again."""


def inverse(x: int, p: int) -> int:
    if x % p == 0:
        raise NotInField("division by zero in GF(p)")
    return pow(x, -1, p)


class Residue:
    """An element of GF(p)."""

    __slots__ = ("p", "x")

    def __init__(self, x: int, p: int) -> None:
        self.x = x % p
        self.p = p

    def _value(self, other: object) -> int:
        if type(other) is Residue:
            return other.x
        if isinstance(other, int):
            return other
        if isinstance(other, Fraction):
            return other.numerator * inverse(other.denominator, self.p)
        raise TypeError(f"cannot mix GF(p) with {type(other).__name__}")

    def __add__(self, other: object) -> Residue:
        return Residue(self.x + self._value(other), self.p)

    __radd__ = __add__

    def __sub__(self, other: object) -> Residue:
        return Residue(self.x - self._value(other), self.p)

    def __rsub__(self, other: object) -> Residue:
        return Residue(self._value(other) - self.x, self.p)

    def __mul__(self, other: object) -> Residue:
        return Residue(self.x * self._value(other), self.p)

    __rmul__ = __mul__

    def __truediv__(self, other: object) -> Residue:
        return Residue(self.x * inverse(self._value(other), self.p), self.p)

    def __rtruediv__(self, other: object) -> Residue:
        return Residue(self._value(other) * inverse(self.x, self.p), self.p)

    def __neg__(self) -> Residue:
        return Residue(-self.x, self.p)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Residue | int | Fraction):
            return NotImplemented
        return (self.x - self._value(other)) % self.p == 0

    def __hash__(self) -> int:
        return hash((self.x, self.p))

    def __repr__(self) -> str:
        return f"{self.x} mod {self.p}"


@dataclass(frozen=True)
class FieldNumbers:
    """GF(p) as a number type. ``p`` must be 3 modulo 4 (square roots are then one power)."""

    p: int = MERSENNE_61
    seed: int = 0
    _known: dict[tuple[str, int], int] = field(default_factory=dict, compare=False, repr=False)
    _sums: dict[int, tuple[int, int]] = field(default_factory=dict, compare=False, repr=False)
    """Angles whose cosine and sine follow from those of others by the addition theorem."""

    def const(self, value: Fraction | int) -> Residue:
        if isinstance(value, int):
            return Residue(value, self.p)
        return Residue(value.numerator * inverse(value.denominator, self.p), self.p)

    def random(self, name: str, x: int) -> int:
        """A pseudo-random element, a function of (seed, name, x)."""
        key = (name, x)
        found = self._known.get(key)
        if found is None:
            text = f"{self.seed}:{self.p}:{name}:{x}".encode()
            found = self._known[key] = int.from_bytes(hashlib.blake2b(text, digest_size=16).digest(), "big") % self.p
        return found

    def angle_known(self, x: int) -> bool:
        """True when the cosine and sine of x have been asked for, or follow from others."""
        return x in self._sums or ("angle", min(x, self.p - x)) in self._known

    def add_angles(self, x: int, y: int) -> None:
        """From now on the cosine and sine of x + y are what the addition theorem makes of those of x and y."""
        p, total = self.p, (x + y) % self.p
        if total == 0 or self.angle_known(total):
            return
        cx, sx, cy, sy = (self.apply(name, z) for z in (x, y) for name in ("cos", "sin"))
        c, s = (cx * cy - sx * sy) % p, (sx * cy + cx * sy) % p
        self._sums[total], self._sums[p - total] = (c, s), (c, -s % p)

    def apply(self, function: str, x: int) -> int:
        """The value of a named function (``cos``, ``sqrt``, …) at residue x, as an int."""
        p = self.p
        if function in ("cos", "sin"):
            if x == 0:
                return 1 if function == "cos" else 0
            if x in self._sums:
                return self._sums[x][function == "sin"]
            magnitude = min(x, p - x)
            t = self.random("angle", magnitude)
            scale = inverse(1 + t * t, p)
            if function == "cos":
                return (1 - t * t) * scale % p
            return (2 * t if magnitude == x else -2 * t) * scale % p
        if function == "sqrt":
            root = pow(x, (p + 1) // 4, p)
            return root if root * root % p == x % p else self.random("sqrt", x % p)
        if x == 0:
            return inverse(6, p) if function == "sinc3_sqrt" else 1
        if function == "sinc3_sqrt":
            return (1 - self.random("sinc_sqrt", x)) * inverse(x, p) % p
        return self.random(function, x)

    def sqrt(self, x: Residue) -> Residue:
        return Residue(self.apply("sqrt", x.x), self.p)

    def cos(self, x: Residue) -> Residue:
        return Residue(self.apply("cos", x.x), self.p)

    def sin(self, x: Residue) -> Residue:
        return Residue(self.apply("sin", x.x), self.p)

    def cos_sqrt(self, x: Residue) -> Residue:
        return Residue(self.apply("cos_sqrt", x.x), self.p)

    def sinc_sqrt(self, x: Residue) -> Residue:
        return Residue(self.apply("sinc_sqrt", x.x), self.p)

    def sinc3_sqrt(self, x: Residue) -> Residue:
        return Residue(self.apply("sinc3_sqrt", x.x), self.p)


def random_prime(seed: int, bits: int = 61) -> int:
    """A prime of ``bits`` bits that is 3 modulo 4, a deterministic function of the seed."""
    counter = 0
    while True:
        digest = hashlib.blake2b(f"prime:{seed}:{counter}".encode(), digest_size=16).digest()
        candidate = (int.from_bytes(digest, "big") >> (128 - bits)) | (1 << (bits - 1)) | 3
        if candidate % 4 == 3 and is_prime(candidate):
            return candidate
        counter += 1


def is_prime(n: int) -> bool:
    """Miller–Rabin with the bases that decide every n below 3.3e24."""
    for small in (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41):
        if n % small == 0:
            return n == small
    d, r = n - 1, 0
    while d % 2 == 0:
        d, r = d // 2, r + 1
    for base in (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41):
        x = pow(base, d, n)
        if x in (1, n - 1):
            continue
        for _ in range(r - 1):
            x = x * x % n
            if x == n - 1:
                break
        else:
            return False
    return True
