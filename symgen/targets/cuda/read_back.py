"""CUDA read back: the statements as those of C functions, and around them nothing but the frame."""

from __future__ import annotations

import re
from fractions import Fraction

from symgen.errors import CertificateError
from symgen.targets.c.function_text import FunctionReader, ReadFunction
from symgen.targets.c.read_back import strip_comments
from symgen.targets.c.rounding import check_literal, literal_value
from symgen.targets.cuda.emit import EmittedCuda, device_text, kernels_text

_MARK = "\x01"
_CONSTANT = re.compile(r"static constexpr (double|float) (\w+) = ([\w.+-]+);(?: /\*[^*]*\*/)?\n?", re.ASCII)


def read_cuda(emitted: EmittedCuda) -> dict[str, ReadFunction]:
    """Program name → its function of one state as it is read.

    Everything else (built-in functions, places of arrays, kernels, launches) is compared with what it must be. Every
    named constant is proven correctly rounded. Raises CertificateError for whatever differs.
    """
    header, source = emitted.headers[0], emitted.sources[0]
    if emitted.files[source] != kernels_text(emitted):
        raise CertificateError(f"{source}: is not what a file of kernels must be")
    table = _MARK if emitted.constants else ""
    pieces = device_text(emitted, [f"{_MARK}\n"] * len(emitted.functions), table).split(_MARK)
    found = _between(header, emitted.files[header], pieces)
    values = _constants(header, found.pop(0), emitted) if table else {}
    options = emitted.info.options
    functions = {}
    for function, text in zip(emitted.functions, found, strict=True):
        place = f"{header}: {function.name}"
        body = _plain(place, text)
        status = options.status and bool(function.program.guards)
        reader = FunctionReader(place, function.program, values, options.precision, options.trigonometry, status)
        functions[function.program.name] = reader.read(body)
    used = {name for read in functions.values() for name in read.constants}
    if used != set(values):
        raise CertificateError(f"{header}: constants that are never used")
    return functions


def _between(file: str, text: str, pieces: list[str]) -> list[str]:
    """What stands between the pieces of the frame, which all must be there, in their order."""
    if not text.startswith(pieces[0]) or not text.endswith(pieces[-1]):
        raise CertificateError(f"{file}: does not begin or end as it must")
    found, position = list[str](), len(pieces[0])
    for piece in pieces[1:-1]:
        end = text.find(piece, position)
        if end < 0:
            raise CertificateError(f"{file}: its frame is not what it must be")
        found.append(text[position:end])
        position = end + len(piece)
    end = len(text) - len(pieces[-1])
    if end < position:
        raise CertificateError(f"{file}: its frame is not what it must be")
    return [*found, text[position:end]] if len(pieces) > 1 else []


def _plain(place: str, text: str) -> str:
    """Statements without comments; refuses what could make a compiler read them differently."""
    code = strip_comments(text)
    for mark in ("//", "??", "\\", "/*", '"', "#"):
        if mark in code:
            raise CertificateError(f"{place}: {mark} is not part of emitted code")
    if not code.isascii():
        raise CertificateError(f"{place}: code outside comments is not ASCII")
    return re.sub(r"[ \t]+\n", "\n", code)


def _constants(file: str, text: str, emitted: EmittedCuda) -> dict[str, Fraction]:
    """Name → exact value of every line of the table, each proven correctly rounded."""
    values: dict[str, Fraction] = {}
    position = 0
    while match := _CONSTANT.match(text, position):
        c_type, name, literal = match.groups()
        position = match.end()
        if c_type != emitted.info.options.precision or name not in emitted.constants or name in values:
            raise CertificateError(f"{file}: constant {name} is not one of the table")
        literal_value(literal, c_type)
        try:
            check_literal(literal, emitted.constants[name], c_type)
        except CertificateError as error:
            raise CertificateError(f"{file}: {name}: {error}") from None
        values[name] = emitted.constants[name]
    if position != len(text):
        raise CertificateError(f"{file}: a table of constants has something else in it")
    return values
