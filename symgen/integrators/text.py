"""A composed function as C: its updates as static functions, then nothing but arrays and calls."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import prod

from symgen.loops.text import WIDTH, LoopBody, symbol_of
from symgen.program.composed import Call, ComposedProgram, total
from symgen.program.instructions import Counts, Port, Program
from symgen.targets.c.literals import ConstantTable
from symgen.targets.c.statements import Functions, write_body


def update_arguments(update: Program, real: str) -> list[str]:
    """How an update is declared."""
    inputs = [
        f"const {real} *SYMGEN_ALONE {port.name}" if port.shape else f"{real} {port.name}" for port in update.inputs
    ]
    return [*inputs, *(f"{real} *SYMGEN_ALONE {port.name}" for port in update.outputs)]


def call_text(call: Call, called: Program, symbol: str) -> str:
    """``rrpr_forward_dynamics(q2, v2, tau, a2)``."""
    inputs = [call.inputs[port.name] for port in called.inputs if port.size]
    outputs = [call.outputs[port.name] for port in called.outputs if port.size]
    return f"{symbol}({', '.join((*inputs, *outputs))})"


def body_lines(program: ComposedProgram, symbol: str, symbols: Mapping[str, str], real: str, status: bool) -> list[str]:
    """The statements of the function. ``symbols``: emitted function → its C name; ``status``: functions that may have
    no answer say so."""
    lines = [f"{real} {port.name}[{prod(port.shape)}];" for port in program.locals.values()]
    lines += ["int status = 0;"] if status and program.guards else []
    for call in program.calls:
        called = program.called(call)
        name = symbol_of(symbol, call.function) if call.update else symbols[call.function]
        fails = status and bool(called.guards)
        lines.append(f"{'status |= ' if fails else ''}{call_text(call, called, name)};")
    return lines + (["return status;"] if status and program.guards else [])


def write_composed(
    program: ComposedProgram,
    symbol: str,
    symbols: Mapping[str, str],
    counts: Mapping[str, Counts],
    table: ConstantTable,
    functions: Functions,
    taken: frozenset[str],
    status: bool,
) -> LoopBody:
    """The text of one function. ``counts``: emitted function → the operations of its text."""
    real = table.precision.c_type
    bodies = {step.name: write_body(step, table, functions, taken) for step in program.steps}
    steps = []
    for update in {step.name: step for step in program.steps}.values():
        own, name = update_arguments(update, real), symbol_of(symbol, update.name)
        text = [line for kind, line in bodies[update.name].lines if kind == "code"]
        steps.append({"declaration": _declared(name, own), "lines": text})
    lines = body_lines(program, symbol, symbols, real, status)
    every = [line for row in steps for line in row["lines"]] + lines
    return LoopBody(
        tuple(("code", line) for line in every),
        (),
        (),
        frozenset(name for body in bodies.values() for name in body.called),
        frozenset(word for body in bodies.values() for word in body.words),
        total(program, {**counts, **{name: body.counts for name, body in bodies.items()}}),
        tuple(steps),
        (),
        tuple(lines),
        _kilobytes(program.locals.values(), table.precision.name),
    )


def _declared(name: str, arguments: Sequence[str]) -> str:
    text = f"{name}({', '.join(arguments)})"
    return text if len(text) <= WIDTH else f"{name}(\n    " + ",\n    ".join(arguments) + ")"


def _kilobytes(ports: Iterable[Port], precision: str) -> int:
    size = sum(port.size for port in ports)
    return -(-size * (8 if precision == "double" else 4) // 1024) or 1
