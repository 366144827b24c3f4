"""Batch files read back: statements over vectors as scalar ones, and around them nothing but the frame."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from symgen.errors import CertificateError
from symgen.program.instructions import Program
from symgen.targets.c.batch import BatchFile, BatchFunction
from symgen.targets.c.literals import Constant
from symgen.targets.c.vector import VectorBody, scalar_text

_MARK = "@"


@dataclass(frozen=True)
class ReadBatch:
    """What is special in one batch file; all the rest is as the templates say."""

    constants: str
    """Text of the table of constants."""
    bodies: tuple[tuple[Program, str, str], ...]
    """(program, its symbol, its statements as the body of a scalar function)."""


def read_batch(batch: BatchFile, code: str, strip: Callable[[str], str]) -> ReadBatch:
    """Split the ``code`` of a batch file, comments stripped by ``strip``, into what is special and the frame.

    Raises CertificateError where the frame (loads and stores, tails, dispatch, built-in functions) differs in any
    character from what it must be, or a body has anything but statements over vectors.
    """
    options = batch.options
    frame = strip(_frame(batch))
    found = _between(batch.file, code, frame.split(_MARK))
    bodies = [row for row in batch.functions if row.vector]
    constants = found.pop() if len(found) > len(bodies) else ""
    read = []
    for row, text in zip(bodies, found, strict=True):
        status = options.status and bool(row.program.guards)
        place = f"{batch.file}: {row.symbols.scalar}"
        body = scalar_text(place, text, row.program, options.precision, options.trigonometry, status)
        read.append((row.program, place, body))
    return ReadBatch(constants, tuple(read))


def _frame(batch: BatchFile) -> str:
    """The file with a mark in place of every body and of the rows of the constant table."""

    def hollow(row: BatchFunction) -> BatchFunction:
        if row.vector is None:
            return row
        return replace(row, vector=VectorBody((("code", _MARK),), (), (), row.vector.called, row.vector.words))

    table = [Constant(_MARK, Fraction(0), _MARK)] if batch.constants else []
    text = replace(batch, functions=tuple(map(hollow, batch.functions))).render(table)
    return re.sub(rf"    {_MARK}\n|static const \w+ {_MARK} = {_MARK};.*\n", _MARK, text)


def _between(file: str, code: str, pieces: list[str]) -> list[str]:
    """What stands between the pieces of the frame, which all must be there, in their order."""
    if not code.startswith(pieces[0]):
        raise CertificateError(f"{file}: does not begin as a batch file")
    found: list[str] = []
    position = len(pieces[0])
    for number, piece in enumerate(pieces[1:], 1):
        last = number == len(pieces) - 1
        end = len(code) - len(piece) if last else code.find(piece, position)
        if end < position or not code.startswith(piece, end):
            line = code.count("\n", 0, position) + 1
            raise CertificateError(f"{file}: after line {line} it is not what a batch file must be")
        found.append(code[position:end])
        position = end + len(piece)
    return found
