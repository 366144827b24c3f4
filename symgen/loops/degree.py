"""Formal degrees of what loops compute, for the certificate's probability (see `symgen.certificate`).

Degrees of numerator and denominator are propagated through the sweeps, row by row. A sweep over columns is run once per
link, on the largest degrees that any column has.
"""

from __future__ import annotations

from collections.abc import Sequence

from symgen.loops.model import Angles, Clear, Diagonal, LoopProgram, Mirror, Spread, Sweep, Zeros
from symgen.loops.text import ROWS
from symgen.program.instructions import Instruction, Program

Pair = tuple[int, int]
CONSTANT: Pair = (0, 0)
INPUT: Pair = (1, 0)
TURN: Pair = (4, 0)


def formal_degree(program: LoopProgram, limit: int) -> int:
    """Of numerator and denominator of the outputs, nothing cancelled; at most ``limit`` + 1 where they outgrow it."""
    arrays: dict[str, list[Pair]] = {name: [CONSTANT] * size for name, size in program.locals.items()}
    arrays |= {port.name: [INPUT] * port.size for port in program.inputs}
    arrays |= {port.name: [CONSTANT] * port.size for port in program.outputs}
    for part in program.parts:
        if isinstance(part, Angles):
            for name in ("sines", "cosines"):
                arrays[name] = [TURN] * len(arrays[name])
        elif isinstance(part, Spread):
            found = arrays[part.source]
            for row in range(ROWS):
                arrays[part.target][row * part.n] = _largest(found[row::ROWS])
        elif isinstance(part, Sweep):
            _columns(part, arrays, limit) if part.span else _sweep(part, arrays, limit)
        else:
            assert isinstance(part, Clear | Diagonal | Mirror | Zeros)
    largest = [_largest(arrays[port.name]) for port in program.outputs]
    return max((a + b for a, b in largest), default=0)


def _largest(pairs: Sequence[Pair]) -> Pair:
    return max((a for a, _ in pairs), default=0), max((b for _, b in pairs), default=0)


def _sweep(sweep: Sweep, arrays: dict[str, list[Pair]], limit: int) -> None:
    for row in sweep.table:
        step = sweep.steps[row[0]]
        inputs = {
            port.name: arrays[sweep.arrays[port.name]][_start(sweep, row, port.name) :][: port.size]
            for port in step.inputs
            if port.name in sweep.arrays
        }
        for port, found in zip(step.outputs, _run(step, inputs, limit), strict=True):
            start = _start(sweep, row, port.name)
            arrays[sweep.arrays[port.name]][start : start + port.size] = found
        if sweep.join:
            array, to, used = arrays[sweep.join.array], row[sweep.join.to], row[sweep.join.used]
            for k in range(sweep.join.size):
                array[to + k] = _sum(arrays["sent"][k], array[to + k])
                array[used + k] = CONSTANT


def _start(sweep: Sweep, row: Sequence[int], port: str) -> int:
    return row[sweep.offsets[port]] if port in sweep.offsets else 0


def _columns(sweep: Sweep, arrays: dict[str, list[Pair]], limit: int) -> None:
    """One column stands for all."""
    wrench, n = arrays["columns"], len(arrays["columns"]) // ROWS
    matrix = sweep.arrays["m"]
    for row in sweep.table:
        step = sweep.steps[row[0]]
        inputs = {
            port.name: arrays[sweep.arrays[port.name]][_start(sweep, row, port.name) :][: port.size]
            for port in step.inputs
            if port.name in sweep.arrays
        }
        inputs |= {f"w{k}": [wrench[k * n]] for k in range(ROWS)}
        for port, found in zip(step.outputs, _run(step, inputs, limit), strict=True):
            if port.name == "x":
                for k, pair in enumerate(found):
                    wrench[k * n] = _largest([wrench[k * n], pair])
            else:
                arrays[matrix][0] = _largest([arrays[matrix][0], *found])


def _run(step: Program, inputs: dict[str, list[Pair]], limit: int) -> list[list[Pair]]:
    pairs: list[Pair] = []
    for instruction in step.instructions:
        a, b = _pair(instruction, pairs, inputs)
        pairs.append((min(a, limit), min(b, limit)))
    return [[pairs[k] for k in row] for row in step.results]


def _pair(instruction: Instruction, pairs: Sequence[Pair], inputs: dict[str, list[Pair]]) -> Pair:
    args = [pairs[k] for k in instruction.args]
    if instruction.op == "input":
        assert isinstance(instruction.value, tuple)
        name, index = instruction.value
        return inputs[name][index] if name in inputs else CONSTANT
    if instruction.op == "const":
        return CONSTANT
    if instruction.op in ("add", "sub"):
        return _sum(*args)
    if instruction.op == "mul":
        return args[0][0] + args[1][0], args[0][1] + args[1][1]
    if instruction.op == "div":
        return args[0][0] + args[1][1], args[0][1] + args[1][0]
    return args[0]


def _sum(x: Pair, y: Pair) -> Pair:
    return max(x[0] + y[1], y[0] + x[1]), x[1] + y[1]
