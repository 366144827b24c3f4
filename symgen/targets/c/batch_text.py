"""The batch file read back: every function is one loop over states that calls its scalar function rightly."""

from __future__ import annotations

import re
from collections.abc import Sequence

from symgen.errors import CertificateError
from symgen.program.instructions import Program

_FUNCTION = re.compile(r"\s*(void|int) (\w+)\(([^()]*)\)\s*\{(.*?)\n\}\n", re.ASCII | re.DOTALL)
_LOOP = re.compile(r"\s*for \(size_t i = 0; i < n; \+\+i\) \{\s*(\w+)\(([^()]*)\);\s*\}\s*", re.ASCII)
_STATUS_LOOP = re.compile(
    r"\s*int status = 0;\s*for \(size_t i = 0; i < n; \+\+i\) \{\s*status \|= (\w+)\(([^()]*)\);\s*\}"
    r"\s*return status;\s*",
    re.ASCII,
)
_SHARED = ("dt", "p")


def check_batch(
    file: str, code: str, header: str, functions: Sequence[tuple[Program, str, str, bool]], precision: str, status: bool
) -> None:
    """Check the code of a batch file, comments stripped. ``functions``: (program, scalar symbol, batch symbol, whether
    p is per state), in their order. Raises CertificateError."""
    include = re.match(rf'\s*#include "{re.escape(header)}"\n', code)
    if include is None:
        raise CertificateError(f"{file}: must begin with its include")
    position = include.end()
    for program, scalar, symbol, own_parameters in functions:
        match = _FUNCTION.match(code, position)
        if match is None or match[2] != symbol:
            raise CertificateError(f"{file}: {symbol} expected, found something else")
        position = match.end()
        answers = status and bool(program.guards)
        loop = (_STATUS_LOOP if answers else _LOOP).fullmatch(match[4])
        declared, passed = _expected(program, own_parameters, precision)
        if match[1] != ("int" if answers else "void") or _split(match[3]) != declared:
            raise CertificateError(f"{file}: {symbol} is not declared as it should be")
        if loop is None or loop[1] != scalar or _split(loop[2]) != passed:
            raise CertificateError(f"{file}: {symbol} is not a loop over {scalar}")
    if code[position:].strip():
        raise CertificateError(f"{file}: text after the last function")


def _split(arguments: str) -> list[str]:
    return [" ".join(argument.split()) for argument in arguments.split(",")]


def _expected(program: Program, own_parameters: bool, precision: str) -> tuple[list[str], list[str]]:
    """Declared arguments, and those of the call for state i."""
    declared, passed = ["size_t n"], []
    for port in program.inputs:
        if port.name not in _SHARED or (port.name == "p" and own_parameters):
            declared.append(f"const {precision} *{port.name}")
            passed.append(f"{port.name} + {port.size} * i")
        else:
            declared.append(f"const {precision} {port.name}[{port.size}]" if port.shape else f"{precision} {port.name}")
            passed.append(port.name)
    for port in program.outputs:
        declared.append(f"{precision} *{port.name}")
        passed.append(f"{port.name} + {port.size} * i")
    return declared, passed
