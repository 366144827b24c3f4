"""A program as a casadi.Function with the names of the interface."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import casadi

from symgen.program.evaluate import evaluate
from symgen.program.instructions import Port, Program
from symgen.targets.casadi.numbers import CasadiNumbers


def _symbol(port: Port) -> Any:
    return casadi.SX.sym(port.name, *(port.shape or (1,)))


def _matrix(port: Port, entries: tuple[Any, ...]) -> Any:
    """Row-major entries → an SX of the port's shape (CasADi itself stores columns). Structural zeros are kept dense,
    so that the sparsity of an output does not depend on the scene's numbers."""
    rows, columns = (*port.shape, 1, 1)[:2] if len(port.shape) < 2 else port.shape
    flat = [casadi.SX(x) for x in entries]
    return casadi.vertcat(*(casadi.horzcat(*flat[i * columns : (i + 1) * columns]) for i in range(rows)))


@contextmanager
def _as_written() -> Iterator[None]:
    """CasADi's own simplification, which folds constants in floating point, switched off: the program is simplified
    already, exactly."""
    before = casadi.GlobalOptions.getSimplificationOnTheFly()
    casadi.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        casadi.GlobalOptions.setSimplificationOnTheFly(before)


def casadi_function(program: Program) -> casadi.Function:
    """The function ``program.name``: inputs and outputs named as in the catalogue, matrices as matrices. Guards are
    not part of it: where the mathematics has no answer, neither has the function."""
    symbols = {port.name: _symbol(port) for port in program.inputs}
    flat = {name: [symbol[i] for i in range(symbol.numel())] for name, symbol in symbols.items()}
    with _as_written():
        results = evaluate(program, CasadiNumbers(), flat)
    outputs = [_matrix(port, results[port.name]) for port in program.outputs]
    return casadi.Function(
        program.name,
        [symbols[port.name] for port in program.inputs],
        [casadi.densify(output) for output in outputs],
        [port.name for port in program.inputs],
        [port.name for port in program.outputs],
    )
