"""Constants of a class of links: what a step computes from them alone is computed here, exactly, for every link.

What is the same for all links of the class stands in its code; the rest are the columns of a table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symgen.errors import SceneError
from symgen.loops.model import CONSTANTS
from symgen.program.graph import Graph, Node, extract
from symgen.program.instructions import Port, Program
from symgen.program.passes import optimise


@dataclass(frozen=True)
class Tabulated:
    """A step, and per link the entries of its port of constants."""

    program: Program
    rows: tuple[tuple[Fraction, ...], ...]


def tabulate(program: Program, members: Sequence[Sequence[Fraction]]) -> Tabulated:
    """Fold what depends on constants alone. ``members``: the slots of every link of the class."""
    constant = _constant_parts(program)
    wanted = _frontier(program, constant)
    values = [_evaluated(program, constant, wanted, member) for member in members]
    graph, done = Graph(), dict[int, Node]()
    columns: dict[tuple[Fraction, ...], int] = {}
    for index, step in enumerate(program.instructions):
        if constant[index]:
            if index not in wanted:
                continue
            column = tuple(row[index] for row in values)
            if all(x == column[0] for x in column):
                done[index] = graph.const(column[0])
            elif (negative := tuple(-x for x in column)) in columns:
                done[index] = graph.neg(graph.input(CONSTANTS, columns[negative]))
            else:
                done[index] = graph.input(CONSTANTS, columns.setdefault(column, len(columns)))
        elif step.op == "input":
            assert isinstance(step.value, tuple)
            done[index] = graph.input(*step.value)
        else:
            args = [done[k] for k in step.args]
            done[index] = graph.binary(step.op, *args) if len(args) == 2 else graph.unary(step.op, *args)
    results = [[done[k] for k in row] for row in program.results]
    folded = extract(graph, program.name, program.inputs, program.outputs, results)
    return _without_unread(optimise(folded), list(columns))


def _without_unread(program: Program, columns: Sequence[tuple[Fraction, ...]]) -> Tabulated:
    """Columns that simplification has left without a reader go, and so do ports."""
    read: dict[str, set[int]] = {}
    for step in program.instructions:
        if step.op == "input":
            assert isinstance(step.value, tuple)
            read.setdefault(step.value[0], set()).add(step.value[1])
    kept = sorted(read.get(CONSTANTS, ()))
    place = {old: new for new, old in enumerate(kept)}
    instructions = tuple(
        step._replace(value=(CONSTANTS, place[step.value[1]]))
        if step.op == "input" and isinstance(step.value, tuple) and step.value[0] == CONSTANTS
        else step
        for step in program.instructions
    )
    inputs = [port for port in program.inputs if port.name in read and port.name != CONSTANTS]
    if kept:
        inputs.insert(0, Port(CONSTANTS, (len(kept),)))
    rows = tuple(zip(*(columns[k] for k in kept), strict=True)) if kept else ()
    return Tabulated(replace(program, inputs=tuple(inputs), instructions=instructions), rows)


def _constant_parts(program: Program) -> list[bool]:
    """Per instruction, whether it depends on constants alone."""
    found: list[bool] = []
    for step in program.instructions:
        own = step.op == "const" or (
            step.op == "input" and isinstance(step.value, tuple) and step.value[0] == CONSTANTS
        )
        found.append(own or (bool(step.args) and all(found[k] for k in step.args)))
    return found


def _frontier(program: Program, constant: Sequence[bool]) -> set[int]:
    """Constant instructions that others, or results, read."""
    wanted = {k for row in program.results for k in row if constant[k]}
    for index, step in enumerate(program.instructions):
        if not constant[index]:
            wanted.update(k for k in step.args if constant[k])
    return wanted


def _evaluated(
    program: Program, constant: Sequence[bool], wanted: set[int], member: Sequence[Fraction]
) -> dict[int, Fraction]:
    found: dict[int, Fraction] = {}
    for index, step in enumerate(program.instructions):
        if not constant[index]:
            continue
        if step.op == "const":
            assert isinstance(step.value, Fraction)
            found[index] = step.value
        elif step.op == "input":
            assert isinstance(step.value, tuple)
            found[index] = member[step.value[1]]
        else:
            x, y = found[step.args[0]], found[step.args[-1]]
            found[index] = _operate(step.op, x, y)
    return found


def _operate(op: str, x: Fraction, y: Fraction) -> Fraction:
    if op == "div":
        if y == 0:
            raise SceneError("the mass matrix is singular: nothing with inertia moves with one of the joints")
        return x / y
    if op == "add":
        return x + y
    if op == "sub":
        return x - y
    return x * y if op == "mul" else -x
