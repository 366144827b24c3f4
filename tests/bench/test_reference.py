"""The fifty-digit reference that the bench relies on."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import pytest

from symgen.bench.multiprecision import DIGITS, MultiprecisionNumbers, exact_outputs, relative_error
from symgen.program.instructions import Instruction, Port, Program


def test_functions_of_a_squared_angle_to_fifty_digits() -> None:
    numbers = MultiprecisionNumbers()
    for angle in ("1e-30", "1e-9", "0.1", "1", "3", "20"):
        with mpmath.workdps(3 * DIGITS):
            y = mpmath.mpf(angle)
            truth = (mpmath.cos(y), mpmath.sin(y) / y, (y - mpmath.sin(y)) / y**3)
        with mpmath.workdps(DIGITS):
            x = mpmath.mpf(angle) ** 2
            found = (numbers.cos_sqrt(x), numbers.sinc_sqrt(x), numbers.sinc3_sqrt(x))
            for exact, value in zip(truth, found, strict=True):
                assert abs(value - exact) <= abs(exact) * mpmath.mpf(10) ** (8 - DIGITS), angle
    assert numbers.sinc_sqrt(mpmath.mpf(0)) == 1
    assert abs(numbers.sinc3_sqrt(mpmath.mpf(0)) - mpmath.mpf(1) / 6) < 1e-15


@pytest.fixture
def program() -> Program:
    """y = q/3 · cos q, in doubles one rounding per operation away from the truth."""
    instructions = (
        Instruction("input", value=("q", 0)),
        Instruction("const", value=Fraction(1, 3)),
        Instruction("mul", (0, 1)),
        Instruction("cos", (0,)),
        Instruction("mul", (2, 3)),
    )
    return Program("f", (Port("q", (1,)),), (Port("y", (1,)),), instructions, ((4,),))


def test_exact_outputs_see_the_rounding_of_a_constant(program: Program) -> None:
    q = 0.7
    exact = exact_outputs(program, {"q": [q]})["y"]
    rounded = q * (1 / 3) * float(mpmath.cos(q))
    assert 0 < relative_error([rounded], exact) < 1e-15
    assert relative_error([rounded * (1 + 1e-12)], exact) == pytest.approx(1e-12, rel=1e-3)
