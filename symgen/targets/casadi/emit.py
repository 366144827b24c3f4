"""A program as a casadi.Function with the names of the interface."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import prod
from typing import Any

import casadi

from symgen.program.evaluate import evaluate
from symgen.program.instructions import Port, Program
from symgen.targets.casadi.numbers import CasadiNumbers


def casadi_name(name: str) -> str:
    """``name`` as CasADi wants it: a letter first, no two underscores in a row, none of its own words."""
    plain = re.sub("_+", "_", name).lstrip("_")
    return plain if plain[:1].isalpha() and plain not in ("null", "jac", "hess") else f"f_{plain}"


def casadi_names(ports: Sequence[Port]) -> list[str]:
    """Names of arguments or results, each once."""
    names: list[str] = []
    for port in ports:
        name, number = casadi_name(port.name), 2
        while name in names:
            name, number = f"{casadi_name(port.name)}_{number}", number + 1
        names.append(name)
    return names


def matrix_shape(port: Port) -> tuple[int, int]:
    """Rows and columns of a port: in CasADi everything is a matrix, further dimensions lie side by side."""
    rows = port.shape[0] if port.shape else 1
    return rows, prod(port.shape[1:])


def _symbol(port: Port) -> Any:
    return casadi.SX.sym(port.name, *matrix_shape(port))


def _entries(symbol: Any) -> list[Any]:
    """Row-major entries."""
    rows, columns = symbol.shape
    return [symbol[i, j] for i in range(rows) for j in range(columns)]


def _matrix(port: Port, entries: tuple[Any, ...]) -> Any:
    """Row-major entries → an SX of the port's shape (CasADi itself stores columns). Structural zeros are kept dense,
    so that the sparsity of an output does not depend on the scene's numbers."""
    rows, columns = matrix_shape(port)
    if not entries:
        return casadi.SX(rows, columns)
    by_columns = [entries[i * columns + j] for j in range(columns) for i in range(rows)]
    return casadi.reshape(casadi.vertcat(*by_columns), rows, columns)


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
    """The function ``program.name``: inputs and outputs named as in the catalogue, matrices as matrices (see
    `casadi_name` for names that CasADi does not take). Guards are not part of it: where the mathematics has no answer,
    neither has the function.

    Raises NotSupportedError for a constant that a double cannot hold.
    """
    symbols = {port.name: _symbol(port) for port in program.inputs}
    flat = {name: _entries(symbol) for name, symbol in symbols.items()}
    with _as_written():
        results = evaluate(program, CasadiNumbers(), flat)
    outputs = [_matrix(port, results[port.name]) for port in program.outputs]
    return casadi.Function(
        casadi_name(program.name),
        [symbols[port.name] for port in program.inputs],
        [casadi.densify(output) for output in outputs],
        casadi_names(program.inputs),
        casadi_names(program.outputs),
    )
