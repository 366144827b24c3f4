"""Generated C taken apart: functions with their comments and phases, and what stands between them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_COMMENT_LINE = re.compile(r"    +/\* ([^*]+) \*/")


_OWN = re.compile(r"[A-Z_]+")
"""A macro in a line of its own, which ends what one before the function began."""


@dataclass(frozen=True)
class Heading:
    """A phase comment. ``line``: its place in the function's lines."""

    line: int
    text: str


@dataclass(frozen=True)
class Source:
    """A piece of a file. ``first``: number of its first line in the file."""

    file: str
    first: int
    lines: tuple[str, ...]

    @property
    def text(self) -> str:
        return "\n".join(self.lines)

    def headings(self) -> list[Heading]:
        found = []
        for k, line in enumerate(self.lines):
            match = _COMMENT_LINE.fullmatch(line)
            if match:
                found.append(Heading(k, match[1].strip()))
        return found

    def cut(self, most: int) -> tuple[Source, int]:
        """At most so many lines, and how many were left out."""
        left = max(0, len(self.lines) - most)
        return Source(self.file, self.first, self.lines[:most]), left


def definition(source: Source, symbol: str) -> Source | None:
    """A function's definition with the comment above it; None when it is not in this file."""
    lines = source.lines
    for start, line in enumerate(lines):
        if f" {symbol}(" in f" {line}" and not line.startswith((" ", "\t", "/", "*", "#")):
            end = next((k for k in range(start, len(lines)) if lines[k].startswith("}")), None)
            declared = next((k for k in range(start, len(lines)) if lines[k].rstrip().endswith(";")), len(lines))
            opened = next((k for k in range(start, len(lines)) if "{" in lines[k]), len(lines))
            if end is None or declared < opened:
                continue
            first = start
            while first > 0 and lines[first - 1].strip() and not lines[first - 1].startswith(("}", "#")):
                first -= 1
            after = end + 2 if end + 1 < len(lines) and _OWN.fullmatch(lines[end + 1]) else end + 1
            return Source(source.file, source.first + first, lines[first:after])
    return None


def read(directory: Path, names: Sequence[str]) -> list[Source]:
    """Whole files."""
    texts = [(name, (directory / name).read_text(encoding="utf-8")) for name in names]
    return [Source(name, 1, tuple(text.rstrip("\n").split("\n"))) for name, text in texts]


@dataclass(frozen=True)
class Code:
    """The C of an artifact. ``functions``: by the name in the manifest; ``rest``: files without them, in pieces."""

    headers: tuple[Source, ...]
    functions: Mapping[str, Source]
    rest: tuple[Source, ...]


def code(directory: Path, manifest: Mapping[str, Any]) -> Code:
    headers, sources = read(directory, manifest["headers"]), read(directory, manifest["sources"])
    functions: dict[str, Source] = {}
    taken: dict[str, list[tuple[int, int]]] = {source.file: [] for source in sources}
    for row in manifest["functions"]:
        for source in sources:
            found = definition(source, row["symbol"]) if row["symbol"] else None
            if found is not None:
                functions[row["name"]] = found
                taken[source.file].append((found.first, found.first + len(found.lines)))
                break
    rest = [piece for source in sources for piece in _between(source, taken[source.file])]
    return Code(tuple(headers), functions, tuple(rest))


def _between(source: Source, taken: Sequence[tuple[int, int]]) -> list[Source]:
    """What is left of a file, without blank ends."""
    found, at = [], 1
    for first, after in [*sorted(taken), (len(source.lines) + 1, 0)]:
        lines = list(source.lines[at - 1 : first - 1])
        while lines and not lines[0].strip():
            lines.pop(0)
            at += 1
        while lines and not lines[-1].strip():
            lines.pop()
        if lines:
            found.append(Source(source.file, at, tuple(lines)))
        at = after
    return found
