"""Excerpts of the generated C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HEADER_LINES = 120
FUNCTION_LINES = 160
PREFERRED = ("mass_matrix", "forward_dynamics", "inverse_dynamics")


@dataclass(frozen=True)
class Excerpt:
    title: str
    text: str


def excerpts(directory: Path, manifest: Mapping[str, Any]) -> Sequence[Excerpt]:
    """The beginning of the header and one function."""
    found = []
    for name in manifest["headers"][:1]:
        found.append(Excerpt(f"{name}, the header", _cut((directory / name).read_text(encoding="utf-8"), HEADER_LINES)))
    rows = {row["name"]: row for row in manifest["functions"] if row["symbol"]}
    chosen = next((rows[name] for name in PREFERRED if name in rows), next(iter(rows.values()), None))
    if chosen is not None:
        for name in manifest["sources"]:
            text = function_text((directory / name).read_text(encoding="utf-8"), chosen["symbol"])
            if text:
                found.append(Excerpt(f"{chosen['symbol']} in {name}", _cut(text, FUNCTION_LINES)))
                break
    return found


def function_text(source: str, symbol: str) -> str:
    """A function's definition with the comment above it; empty when it is not in this file."""
    lines = source.splitlines()
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
            return "\n".join(lines[first : end + 1])
    return ""


def _cut(text: str, most: int) -> str:
    lines = text.rstrip().splitlines()
    if len(lines) <= most:
        return "\n".join(lines)
    return "\n".join([*lines[:most], f"… ({len(lines) - most} more lines)"])
