"""Exact polynomials: arithmetic, relations, normal form."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symgen.targets.sympy.angles import merge_angles
from symgen.targets.sympy.polynomials import Polynomial, PolynomialNumbers, Ring, TooLargeError, exponents

VALUES = {"x": 0.7, "y": -1.3, "a": 0.4, "b": 1.9}


class Fixture:
    """x, y plain; a, b angles."""

    def __init__(self) -> None:
        self.ring = Ring()
        self.x, self.y, self.a, self.b = (self.ring.symbol(name) for name in "xyab")
        turns = {2: self.ring.angle({2: 1}), 3: self.ring.angle({3: 1})}
        self.numbers = PolynomialNumbers(self.ring, turns)


def value(polynomial: Polynomial) -> float:
    """With floats in place of the generators."""
    total = 0.0
    for monomial, coefficient in polynomial.coefficients.items():
        term = float(coefficient)
        for index, exponent in exponents(monomial):
            term *= generator(polynomial.ring, index) ** exponent
        total += term
    return total


def generator(ring: Ring, index: int) -> float:
    found = ring.generators[index]
    if found.kind == "symbol":
        return VALUES[found.meaning]
    if found.kind in ("cos", "sin"):
        return float(getattr(math, found.kind)(sum(n * generator(ring, k) for k, n in found.meaning.items())))
    argument = value(found.meaning)
    return 1.0 / argument if found.kind == "inverse" else math.sqrt(argument)


ATOMS = ("x", "y", "cos a", "sin a", "cos b", "sin b", "2/3", "-5")


@st.composite
def programs(draw: Any) -> list[tuple[str, int, int]]:
    """A short straight-line program over the atoms."""
    steps = []
    for n in range(draw(st.integers(1, 6))):
        known = len(ATOMS) + n
        op = draw(st.sampled_from("+-*"))
        steps.append((op, draw(st.integers(0, known - 1)), draw(st.integers(0, known - 1))))
    return steps


def run(steps: list[tuple[str, int, int]], atoms: list[Any]) -> Any:
    values = list(atoms)
    for op, i, j in steps:
        x, y = values[i], values[j]
        values.append(x + y if op == "+" else x - y if op == "-" else x * y)
    return values[-1]


@given(programs())
def test_arithmetic_is_that_of_numbers(steps: list[tuple[str, int, int]]) -> None:
    f = Fixture()
    atoms: list[Any] = [
        f.x, f.y, f.numbers.cos(f.a), f.numbers.sin(f.a), f.numbers.cos(f.b), f.numbers.sin(f.b),
        f.numbers.const(Fraction(2, 3)), f.numbers.const(-5),
    ]  # fmt: skip
    v = VALUES
    floats = [v["x"], v["y"], math.cos(v["a"]), math.sin(v["a"]), math.cos(v["b"]), math.sin(v["b"]), 2 / 3, -5.0]
    found = run(steps, atoms)
    assert value(found) == pytest.approx(run(steps, floats), rel=1e-9, abs=1e-9)
    (merged,) = merge_angles([found])
    assert value(merged) == pytest.approx(value(found), rel=1e-9, abs=1e-9)
    assert len(merged.terms) <= max(1, len(found.terms)) or not found.terms


def test_identities_are_zero() -> None:
    f = Fixture()
    c, s = f.numbers.cos(f.a), f.numbers.sin(f.a)
    assert not c * c + s * s - 1
    assert not (c + s) * (c - s) - (1 - 2 * s * s)
    assert c * c + s * s == 1
    assert bool(c - s)


def test_inverse_of_a_norm_cancels() -> None:
    f = Fixture()
    norm = f.x * f.x + f.y * f.y
    k = 1 / norm
    assert k * norm == 1
    assert 1 / norm * f.x * f.x + f.y * f.y / norm == 1
    assert value(k * f.x) == pytest.approx(VALUES["x"] / (VALUES["x"] ** 2 + VALUES["y"] ** 2))


def test_roots_square_to_their_argument() -> None:
    f = Fixture()
    inside = f.x * f.x * Fraction(1, 3) + 2
    root = f.numbers.sqrt(inside)
    assert root * root == inside
    assert f.numbers.sqrt(inside) == root
    assert 1 / root * root == 1
    assert root * root * root == root * inside


def test_division_by_numbers() -> None:
    f = Fixture()
    assert (f.x * 6) / 4 == f.x * Fraction(3, 2)
    assert 1 / f.numbers.const(Fraction(2, 3)) == Fraction(3, 2)


def test_angle_sums_are_merged_both_ways() -> None:
    f = Fixture()
    ca, sa, cb, sb = f.numbers.cos(f.a), f.numbers.sin(f.a), f.numbers.cos(f.b), f.numbers.sin(f.b)
    for polynomial, kind, angles in (
        (ca * cb - sa * sb, "cos", {2: 1, 3: 1}),
        (ca * cb + sa * sb, "cos", {2: 1, 3: -1}),
        (sa * cb + ca * sb, "sin", {2: 1, 3: 1}),
        (sa * cb - ca * sb, "sin", {2: 1, 3: -1}),
    ):
        (merged,) = merge_angles([polynomial * f.x * 3])
        ((monomial, coefficient),) = merged.terms.items()
        assert coefficient == 3
        found = [merged.ring.generators[k] for k, _ in exponents(monomial)]
        assert [(g.kind, g.meaning) for g in found] == [("symbol", "x"), (kind, angles)]
        assert value(merged) == pytest.approx(value(polynomial * f.x * 3))


def test_unequal_products_stay() -> None:
    f = Fixture()
    ca, sa, cb, sb = f.numbers.cos(f.a), f.numbers.sin(f.a), f.numbers.cos(f.b), f.numbers.sin(f.b)
    (merged,) = merge_angles([ca * cb + 2 * sa * sb])
    assert len(merged.terms) == 2
    assert value(merged) == pytest.approx(value(ca * cb + 2 * sa * sb))


def test_the_budget_ends_a_derivation() -> None:
    ring = Ring(budget=100)
    x = ring.symbol("x") + ring.symbol("y") + 1
    with pytest.raises(TooLargeError):
        for _ in range(20):
            x = x * x


def test_cosines_of_other_than_joint_angles_keep_their_identity() -> None:
    f = Fixture()
    cosine, sine = f.numbers.cos(f.x), f.numbers.sin(f.x)
    assert f.numbers.cos(f.x) == cosine
    assert cosine * cosine + sine * sine == f.numbers.const(1)
