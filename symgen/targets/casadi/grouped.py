"""A program run on CasADi's SX, many instructions at a time.

A call to CasADi costs as much as dozens of operations inside it. So the values of all instructions stand in one column,
and every call does all instructions of one kind whose arguments are there.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import casadi

from symgen.program.instructions import Program
from symgen.targets.casadi.numbers import CasadiNumbers, rounded


def evaluate_grouped(program: Program, inputs: Mapping[str, Any]) -> Any:
    """The values of all instructions, one below the other. ``inputs``: name → SX column, row-major.

    Raises NotSupportedError for a constant that a double cannot hold.
    """
    numbers, code = CasadiNumbers(), program.instructions
    functions: dict[str, Callable[..., Any]] = {
        "add": operator.add,
        "sub": operator.sub,
        "mul": operator.mul,
        "div": operator.truediv,
        "neg": operator.neg,
        **{name: getattr(numbers, name) for name in ("sqrt", "cos", "sin", "cos_sqrt", "sinc_sqrt", "sinc3_sqrt")},
    }
    values = casadi.SX.zeros(len(code), 1)
    constants = [i for i, step in enumerate(code) if step.op == "const"]
    if constants:
        exact = [code[i].value for i in constants]
        column = casadi.DM([rounded(value) for value in exact if isinstance(value, Fraction)])
        values.set_nz(casadi.SX(column), False, constants)
    for name, places, entries in _inputs(program):
        values.set_nz(inputs[name].get_nz(False, entries), False, places)
    for op, group in groups(program):
        arguments = zip(*(code[i].args for i in group), strict=True)
        values.set_nz(functions[op](*(values.get_nz(False, list(row)) for row in arguments)), False, group)
    return values


def _inputs(program: Program) -> Iterator[tuple[str, list[int], list[int]]]:
    """(name, instructions that read of it, which entries they read)."""
    found: dict[str, tuple[list[int], list[int]]] = {}
    for i, step in enumerate(program.instructions):
        if step.op == "input":
            assert isinstance(step.value, tuple)
            places, entries = found.setdefault(step.value[0], ([], []))
            places.append(i)
            entries.append(step.value[1])
    for name, (places, entries) in found.items():
        yield name, places, entries


def groups(program: Program) -> Iterator[tuple[str, Sequence[int]]]:
    """The instructions that have arguments, each after those: (operation, instructions), of the kind of which most are
    ready."""
    code = program.instructions
    users: list[list[int]] = [[] for _ in code]
    missing = [0] * len(code)
    for i, step in enumerate(code):
        for argument in step.args:
            if code[argument].args:
                users[argument].append(i)
                missing[i] += 1
    ready: dict[str, list[int]] = {}
    for i, step in enumerate(code):
        if step.args and not missing[i]:
            ready.setdefault(step.op, []).append(i)
    while ready:
        op = max(ready, key=lambda kind: len(ready[kind]))
        group = ready.pop(op)
        yield op, group
        for i in group:
            for user in users[i]:
                missing[user] -= 1
                if not missing[user]:
                    ready.setdefault(code[user].op, []).append(user)
