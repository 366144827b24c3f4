"""Error tables: text for people, CSV, JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import fields

from symgen.accuracy.measure import Row

HEADS = ("function", "variant", "plan", "max", "99.9 %", "median", "sought", "condition", "units", "wrong")


def as_text(rows: Sequence[Row]) -> str:
    """One table; the plan that is chosen has a star."""
    lines = [HEADS, *(_cells(row) for row in rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(HEADS))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


SUMMARY = (
    "scene", "function", "plan", "states", "double: max", "99.9 %", "sought", "units", "best plan: max", "float: max",
    "units",
)  # fmt: skip


def as_markdown(rows: Sequence[Row]) -> str:
    """One line per function: its chosen plan in double and in float, and the best plan's error beside it."""
    lines = [SUMMARY, ("---",) * len(SUMMARY)]
    for scene, function in dict.fromkeys((row.scene, row.function) for row in rows):
        own = [row for row in rows if (row.scene, row.function) == (scene, function)]
        chosen = next((row for row in own if row.variant == "double" and row.chosen), None)
        single = next((row for row in own if row.variant == "float" and row.chosen), None)
        if chosen is None:
            continue
        doubles = [row for row in own if row.variant == "double"]
        best = f"{min(row.largest for row in doubles):.1e}" if len({row.plan for row in doubles}) > 1 else ""
        sought = "" if chosen.sought is None else f"{chosen.sought:.1e}"
        found = (f"{chosen.largest:.1e}", f"{chosen.percentile:.1e}", sought, f"{chosen.backward:.1f}", best)
        floats = (f"{single.largest:.1e}", f"{single.backward:.1f}") if single else ("", "")
        lines.append((scene, function, chosen.plan, str(chosen.states), *found, *floats))
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _cells(row: Row) -> tuple[str, ...]:
    sought = "" if row.sought is None else f"{row.sought:.1e}"
    errors = (f"{row.largest:.1e}", f"{row.percentile:.1e}", f"{row.median:.1e}", sought)
    plan = row.plan + (" *" if row.chosen else "")
    return (row.function, row.variant, plan, *errors, f"{row.condition:.1e}", f"{row.backward:.1f}", str(row.wrong))


def as_csv(rows: Sequence[Row]) -> str:
    text = io.StringIO()
    names = [field.name for field in fields(Row)]
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(row.to_json() for row in rows)
    return text.getvalue()


def as_json(rows: Sequence[Row]) -> str:
    return json.dumps([row.to_json() for row in rows], indent=1, allow_nan=False) + "\n"
