"""How exact what was measured is: every variant's results against the exact program, at the states it was given.

The exact values come from ball arithmetic, at all states, where python-flint is installed; else from fifty digits, at a
few. Variants in float get states that a float holds, and have exact values of their own there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symgen.bench.multiprecision import ZERO, exact_outputs
from symgen.bench.variant import Array, Problem, State, Variant
from symgen.errors import ToolError
from symgen.program.instructions import Program
from symgen.program.rounding import UNITS, condition

FEW = 5
"""States where fifty digits have to do: they take seconds each for long functions."""


@dataclass(frozen=True)
class Exact:
    """Exact results of a function, output by output: (states, size) each, as sums of two doubles."""

    high: tuple[Array, ...]
    low: tuple[Array, ...]
    conditions: tuple[Array, ...] | None
    """κ of every output at every state (see `symgen.program.rounding`); None without python-flint."""

    @property
    def states(self) -> int:
        return len(self.high[0]) if self.high else 0


@dataclass(frozen=True)
class Errors:
    """‖x − x̂‖∞/‖x̂‖∞ over the states, the largest of a function's outputs at each."""

    largest: float
    median: float
    units: float | None
    """The largest in units of u · max(1, κ); None where the condition κ is not known."""


def has_flint() -> bool:
    try:
        import symgen.accuracy.balls  # noqa: F401
    except ToolError:
        return False
    return True


@dataclass
class Truth:
    """The exact results of a problem's functions, each computed once."""

    problem: Problem
    balls: bool = field(default_factory=has_flint)
    _known: dict[tuple[str, str], Exact] = field(default_factory=dict)

    def of(self, function: str, real: str) -> Exact:
        """Exact results for variants of that precision. Raises ToolError where no precision is enough."""
        key = (function, real)
        if key not in self._known:
            columns = rounded(self.problem, function, real)
            self._known[key] = (
                by_balls(self.problem, function, columns)
                if self.balls
                else by_digits(self.problem.programs[function], columns)
            )
        return self._known[key]

    @property
    def states(self) -> int:
        """How many states errors are taken over."""
        return len(self.problem.states) if self.balls else min(FEW, len(self.problem.states))

    @property
    def method(self) -> str:
        return "ball arithmetic" if self.balls else "fifty digits"


def rounded(problem: Problem, function: str, real: str) -> dict[str, Array]:
    """The inputs of a function at all states, (states, size), as variants of that precision get them."""
    columns = {port.name: problem.column(port.name) for port in problem.programs[function].inputs}
    if real == "double":
        return columns
    return {name: rows.astype(np.float32).astype(np.float64) for name, rows in columns.items()}


def by_balls(problem: Problem, function: str, columns: dict[str, Array]) -> Exact:
    """At every state, to twenty digits beyond a double."""
    from symgen.accuracy.balls import Reference
    from symgen.accuracy.measure import as_given

    program = problem.programs[function]
    if not columns:  # nothing goes in: one result serves all states
        columns = {"": np.zeros((len(problem.states), 0))}
    high, low = Reference(program).over(columns)
    ends = np.cumsum([port.size for port in program.outputs])[:-1]
    datum = as_given(problem.system, problem.system.output(function))
    conditions = tuple(
        np.broadcast_to(condition(one, columns if one.inputs else {}), len(high)) for one in output_by_output(datum)
    )
    return Exact(tuple(np.split(high, ends, axis=1)), tuple(np.split(low, ends, axis=1)), conditions)


def output_by_output(program: Program) -> list[Program]:
    """The same program once for every output, with no other."""
    pairs = zip(program.outputs, program.results, strict=True)
    return [replace(program, outputs=(port,), results=(row,)) for port, row in pairs]


def by_digits(program: Program, columns: dict[str, Array]) -> Exact:
    """At the first few states, to fifty digits."""
    count = len(next(iter(columns.values()))) if columns else 1
    highs: list[list[Array]] = [[] for _ in program.outputs]
    lows: list[list[Array]] = [[] for _ in program.outputs]
    for k in range(min(FEW, count)):
        row = exact_outputs(program, {name: values[k].tolist() for name, values in columns.items()})
        for at, values in enumerate(row.values()):
            high = np.array([float(x) for x in values])
            highs[at].append(high)
            lows[at].append(np.array([float(x - y) for x, y in zip(values, high.tolist(), strict=True)]))
    return Exact(tuple(map(np.array, highs)), tuple(map(np.array, lows)), None)


def errors_of(outputs: Sequence[Sequence[Any]], exact: Exact, real: str) -> Errors:
    """``outputs``: per state the outputs, flat. A result that is not finite where there is an answer is infinitely
    wrong, and a state without an answer counts for nothing."""
    count = min(exact.states, len(outputs))
    worst, most = np.zeros(count), 0.0
    answered = np.ones(count, dtype=bool)
    for at, (high, low) in enumerate(zip(exact.high, exact.low, strict=True)):
        got = np.array([np.ravel(row[at]) for row in outputs[:count]], dtype=np.float64).reshape(count, -1)
        found = relative(got, high[:count], low[:count])
        answer = np.isfinite(high[:count]).all(axis=1)
        answered &= answer
        worst = np.maximum(worst, found)
        if exact.conditions is not None and answer.any():
            units = found / (UNITS[real] * np.fmax(exact.conditions[at][:count], 1.0))
            most = max(most, float(np.max(units[answer])))
    if not answered.any():
        return Errors(0.0, 0.0, None if exact.conditions is None else 0.0)
    kept = worst[answered]
    return Errors(float(np.max(kept)), float(np.median(kept)), None if exact.conditions is None else most)


def relative(got: Array, high: Array, low: Array) -> Array:
    """‖x − x̂‖∞/‖x̂‖∞ of every row; the absolute error where the exact value is zero, or only not because the state is
    rounded (a constraint at a rounded quaternion)."""
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs((got - high) - low)
    apart = np.where(np.isfinite(got), apart, np.inf)
    largest = np.max(apart, axis=1, initial=0.0)
    scale = np.max(np.abs(np.nan_to_num(high)), axis=1, initial=0.0)
    return np.asarray(largest / np.where(scale > ZERO, scale, 1.0))


def unpacked(variant: Variant, flat: Array, problem: Problem) -> list[list[Array]]:
    """A variant's results at every state as the function's outputs, each flat."""
    rows = by_state(flat, variant, problem) if variant.batch else flat
    return [variant.unpack(row, state) for row, state in zip(rows, problem.states, strict=True)]


def by_state(flat: Array, variant: Variant, problem: Problem) -> Array:
    """A batch leaves output after output; those of a structure of arrays have the states inside."""
    n, sizes = len(problem.states), problem.shapes(variant.function)
    parts = np.split(flat.ravel(), np.cumsum([n * size for size in sizes])[:-1])
    if variant.columns:
        rows = [part.reshape(size, n).T for part, size in zip(parts, sizes, strict=True)]
    else:
        rows = [part.reshape(n, size) for part, size in zip(parts, sizes, strict=True)]
    return np.hstack(rows)


__all__ = ["Errors", "Exact", "State", "Truth", "errors_of", "unpacked"]
