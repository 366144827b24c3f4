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


def as_markdown(rows: Sequence[Row]) -> str:
    heads = ("scene", *HEADS)
    body = [heads, ("---",) * len(heads), *((row.scene, *_cells(row)) for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in body) + "\n"


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
