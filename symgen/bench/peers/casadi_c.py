"""C by CasADi's own code generator: of our expressions, and for peers that derive with CasADi.

The generated functions are called directly, with the tables of pointers filled once: none of CasADi's own evaluation
is in the figures.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from symgen.bench.variant import PRINTED, Array, Found, Problem, State, Unit, Variant
from symgen.bench.workshop import Workshop

WORK = 1 << 16


def casadi_variant(
    peer: str, function: str, symbol: str, text: str, arrays: Mapping[str, Array], outputs: Sequence[int],
    unpack: Callable[[Array, State], list[Array]], generate_s: float, operations: int | None,
) -> Variant:  # fmt: skip
    """A function with CasADi's C interface; ``outputs`` are the sizes of its results, side by side in ``out``."""
    starts = [0, *np.cumsum(outputs)[:-1].tolist()]
    fill = " ".join(f"{symbol}_arg[{i}] = {{{name}}};" for i, name in enumerate(arrays))
    declaration = (
        f"int {symbol}(const double **, double **, long long *, double *, int);\n"
        f"static const double *{symbol}_arg[{len(arrays)}];\n"
        f"static double *{symbol}_res[{len(outputs)}], {symbol}_w[{WORK}];\nstatic long long {symbol}_iw[{WORK}];"
    )
    setup = " ".join(f"{symbol}_res[{i}] = out + {start};" for i, start in enumerate(starts))
    return Variant(
        peer, function, declaration, f"{fill} {symbol}({symbol}_arg, {symbol}_res, {symbol}_iw, {symbol}_w, 0);",
        arrays, sum(outputs), unpack, (Unit(symbol, text),), setup=setup, generate_s=generate_s, operations=operations,
    )  # fmt: skip


def c_text(function: Any) -> str:
    """What CasADi's code generator writes for a casadi.Function."""
    import casadi

    with tempfile.TemporaryDirectory() as scratch:
        file = f"{function.name()}.c"  # names inside are made of it
        generator = casadi.CodeGenerator(file, {"with_header": False})
        generator.add(function)
        generator.generate(scratch + "/")
        return Path(scratch, file).read_text()


def operations(function: Any) -> int:
    """Additions, multiplications, divisions and roots of an SX function."""
    import casadi

    names = ("ADD", "SUB", "MUL", "DIV", "NEG", "SQ", "INV", "TWICE", "SQRT")
    counted = {getattr(casadi, f"OP_{name}") for name in names}
    return sum(function.instruction_id(k) in counted for k in range(function.n_instructions()))


def by_columns(function: Any) -> Callable[[Array, State], list[Array]]:
    """CasADi's results, whose matrices are stored by columns, as flat row-major ones."""
    shapes = [function.size_out(k) for k in range(function.n_out())]
    ends = np.cumsum([rows * columns for rows, columns in shapes])[:-1]

    def unpack(flat: Array, _state: State) -> list[Array]:
        parts = np.split(flat, ends)
        return [part.reshape(shape, order="F").ravel() for part, shape in zip(parts, shapes, strict=True)]

    return unpack


def own(problem: Problem, workshop: Workshop) -> Found:
    """CasADi's C for the programs that symgen chose."""
    import casadi

    from symgen.targets.casadi import casadi_function
    from symgen.targets.casadi.emit import casadi_name

    found = Found()
    for name, program in problem.programs.items():
        if not program.inputs or not any(port.size for port in program.outputs):
            continue
        started = time.process_time()
        made = casadi_function(program)
        symbol = casadi_name(f"owncasadi_{program.name}")
        inputs = made.sx_in()
        function = casadi.Function(symbol, inputs, made.call(inputs))
        text = c_text(function)
        taken = time.process_time() - started
        arrays = {port.name: np.atleast_2d(problem.column(port.name)) for port in program.inputs}
        sizes = [function.numel_out(k) for k in range(function.n_out())]
        found.variants.append(
            casadi_variant(
                PRINTED, name, symbol, text, arrays, sizes, by_columns(function), taken, operations(function)
            )
        )
    return found
