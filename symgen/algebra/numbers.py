"""Number types: what a derivation needs from the scalars it runs on.

The mathematics is written once with ``+ - * /`` and the few functions of `Numbers`; each
number type supplies those. Floats live here; GF(p) in `symgen.algebra.field`, the exact graph in
`symgen.program.graph`, SymPy and CasADi beside their targets.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

Scalar = Any


class Numbers(Protocol):
    """The functions a number type adds to its arithmetic.

    The last three are entire functions of x = angle², used where a rotation vector is turned into a
    rotation, so that no formula divides by an angle that may be zero.
    """

    def const(self, value: Fraction | int) -> Scalar: ...
    def sqrt(self, x: Scalar) -> Scalar: ...
    def cos(self, x: Scalar) -> Scalar: ...
    def sin(self, x: Scalar) -> Scalar: ...
    def cos_sqrt(self, x: Scalar) -> Scalar:
        """cos √x."""
        ...

    def sinc_sqrt(self, x: Scalar) -> Scalar:
        """sin √x / √x."""
        ...

    def sinc3_sqrt(self, x: Scalar) -> Scalar:
        """(√x − sin √x) / √x³."""
        ...


@dataclass(frozen=True)
class State:
    """The arguments of generated functions, as scalars of one number type (see interface: q, v, a, tau, dt, p)."""

    q: Sequence[Scalar] = ()
    v: Sequence[Scalar] = ()
    a: Sequence[Scalar] = ()
    tau: Sequence[Scalar] = ()
    dt: Scalar = 0
    p: Sequence[Scalar] = ()


class FloatNumbers:
    """Python floats."""

    def const(self, value: Fraction | int) -> float:
        return float(value)

    def sqrt(self, x: float) -> float:
        return math.sqrt(x)

    def cos(self, x: float) -> float:
        return math.cos(x)

    def sin(self, x: float) -> float:
        return math.sin(x)

    def cos_sqrt(self, x: float) -> float:
        return math.cos(math.sqrt(x))

    def sinc_sqrt(self, x: float) -> float:
        return math.sin(math.sqrt(x)) / math.sqrt(x) if x > 1e-8 else 1.0 - x / 6.0 + x * x / 120.0

    def sinc3_sqrt(self, x: float) -> float:
        if x > 1e-2:
            y = math.sqrt(x)
            return (y - math.sin(y)) / (x * y)
        return 1.0 / 6.0 - x / 120.0 + x * x / 5040.0 - x**3 / 362880.0 + x**4 / 39916800.0
