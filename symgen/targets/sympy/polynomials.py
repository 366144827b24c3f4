"""Exact polynomials as a number type: cosines, sines, rates and parameters are generators, relations are reduced away.

Run on it, a derivation comes out in a normal form: two expressions are equal exactly when their terms are. So nothing
is left to "simplify", and the SymPy expression is built once, at the end, from few terms. Generators come as they are
needed (roots and quotients of springs, norms of quaternions), which SymPy's rings do not offer; and its exponent tuples
and term-by-term rationals cost some thirty times as much here.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import gcd, lcm
from typing import Any

WIDTH = 8
"""Bits per exponent in a packed monomial: the product of two monomials is the sum of two ints."""
AT_LEAST = {1: 0xFF, 2: 0xFE}
Terms = dict[int, Any]
"""{packed monomial: numerator}; rationals only while a relation with rational coefficients is applied."""


class TooLargeError(Exception):
    """The closed form has more terms than anybody would read."""


@dataclass(frozen=True)
class Relation:
    """A monomial that is rewritten: it divides a term where the term's bits meet every mask."""

    masks: tuple[int, ...]
    monomial: int
    replacement: tuple[tuple[int, Any], ...]


@dataclass(frozen=True)
class Generator:
    """``kind``: ``symbol``; ``cos``, ``sin`` (``meaning``: the angle as {symbol generator: ±1}); or a function of a
    polynomial (``meaning``): ``cos_of``, ``sin_of``, ``sqrt``, ``inverse``, ``cos_sqrt``, …."""

    index: int
    kind: str
    meaning: Any

    @property
    def monomial(self) -> int:
        return 1 << (WIDTH * self.index)


@dataclass
class Ring:
    """The generators made so far and the relations among them. ``budget`` limits the products of terms."""

    budget: int = 400_000
    generators: list[Generator] = field(default_factory=list)
    relations: list[Relation] = field(default_factory=list)
    suspects: int = 0
    """Bits of which one must be set in a term for any relation to apply."""
    _opaque: dict[tuple[str, int, frozenset[tuple[int, int]]], Generator] = field(default_factory=dict)

    def generator(self, kind: str, meaning: Any) -> Generator:
        found = Generator(len(self.generators), kind, meaning)
        self.generators.append(found)
        return found

    def const(self, value: Fraction | int) -> Polynomial:
        exact = Fraction(value)
        return Polynomial(self, {0: exact.numerator} if exact else {}, exact.denominator)

    def sole(self, generator: Generator) -> Polynomial:
        return Polynomial(self, {generator.monomial: 1})

    def symbol(self, meaning: Any) -> Polynomial:
        """A generator without relations; ``meaning`` is what it becomes in the end."""
        return self.sole(self.generator("symbol", meaning))

    def angle(self, meaning: dict[int, int]) -> tuple[Polynomial, Polynomial]:
        """(cos, sin) of a sum of symbol generators with sin² = 1 − cos²."""
        c, s = self.generator("cos", meaning), self.generator("sin", meaning)
        self.relate(((s.index, 2),), ((0, 1), (2 * c.monomial, -1)))
        return self.sole(c), self.sole(s)

    def relate(self, leading: Sequence[tuple[int, int]], replacement: Iterable[tuple[int, Any]]) -> None:
        """Rewrite the monomial Π generator^exponent (exponents 1 or 2) wherever it divides a term."""
        masks = tuple(AT_LEAST[exponent] << (WIDTH * index) for index, exponent in leading)
        monomial = sum(exponent << (WIDTH * index) for index, exponent in leading)
        self.relations.append(Relation(masks, monomial, tuple(replacement)))
        self.suspects |= masks[0]

    def spend(self, products: int) -> None:
        self.budget -= products
        if self.budget < 0:
            raise TooLargeError

    def reduced(self, terms: Terms) -> Terms:
        """The normal form of a sum of terms."""
        if not any(monomial & self.suspects for monomial in terms):
            return {monomial: value for monomial, value in terms.items() if value}
        result: Terms = {}
        while terms:
            self.spend(len(terms))
            again: Terms = {}
            for monomial, value in terms.items():
                if not value:
                    continue
                relation = self._applies(monomial) if monomial & self.suspects else None
                if relation is None:
                    result[monomial] = result[monomial] + value if monomial in result else value
                    continue
                rest = monomial - relation.monomial
                for factor, coefficient in relation.replacement:
                    key = rest + factor
                    part = value if coefficient == 1 else value * coefficient
                    again[key] = again[key] + part if key in again else part
            terms = again
        return {monomial: value for monomial, value in result.items() if value}

    def _applies(self, monomial: int) -> Relation | None:
        for relation in self.relations:
            if all(monomial & mask for mask in relation.masks):
                return relation
        return None

    def function(self, kind: str, argument: Polynomial) -> Polynomial:
        """A generator for a function of a polynomial (one per function and argument)."""
        key = (kind, argument.denominator, frozenset(argument.terms.items()))
        known = self._opaque.get(key)
        if known is None:
            known = self._opaque[key] = self.generator(kind, argument)
            if kind == "sqrt":
                self.relate(((known.index, 2),), argument.coefficients.items())
            if kind == "sin_of":
                cosine = self.function("cos_of", argument).sole
                assert cosine is not None
                self.relate(((known.index, 2),), ((0, 1), (2 * cosine.monomial, -1)))
            if kind == "inverse":
                self._relate_inverse(known, argument)
        return self.sole(known)

    def _relate_inverse(self, inverse: Generator, argument: Polynomial) -> None:
        """x · (1/x) = 1 where x is one generator or a sum of squares of generators (the norm of a quaternion)."""
        powers = [exponents(monomial) for monomial in argument.terms]
        if not all(len(row) == 1 and row[0][1] == (1 if len(powers) == 1 else 2) for row in powers):
            return
        terms = argument.coefficients
        last = max(terms)
        leading = exponents(last)[0]
        scale = whole(1 / terms[last])
        replacement = [(0, scale)]
        replacement += [(m + inverse.monomial, whole(-scale * k)) for m, k in terms.items() if m != last]
        self.relate(((inverse.index, 1), leading), replacement)


