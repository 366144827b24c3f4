"""What was measured for a page, under which settings, and what could not be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from symgen.report.tables import Table
from symgen.report.words import thousands


def values(data: Mapping[str, Any]) -> dict[str, object]:
    """``rows``: title, effort, settings, outcome (empty: it was measured), failed, file (its data, from the page),
    cpu_seconds."""
    rows = []
    for row in data["rows"]:
        settings = ", ".join(f"{name.replace('_', ' ')} {_value(value)}" for name, value in row["settings"].items())
        state = "failed" if row["failed"] else "not measured" if row["outcome"] else "measured"
        what = Markup('<a href="{}">{}</a>').format(row["file"], row["title"])
        took = f"{row['cpu_seconds']:.1f}"
        rows.append((what, row["effort"], settings or "as symgen sets them", took, _outcome(state, row["outcome"])))
    caption = "What was measured for this page; each line leads to its numbers (JSON)"
    header = ("measurement", "effort", "settings", "CPU time, s", "outcome")
    return {"table": Table(caption, header, tuple(rows), frozenset({3})) if rows else None}


def _value(value: object) -> str:
    return thousands(value) if isinstance(value, int) and not isinstance(value, bool) else str(value)


def _outcome(state: str, reason: str) -> str:
    return f"{state}: {reason}" if reason else state
