"""The page of benchmark problems: what each is, the right answer and where it stands, how near every method came."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from symgen.report.plots import Axis, power
from symgen.report.shell import ALONE, Place, page
from symgen.report.svg import figure, path, tag
from symgen.report.tables import Table, scientific
from symgen.report.words import slug, thousands

Row = Mapping[str, Any]
SMALLEST = 1e-16
"""Errors below are drawn here."""
LEFT, RIGHT, STEP = 350.0, 1040.0, 19.0
LETTER = 6.6
"""Pixels that a letter takes at most, on average."""


def benchmarks_page(rows: Sequence[Row], place: Place = ALONE) -> str:
    """The page as text. ``rows``: as `symgen.validation.benchmarks.benchmark_data` gives them."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row["problem"], []).append(row)
    problems = [
        {
            "id": identifier(name),
            "name": name,
            "statement": mine[0]["statement"],
            "table": _table(name, mine),
            "notes": _notes(mine),
        }
        for name, mine in groups.items()
    ]
    failed = [row for row in rows if not row["passed"]]
    return page(
        "report/benchmarks.html.j2",
        "Benchmark problems",
        [("overview", "Overview"), *((str(problem["id"]), str(problem["name"])) for problem in problems)],
        place,
        problems=problems,
        overview=overview(groups),
        facts=[("problems", str(len(groups))), ("answers", str(len(rows))), ("CPU time", _total(rows))],
        verdict=f"✗ {len(failed)} of {len(rows)} answers failed" if failed else "✓ all within their bars",
        passed=not failed,
    )


def _notes(rows: Sequence[Row]) -> list[str]:
    """What lines say besides, unless the statement says it."""
    said = rows[0]["statement"]["published"]
    return list(dict.fromkeys(row["published"] for row in rows if row["published"] and not said))


def identifier(name: str) -> str:
    """A problem's name as an address within the page."""
    return "p-" + slug(name)


def milliseconds(seconds: float) -> str:
    """Three digits, without a power of ten."""
    return f"{1e3 * seconds:.3g}" if seconds < 1.0 else thousands(1e3 * seconds)


def _total(rows: Sequence[Row]) -> str:
    return f"{sum(row['cpu_seconds'] for row in rows):.1f} s"


def _table(name: str, rows: Sequence[Row]) -> Table:
    cells = []
    for row in rows:
        style, sign = ("pass", "✓") if row["passed"] else ("fail", "✗")
        drift = "–" if row["drift"] is None else scientific(row["drift"])
        error = "not a number" if row["error"] is None else scientific(row["error"])
        verdict = Markup('<span class="{}">{}</span>').format(style, sign)
        cells.append(
            (row["quantity"], row["method"], error, scientific(row["bar"]), verdict, row["against"], drift,
             milliseconds(row["cpu_seconds"]))
        )  # fmt: skip
    header = ("quantity", "method", "error", "allowed", "", "against", "energy drift", "CPU time, ms")
    return Table(f"{name}: error reached and allowed", header, tuple(cells), frozenset({2, 3, 6, 7}))


def overview(groups: Mapping[str, Sequence[Row]]) -> Markup:
    """A line for every answer: the error reached as a dot, what is allowed as a bar, on one logarithmic axis."""
    labels = [f"{row['quantity']}, {row['method']}" for rows in groups.values() for row in rows]
    left = max(LEFT, LETTER * max(map(len, labels), default=0) + 16)
    right = left + RIGHT - LEFT
    axis = Axis(-16.0, 0.0, left, right, log=True)
    parts: list[Markup] = []
    y = 34.0
    for name, rows in groups.items():
        parts.append(tag("text", name, class_="group", x="0", y=y + 4))
        y += STEP
        for row in rows:
            parts.append(tag("text", f"{row['quantity']}, {row['method']}", x=left - 12, y=y + 4, text_anchor="end"))
            parts += _answer(row, axis, y)
            y += STEP
        y += 8
    grid = [
        tag("path", class_="grid", d=path([(axis.at(10.0**k), 20.0), (axis.at(10.0**k), y)])) for k in range(-16, 1, 2)
    ]
    names = [tag("text", power(k), x=axis.at(10.0**k), y=12.0, text_anchor="middle") for k in range(-16, 1, 2)]
    title = "Error reached (dot) and allowed (bar) of every answer, logarithmic"
    return figure([*grid, *names, *parts], right + 24.0, y + 6, title, class_="plot")


def _answer(row: Row, axis: Axis, y: float) -> list[Markup]:
    allowed = axis.at(min(max(row["bar"], SMALLEST), 1.0))
    bar = tag("path", class_="curve s1", d=path([(allowed, y - 7), (allowed, y + 7)]))
    if row["error"] is None or not math.isfinite(row["error"]):
        return [bar]
    error = axis.at(min(max(row["error"], SMALLEST), 1.0))
    style = "s0" if row["passed"] else "s3"
    line = tag("path", class_="slope", d=path([(error, y), (allowed, y)]))
    reached = f"{scientific(row['error'])} of {scientific(row['bar'])}"
    title = tag("title", f"{row['problem']}, {row['quantity']}, {row['method']}: {reached}")
    return [line, bar, tag("circle", title, class_=f"mark {style}", cx=error, cy=y, r="4.5")]
