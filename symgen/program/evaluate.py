"""Run a program in any number type: the same instructions, other scalars."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from symgen.algebra.field import FieldNumbers, inverse
from symgen.algebra.numbers import Numbers
from symgen.program.instructions import Program

Scalar = Any

_ARITHMETIC: dict[str, Callable[..., Scalar]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
}


def evaluate_all(program: Program, numbers: Numbers, inputs: Mapping[str, Sequence[Scalar]]) -> list[Scalar]:
    """The value of every instruction. ``inputs``: name → flat, row-major scalars."""
    functions: dict[str, Callable[[Scalar], Scalar]] = {
        "sqrt": numbers.sqrt,
        "cos": numbers.cos,
        "sin": numbers.sin,
        "cos_sqrt": numbers.cos_sqrt,
        "sinc_sqrt": numbers.sinc_sqrt,
        "sinc3_sqrt": numbers.sinc3_sqrt,
    }
    values: list[Scalar] = []
    for op, args, value, _, _ in program.instructions:
        if op in _ARITHMETIC:
            values.append(_ARITHMETIC[op](*[values[i] for i in args]))
        elif op == "const":
            assert isinstance(value, Fraction)
            values.append(numbers.const(value))
        elif op == "input":
            assert isinstance(value, tuple)
            values.append(inputs[value[0]][value[1]])
        else:
            values.append(functions[op](values[args[0]]))
    return values


def evaluate_residues(program: Program, numbers: FieldNumbers, inputs: Mapping[str, Sequence[int]]) -> list[int]:
    """The value of every instruction in GF(p), on plain ints (`evaluate_all` with residues, five times as fast)."""
    p, values = numbers.p, list[int]()
    for op, args, value, _, _ in program.instructions:
        if op == "mul":
            values.append(values[args[0]] * values[args[1]] % p)
        elif op == "add":
            values.append((values[args[0]] + values[args[1]]) % p)
        elif op == "sub":
            values.append((values[args[0]] - values[args[1]]) % p)
        elif op == "const":
            assert isinstance(value, Fraction)
            values.append(value.numerator * inverse(value.denominator, p) % p)
        elif op == "input":
            assert isinstance(value, tuple)
            values.append(inputs[value[0]][value[1]] % p)
        elif op == "neg":
            values.append(-values[args[0]] % p)
        elif op == "div":
            values.append(values[args[0]] * inverse(values[args[1]], p) % p)
        else:
            values.append(numbers.apply(op, values[args[0]]))
    return values


Residues = Callable[[FieldNumbers, Mapping[str, Sequence[int]]], Sequence[int]]


def remembered_residues(program: Program) -> Residues:
    """`evaluate_residues` of a program, which remembers the last point: several candidates ask at each."""
    last: list[Any] = [None, None, ()]

    def values(numbers: FieldNumbers, inputs: Mapping[str, Sequence[int]]) -> Sequence[int]:
        if last[0] is not numbers or last[1] is not inputs:
            last[:] = numbers, inputs, evaluate_residues(program, numbers, inputs)
        found: Sequence[int] = last[2]
        return found

    return values


def evaluate(
    program: Program, numbers: Numbers, inputs: Mapping[str, Sequence[Scalar]]
) -> dict[str, tuple[Scalar, ...]]:
    """Outputs by name, flat, row-major. Guards are not looked at."""
    found = outputs_of(program, evaluate_all(program, numbers, inputs))
    return {name: tuple(values) for name, values in found.items()}


def evaluate_in_field(
    program: Program, numbers: FieldNumbers, inputs: Mapping[str, Sequence[int]]
) -> dict[str, list[int]]:
    """`evaluate` in GF(p), on plain ints."""
    return outputs_of(program, evaluate_residues(program, numbers, inputs))


def outputs_of(program: Program, values: Sequence[Scalar]) -> dict[str, list[Scalar]]:
    """Outputs by name, flat, row-major, among the values of all instructions."""
    return {port.name: [values[i] for i in row] for port, row in zip(program.outputs, program.results, strict=True)}
