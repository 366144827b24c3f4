"""Rationals as literals: exact where a short decimal is, correctly rounded where not, proven independently."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from symgen.errors import CertificateError, NotSupportedError
from symgen.targets.c.literals import PRECISIONS, inline_literal, round_to, rounded_literal
from symgen.targets.c.rounding import LITERAL, check_literal, literal_value, rounds_to

DOUBLE, FLOAT = PRECISIONS["double"], PRECISIONS["float"]
RATIONALS = st.fractions().filter(lambda x: x > 0) | st.builds(
    lambda m, e: Fraction(m) * Fraction(10) ** e, st.integers(1, 10**20), st.integers(-30, 15)
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Fraction(1, 10), "0.1"),
        (Fraction(12), "12.0"),
        (Fraction(0), "0.0"),
        (Fraction(981, 100), "9.81"),
        (Fraction(1, 10**5), "0.00001"),
        (Fraction(1, 10**7), "1.0e-7"),
        (Fraction(10**15), "1000000000000000.0"),
        (Fraction(25 * 10**20), "2.5e21"),
        (Fraction(1, 2**20), "9.5367431640625e-7"),
        (Fraction(12345678901234567), "1.2345678901234567e16"),
    ],
)
def test_short_decimals_stand_inline(value: Fraction, text: str) -> None:
    assert inline_literal(value, DOUBLE) == text
    assert inline_literal(value, FLOAT) == text + "f"


@pytest.mark.parametrize("value", [Fraction(1, 3), Fraction(1, 2**60), Fraction(123456789012345678), Fraction(1, 7)])
def test_others_need_a_name(value: Fraction) -> None:
    assert inline_literal(value, DOUBLE) is None


@given(RATIONALS)
def test_inline_text_is_the_rational(value: Fraction) -> None:
    text = inline_literal(value, DOUBLE)
    if text is not None:
        assert LITERAL.fullmatch(text)
        assert literal_value(text, "double") == value


@given(RATIONALS)
def test_double_literals_are_correctly_rounded(value: Fraction) -> None:
    text = rounded_literal(value, DOUBLE)
    assert float(text) == value.numerator / value.denominator
    check_literal(text, value, "double")
    for wrong in (math.nextafter(float(text), 0), math.nextafter(float(text), math.inf)):
        with pytest.raises(CertificateError):
            check_literal(format(wrong, ".17e").replace("e+", "e"), value, "double")


@given(RATIONALS.filter(lambda x: Fraction(1, 10**30) < x < 10**30))
def test_float_literals_are_correctly_rounded(value: Fraction) -> None:
    text = rounded_literal(value, FLOAT)
    check_literal(text, value, "float")
    x = np.float32(text.rstrip("f"))
    for wrong in (np.nextafter(x, np.float32(0)), np.nextafter(x, np.float32(np.inf))):
        assert not rounds_to(value, float(wrong), "float")


def test_no_double_rounding() -> None:
    """Just above a tie between floats: rounding through double would land on the tie and go to even."""
    value = Fraction(1) + Fraction(1, 2**24) + Fraction(1, 2**80)
    assert round_to(value, FLOAT) == 1 + Fraction(1, 2**23)
    assert np.float32(float(value)) == 1.0  # what double rounding gives
    check_literal(rounded_literal(value, FLOAT), value, "float")
    with pytest.raises(CertificateError):
        check_literal("1.0f", value, "float")


def test_ties_go_to_even() -> None:
    assert round_to(Fraction(2**53 + 1), DOUBLE) == 2**53
    assert round_to(Fraction(2**53 + 3), DOUBLE) == 2**53 + 4
    assert rounds_to(Fraction(2**53 + 1), float(2**53), "double")
    assert not rounds_to(Fraction(2**53 + 1), float(2**53 + 2), "double")


@pytest.mark.parametrize(
    ("value", "precision"),
    [
        (Fraction(10) ** 309, DOUBLE),
        (Fraction(10) ** 39, FLOAT),
        (Fraction(1, 10**50), FLOAT),
        (Fraction(1, 10**330), DOUBLE),
    ],
)
def test_out_of_range_is_an_error_of_the_users(value: Fraction, precision: object) -> None:
    with pytest.raises(NotSupportedError, match="is too"):
        round_to(value, precision)  # type: ignore[arg-type]
    with pytest.raises(NotSupportedError):
        inline_literal(value, precision)  # type: ignore[arg-type]


def test_subnormal_constants_round_correctly() -> None:
    value = Fraction(1, 10**45) * 3
    check_literal(rounded_literal(value, FLOAT), value, "float")
    assert round_to(Fraction(1, 2**1074), DOUBLE) == Fraction(1, 2**1074)


@pytest.mark.parametrize("text", ["1", "1.", ".5", "1e5", "0x1.0p0", "1.0f", "1.0e+5", "1.0L", "1_0.0", "1.0e99999"])
def test_other_forms_are_refused(text: str) -> None:
    with pytest.raises(CertificateError):
        literal_value(text, "double")
