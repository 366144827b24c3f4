"""Polynomials in normal form → short SymPy expressions: angle sums merged, common factors outside."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from functools import reduce
from math import gcd, lcm
from typing import Any

import sympy
from sympy.core.parameters import distribute

from symgen.targets.sympy.angles import merge_angles
from symgen.targets.sympy.numbers import SympyNumbers, rational
from symgen.targets.sympy.polynomials import WIDTH, Generator, Polynomial, exponents

Powers = tuple[tuple[int, int], ...]
"""((generator, exponent), …)"""
Sum = dict[Powers, Fraction]


class Writer:
    """Turns polynomials into SymPy expressions."""

    def __init__(self, collected: tuple[sympy.Symbol, ...] = ()) -> None:
        self.collected = frozenset(collected)
        """Symbols in whose powers and products an entry is written as a polynomial (accelerations, forces)."""
        self._functions: dict[Polynomial, sympy.Expr] = {}

    def write(self, polynomial: Any) -> sympy.Expr:
        """The expression of a scalar: a polynomial, or a number left as it was."""
        if not isinstance(polynomial, Polynomial):
            return rational(polynomial)
        (polynomial,) = merge_angles([polynomial])
        best = fewest_terms(polynomial)
        terms = {tuple(exponents(monomial)): value for monomial, value in best.items()}
        with distribute(False):
            return self._collected(polynomial, terms)

    def _collected(self, polynomial: Polynomial, terms: Sum) -> sympy.Expr:
        """Σ (coefficient) · (product of the symbols to collect by)."""
        generators = polynomial.ring.generators
        mine = {k for k, g in enumerate(generators) if g.kind == "symbol" and g.meaning in self.collected}
        groups: dict[Powers, Sum] = {}
        for powers, value in terms.items():
            key = tuple((k, n) for k, n in powers if k in mine)
            groups.setdefault(key, {})[tuple((k, n) for k, n in powers if k not in mine)] = value
        if set(groups) <= {()}:
            return self._factored(polynomial, terms)
        parts = []
        for key, group in groups.items():
            outside = [self._expression(polynomial, k) ** n for k, n in key]
            parts.append(sympy.Mul(self._factored(polynomial, group), *outside))
        return sympy.Add(*parts)

    # --- generators -------------------------------------------------------------------------------------------------

    def _expression(self, polynomial: Polynomial, index: int) -> sympy.Expr:
        generator = polynomial.ring.generators[index]
        if generator.kind == "symbol":
            return generator.meaning
        if generator.kind in ("cos", "sin"):
            angles = sorted(generator.meaning.items())
            with distribute(True):  # SymPy's cos does not end on some sums without
                argument = sympy.Add(*(n * polynomial.ring.generators[k].meaning for k, n in angles))
                return sympy.cos(argument) if generator.kind == "cos" else sympy.sin(argument)
        if generator.meaning not in self._functions:
            self._functions[generator.meaning] = Writer().write(generator.meaning)
        argument = self._functions[generator.meaning]
        if generator.kind == "inverse":
            return 1 / argument
        return getattr(SympyNumbers(), generator.kind.removesuffix("_of"))(argument)

    # --- factors ------------------------------------------------------------------------------------------------------

    def _factored(self, polynomial: Polynomial, terms: Sum) -> sympy.Expr:
        if not terms:
            return sympy.Integer(0)
        number, common = _content(terms), _common(terms)
        if number == -1 and not common and len(terms) > 1:
            number = Fraction(1)
        rest = {_divided(powers, common): value / number for powers, value in terms.items()}
        factors = [rational(number), *(self._expression(polynomial, k) ** n for k, n in common)]
        if len(rest) > 1:
            factors.append(self._split(polynomial, rest))
        return sympy.Mul(*factors)

    def _split(self, polynomial: Polynomial, terms: Sum) -> sympy.Expr:
        """A sum of at least two terms without a common factor, as generator · (…) + …, the most frequent first."""
        chosen = self._most_frequent(polynomial, terms)
        if chosen is None:
            return sympy.Add(*(self._factored(polynomial, {powers: value}) for powers, value in terms.items()))
        inside = {powers: value for powers, value in terms.items() if any(k == chosen for k, _ in powers)}
        outside = {powers: value for powers, value in terms.items() if powers not in inside}
        return sympy.Add(self._factored(polynomial, inside), self._outside(polynomial, outside))

    def _outside(self, polynomial: Polynomial, terms: Sum) -> sympy.Expr:
        """What a factor was split off from: no common factor is asked of it, so that sums stay flat."""
        return self._split(polynomial, terms) if len(terms) > 1 else self._factored(polynomial, terms)

    def _most_frequent(self, polynomial: Polynomial, terms: Sum) -> int | None:
        tally = Counter(k for powers in terms for k, _ in powers)
        shared = [k for k, count in tally.items() if count > 1]
        if not shared:
            return None
        generators = polynomial.ring.generators

        def rank(k: int) -> tuple[int, bool, int]:
            return (-tally[k], k < len(generators) and generators[k].kind == "symbol", k)

        return min(shared, key=rank)


def fewest_terms(polynomial: Polynomial) -> dict[int, Fraction]:
    """The normal form has no sin²; angle by angle, cos² → 1 − sin² is kept where it leaves fewer terms."""
    terms = polynomial.coefficients
    for cosine, sine in zip(polynomial.ring.generators, polynomial.ring.generators[1:], strict=False):
        if cosine.kind == "cos" and sine.kind == "sin" and cosine.meaning == sine.meaning:
            other = _with_sines(terms, cosine, sine)
            if len(other) < len(terms):
                terms = other
    return terms


def _with_sines(terms: dict[int, Fraction], cosine: Generator, sine: Generator) -> dict[int, Fraction]:
    """cos² → 1 − sin² until no power of the cosine is left above one."""
    mask, shift = 0xFE << (WIDTH * cosine.index), 2 * cosine.monomial
    while any(monomial & mask for monomial in terms):
        found: dict[int, Fraction] = {}
        for monomial, value in terms.items():
            parts = (
                ((monomial - shift, value), (monomial - shift + 2 * sine.monomial, -value))
                if monomial & mask
                else ((monomial, value),)
            )
            for key, part in parts:
                found[key] = found.get(key, Fraction(0)) + part
        terms = {monomial: value for monomial, value in found.items() if value}
    return terms


def _divided(powers: Powers, common: Powers) -> Powers:
    gone = dict(common)
    return tuple((k, n - gone.get(k, 0)) for k, n in powers if n > gone.get(k, 0))


def _common(terms: Sum) -> Powers:
    first, *others = terms
    shared = dict(first)
    for powers in others:
        here = dict(powers)
        shared = {k: min(n, here[k]) for k, n in shared.items() if k in here}
    return tuple(sorted(shared.items()))


SMALL = 2
"""A number is taken out of a sum when the integers it leaves are this small."""


def _content(terms: Sum) -> Fraction:
    """The number to take out of a sum: its greatest common divisor where that leaves 1s and 2s, else a sign at most."""
    values = list(terms.values())
    if len(values) == 1:
        return values[0]
    denominator = reduce(lcm, (value.denominator for value in values))
    whole = [int(value * denominator) for value in values]
    divisor = reduce(gcd, whole)
    sign = -1 if all(value < 0 for value in values) else 1
    largest = max(abs(value) // divisor for value in whole)
    if largest > (1 if () in terms else SMALL):
        return Fraction(sign)
    return Fraction(sign * divisor, denominator)
