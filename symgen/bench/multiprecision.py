"""A program's exact value to fifty digits: the reference that compiled results are compared with.

Fifty digits carry the value far beyond double precision, but come without a proven bound; what a user needs
proven is in the certificates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import mpmath

from symgen.program.evaluate import evaluate
from symgen.program.instructions import Program

DIGITS = 50
ZERO = 1e-15
"""What is smaller counts as zero when errors are made relative."""


class MultiprecisionNumbers:
    """mpmath's floats as a number type (see `symgen.algebra.numbers.Numbers`)."""

    def const(self, value: Fraction | int) -> mpmath.mpf:
        value = Fraction(value)
        return mpmath.mpf(value.numerator) / value.denominator

    def sqrt(self, x: mpmath.mpf) -> mpmath.mpf:
        return mpmath.sqrt(x)

    def cos(self, x: mpmath.mpf) -> mpmath.mpf:
        return mpmath.cos(x)

    def sin(self, x: mpmath.mpf) -> mpmath.mpf:
        return mpmath.sin(x)

    def cos_sqrt(self, x: mpmath.mpf) -> mpmath.mpf:
        return mpmath.cos(mpmath.sqrt(x))

    def sinc_sqrt(self, x: mpmath.mpf) -> mpmath.mpf:
        return mpmath.sinc(mpmath.sqrt(x))

    def sinc3_sqrt(self, x: mpmath.mpf) -> mpmath.mpf:
        """(√x − sin √x)/√x³ = Σ (−x)ᵏ/(2k+3)!, as the hypergeometric series it is: nothing cancels near 0."""
        return mpmath.hyp1f2(1, 2, mpmath.mpf(5) / 2, -x / 4) / 6


def exact_outputs(program: Program, inputs: Mapping[str, Sequence[float]]) -> dict[str, list[mpmath.mpf]]:
    """Outputs by name, flat and row-major, at a state given in doubles (taken as exact)."""
    with mpmath.workdps(DIGITS):
        exact = {name: [mpmath.mpf(float(x)) for x in values] for name, values in inputs.items()}
        values = evaluate(program, MultiprecisionNumbers(), exact)
        return {name: [mpmath.mpf(x) for x in row] for name, row in values.items()}


def relative_error(computed: Sequence[float], exact: Sequence[mpmath.mpf]) -> float:
    """‖x − x̂‖∞ / ‖x̂‖∞; the absolute error where the exact value is zero, or only not because the state is rounded
    (a constraint at a rounded quaternion)."""
    with mpmath.workdps(DIGITS):
        error = max(abs(mpmath.mpf(float(x)) - y) for x, y in zip(computed, exact, strict=True))
        scale = max(abs(y) for y in exact)
        return float(error / scale) if scale > ZERO else float(error)
