"""CasADi SX as a number type."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import casadi

from symgen.errors import NotSupportedError

SERIES_BELOW = 1e-2
"""Below this value of x = angle² the entire functions are summed as series."""
SERIES_TERMS = 8
"""Their number: the error is under 1e-24."""


class CasadiNumbers:
    """SX expressions. Constants are rounded here, once, to double."""

    def const(self, value: Fraction | int) -> Any:
        return casadi.SX(rounded(value))

    def sqrt(self, x: Any) -> Any:
        return casadi.sqrt(x)

    def cos(self, x: Any) -> Any:
        return casadi.cos(x)

    def sin(self, x: Any) -> Any:
        return casadi.sin(x)

    def cos_sqrt(self, x: Any) -> Any:
        small, root = _guarded(x)
        return casadi.if_else(small, _series(x, 0), casadi.cos(root))

    def sinc_sqrt(self, x: Any) -> Any:
        small, root = _guarded(x)
        return casadi.if_else(small, _series(x, 1), casadi.sin(root) / root)

    def sinc3_sqrt(self, x: Any) -> Any:
        small, root = _guarded(x)
        return casadi.if_else(small, _series(x, 3), (1 - casadi.sin(root) / root) / x)


def rounded(value: Fraction | int) -> float:
    """The double next to a rational. Raises NotSupportedError where there is none."""
    try:
        found = float(value)
    except OverflowError:
        found = 0.0
    if value and not found:
        raise NotSupportedError("a constant is too large or too small for double precision")
    return found


def _guarded(x: Any) -> tuple[Any, Any]:
    """Whether x is small, and √x with an argument away from zero there, so that derivatives stay finite."""
    small = x < SERIES_BELOW
    return small, casadi.sqrt(casadi.if_else(small, 1, x))


def _series(x: Any, first: int) -> Any:
    """Σ (−x)ᵏ/(2k + first)!, nested: cos √x for first = 0, sin √x/√x for 1, (√x − sin √x)/√x³ for 3."""
    result: Any = 1
    for k in range(SERIES_TERMS - 1, 0, -1):
        result = 1 - x * result / ((2 * k + first - 1) * (2 * k + first))
    return result / (6 if first == 3 else 1)
