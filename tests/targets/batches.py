"""Batches called in every form, and held to what a certificate asks."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from symgen.algebra.field import NotInField, Residue
from symgen.errors import CertificateError
from symgen.program.evaluate import evaluate_all
from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port, Program
from symgen.targets.c import Emitted, read_back
from tests.targets.programs import P, arm, compile_library, pointer, rotation, solver, write_files
from tests.targets.test_read_back import expected, point

WIDEST = (64, 32, 16, 0)
REAL = {"double": np.float64, "float": np.float32}
C_REAL = {"double": ctypes.c_double, "float": ctypes.c_float}


def wide() -> Program:
    """More rows than four, a multiple of four and not; many zeros; one angle more than once."""
    g = Graph()
    q = g.inputs("q", 9)
    p = g.inputs("p", 4)
    c = [g.cos(x) for x in q]
    s = [g.sin(x) for x in q]
    rows = [c[i] * s[j] - p[i % 4] * Fraction(1, 3) for i in range(9) for j in range(2)]
    zeros: list[Any] = [0] * 40
    zeros[3], zeros[17] = s[0] * c[0], Fraction(1, 3)
    ports = (Port("M", (9, 2)), Port("Z", (40,)), Port("few", (3,)))
    return extract(g, "wide", (Port("q", (9,)), P), ports, [rows, zeros, [q[0], -c[1], s[2]]])


def programs() -> list[Program]:
    return [arm(), solver(), rotation(), wide()]


def library(emitted: Emitted, folder: Path, cc: str, widest: int, flags: Sequence[str] = ("-O0",)) -> ctypes.CDLL:
    write_files(emitted, folder)
    target = folder / str(widest)
    target.mkdir()
    for file in emitted.files:
        (target / file).write_text(emitted.files[file])
    return compile_library(target, emitted.sources, cc, [*flags, f"-DSYMGEN_WIDEST={widest}"])


class Caller:
    """Calls the functions of a library in every form, on states at random."""

    def __init__(self, emitted: Emitted, handle: ctypes.CDLL, n: int, **special: Sequence[float]) -> None:
        self.emitted, self.handle, self.n = emitted, handle, n
        self.real = REAL[emitted.info.options.precision]
        self.number = C_REAL[emitted.info.options.precision]
        rng = np.random.default_rng(n)
        ports = {port.name: port for f in emitted.functions for port in f.program.inputs}
        sizes = {
            name: max(p.size for f in emitted.functions for p in f.program.inputs if p.name == name) for name in ports
        }
        self.inputs = {name: rng.uniform(0.5, 1.5, (n, size)).astype(self.real) for name, size in sizes.items()}
        for name, values in special.items():
            for k, value in enumerate(values):
                self.inputs[name][k * 5 % n, k % sizes[name]] = value

    def state(self, port: Port, i: int, own: bool) -> Any:
        row = self.inputs[port.name][i if port.name not in ("dt", "p") or (port.name == "p" and own) else 0]
        return self.number(float(row[0])) if port.name == "dt" else pointer_kept(row[: port.size].copy())

    def scalar(self, function: Any, own: bool) -> tuple[list[Any], int]:
        results = [np.full((self.n, port.size), 9, self.real) for port in function.program.outputs]
        status = 0
        for i in range(self.n):
            arguments = [self.state(port, i, own) for port in function.program.inputs]
            raw = [a if not isinstance(a, np.ndarray) else pointer(a) for a in arguments]
            answer = self.handle[function.symbols.scalar](*raw, *(pointer(r[i]) for r in results))
            status |= answer if self.answers(function) else 0
        return results, status

    def answers(self, function: Any) -> bool:
        return bool(self.emitted.info.options.status and function.program.guards)

    def form(self, function: Any, form: str) -> tuple[list[Any], int]:
        """``form``: batch, batch_p, soa or soa_p."""
        entry = self.handle[getattr(function.symbols, form)]
        return self.run(function, entry, form.endswith("_p"), form.startswith("soa"))

    def run(self, function: Any, entry: Callable[..., int], own: bool, columns: bool) -> tuple[list[Any], int]:
        """``entry`` on all states. ``own``: parameters per state; ``columns``: a structure of arrays."""
        stride = self.n + 3
        arguments: list[Any] = [ctypes.c_size_t(self.n)] + ([ctypes.c_size_t(stride)] if columns else [])
        kept = []
        for port in function.program.inputs:
            shared = port.name == "dt" or (port.name == "p" and not own)
            if shared:
                kept.append(self.state(port, 0, False))
            else:
                rows = self.inputs[port.name][:, : port.size]
                kept.append(spread(rows, stride) if columns else rows.copy())
        size = stride if columns else self.n
        results = [
            np.full((port.size, size) if columns else (size, port.size), 9, self.real)
            for port in function.program.outputs
        ]
        raw = [a if not isinstance(a, np.ndarray) else pointer(a) for a in [*kept, *results]]
        status = entry(*arguments, *raw)
        if columns:
            assert all((r[:, self.n :] == 9).all() for r in results)
            results = [np.ascontiguousarray(r[:, : self.n].T) for r in results]
        return results, status if self.answers(function) else 0


def pointer_kept(array: Any) -> Any:
    return array


def spread(rows: Any, stride: int) -> Any:
    columns = np.full((rows.shape[1], stride), np.nan, rows.dtype)
    columns[:, : len(rows)] = rows.T
    return columns


def certify(emitted: Emitted) -> None:
    """What a certificate does with the functions of the batch file; raises CertificateError."""
    read = read_back(emitted)
    read.check_literals()
    for function in emitted.functions:
        program = function.program
        if program.name not in read.vectors:
            assert not function.symbols.batch
            continue
        numbers, inputs = point(program)
        try:
            found = read.vectors[program.name].evaluate_mod(numbers.p, inputs, numbers.apply)
            guards = read.vectors[program.name].guards_mod(numbers.p, inputs, numbers.apply)
        except NotInField:
            raise CertificateError("no value") from None
        every = evaluate_all(program, numbers, {k: [Residue(x, numbers.p) for x in row] for k, row in inputs.items()})
        if found != expected(program, numbers, inputs) or guards != [every[i].x for i in program.guards]:
            raise CertificateError(f"{program.name} differs")
