"""A program's exact value in ball arithmetic: every number carries a bound of its own error (FLINT's `arb`).

The precision is raised until the enclosure has twenty digits beyond what is compared, so that what is measured is
the error of the compiled code and of nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.errors import ToolError
from symgen.program.instructions import Program

try:
    from flint import arb, ctx, fmpq
except ImportError as error:  # pragma: no cover
    raise ToolError("python-flint is not installed: pip install 'symgen[accuracy]'") from error

__all__ = ["ArbNumbers", "Exact", "Reference", "arb", "ctx", "errors", "relative", "relative_to"]
Array = NDArray[np.float64]
Ball = Any

BITS = 192
"""Precision to begin with."""
MOST_BITS = 12288
"""Precision at which a pivot that still may be zero is taken for zero."""
BEYOND = Fraction(1, 10**20)
"""The radius of a reference, in units of the rounding of a double."""
DOUBLE_UNIT = Fraction(1, 2**53)
SMALLEST = 5e-324


class ArbNumbers:
    """Balls as a number type (see `symgen.algebra.numbers.Numbers`), at the precision that is set in FLINT."""

    def __init__(self) -> None:
        self._constants: dict[int, tuple[Fraction | int, Ball]] = {}
        """By the identity of the constant, which is kept: fractions take long to hash."""

    def const(self, value: Fraction | int) -> Ball:
        known = self._constants.get(id(value))
        if known is None:
            ball = arb(fmpq(value.numerator, value.denominator))
            known = self._constants[id(value)] = (value, ball)
        return known[1]

    def sqrt(self, x: Ball) -> Ball:
        return x.sqrt()

    def cos(self, x: Ball) -> Ball:
        return x.cos()

    def sin(self, x: Ball) -> Ball:
        return x.sin()

    def cos_sqrt(self, x: Ball) -> Ball:
        """cos √x = ₀F₁(1/2; −x/4): no root of a ball that may reach below zero."""
        return (-x / 4).hypgeom([], [arb(1) / 2])

    def sinc_sqrt(self, x: Ball) -> Ball:
        """sin √x / √x = ₀F₁(3/2; −x/4)."""
        return (-x / 4).hypgeom([], [arb(3) / 2])

    def sinc3_sqrt(self, x: Ball) -> Ball:
        """(√x − sin √x)/√x³ = Σ (−x)ᵏ/(2k+3)! = ₁F₂(1; 2, 5/2; −x/4)/6."""
        return (-x / 4).hypgeom([1], [2, arb(5) / 2]) / 6


@dataclass(frozen=True)
class Exact:
    """Exact values of all outputs at one state, one behind the other, as sums of two doubles.

    Where the function has no answer (a pivot is not positive, or a division by zero) all are NaN.
    """

    high: Array
    low: Array
    bits: int
    """The precision that it took."""

    @property
    def answer(self) -> bool:
        return bool(np.all(np.isfinite(self.high)))


class Reference:
    """The exact values of one program, state by state."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self._numbers: dict[int, ArbNumbers] = {}
        results = [i for row in program.results for i in row]
        self._distinct = list(dict.fromkeys(results))
        places = {i: k for k, i in enumerate(self._distinct)}
        self._places = np.array([places[i] for i in results], dtype=int)
        """Where every output entry stands among the distinct ones."""
        self._steps = _compiled(program, [*self._distinct, *program.guards])

    def balls(self, state: Mapping[str, Sequence[float]], bits: int) -> tuple[list[Ball], bool | None]:
        """Outputs, one behind the other, and whether all guards are positive (None where that cannot be told)."""
        found, positive = self._enclosed(state, bits)
        return [found[k] for k in self._places], positive

    def _enclosed(self, state: Mapping[str, Sequence[float]], bits: int) -> tuple[list[Ball], bool | None]:
        """`balls` of the distinct entries."""
        with ctx.workprec(bits):
            numbers = self._numbers.setdefault(bits, ArbNumbers())
            inputs = [[arb(x) for x in state[port.name]] for port in self.program.inputs]
            values = self._steps(numbers, *inputs)
            count = len(self._distinct)
            found, guards = values[:count], values[count:]
            if any(not guard > 0 and guard <= 0 for guard in guards):
                return found, False
            return found, True if all(guard > 0 for guard in guards) else None

    def at(self, state: Mapping[str, Sequence[float]]) -> Exact:
        """``state``: name → flat doubles, taken as exact. Raises ToolError where no precision is enough."""
        bits = BITS
        while bits <= MOST_BITS:
            found, positive = self._enclosed(state, bits)
            if positive is False:
                return self._nothing(bits)
            if positive and _good(found):
                return _split(found, self._places, bits)
            bits *= 2
        found, positive = self._enclosed(state, bits)
        if positive is None or not all(x.is_finite() for x in found):
            return self._nothing(bits)  # exactly singular as far as anybody can tell
        raise ToolError(f"{self.program.name}: {MOST_BITS} bits are not enough for a reference")

    def over(self, states: Mapping[str, Array]) -> tuple[Array, Array]:
        """(high, low), one state per row. ``states``: name → array (states, size)."""
        names = [port.name for port in self.program.inputs]
        count = len(next(iter(states.values())))
        rows = [self.at({name: states[name][i].tolist() for name in names}) for i in range(count)]
        return np.array([row.high for row in rows]), np.array([row.low for row in rows])

    def _nothing(self, bits: int) -> Exact:
        size = sum(port.size for port in self.program.outputs)
        return Exact(np.full(size, np.nan), np.zeros(size), bits)


