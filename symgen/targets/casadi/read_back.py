"""A casadi.Function read back instruction by instruction and run in GF(p), for its certificate.

CasADi keeps constants as doubles and merges equal ones, so two different rationals of a program may stand behind
one double. Each use may then be either; the value wanted is recognised by being a value of the program, and the
certificate's claim stays what it is: some choice of rationals, each correctly rounded, gives the literal function.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import casadi

from symgen.algebra.field import FieldNumbers, inverse
from symgen.errors import CertificateError
from symgen.program.instructions import Program


@dataclass(frozen=True)
class _Root:
    """√x before it is known whether only its cosine or sine is wanted, which need no root in GF(p)."""

    x: int


@dataclass(frozen=True)
class _SineOfRoot:
    x: int


Value = Any
"""An int, a `_Root`, a `_SineOfRoot`, or a tuple of the ints that one double may stand for."""


def rationals(program: Program) -> dict[float, tuple[Fraction, ...]]:
    """double → the program's constants that round to it."""
    found: dict[float, list[Fraction]] = {}
    for instruction in program.instructions:
        if isinstance(instruction.value, Fraction):
            for value in (instruction.value, -instruction.value):
                same = found.setdefault(float(value), [])
                if value not in same:
                    same.append(value)
    return {double: tuple(values) for double, values in found.items()}


class _Machine:
    """Arithmetic of one prime."""

    def __init__(self, numbers: FieldNumbers, wanted: frozenset[int]) -> None:
        self.numbers, self.p, self.wanted = numbers, numbers.p, wanted
        self.operations: dict[int, Callable[..., Value]] = {
            casadi.OP_ADD: lambda x, y: x + y,
            casadi.OP_SUB: lambda x, y: x - y,
            casadi.OP_MUL: lambda x, y: x * y,
            casadi.OP_DIV: lambda x, y: x * inverse(y, self.p),
            casadi.OP_NEG: lambda x: -x,
            casadi.OP_SQ: lambda x: x * x,
            casadi.OP_TWICE: lambda x: 2 * x,
            casadi.OP_INV: lambda x: inverse(x, self.p),
            casadi.OP_ASSIGN: lambda x: x,
            casadi.OP_COS: lambda x: numbers.apply("cos", x % self.p),
            casadi.OP_SIN: lambda x: numbers.apply("sin", x % self.p),
            # The series of an entire function stands in the branch for small arguments; the other one is checked.
            casadi.OP_LT: lambda x, y: 0,
            casadi.OP_NOT: lambda x: 1 - x,
            casadi.OP_IF_ELSE_ZERO: lambda x, y: x * y,
        }

    def resolve(self, value: Value) -> tuple[int, ...]:
        """The ints a value may stand for."""
        if isinstance(value, _Root):
            return (self.numbers.apply("sqrt", value.x),)
        if isinstance(value, _SineOfRoot):
            return (self.numbers.apply("sin", self.numbers.apply("sqrt", value.x)),)
        return value if isinstance(value, tuple) else (value,)

    def run(self, op: int, args: Sequence[Value]) -> Value:
        if op == casadi.OP_SQRT:
            return _Root(args[0] % self.p)
        if isinstance(args[0], _Root) and op == casadi.OP_COS:
            return self.numbers.apply("cos_sqrt", args[0].x)
        if isinstance(args[0], _Root) and op == casadi.OP_SIN:
            return _SineOfRoot(args[0].x)
        if op == casadi.OP_DIV and isinstance(args[0], _SineOfRoot) and args[1] == _Root(args[0].x):
            return self.numbers.apply("sinc_sqrt", args[0].x)
        operation = self.operations.get(op)
        if operation is None:
            raise CertificateError(f"CasADi operation {op} is not one that symgen emits")
        results = [operation(*choice) % self.p for choice in product(*(self.resolve(arg) for arg in args))]
        if len(results) == 1:
            return results[0]
        known = {result for result in results if result in self.wanted}
        return known.pop() if len(known) == 1 else tuple(dict.fromkeys(results))


def evaluate_mod(
    function: casadi.Function,
    program: Program,
    numbers: FieldNumbers,
    inputs: Mapping[str, Sequence[int]],
    wanted: Iterable[int],
) -> dict[str, list[int]]:
    """Outputs (flat, row-major) of an SX function in GF(p). ``wanted``: the values of the program's instructions
    there, which tell apart constants that share a double.

    Raises CertificateError for an operation or a constant that the program does not account for.
    """
    known = rationals(program)
    machine = _Machine(numbers, frozenset(wanted))
    work: list[Value] = [0] * function.sz_w()
    outputs = [[0] * function.numel_out(i) for i in range(function.n_out())]
    arguments = [inputs[function.name_in(i)] for i in range(function.n_in())]
    for k in range(function.n_instructions()):
        op, target, source = function.instruction_id(k), function.instruction_output(k), function.instruction_input(k)
        if op == casadi.OP_CONST:
            work[target[0]] = _constant(function.instruction_constant(k), known, numbers)
        elif op == casadi.OP_INPUT:
            work[target[0]] = arguments[source[0]][_row_major(function, source[0], source[1], False)]
        elif op == casadi.OP_OUTPUT:
            value = machine.resolve(work[source[0]])
            place = _row_major(function, target[0], target[1], True)
            outputs[target[0]][place] = value[0] % numbers.p
        else:
            work[target[0]] = machine.run(op, [work[i] for i in source])
    return {function.name_out(i): values for i, values in enumerate(outputs)}


def _row_major(function: casadi.Function, port: int, place: int, is_output: bool) -> int:
    """Place in a column-major, dense matrix → place in the row-major one."""
    rows, columns = function.size_out(port) if is_output else function.size_in(port)
    return (place % rows) * columns + place // rows


SMALL = 10**4
"""Whole numbers up to this stand for themselves (coefficients of the series, 1, 2 …)."""


def _constant(value: float, known: Mapping[float, tuple[Fraction, ...]], numbers: FieldNumbers) -> Value:
    exact = Fraction(value)
    candidates = list(known.get(value, ()))
    if exact.denominator == 1 and abs(exact) <= SMALL and exact not in candidates:
        candidates.append(exact)
    if exact == Fraction(1e-2):
        candidates.append(exact)  # the bound below which series are used; it only meets the comparison
    if not candidates:
        raise CertificateError(f"the constant {value!r} of a CasADi function is not one of its program's")
    return tuple(dict.fromkeys(numbers.const(candidate).x for candidate in candidates))
