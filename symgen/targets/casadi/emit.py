"""A program as a casadi.Function with the names of the interface."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import prod
from typing import Any

import casadi

from symgen.program.instructions import Port, Program
from symgen.targets.casadi.grouped import evaluate_grouped


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


def _column(symbol: Any) -> Any:
    """Row-major entries, one below the other."""
    return casadi.vec(symbol.T)


def _matrix(port: Port, column: Any) -> Any:
    """Row-major entries → an SX of the port's shape (CasADi itself stores columns). Structural zeros are kept dense,
    so that the sparsity of an output does not depend on the scene's numbers."""
    rows, columns = matrix_shape(port)
    return casadi.reshape(column, columns, rows).T if rows and columns else casadi.SX(rows, columns)


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
    with _as_written():
        values = evaluate_grouped(program, {name: _column(symbol) for name, symbol in symbols.items()})
    rows = zip(program.outputs, program.results, strict=True)
    outputs = [_matrix(port, values.get_nz(False, list(row)) if row else None) for port, row in rows]
    return casadi.Function(
        casadi_name(program.name),
        [symbols[port.name] for port in program.inputs],
        [casadi.densify(output) for output in outputs],
        casadi_names(program.inputs),
        casadi_names(program.outputs),
    )
