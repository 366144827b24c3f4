"""Products of cosines and sines → cosines and sines of sums and differences, where that is shorter."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction

from symgen.targets.sympy.polynomials import Generator, Polynomial, Ring, exponents

Powers = tuple[tuple[int, int], ...]
Angles = tuple[tuple[int, int], ...]
"""((symbol generator, ±1), …), the first with +1."""
TURNING = ("cos", "sin")


def merge_angles(polynomials: Sequence[Polynomial]) -> list[Polynomial]:
    """The polynomials in a ring of their own, in which cos A cos B ± sin A sin B is the generator cos(A ∓ B), and so
    on, wherever both products stand with the same cofactor.

    In the new ring those generators are independent but for sin² + cos² = 1: a normal form no longer, but products of
    such polynomials (determinants) stay short.
    """
    merging = _Merging(polynomials[0].ring)
    return [merging.merged(polynomial) for polynomial in polynomials]


class _Merging:
    def __init__(self, old: Ring) -> None:
        self.old = old
        self.ring = Ring(budget=old.budget)
        self.known: dict[int, Polynomial] = {}
        self.turns: dict[Angles, tuple[Polynomial, Polynomial]] = {}
        for generator in old.generators:
            # Same numbers for the symbols that angles are sums of: they were made first, and are again.
            if generator.kind == "symbol":
                made = self.ring.generator("symbol", generator.meaning)
                self.known[generator.index] = self.ring.sole(made)
            else:
                self.ring.generator("unused", None)

    def generator(self, index: int) -> Polynomial:
        """A generator of the old ring in the new one."""
        if index not in self.known:
            generator = self.old.generators[index]
            if generator.kind in TURNING:
                self.known[index] = self.turn(generator.kind, generator.meaning)
            else:
                self.known[index] = self.ring.function(generator.kind, self.merged(generator.meaning))
        return self.known[index]

    def turn(self, kind: str, angles: dict[int, int]) -> Polynomial:
        """cos or sin of a sum of angles."""
        items = tuple((k, n) for k, n in sorted(angles.items()) if n)
        sign = 1
        if items[0][1] < 0:
            items, sign = tuple((k, -n) for k, n in items), -1
        if items not in self.turns:
            self.turns[items] = self.ring.angle(dict(items))
        cosine, sine = self.turns[items]
        return cosine if kind == "cos" else sine * sign

    def merged(self, polynomial: Polynomial) -> Polynomial:
        terms = {tuple(exponents(monomial)): value for monomial, value in polynomial.coefficients.items()}
        found = self.ring.const(0)
        for powers in sorted(terms):
            if powers not in terms:
                continue
            value = terms.pop(powers)
            pair = self._pair(terms, powers, value)
            if pair is None:
                found = found + self._product(powers) * value
                continue
            rest, kind, angles = pair
            found = found + self._product(rest) * self.turn(kind, angles) * value
        return found

    def _product(self, powers: Powers) -> Polynomial:
        found = self.ring.const(1)
        for index, exponent in powers:
            for _ in range(exponent):
                found = found * self.generator(index)
        return found

    def _pair(
        self, terms: dict[Powers, Fraction], powers: Powers, value: Fraction
    ) -> tuple[Powers, str, dict[int, int]] | None:
        """(cofactor, cos or sin, angles) of a term and its partner, which is taken out of ``terms``.

        cos A cos B ± sin A sin B = cos(A ∓ B);  sin A cos B ± cos A sin B = sin(A ± B).
        """
        generators = self.old.generators
        for a, b, partner in _partners(powers, generators):
            if abs(terms.get(partner, 0)) != abs(value):
                continue
            same = terms.pop(partner) == value
            kind = "cos" if a.kind == "cos" else "sin"
            minus = same if kind == "cos" else not same
            angles = Counter(a.meaning)
            for k, n in b.meaning.items():
                angles[k] += -n if minus else n
            return _without(powers, (a.index, b.index)), kind, dict(angles)
        return None


def _partners(powers: Powers, generators: list[Generator]) -> Iterator[tuple[Generator, Generator, Powers]]:
    """(a, b, term): b is a cosine, a a cosine or sine of another angle, and the term has the other kind of both."""
    turning = [generators[k] for k, _ in powers if generators[k].kind in TURNING]
    for b in turning:
        if b.kind != "cos":
            continue
        for a in turning:
            if a.meaning == b.meaning:
                continue
            rest = _without(powers, (a.index, b.index))
            # a ring makes the sine of an angle right after its cosine
            other = a.index + 1 if a.kind == "cos" else a.index - 1
            yield a, b, _times(_times(rest, other), b.index + 1)


def _without(powers: Powers, gone: tuple[int, int]) -> Powers:
    """Each of the two generators once less."""
    return tuple((k, n - 1 if k in gone else n) for k, n in powers if n > 1 or k not in gone)


def _times(powers: Powers, index: int) -> Powers:
    found = dict(powers)
    found[index] = found.get(index, 0) + 1
    return tuple(sorted(found.items()))
