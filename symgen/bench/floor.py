"""A floor under the instructions of straight-line scalar code, counted from the program that is emitted.

Every input that is used is read once, every output written once; a multiplication is free where an addition takes it
along (a fused multiply-add), one for one at best; negations and constants cost nothing; sines and cosines cost what
they were counted to in a function that does nothing else, the call included. What a compiler adds (spills, moves, the
guards) is what instructions ÷ floor shows.
"""

from __future__ import annotations

from typing import NamedTuple

from symgen.program.instructions import Instruction, Port, Program

ARITHMETIC = ("add", "sub", "mul", "div", "sqrt")


def fused(program: Program) -> int:
    """At most so many multiplications vanish into additions: those whose every use is an addition, and no more than
    there are additions that have one among their operands."""
    elsewhere: set[int] = set()
    for step in program.instructions:
        if step.op not in ("add", "sub"):
            elsewhere.update(step.args)
    for row in program.results:
        elsewhere.update(row)
    elsewhere.update(program.guards)
    steps = program.instructions
    free = {i for i, step in enumerate(steps) if step.op == "mul" and i not in elsewhere}
    takers = sum(1 for step in steps if step.op in ("add", "sub") and free & set(step.args))
    return min(len(free), takers)


class Angles(NamedTuple):
    """What a program takes of angles: how many, and which functions of them."""

    number: int
    cosines: bool
    sines: bool


def angles_of(program: Program) -> Angles:
    steps = program.instructions
    taken = {op: {step.args[0] for step in steps if step.op == op} for op in ("cos", "sin")}
    return Angles(len(taken["cos"] | taken["sin"]), bool(taken["cos"]), bool(taken["sin"]))


def reads_and_writes(program: Program) -> int:
    steps = program.instructions
    used = {i for step in steps for i in step.args} | {i for row in program.results for i in row}
    reads = sum(1 for i, step in enumerate(steps) if step.op == "input" and i in used)
    return reads + sum(port.size for port in program.outputs)


def floor(program: Program, of_angles: float) -> float:
    """Instructions of a call at least; ``of_angles`` is what its sines and cosines and the call itself cost, as counted
    in its `probe` (see `cost_of_angles`)."""
    arithmetic = sum(1 for step in program.instructions if step.op in ARITHMETIC)
    return reads_and_writes(program) + arithmetic - fused(program) + of_angles


def probe(angles: Angles) -> Program:
    """A function that is nothing but such sines and cosines of its inputs."""
    n = max(1, angles.number)
    steps = [Instruction("input", value=("q", k)) for k in range(n)]
    outputs, rows = [], []
    for op, taken in (("cos", angles.cosines), ("sin", angles.sines)):
        if taken:
            rows.append(tuple(range(len(steps), len(steps) + n)))
            outputs.append(Port(op, (n,)))
            steps += [Instruction(op, (k,)) for k in range(n)]
    if not outputs:  # the call itself
        rows, outputs = [tuple(range(n))], [Port("copy", (n,))]
    return Program(probe_name(angles), (Port("q", (n,)),), tuple(outputs), tuple(steps), tuple(rows), plan="probe")


def probe_name(angles: Angles) -> str:
    return f"probe_{angles.number}_{'c' * angles.cosines}{'s' * angles.sines}"


def cost_of_angles(counted: float, angles: Angles) -> float:
    """Instructions that a probe was counted to take, its reads and writes taken off."""
    return counted - reads_and_writes(probe(angles))