def exponents(monomial: int) -> list[tuple[int, int]]:
    """[(generator index, exponent), …] of a packed monomial."""
    found, index = [], 0
    while monomial:
        exponent = monomial & 0xFF
        if exponent:
            found.append((index, exponent))
        monomial >>= WIDTH
        index += 1
    return found


def whole(value: Fraction) -> Fraction | int:
    """An int where a rational is one: relations with integers keep numerators integers."""
    return value.numerator if value.denominator == 1 else value


class Polynomial:
    """Σ numerator · monomial / denominator in lowest terms and in normal form. Immutable; mixes with ints and
    rationals. (One denominator for all: rationals term by term would spend their time in greatest common divisors.)"""

    __slots__ = ("denominator", "ring", "terms")

    def __init__(self, ring: Ring, terms: Terms, denominator: int = 1) -> None:
        self.ring = ring
        self.terms = terms
        self.denominator = denominator

    @property
    def coefficients(self) -> dict[int, Fraction]:
        return {monomial: Fraction(value, self.denominator) for monomial, value in self.terms.items()}

    def _normal(self, terms: Terms, denominator: int) -> Polynomial:
        fractions = [value.denominator for value in terms.values() if type(value) is Fraction]
        if fractions:
            factor = lcm(*fractions)
            terms = {monomial: int(value * factor) for monomial, value in terms.items()}
            denominator *= factor
        divisor = gcd(denominator, *terms.values()) if denominator != 1 else 1
        if divisor != 1:
            terms = {monomial: value // divisor for monomial, value in terms.items()}
            denominator //= divisor
        return Polynomial(self.ring, terms, denominator)

    def _lift(self, other: Any) -> Polynomial:
        return other if isinstance(other, Polynomial) else self.ring.const(other)

    def _sum(self, other: Polynomial, sign: int) -> Polynomial:
        common = lcm(self.denominator, other.denominator)
        mine, theirs = common // self.denominator, sign * (common // other.denominator)
        terms = {monomial: value * mine for monomial, value in self.terms.items()} if mine != 1 else dict(self.terms)
        for monomial, value in other.terms.items():
            if monomial in terms:
                found = terms[monomial] + value * theirs
                if found:
                    terms[monomial] = found
                else:
                    del terms[monomial]
            else:
                terms[monomial] = value * theirs
        return self._normal(terms, common)

    def __add__(self, other: Any) -> Polynomial:
        return self._sum(self._lift(other), 1)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Polynomial:
        return self._sum(self._lift(other), -1)

    def __rsub__(self, other: Any) -> Polynomial:
        return self._lift(other)._sum(self, -1)

    def __neg__(self) -> Polynomial:
        return Polynomial(self.ring, {monomial: -value for monomial, value in self.terms.items()}, self.denominator)

    def __mul__(self, other: Any) -> Polynomial:
        factor = self._lift(other)
        self.ring.spend(len(self.terms) * len(factor.terms))
        terms: Terms = {}
        for m, a in self.terms.items():
            for n, b in factor.terms.items():
                key = m + n
                terms[key] = terms[key] + a * b if key in terms else a * b
        return self._normal(self.ring.reduced(terms), self.denominator * factor.denominator)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Polynomial:
        divisor = self._lift(other)
        if set(divisor.terms) == {0}:
            return self * Fraction(divisor.denominator, divisor.terms[0])
        return self * self.ring.function("inverse", divisor)

    def __rtruediv__(self, other: Any) -> Polynomial:
        return self._lift(other) / self

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Polynomial | int | Fraction):
            return False
        theirs = self._lift(other)
        return self.terms == theirs.terms and (self.denominator == theirs.denominator or not self.terms)

    def __hash__(self) -> int:
        return hash(frozenset(self.coefficients.items()))

    def __bool__(self) -> bool:
        return bool(self.terms)

    @property
    def sole(self) -> Generator | None:
        """The generator this is, if it is one."""
        if len(self.terms) != 1:
            return None
        ((monomial, value),) = self.terms.items()
        powers = exponents(monomial)
        if value != 1 or self.denominator != 1 or len(powers) != 1 or powers[0][1] != 1:
            return None
        return self.ring.generators[powers[0][0]]


