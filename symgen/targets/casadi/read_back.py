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


_BINARY = frozenset({
    casadi.OP_ADD, casadi.OP_SUB, casadi.OP_MUL, casadi.OP_DIV, casadi.OP_LT, casadi.OP_IF_ELSE_ZERO,
})  # fmt: skip

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


def _doubles(program: Program) -> dict[int, float]:
    """Instruction → its double, of the constants and of what CasADi makes of constants alone when it is given them (the
    root of one, and what is computed from that)."""
    found: dict[int, float] = {}
    for i, (op, args, value, _, _) in enumerate(program.instructions):
        if op == "const":
            assert isinstance(value, Fraction)
            found[i] = float(value)
        elif args and args[0] in found and op in _FOLDED and all(k in found for k in args):
            try:
                found[i] = _FOLDED[op](*(found[k] for k in args))
            except (ArithmeticError, ValueError):
                continue
    return found


def _constants(program: Program, wanted: Sequence[int], p: int) -> dict[float, dict[int, None]]:
    """double → what it may stand for: the program's values that round to it."""
    found: dict[float, dict[int, None]] = {}
    for i, double in _doubles(program).items():
        found.setdefault(double, {})[wanted[i]] = None
        found.setdefault(-double, {})[-wanted[i] % p] = None
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


Listing = Sequence[tuple[int, int, int, int, float]]
"""The instructions of a casadi.Function: operation, where the result goes, where the arguments come from, constant. Of
an input the first argument is its number and the second the entry; of an output, the target and the second argument."""


def listing(function: casadi.Function) -> Listing:
    """Read once what every evaluation needs (each question to CasADi costs more than the arithmetic)."""
    rows: list[tuple[int, int, int, int, float]] = []
    operation, target, source = function.instruction_id, function.instruction_output, function.instruction_input
    for k in range(function.n_instructions()):
        op, to, of = operation(k), target(k), source(k)
        if op == casadi.OP_CONST:
            rows.append((op, to[0], 0, 0, function.instruction_constant(k)))
        elif op == casadi.OP_OUTPUT:
            rows.append((op, to[0], of[0], to[1], 0.0))
        else:
            rows.append((op, to[0], of[0], of[-1], 0.0))
    return rows


def evaluate_mod(
    function: casadi.Function,
    program: Program,
    numbers: FieldNumbers,
    inputs: Mapping[str, Sequence[int]],
    instructions: Listing | None = None,
    values: Sequence[int] | None = None,
) -> dict[str, list[int]]:
    """Outputs (flat, row-major) in GF(p) of the SX function that ``program`` became. ``instructions``: its `listing`,
    if it was read before; ``values``: those of the program's instructions, if they are known.

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
    known: Sequence[int] = evaluate_residues(program, numbers, inputs) if values is None else values
    return _run(rows, function.sz_w(), program, numbers, inputs, known, False)


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
    given = [(inputs[port.name], _row_major(port)) for port in program.inputs]
    outputs = [[0] * port.size for port in program.outputs]
    places = [_row_major(port) for port in program.outputs]
    p, plain = numbers.p, {casadi.OP_ADD: operator.add, casadi.OP_SUB: operator.sub, casadi.OP_MUL: operator.mul}
    for op, target, first, second, constant in rows:
        if op in plain:
            x, y = work[first], work[second]
            if type(x) is int and type(y) is int:
                work[target] = plain[op](x, y) % p
            else:
                work[target] = machine.run(op, (x, y))
        elif op == casadi.OP_CONST:
            work[target] = machine.constant(constant)
        elif op == casadi.OP_INPUT:
            values, rowwise = given[first]
            work[target] = values[rowwise[second]]
        elif op == casadi.OP_OUTPUT:
            place, value = places[target][second], work[first]
            if type(value) is not int:
                right, possible = wanted[program.results[target][place]], machine.resolve(value)
                value = right if right in possible else possible[0] % p
            outputs[target][place] = value
        else:
            work[target] = machine.run(op, (work[first], work[second]) if op in _BINARY else (work[first],))
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


def _row_major(port: Port) -> list[int]:
    """Per place in CasADi's column-major matrix, the place in the row-major one."""
    rows, columns = matrix_shape(port)
    return [row * columns + column for column in range(columns) for row in range(rows)]
