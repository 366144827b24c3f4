"""A casadi.Function read back instruction by instruction and run in GF(p), for its certificate.

CasADi keeps constants as doubles and merges equal ones, so two different rationals of a program may stand behind
one double. Each use may then be either; the value wanted is recognised by being a value of the program, and the
certificate's claim stays what it is: some choice of rationals, each correctly rounded, gives the literal function.

An entire function is a series where its argument is small and a quotient elsewhere. Both branches are read: the
quotient has to be the function, the series has to be the beginning of its power series.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import casadi

from symgen.algebra.field import FieldNumbers, inverse
from symgen.errors import CertificateError
from symgen.program.evaluate import evaluate_residues, outputs_of
from symgen.program.instructions import Port, Program
from symgen.targets.casadi.emit import casadi_names, matrix_shape
from symgen.targets.casadi.numbers import SERIES_BELOW, SERIES_TERMS

ENTIRE = {"cos_sqrt": 0, "sinc_sqrt": 1, "sinc3_sqrt": 3}
"""Entire function → m, its power series being Σ (−x)ᵏ/(2k + m)!."""
SMALL = 10**4
"""Whole numbers up to this stand for themselves (coefficients of the series, 1, 2 …)."""
BOUND = Fraction(SERIES_BELOW)


@dataclass(frozen=True)
class _Root:
    """√x before it is known whether only its cosine or sine is wanted, which need no root in GF(p)."""

    x: int


@dataclass(frozen=True)
class _SineOfRoot:
    x: int


Value = Any
"""An int, a `_Root`, a `_SineOfRoot`, or a tuple of the ints that one double may stand for."""


class _SeriesNumbers(FieldNumbers):
    """GF(p) with the beginnings of their power series for the entire functions."""

    def apply(self, function: str, x: int) -> int:
        if function not in ENTIRE:
            return super().apply(function, x)
        terms = (
            pow(-x, k, self.p) * inverse(math.factorial(2 * k + ENTIRE[function]), self.p) for k in range(SERIES_TERMS)
        )
        return sum(terms) % self.p


_FOLDED: dict[str, Callable[..., float]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    "sqrt": math.sqrt,
}


def _constants(program: Program, wanted: Sequence[int], p: int) -> dict[float, dict[int, None]]:
    """double → what it may stand for: the program's constants that round to it, and what CasADi makes of constants
    alone when it is given them (the root of one, and what is computed from that)."""
    doubles: dict[int, float] = {}
    found: dict[float, dict[int, None]] = {}
    for i, instruction in enumerate(program.instructions):
        if isinstance(instruction.value, Fraction):
            doubles[i] = float(instruction.value)
        elif instruction.op in _FOLDED and all(k in doubles for k in instruction.args):
            try:
                doubles[i] = _FOLDED[instruction.op](*(doubles[k] for k in instruction.args))
            except (ArithmeticError, ValueError):
                continue
        else:
            continue
        found.setdefault(doubles[i], {})[wanted[i]] = None
        found.setdefault(-doubles[i], {})[-wanted[i] % p] = None
    return found


class _Machine:
    """Arithmetic of one prime. ``wanted``: the values of the program's instructions, which tell apart constants that
    share a double. ``small``: the branch of the entire functions that is run."""

    def __init__(self, program: Program, numbers: FieldNumbers, wanted: Sequence[int], small: bool) -> None:
        self.numbers, self.p, self.wanted, self.small = numbers, numbers.p, frozenset(wanted), small
        self.known = _constants(program, wanted, self.p)
        self.bound = numbers.const(BOUND).x
        self.arguments = {wanted[ins.args[0]] for ins in program.instructions if ins.op in ENTIRE}
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

    def constant(self, value: float) -> Value:
        exact = Fraction(value)
        candidates = dict(self.known.get(value, {}))
        if exact == BOUND or (exact.denominator == 1 and abs(exact) <= SMALL):
            candidates[self.numbers.const(exact).x] = None
        if not candidates:
            raise CertificateError(f"the constant {value!r} of a CasADi function is not one of its program's")
        return next(iter(candidates)) if len(candidates) == 1 else tuple(candidates)

    def run(self, op: int, args: Sequence[Value]) -> Value:
        operation = self.operations.get(op)
        if operation is not None and all(type(arg) is int for arg in args):
            return operation(*args) % self.p
        if op == casadi.OP_SQRT:
            return _Root(self.settle(self.resolve(args[0]))[0])
        if op == casadi.OP_LT:
            return self.is_small(args[0], args[1])
        if isinstance(args[0], _Root) and op == casadi.OP_COS:
            return self.numbers.apply("cos_sqrt", args[0].x)
        if isinstance(args[0], _Root) and op == casadi.OP_SIN:
            return _SineOfRoot(args[0].x)
        if op == casadi.OP_DIV and isinstance(args[0], _SineOfRoot) and args[1] == _Root(args[0].x):
            return self.numbers.apply("sinc_sqrt", args[0].x)
        if operation is None:
            raise CertificateError(f"CasADi operation {op} is not one that symgen emits")
        results = [operation(*choice) % self.p for choice in product(*(self.resolve(arg) for arg in args))]
        found = self.settle(results)
        return found[0] if len(found) == 1 else found

    def settle(self, results: Sequence[int]) -> tuple[int, ...]:
        """Those of several possible values that the program has, where it has any."""
        different = tuple(dict.fromkeys(results))
        return tuple(x for x in different if x in self.wanted) or different

    def is_small(self, x: Value, bound: Value) -> int:
        """The choice between series and quotient: the argument of an entire function below the bound."""
        if self.bound not in self.resolve(bound) or not self.arguments.intersection(self.resolve(x)):
            raise CertificateError("a CasADi function compares what symgen does not")
        return int(self.small)


Listing = Sequence[tuple[int, Sequence[int], Sequence[int], float]]
"""The instructions of a casadi.Function: operation, where the result goes, where arguments come from, constant."""


def listing(function: casadi.Function) -> Listing:
    """Read once what every evaluation needs (each question to CasADi costs more than the arithmetic)."""
    rows = []
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        constant = function.instruction_constant(k) if op == casadi.OP_CONST else 0.0
        rows.append((op, function.instruction_output(k), function.instruction_input(k), constant))
    return rows


def evaluate_mod(
    function: casadi.Function,
    program: Program,
    numbers: FieldNumbers,
    inputs: Mapping[str, Sequence[int]],
    instructions: Listing | None = None,
) -> dict[str, list[int]]:
    """Outputs (flat, row-major) in GF(p) of the SX function that ``program`` became. ``instructions``: its `listing`,
    if it was read before.

    Raises CertificateError for arguments and results that are not the program's, for an operation or a constant that
    the program does not account for, and for a series that is not its function's.
    """
    _check_ports(function, program)
    rows = listing(function) if instructions is None else instructions
    if any(instruction.op in ENTIRE for instruction in program.instructions):
        series = _SeriesNumbers(numbers.p, numbers.seed)
        wanted = evaluate_residues(program, series, inputs)
        if _run(rows, function.sz_w(), program, series, inputs, wanted, True) != outputs_of(program, wanted):
            raise CertificateError(f"{program.name}: a series of the CasADi function is not its function's")
    wanted = evaluate_residues(program, numbers, inputs)
    return _run(rows, function.sz_w(), program, numbers, inputs, wanted, False)


def _run(
    rows: Listing,
    work_size: int,
    program: Program,
    numbers: FieldNumbers,
    inputs: Mapping[str, Sequence[int]],
    wanted: Sequence[int],
    small: bool,
) -> dict[str, list[int]]:
    machine = _Machine(program, numbers, wanted, small)
    work: list[Value] = [0] * work_size
    outputs = [[0] * port.size for port in program.outputs]
    for op, target, source, constant in rows:
        if op == casadi.OP_CONST:
            work[target[0]] = machine.constant(constant)
        elif op == casadi.OP_INPUT:
            port = program.inputs[source[0]]
            work[target[0]] = inputs[port.name][_row_major(port, source[1])]
        elif op == casadi.OP_OUTPUT:
            place = _row_major(program.outputs[target[0]], target[1])
            possible = machine.resolve(work[source[0]])
            right = wanted[program.results[target[0]][place]]
            outputs[target[0]][place] = right if right in possible else possible[0] % numbers.p
        else:
            work[target[0]] = machine.run(op, [work[i] for i in source])
    return {port.name: values for port, values in zip(program.outputs, outputs, strict=True)}


def _check_ports(function: casadi.Function, program: Program) -> None:
    """Arguments and results are the program's, in its order, dense, with its shapes."""
    inputs = [
        (name, matrix_shape(port)) for name, port in zip(casadi_names(program.inputs), program.inputs, strict=True)
    ]
    outputs = [
        (name, matrix_shape(port)) for name, port in zip(casadi_names(program.outputs), program.outputs, strict=True)
    ]
    found_in = [(function.name_in(i), function.size_in(i)) for i in range(function.n_in())]
    found_out = [(function.name_out(i), function.size_out(i)) for i in range(function.n_out())]
    dense = all(function.sparsity_in(i).is_dense() for i in range(function.n_in())) and all(
        function.sparsity_out(i).is_dense() for i in range(function.n_out())
    )
    if inputs != found_in or outputs != found_out or not dense:
        raise CertificateError(f"{program.name}: the CasADi function has other arguments or results")


def _row_major(port: Port, place: int) -> int:
    """Place in CasADi's column-major matrix → place in the row-major one."""
    rows, columns = matrix_shape(port)
    return (place % rows) * columns + place // rows
