"""Names and prototypes of the C functions, the one place that knows how a port is passed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symgen.errors import SceneError
from symgen.program.instructions import Port, Program
from symgen.targets.c.literals import Precision

_WIDTH = 110

SHARED = ("dt", "p")
"""Inputs that a batch has one of per state; dt and p are shared."""


@dataclass(frozen=True)
class Symbols:
    """The C functions made of one program; empty where there is none."""

    scalar: str
    batch: str = ""
    batch_p: str = ""
    soa: str = ""
    soa_p: str = ""

    @property
    def all(self) -> Iterator[str]:
        return (symbol for symbol in (self.scalar, self.batch, self.batch_p, self.soa, self.soa_p) if symbol)


def symbols(name: str, programs: Sequence[Program], precision: Precision, batch: bool) -> list[Symbols]:
    """Symbols of all programs. Raises SceneError where two functions, or two arguments, would have
    one name."""
    rows = []
    owner: dict[str, str] = {}
    for program in programs:
        ports = [port.name for port in program.inputs + program.outputs]
        for port in ports:
            if ports.count(port) > 1:
                raise SceneError(f"{program.name} has two arguments {port}; ask for its outputs apart", "outputs")
        batched = batch and any(port.name not in SHARED for port in program.inputs)
        with_p = batched and any(port.name == "p" for port in program.inputs)
        stem, suffix = f"{name}_{program.name}", precision.symbol_suffix
        row = Symbols(
            f"{stem}{suffix}",
            f"{stem}_batch{suffix}" if batched else "",
            f"{stem}_batch_p{suffix}" if with_p else "",
            f"{stem}_soa{suffix}" if batched else "",
            f"{stem}_soa_p{suffix}" if with_p else "",
        )
        for symbol in row.all:
            if symbol in owner:
                raise SceneError(f"{program.name} and {owner[symbol]} both need the C function {symbol}", "outputs")
            owner[symbol] = program.name
        rows.append(row)
    return rows


def _array(port: Port) -> bool:
    return port.shape != ()


def returns_status(program: Program, status: bool) -> bool:
    """True for functions that may have no answer, where the scene asks for a status."""
    return status and bool(program.guards)


def declaration(result: str, symbol: str, arguments: Sequence[str]) -> str:
    """On one line, or with one argument a line where that is too long."""
    text = f"{result} {symbol}({', '.join(arguments)})"
    if len(text) <= _WIDTH:
        return text
    return f"{result} {symbol}(\n    " + ",\n    ".join(arguments) + ")"


def prototype(program: Program, row: Symbols, precision: Precision, status: bool) -> str:
    """``void rrpr_mass_matrix(const double q[4], double M[16])``."""
    arguments = scalar_arguments(program, precision)
    return declaration("int" if returns_status(program, status) else "void", row.scalar, arguments)


def scalar_arguments(program: Program, precision: Precision) -> list[str]:
    """Of the function of one state, as declared."""
    real = precision.c_type
    arguments = [f"const {real} {p.name}[{p.size}]" if _array(p) else f"{real} {p.name}" for p in program.inputs]
    return [*arguments, *(f"{real} {p.name}[{p.size}]" for p in program.outputs)]


def batch_prototype(program: Program, symbol: str, precision: Precision, status: bool, own_parameters: bool) -> str:
    """As the scalar function, with n states one after the other; ``own_parameters``: p per state too."""
    real = precision.c_type
    arguments = ["size_t n"]
    for port in program.inputs:
        shared = port.name in SHARED and not (port.name == "p" and own_parameters)
        size = f"[{port.size}]" if shared else ""
        arguments.append(f"const {real} {port.name}{size}" if size else f"const {real} *{port.name}")
        if not _array(port):
            arguments[-1] = f"{real} {port.name}"
    arguments += [f"{real} *{port.name}" for port in program.outputs]
    return declaration("int" if returns_status(program, status) else "void", symbol, arguments)


def soa_prototype(program: Program, symbol: str, precision: Precision, status: bool, own_parameters: bool) -> str:
    """n states as a structure of arrays: component j of state i of every port is at [j * stride + i]."""
    real = precision.c_type
    arguments = ["size_t n", "size_t stride"]
    for port in program.inputs:
        shared = port.name in SHARED and not (port.name == "p" and own_parameters)
        arguments.append(f"const {real} {port.name}[{port.size}]" if shared else f"const {real} *{port.name}")
        if not _array(port):
            arguments[-1] = f"{real} {port.name}"
    arguments += [f"{real} *{port.name}" for port in program.outputs]
    return declaration("int" if returns_status(program, status) else "void", symbol, arguments)


def batch_prototypes(program: Program, row: Symbols, precision: Precision, status: bool) -> dict[str, str]:
    """Symbol → prototype of every form over many states."""
    found = {}
    for symbol, own in ((row.batch, False), (row.batch_p, True)):
        if symbol:
            found[symbol] = batch_prototype(program, symbol, precision, status, own)
    for symbol, own in ((row.soa, False), (row.soa_p, True)):
        if symbol:
            found[symbol] = soa_prototype(program, symbol, precision, status, own)
    return found
