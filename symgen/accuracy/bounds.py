"""Proven bounds of the rounding error over a box of states, by running error analysis in balls.

Every operation of a program gives its exact result times 1 + δ, |δ| ≤ u (Higham 2002, §2.2; no underflow). The computed
outputs are then F(x, δ) with F(x, 0) exact, and by the mean value theorem

    |F(x, δ) − F(x, 0)| ≤ Σₖ max |∂F/∂δₖ| |δₖ|        over the box and all |δ| ≤ u,

where ∂F/∂δₖ is the adjoint of operation k times its value. Values and adjoints are enclosed by balls over the whole
box *and* all roundings, so the bound holds to all orders. It also covers code that contracts a·b + c to one operation
(δ = 0 for the product). Boxes are halved where the bound is largest; those that hold no quaternion of length one (to
1e-6) are left out.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symgen.accuracy.balls import ArbNumbers, arb, ctx
from symgen.errors import NotSupportedError, SceneError
from symgen.program.instructions import Instruction, Program
from symgen.program.rounding import UNITS, is_datum

Ball = Any
Interval = tuple[float, float]

BITS = 96
TRIGONOMETRY = 2.0
"""Sine and cosine are right to so many u: one unit in the last place, as the header of the generated C states."""
ENTIRE = 4.0
"""So are sin √x/√x and its like, to two units in the last place; cos √x is to as many of 1, not of itself."""
ANGLES = 16.0
SPHERE = 1e-6
"""Quaternions whose squared length is within twice this of 1 are covered."""


@dataclass(frozen=True)
class Bound:
    """A bound of |x − x̂| over a box of states."""

    error: float
    """Of every entry of the outputs."""
    largest: float
    """No entry of the exact outputs is larger than this over the box."""
    boxes: int
    """Into how many the box was divided."""

    @property
    def relative(self) -> float:
        """The error over the largest entry that the box has."""
        return self.error / self.largest if self.largest else self.error


def bound(
    program: Program, box: Sequence[Interval], boxes: int = 256, precision: str = "double", spheres: Sequence[int] = ()
) -> Bound:
    """A proven bound of the rounding error of every output entry over ``box``, one interval per scalar input in the
    order of the program's ports (run-time parameters included). A box where a divisor may vanish has the bound inf.
    ``spheres``: where four scalars in a row begin that are a unit quaternion (to 1e-6).

    Raises NotSupportedError for operations that no bound is stated for.
    """
    with ctx.workprec(BITS):
        unit, weights = UNITS[precision], _weights(program, box, spheres)
        first, ones = [(low, high) for low, high in box], _lengths(program, spheres)
        error, largest = _over(program, first, unit, ones)
        heap = [(-error, 0, first, largest)]
        number = 0
        while len(heap) < boxes and heap and heap[0][0] < 0:
            place = heapq.heappop(heap)[2]
            for half in _halves(place, weights):
                if _meets(half, spheres):
                    number += 1
                    error, largest = _over(program, half, unit, ones)
                    heapq.heappush(heap, (-error, number, half, largest))
        if not heap:
            raise SceneError("no state of this box has quaternions of unit length", program.name)
        return Bound(-heap[0][0], max(largest for _, _, _, largest in heap), len(heap))


def _meets(box: Sequence[Interval], spheres: Sequence[int]) -> bool:
    """Whether quaternions in the box may have unit length."""
    for start in spheres:
        sides = box[start : start + 4]
        least = sum(0.0 if low <= 0 <= high else min(low * low, high * high) for low, high in sides)
        most = sum(max(low * low, high * high) for low, high in sides)
        if least > 1 + 2 * SPHERE or most < 1 - 2 * SPHERE:
            return False
    return True


def _scalars(program: Program) -> list[tuple[str, int]]:
    """The scalar inputs, in the order of the ports."""
    return [(port.name, k) for port in program.inputs for k in range(port.size)]


def _weights(program: Program, box: Sequence[Interval], spheres: Sequence[int]) -> list[float]:
    """How much the width of each side counts: what goes into sines and cosines or makes a rotation bends everything
    else, what is not read counts nothing."""
    scalars, steps = _scalars(program), program.instructions
    bent = {steps[step.args[0]].value for step in steps if step.op in ("sin", "cos")}
    bent |= {scalars[start + k] for start in spheres for k in range(4)}
    read = {steps[i].value for step in steps for i in step.args if steps[i].op == "input"}
    return [
        (ANGLES if scalar in bent else 1.0) / ((high - low) or 1.0) if scalar in read else 0.0
        for scalar, (low, high) in zip(scalars, box, strict=True)
    ]


def _lengths(program: Program, spheres: Sequence[int]) -> frozenset[int]:
    """Instructions that are the squared length of a unit quaternion: sums of its four squares, whatever the order."""
    scalars, steps = _scalars(program), program.instructions
    units = [frozenset(scalars[start : start + 4]) for start in spheres]
    squares: list[tuple[object, ...]] = []
    """What a step is the sum of squares of; empty: of nothing of the kind."""
    for op, args, _, _, _ in steps:
        terms: tuple[object, ...] = ()
        if op == "mul" and args[0] == args[1] and steps[args[0]].op == "input":
            terms = (steps[args[0]].value,)
        elif op == "add" and squares[args[0]] and squares[args[1]]:
            terms = (*squares[args[0]], *squares[args[1]])
        squares.append(terms)
    return frozenset(k for k, terms in enumerate(squares) if len(terms) == 4 and frozenset(terms) in units)


def _halves(box: list[Interval], weights: Sequence[float]) -> tuple[list[Interval], list[Interval]]:
    """The box cut across the side that counts most."""
    k = max(range(len(box)), key=lambda i: (box[i][1] - box[i][0]) * weights[i])
    low, high = box[k]
    middle = 0.5 * (low + high)
    return [*box[:k], (low, middle), *box[k + 1 :]], [*box[:k], (middle, high), *box[k + 1 :]]


def _over(program: Program, box: Sequence[Interval], unit: float, ones: frozenset[int]) -> tuple[float, float]:
    """(bound of the error, of the largest entry) over one box. ``ones``: see `_lengths`."""
    values = _values(program, box, unit, ones)
    exact = values.before
    results = [i for row in program.results for i in row]
    if not all(exact[i].is_finite() for i in results):
        return float("inf"), float("inf")
    worst = 0.0
    for i in dict.fromkeys(results):
        adjoint = _adjoints(program, values, i)
        terms = [
            abs(bar).upper() * (abs(exact_k).upper() * delta if step.op != "cos_sqrt" else arb(delta))
            for bar, exact_k, delta, step in zip(adjoint, exact, values.own, program.instructions, strict=True)
            if bar is not None and delta
        ]
        total = sum(terms, arb(0))
        worst = max(worst, float(total.upper()) * (1 + 1e-12) if total.is_finite() else float("inf"))
    return worst, max((float(abs(exact[i]).upper()) for i in results), default=0.0)


@dataclass(frozen=True)
class _Values:
    """Of every instruction: its value before its own rounding, with it, and how large that rounding may be."""

    before: list[Ball]
    after: list[Ball]
    own: list[float]


def _values(program: Program, box: Sequence[Interval], unit: float, ones: frozenset[int]) -> _Values:
    numbers, starts, start = ArbNumbers(), dict[str, int](), 0
    for port in program.inputs:
        starts[port.name] = start
        start += port.size
    before: list[Ball] = []
    after: list[Ball] = []
    own: list[float] = []
    for step in program.instructions:
        value = _value(step, numbers, box, starts, after)
        if len(before) in ones:
            value = arb(1, 3 * SPHERE)  # its roundings included
        delta = _delta(step, unit)
        before.append(value)
        after.append(_rounded(step, value, delta))
        own.append(delta)
    return _Values(before, after, own)


def _rounded(step: Instruction, value: Ball, delta: float) -> Ball:
    if step.op == "cos_sqrt":
        return value + arb(0, delta)
    return value * (1 + arb(0, delta)) if delta else value


def _square(x: Ball) -> Ball:
    """x² of a ball that may hold zero, tighter than x times another."""
    return (x.abs_lower() ** 2).union(x.abs_upper() ** 2)


def _value(
    step: Instruction, numbers: ArbNumbers, box: Sequence[Interval], starts: dict[str, int], after: list[Ball]
) -> Ball:
    if step.op == "const":
        assert isinstance(step.value, Fraction)
        return numbers.const(step.value)
    if step.op == "input":
        assert isinstance(step.value, tuple)
        low, high = box[starts[step.value[0]] + step.value[1]]
        return arb(low).union(arb(high))
    x = after[step.args[0]]
    match step.op:
        case "add":
            return x + after[step.args[1]]
        case "sub":
            return x - after[step.args[1]]
        case "mul":
            return _square(x) if step.args[0] == step.args[1] else x * after[step.args[1]]
        case "div":
            return x / after[step.args[1]]
        case "neg":
            return -x
        case "sqrt":
            return x.sqrt()
        case "cos":
            return x.cos()
        case "sin":
            return x.sin()
        case "cos_sqrt":
            return numbers.cos_sqrt(x)
        case "sinc_sqrt":
            return numbers.sinc_sqrt(x)
        case "sinc3_sqrt":
            return numbers.sinc3_sqrt(x)
    raise NotSupportedError(f"no bound is stated for {step.op}")


def _delta(step: Instruction, unit: float) -> float:
    if step.op in ("sin", "cos"):
        return TRIGONOMETRY * unit
    if step.op in ("cos_sqrt", "sinc_sqrt", "sinc3_sqrt"):
        return ENTIRE * unit
    if step.op == "const":
        return unit if is_datum(step) or unit > UNITS["double"] else 0.0
    return 0.0 if step.op in ("input", "neg") else unit


def _adjoints(program: Program, values: _Values, result: int) -> list[Ball | None]:
    """∂(result)/∂(instruction, rounded) for every one that bears on it, enclosed."""
    bars: list[Ball | None] = [None] * len(values.before)
    bars[result] = arb(1)
    for k in range(result, -1, -1):
        bar, step = bars[k], program.instructions[k]
        if bar is None or not step.args:
            continue
        felt = bar if step.op == "cos_sqrt" else _rounded(step, bar, values.own[k])
        for i, slope in zip(step.args, _slopes(step, values, k), strict=True):
            part = felt * slope
            known = bars[i]
            bars[i] = part if known is None else known + part
    return bars


def _slopes(step: Instruction, values: _Values, k: int) -> tuple[Ball, ...]:
    """Derivatives of an operation, before its rounding, by its arguments."""
    x, y = values.after[step.args[0]], values.after[step.args[-1]]
    match step.op:
        case "add":
            return arb(1), arb(1)
        case "sub":
            return arb(1), arb(-1)
        case "mul":
            return y, x
        case "div":
            return 1 / y, -values.before[k] / y
        case "neg":
            return (arb(-1),)
        case "sqrt":
            return (1 / (2 * values.before[k]),)
        case "cos":
            return (-x.sin(),)
        case "cos_sqrt":
            return (-(-x / 4).hypgeom([], [arb(3) / 2]) / 2,)
        case "sinc_sqrt":
            return (-(-x / 4).hypgeom([], [arb(5) / 2]) / 6,)
        case "sinc3_sqrt":
            return (-(-x / 4).hypgeom([2], [3, arb(7) / 2]) / 120,)
        case _:
            return (x.cos(),)
