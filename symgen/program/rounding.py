"""What rounding does to a program, and its data to the result: estimates without compiling anything.

Every value x of interest becomes x(1 + ih s) with a sign s at random: the imaginary part of a result over h is how far
it moves, to first order and without cancellation (the complex step). One evaluation on arrays serves many states, each
with signs of its own.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.program.instructions import Instruction, Program

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Moves = Callable[[Instruction], bool]
"""Which instructions are moved."""

UNITS = {"double": 2.0**-53, "float": 2.0**-24}
"""Precision → u, half the distance from 1 to the next number."""
STEP = 1e-100
TERMS = 14


def _entire(first: int, far: Callable[[Complex, Complex], Complex]) -> Callable[[Complex], Complex]:
    """Σ (−x)ᵏ/(first + 2k)! near zero, the closed form ``far(√x, x)`` elsewhere."""

    def function(x: Complex) -> Complex:
        x = np.asarray(x, dtype=complex)
        near, series, power = np.abs(x) < 4, np.zeros_like(x), np.ones_like(x)
        factorial = 6.0 if first == 3 else 1.0
        for k in range(TERMS):
            series = series + power / factorial
            power = power * -x
            factorial *= (first + 2 * k + 1) * (first + 2 * k + 2)
        away = np.where(near, 4.0, x)
        return np.where(near, series, far(np.sqrt(away), away))

    return function


_OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    "sqrt": np.sqrt,
    "cos": np.cos,
    "sin": np.sin,
    "cos_sqrt": _entire(0, lambda y, _: np.cos(y)),
    "sinc_sqrt": _entire(1, lambda y, _: np.sin(y) / y),
    "sinc3_sqrt": _entire(3, lambda y, x: (y - np.sin(y)) / (y * x)),
}


def is_datum(step: Instruction) -> bool:
    """Inputs, and constants that a double cannot hold: any code knows them to a rounding only."""
    if step.op == "const":
        assert isinstance(step.value, Fraction)
        return step.value.denominator & (step.value.denominator - 1) != 0 or Fraction(float(step.value)) != step.value
    return step.op == "input"


def is_rounded(step: Instruction) -> bool:
    """What is rounded when the program runs: operations, and constants that a double cannot hold. Inputs are what they
    are: moved along, they would hide how plans differ where the problem is badly conditioned."""
    return is_datum(step) if step.op == "const" else step.op not in ("neg", "input")


def movements(program: Program, states: Mapping[str, Array], moves: Moves, seed: int) -> tuple[Array, Array]:
    """Every output entry (row) at every state (column), and |δy| per relative movement. ``states``: input → (states,
    size); every state has random signs of its own."""
    count = len(next(iter(states.values()))) if states else 1
    movable = [moves(step) for step in program.instructions]
    signs = np.random.default_rng(seed).integers(0, 2, (sum(movable), count), dtype=np.int8)
    factors = iter(1 + 1j * STEP * (2.0 * signs - 1))
    values: list[Any] = []
    columns = {name: np.ascontiguousarray(np.asarray(rows).T, dtype=complex) for name, rows in states.items()}
    with np.errstate(all="ignore"):
        for step, moves_here in zip(program.instructions, movable, strict=True):
            if step.op == "input":
                assert isinstance(step.value, tuple)
                value: Any = columns[step.value[0]][step.value[1]]
            elif step.op == "const":
                assert isinstance(step.value, Fraction)
                value = complex(float(step.value))
            else:
                value = _OPERATIONS[step.op](*[values[i] for i in step.args])
            values.append(value * next(factors) if moves_here else value)
        results = [np.broadcast_to(values[i], (count,)) for row in program.results for i in row]
        found = np.array(results).reshape(-1, count)
        return np.asarray(found.real), np.asarray(np.abs(found.imag) / STEP)


def moved(program: Program, states: Mapping[str, Array], moves: Moves, seed: int) -> Array:
    """‖δy‖∞/‖y‖∞ at every state, in units of the relative movement (see `movements`)."""
    values, found = movements(program, states, moves, seed)
    scale = np.max(np.abs(values), axis=0, initial=0.0)
    return np.asarray(np.max(found, axis=0, initial=0.0) / np.where(scale > 0, scale, 1.0))


def condition(program: Program, states: Mapping[str, Array], draws: int = 16, seed: int = 1) -> Array:
    """How far the exact result moves, relative to its norm, per relative movement of its data: the largest over
    ``draws`` sets of random signs."""
    found = [moved(program, states, is_datum, seed + k) for k in range(draws)]
    return np.asarray(np.fmax.reduce(found))


def rounding(program: Program, states: Mapping[str, Array], draws: int = 1, seed: int = 1) -> Array:
    """How far the result of a program moves, relative to its norm, per relative rounding of every operation: an
    estimate of the error of this plan, in roundings. The root of the mean square over ``draws``, which varies less than
    the largest."""
    found = [moved(program, states, is_rounded, seed + k) for k in range(draws)]
    return np.asarray(np.sqrt(np.mean(np.square(found), axis=0)))
