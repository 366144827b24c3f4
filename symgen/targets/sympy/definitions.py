"""A program as a reader's list of definitions: named intermediate quantities, then the result in terms of them."""

from __future__ import annotations

import operator
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import sympy
from sympy.core.parameters import distribute

from symgen.program.instructions import Instruction, Program
from symgen.targets.sympy.numbers import SympyNumbers, rational

Arguments = Mapping[str, Sequence[sympy.Expr]]


@dataclass(frozen=True)
class Definitions:
    """``steps`` in order: (symbol, what it stands for); ``results`` per output, row-major."""

    steps: tuple[tuple[sympy.Symbol, sympy.Expr], ...]
    results: tuple[tuple[sympy.Expr, ...], ...]


def nested(program: Program, arguments: Arguments) -> tuple[tuple[sympy.Expr, ...], ...]:
    """The results without definitions. Parts used more than once stay the same object (SymPy's evaluation would merge
    the sums they stand in, term by term), so the result is a graph in memory, though it prints as a tree."""
    values: list[sympy.Expr] = []
    for instruction in program.instructions:
        values.append(_value(instruction, values, arguments, KEPT))
    return tuple(tuple(values[i] for i in row) for row in program.results)


def define(program: Program, arguments: Arguments) -> Definitions:
    """What is used more than once gets a name: the program's own label, or a numbered t."""
    uses = Counter(i for instruction in program.instructions for i in instruction.args)
    uses.update(i for row in program.results for i in row)
    taken = {symbol.name for row in arguments.values() for symbol in row if isinstance(symbol, sympy.Symbol)}
    values: list[sympy.Expr] = []
    steps: list[tuple[sympy.Symbol, sympy.Expr]] = []
    with distribute(False):
        for place, instruction in enumerate(program.instructions):
            value = _value(instruction, values, arguments, MERGED)
            if uses[place] > 1 and _worth_a_name(value):
                symbol = _symbol(instruction.label, taken, len(steps))
                steps.append((symbol, value))
                value = symbol
            values.append(value)
    results = tuple(tuple(values[i] for i in row) for row in program.results)
    return Definitions(tuple(steps), results)


def _worth_a_name(value: sympy.Expr) -> bool:
    """Not numbers, symbols, their negatives and multiples, cosines and sines."""
    if value.is_Mul and len(value.args) == 2 and value.args[0].is_Number:
        value = value.args[1]
    return not (value.is_Atom or (isinstance(value, sympy.cos | sympy.sin) and value.args[0].is_Symbol))


def _symbol(label: str, taken: set[str], count: int) -> sympy.Symbol:
    stem, name = (label, label) if label else ("t", f"t{count + 1}")
    number = count + 1
    while name in taken:
        number += 1
        name = f"{stem}_{number}" if label else f"t{number}"
    taken.add(name)
    return sympy.Symbol(name)


Operations = Mapping[str, Callable[..., sympy.Expr]]

MERGED: Operations = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
}
"""SymPy's own arithmetic."""


def _product(x: sympy.Expr, y: sympy.Expr) -> sympy.Expr:
    return sympy.Mul(x, y, evaluate=False)


def _minus(x: sympy.Expr) -> sympy.Expr:
    return -x if x.is_Atom else _product(sympy.S.NegativeOne, x)


KEPT: Operations = {
    "add": lambda x, y: sympy.Add(x, y, evaluate=False),
    "sub": lambda x, y: sympy.Add(x, _minus(y), evaluate=False),
    "mul": _product,
    "div": lambda x, y: _product(x, sympy.Pow(y, -1, evaluate=False)),
    "neg": _minus,
}
"""Arithmetic that leaves its operands as they are."""


def _value(
    instruction: Instruction, values: Sequence[sympy.Expr], arguments: Arguments, operations: Operations
) -> sympy.Expr:
    if instruction.op == "const":
        assert not isinstance(instruction.value, tuple) and instruction.value is not None
        return rational(instruction.value)
    if instruction.op == "input":
        assert isinstance(instruction.value, tuple)
        name, index = instruction.value
        return arguments[name][index]
    args = [values[i] for i in instruction.args]
    operation = operations.get(instruction.op)
    if operation is not None:
        return operation(*args)
    with distribute(True):  # SymPy's cos does not end on some sums without
        return getattr(SympyNumbers(), instruction.op)(*args)
