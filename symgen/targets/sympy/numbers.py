"""SymPy as a number type: of expressions, and of polynomials that become expressions.

`SympyNumbers` is the plain one: SymPy does the arithmetic. `polynomial_state` makes the one that readable results
come from: a derivation runs on exact polynomials in normal form, with one generator for every argument and for the
cosine and sine of every sum of angles about parallel axes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy

from symgen.algebra.numbers import State
from symgen.scene.model import Scene
from symgen.targets.sympy.polynomials import Polynomial, PolynomialNumbers, Ring
from symgen.targets.sympy.symbols import Symbols, angle_sums
from symgen.topology.tree import Tree


def rational(value: Fraction | int) -> sympy.Rational:
    exact = Fraction(value)
    return sympy.Rational(exact.numerator, exact.denominator)


class SympyNumbers:
    """SymPy expressions with exact rationals. (Run inside ``distribute(False)`` to keep factors outside sums.)"""

    def const(self, value: Fraction | int) -> sympy.Expr:
        return rational(value)

    def sqrt(self, x: sympy.Expr) -> sympy.Expr:
        return sympy.sqrt(x)

    def cos(self, x: sympy.Expr) -> sympy.Expr:
        return sympy.cos(x)

    def sin(self, x: sympy.Expr) -> sympy.Expr:
        return sympy.sin(x)

    def cos_sqrt(self, x: sympy.Expr) -> sympy.Expr:
        return sympy.cos(sympy.sqrt(x))

    def sinc_sqrt(self, x: sympy.Expr) -> sympy.Expr:
        return sympy.sinc(sympy.sqrt(x))

    def sinc3_sqrt(self, x: sympy.Expr) -> sympy.Expr:
        root = sympy.sqrt(x)
        return sympy.Piecewise((sympy.Rational(1, 6), sympy.Eq(x, 0)), ((root - sympy.sin(root)) / (x * root), True))


@dataclass(frozen=True)
class PolynomialState:
    """Arguments as generators of one ring, and the number type of that ring."""

    numbers: PolynomialNumbers
    state: State


def polynomial_state(
    scene: Scene, tree: Tree, symbols: Symbols, budget: int, given: Mapping[str, Sequence[Any]] | None = None
) -> PolynomialState:
    """All arguments as polynomials. ``given``: parameter → values (SymPy expressions or numbers) to use in place of the
    parameter's symbols; structural zeros (int 0) among them are folded."""
    ring = Ring(budget=budget)
    q = tuple(ring.symbol(symbol) for symbol in symbols.q)
    turns: dict[int, tuple[Polynomial, Polynomial]] = {}
    sums: dict[int, tuple[Polynomial, Polynomial]] = {}
    for k, turn in angle_sums(tree).items():
        c, s = sums[k] = ring.angle(turn.total)
        if turn.before is not None:
            c0, s0 = sums[turn.before]
            c, s = (c * c0 + s * s0, s * c0 - c * s0) if turn.sign > 0 else (c * c0 - s * s0, s * c0 + c * s0)
        turns[k] = (c, s)
    known: dict[Any, Polynomial] = {}
    p: list[Any] = [ring.symbol(symbol) for symbol in symbols.p]
    for parameter in scene.parameters:
        values = (given or {}).get(parameter.name)
        if values is not None:
            p[parameter.start : parameter.start + parameter.size] = [_given(ring, known, value) for value in values]
    v, a, tau = (tuple(ring.symbol(symbol) for symbol in row) for row in (symbols.v, symbols.a, symbols.tau))
    return PolynomialState(PolynomialNumbers(ring, turns), State(q, v, a, tau, ring.symbol(symbols.dt), tuple(p)))


def _given(ring: Ring, known: dict[Any, Polynomial], value: Any) -> Any:
    """A number, a symbol or a product of numbers and symbols as a scalar of the ring."""
    expression = sympy.sympify(value)
    if expression == 0:
        return 0
    coefficient, factors = expression.as_coeff_mul()
    found = ring.const(Fraction(int(coefficient.p), int(coefficient.q)))
    for factor in factors:
        if factor not in known:
            known[factor] = ring.symbol(factor)
        found = found * known[factor]
    return found
