"""SymPy expressions set in a style: one walk for text, LaTeX and MathML."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from math import log10

import sympy

from symgen.targets.sympy.styles import Style, parsed

SUM, PRODUCT, POWER, ATOM = range(4)
"""How tightly a piece holds together."""
DIGITS = 8
"""Decimals of up to so many digits are printed exactly, longer ones rounded to `ROUNDED`."""
ROUNDED = 6
FORCING = frozenset({"alpha", "tau", "F"})
RATES = frozenset({"omega", "v"})
MOVING = frozenset({"theta", "q", "x", "y", "z"}) | RATES
"""First parts of the names of symbols, see `symbols`."""


@dataclass
class Setter:
    """Sets expressions in a style. ``rounded`` says afterwards whether a number was not printed exactly."""

    style: Style
    places: Mapping[sympy.Symbol, int] = field(default_factory=dict)
    """The order of the arguments: sums and products of symbols are written in it."""
    rounded: bool = False
    _known: dict[sympy.Expr, tuple[str, int]] = field(default_factory=dict)

    def set(self, x: sympy.Expr) -> str:
        return self._piece(x)[0]

    def _piece(self, x: sympy.Expr) -> tuple[str, int]:
        found = self._known.get(x)
        if found is None:
            found = self._known[x] = self._walk(x)
        return found

    def _walk(self, x: sympy.Expr) -> tuple[str, int]:
        if x.is_Symbol:
            return self.style.name(parsed(x.name)), ATOM
        if x.is_Add:
            return self._sum(x), SUM
        if x.is_Mul or x.is_Rational:
            negative, text, level = self._product(x)
            return (self.style.sum([(True, text)]), SUM) if negative else (text, level)
        if x.is_Pow:
            return self._power(x)
        if isinstance(x, sympy.Piecewise):
            return self._piece(x.args[-1].expr)
        argument = self.set(x.args[0])
        return self.style.call(x.func.__name__, argument, ""), ATOM

    def _closed(self, x: sympy.Expr, level: int) -> str:
        """The piece, in parentheses when it does not hold together as tightly as ``level``."""
        text, own = self._piece(x)
        return self.style.parentheses(text) if own < level else text

    # --- sums and products --------------------------------------------------------------------------------------------

    def _sum(self, x: sympy.Expr) -> str:
        terms = []
        for term in sorted(x.args, key=self._order):
            negative, text, level = self._product(term)
            terms.append((negative, self.style.parentheses(text) if level == SUM else text))
        return self.style.sum(terms)

    def _product(self, x: sympy.Expr) -> tuple[bool, str, int]:
        """(negative, what follows the sign, how tightly that holds)."""
        number = Fraction(1)
        above: list[sympy.Expr] = []
        below: list[sympy.Expr] = []
        for factor in factors(x):
            if factor.is_Rational:
                number *= Fraction(int(factor.p), int(factor.q))
            elif factor.is_Pow and factor.exp.is_Rational and factor.exp < 0:
                below.append(factor.base ** (-factor.exp) if factor.exp != -1 else factor.base)
            else:
                above.append(factor)
        texts, denominator = self._number(abs(number), bool(above))
        level = PRODUCT if len(texts) + len(above) > 1 else SUM
        upper = texts + [self._closed(factor, level) for factor in sorted(above, key=self._rank)]
        lower = denominator + [self._closed(factor, PRODUCT) for factor in sorted(below, key=self._rank)]
        negative = number < 0
        if not lower:
            held = self._piece(above[0])[1] if len(upper) == 1 and above else PRODUCT if len(upper) > 1 else ATOM
            if negative and held == SUM:
                return True, self.style.parentheses(upper[0]), ATOM
            return negative, upper[0] if len(upper) == 1 else self.style.product(upper), held
        return negative, self._fraction(upper, lower, above, below), PRODUCT

    def _fraction(self, upper: list[str], lower: list[str], above: list[sympy.Expr], below: list[sympy.Expr]) -> str:
        flat = self.style.fraction("", "", True) == "/"
        if len(upper) == 1 and above and flat and self._piece(above[0])[1] == SUM:
            upper = [self.style.parentheses(upper[0])]
        top = upper[0] if len(upper) == 1 else self.style.product(upper or [self.style.number("1", 0)])
        if len(lower) > 1:
            bottom = self.style.product(lower)
            return self.style.fraction(top, self.style.parentheses(bottom) if flat else bottom, False)
        if below:
            bottom = self._closed(below[0], POWER) if flat else self.set(below[0])
            return self.style.fraction(top, bottom, True)
        return self.style.fraction(top, lower[0], True)

    def _number(self, value: Fraction, hidden_one: bool) -> tuple[list[str], list[str]]:
        """Numerator and denominator of a positive number; nothing for a one that stands before something."""
        text, exponent, exact = decimal(value)
        if exact or value.denominator >= 100:
            self.rounded = self.rounded or not exact
            return ([] if value == 1 and hidden_one else [self.style.number(text, exponent)]), []
        top = [] if value.numerator == 1 and hidden_one else [self.style.number(str(value.numerator), 0)]
        return top, [self.style.number(str(value.denominator), 0)]

    # --- order --------------------------------------------------------------------------------------------------------

    def _places(self, x: sympy.Expr) -> tuple[int, ...]:
        return tuple(sorted(self.places.get(symbol, len(self.places)) for symbol in x.free_symbols))

    def _order(self, term: sympy.Expr) -> tuple[int, int, tuple[int, ...], str]:
        """Accelerations and forces first, then what is constant, then the terms with fewer factors."""
        heads = {symbol.name.split("_")[0] for symbol in term.free_symbols}
        leading = any(head.endswith("ddot") or head in FORCING for head in heads)
        rank = 0 if leading else 2 if heads & MOVING or any(head.endswith("dot") for head in heads) else 1
        length = sum(1 for factor in factors(term) if not factor.is_Rational)
        return rank, length, self._places(term), str(term)

    def _rank(self, factor: sympy.Expr) -> tuple[int, tuple[int, ...], str]:
        """Symbols before sums before functions; parameters before coordinates before rates."""
        base = factor.base if factor.is_Pow else factor
        kind = 4 if base.is_Add else 5
        if base.is_Symbol:
            head = base.name.split("_")[0]
            kind = 3 if head.endswith("dot") or head in RATES else 2 if head in MOVING else 0
        return kind, self._places(factor), str(factor)

    # --- powers -------------------------------------------------------------------------------------------------------

    def _power(self, x: sympy.Expr) -> tuple[str, int]:
        base, exponent = x.base, x.exp
        if exponent.is_Rational and exponent < 0:
            return self._product(x)[1], PRODUCT
        if exponent == sympy.Rational(1, 2):
            return self.style.root(self.set(base)), ATOM
        if exponent.is_Rational and exponent.q == 2:
            return self.style.power(self.style.root(self.set(base)), str(exponent.p)), POWER
        if isinstance(base, sympy.cos | sympy.sin) and exponent.is_Integer:
            return self.style.call(base.func.__name__, self.set(base.args[0]), str(exponent)), ATOM
        return self.style.power(self._closed(base, ATOM), str(exponent)), POWER


def factors(x: sympy.Expr) -> list[sympy.Expr]:
    """The factors of a product, nested products opened."""
    if not x.is_Mul:
        return [x]
    return [factor for part in x.args for factor in factors(part)]


def decimal(value: Fraction) -> tuple[str, int, bool]:
    """(mantissa, exponent of ten, exact) of a positive number; the exponent is 0 where the number is short without."""
    exponent = int(log10(value.numerator) - log10(value.denominator)) if value else 0
    for digits in (DIGITS, ROUNDED):
        short = f"{float(value):.{digits}g}" if abs(exponent) < 300 else "0"
        exact = Fraction(short) == value
        if exact or digits == ROUNDED:
            break
    mantissa, _, power = short.partition("e")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    if power and 0 < int(power) <= DIGITS and exact:
        return str(value.numerator), 0, True
    return mantissa, int(power or 0), exact