def _good(found: Sequence[Ball]) -> bool:
    """All radii are small beside the largest entry, or below every double where all entries may be zero."""
    if not all(x.is_finite() for x in found):
        return False
    largest = max((float(abs(x.mid())) for x in found), default=0.0)
    allowed = max(float(DOUBLE_UNIT * BEYOND) * largest, SMALLEST)
    return all(float(x.rad()) <= allowed for x in found)


def _split(found: Sequence[Ball], places: NDArray[np.int64], bits: int) -> Exact:
    with ctx.workprec(bits):
        middles = [x.mid() for x in found]
        high = [float(x) for x in middles]
        low = [float(x - arb(y)) for x, y in zip(middles, high, strict=True)]
    return Exact(np.array(high)[places], np.array(low)[places], bits)


_SIGNS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
WHOLE, CHUNK = 5000, 1000
"""Up to so many steps are one Python function, which runs fastest; of more, so many are compiled at once: Python's
compiler takes a time that grows faster than the length of what it is given."""


def _compiled(program: Program, wanted: Sequence[int]) -> Callable[..., list[Ball]]:
    """The values of the instructions ``wanted`` from numbers and inputs: `evaluate_all` as Python text, four times as
    fast. The text is made of numbers and of names from the closed set of operations only."""
    constants: list[Fraction] = []
    ports = {port.name: k for k, port in enumerate(program.inputs)}
    lines = []
    for k, (op, args, value, _, _) in enumerate(program.instructions):
        if op in _SIGNS:
            text = f"v{args[0]} {_SIGNS[op]} v{args[1]}"
        elif op == "neg":
            text = f"-v{args[0]}"
        elif op == "const":
            assert isinstance(value, Fraction)
            text = f"c[{len(constants)}]"
            constants.append(value)
        elif op == "input":
            assert isinstance(value, tuple)
            text = f"x[{ports[value[0]]}][{value[1]}]"
        else:
            text = f"numbers.{op}(v{args[0]})"
        lines.append(f"v{k} = {text}")
    lines.append(f"found = [{', '.join(f'v{i}' for i in wanted)}]")
    names: dict[str, Any] = {"__builtins__": {}}
    if len(lines) <= WHOLE:
        whole = "\n ".join(["def found(numbers, c, x):", *lines, "return found"])
        made: dict[str, Any] = dict(names)
        exec(compile(whole, "<program in balls>", "exec"), made)
        function = made["found"]
    else:
        codes = [
            compile("\n".join(lines[k : k + CHUNK]), "<program in balls>", "exec") for k in range(0, len(lines), CHUNK)
        ]

        def function(numbers: ArbNumbers, c: list[Ball], x: Sequence[list[Ball]]) -> list[Ball]:
            variables: dict[str, Any] = {**names, "numbers": numbers, "c": c, "x": x}
            for code in codes:
                exec(code, variables)
            found: list[Ball] = variables["found"]
            return found

    def steps(numbers: ArbNumbers, *inputs: list[Ball]) -> list[Ball]:
        found: list[Ball] = function(numbers, [numbers.const(value) for value in constants], inputs)
        return found

    return steps


def errors(computed: Array, high: Array, low: Array) -> Array:
    """|x − x̂| entry by entry. A computed number where there is no answer, or none where there is one, is infinite."""
    with np.errstate(invalid="ignore", over="ignore"):
        found = np.abs((np.asarray(computed, dtype=np.float64) - high) - low)
    none, exists = ~np.isfinite(computed), np.isfinite(high)
    return np.where(exists, np.where(none, np.inf, found), np.where(none, 0.0, np.inf))


def relative(computed: Array, high: Array, low: Array) -> Array:
    """‖x − x̂‖∞/‖x̂‖∞ of every state (one per row); the absolute error where the exact result is zero."""
    return relative_to(errors(computed, high, low), high)


def relative_to(entries: Array, high: Array) -> Array:
    """The same from the errors of all entries."""
    found = np.max(entries, axis=-1, initial=0.0)
    scale = np.max(np.abs(np.nan_to_num(high)), axis=-1, initial=0.0)
    return np.asarray(found / np.where(scale > 0, scale, 1.0))