@dataclass(frozen=True)
class PolynomialNumbers:
    """Polynomials of one ring as a number type; ``turns``: symbol generator → (cos, sin) of it."""

    ring: Ring
    turns: dict[int, tuple[Polynomial, Polynomial]]

    def const(self, value: Fraction | int) -> Polynomial:
        return self.ring.const(value)

    def _turn(self, x: Polynomial) -> tuple[Polynomial, Polynomial]:
        """Of a joint angle; or of a polynomial (a coupled joint's angle, a parameter) without sums taken apart."""
        sole = x.sole
        if sole is None or sole.index not in self.turns:
            return self.ring.function("cos_of", x), self.ring.function("sin_of", x)
        return self.turns[sole.index]

    def cos(self, x: Polynomial) -> Polynomial:
        return self._turn(x)[0]

    def sin(self, x: Polynomial) -> Polynomial:
        return self._turn(x)[1]

    def sqrt(self, x: Polynomial) -> Polynomial:
        return self.ring.function("sqrt", x)

    def cos_sqrt(self, x: Polynomial) -> Polynomial:
        return self.ring.function("cos_sqrt", x)

    def sinc_sqrt(self, x: Polynomial) -> Polynomial:
        return self.ring.function("sinc_sqrt", x)

    def sinc3_sqrt(self, x: Polynomial) -> Polynomial:
        return self.ring.function("sinc3_sqrt", x)
