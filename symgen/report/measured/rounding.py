"""Rounding error: every function, variant and plan beside the exact result, and what is proven."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from markupsafe import Markup

from symgen.program.rounding import UNITS
from symgen.report.measured.ranges import Range, ranges
from symgen.report.svg import path, tag
from symgen.report.tables import Table, scientific
from symgen.report.words import counted, listed, minus, thousands

LEVELS = ((1.0, "u"),)
X_LABEL = "error relative to the result, in u of its precision (double 1.1 × 10⁻¹⁶, float 6.0 × 10⁻⁸)"
STYLES = {"double": 0, "float": 3}
USUAL = "double"


def values(data: Mapping[str, Any]) -> dict[str, object]:
    """``data``: what `symgen.accuracy.rounding_data` gave."""
    rows = variants(data["rows"])
    return {
        "lead": lead(rows),
        "box": data["box"],
        "states": thousands(data["states"]),
        "search": data["search"],
        "drawing": drawing(rows),
        "legend": LEGEND,
        "rows": rows_table(rows),
        "plans": plans_table(data["rows"]),
        "bounds": bounds_table(data["bounds"]),
    }


LEGEND = (
    ("eight of ten states", tag("rect", class_="mark s0", x="2", y="1", width="22", height="10", rx="2",
                                fill_opacity="0.5")),
    ("median", tag("path", class_="axis", stroke_width="2", d=path([(13.0, 0.0), (13.0, 12.0)]))),
    ("99.9 %", tag("path", class_="curve s0", d=path([(13.0, 1.0), (13.0, 11.0)]))),
    ("largest sampled", tag("circle", class_="mark s0", cx="13", cy="6", r="4")),
    ("largest that a search found", tag("circle", class_="curve s0", cx="13", cy="6", r="5")),
)  # fmt: skip


def variants(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The first row of each variant of a function; those after it are of the comparison of plans."""
    first: dict[tuple[str, str], Mapping[str, Any]] = {}
    for row in rows:
        first.setdefault((row["function"], row["variant"]), row)
    return list(first.values())


def functions(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    return list(dict.fromkeys(row["function"] for row in rows))


def lead(rows: Sequence[Mapping[str, Any]]) -> str:
    doubles = [row for row in rows if row["variant"] == USUAL]
    worst = max(doubles, key=_largest)
    most = max(row["backward"] for row in doubles)
    text = f"Double precision: the largest error of all {counted(len(doubles), 'function')} is "
    text += f"{scientific(_largest(worst))}, of {worst['function']}; at most {number(most)} units."
    floats = [row for row in rows if row["variant"] == "float"]
    if floats:
        worst = max(floats, key=_largest)
        most = max(row["backward"] for row in floats)
        text += f" Float: {scientific(_largest(worst))}, of {worst['function']}; at most {number(most)} units."
    wrong = sum(row["wrong"] for row in rows)
    return text + (f" {counted(wrong, 'state')} had a wrong kind of answer." if wrong else "")


def _largest(row: Mapping[str, Any]) -> float:
    return float(max(row["largest"], row["sought"] or 0.0))


def number(x: float) -> str:
    return minus(f"{x:.1f}") if x < 100 else f"{x:.0f}"


def drawing(rows: Sequence[Mapping[str, Any]]) -> Markup:
    groups = [(function, [_range(row) for row in rows if row["function"] == function]) for function in functions(rows)]
    return ranges(groups, f"Rounding errors of {listed(functions(rows))}", X_LABEL, LEVELS)


def _range(row: Mapping[str, Any]) -> Range:
    told = f"{row['function']}, {row['variant']}: median {scientific(row['median'])}, 99.9 % "
    told += f"{scientific(row['percentile'])}, largest {scientific(row['largest'])}, {number(row['backward'])} units"
    precision = row["variant"].split()[0]
    u = UNITS[precision]
    return Range(
        row["variant"], (row["tenth"] / u, row["ninetieth"] / u), row["median"] / u, row["percentile"] / u,
        row["largest"] / u, row["sought"] / u if row["sought"] else None, STYLES[precision], told,
    )  # fmt: skip


Cells = Callable[[Mapping[str, Any]], tuple[str | Markup, ...]]


def _grouped(caption: str, header: tuple[str, ...], rows: Sequence[Mapping[str, Any]], cells: Cells) -> Table:
    groups, lines = list[tuple[str, int]](), list[tuple[str, ...]]()
    for function in functions(rows):
        groups.append((function, len(lines)))
        lines += [cells(row) for row in rows if row["function"] == function]
    return Table(caption, header, tuple(lines), frozenset(range(1, len(header))), tuple(groups))


def rows_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    wrong = any(row["wrong"] for row in rows)

    def cells(row: Mapping[str, Any]) -> tuple[str | Markup, ...]:
        sought = "–" if row["sought"] is None else scientific(row["sought"])
        errors = (scientific(row["largest"]), scientific(row["percentile"]), scientific(row["median"]), sought)
        found = (row["variant"], *errors, scientific(row["condition"]), number(row["backward"]))
        return (*found, str(row["wrong"])) if wrong else found

    header = ("variant", "max", "99.9 %", "median", "sought", "κ at the max", "units")
    return _grouped("Errors of every variant", (*header, "wrong") if wrong else header, rows, cells)


def plans_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Every plan in double, where there are several; as many digits as the best one's or fewer."""
    doubles = [row for row in rows if row["variant"] == USUAL]
    found: list[Mapping[str, Any]] = []
    best: dict[str, float] = {}
    for function in functions(doubles):
        own = {row["plan"]: row for row in doubles if row["function"] == function}
        if len(own) > 1:
            found += sorted(own.values(), key=lambda row: (not row["chosen"], row["operations"]))
            best[function] = max(min(row["largest"] for row in own.values()), UNITS["double"])

    def cells(row: Mapping[str, Any]) -> tuple[str | Markup, ...]:
        name = Markup("<strong>{}</strong> (chosen)").format(row["plan"]) if row["chosen"] else row["plan"]
        times = max(row["largest"], UNITS["double"]) / best[row["function"]]
        errors = (scientific(row["largest"]), scientific(row["percentile"]), scientific(row["median"]))
        return (name, str(row["operations"]), *errors, number(row["backward"]), f"{times:.1f}")

    header = ("plan", "operations", "max", "99.9 %", "median", "units", "× the best max")
    return _grouped("Every plan in double precision", header, found, cells)


def bounds_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    def cells(row: Mapping[str, Any]) -> tuple[str | Markup, ...]:
        measured = row["measured"]
        ratio = f"{row['proven'] / measured:.1f}" if measured else "–"
        shown = scientific(measured) if measured is not None else "–"
        return (
            row["precision"],
            scientific(row["proven"]),
            shown,
            ratio,
            scientific(row["largest"]),
            str(row["boxes"]),
        )

    header = ("precision", "proven", "measured", "proven ÷ measured", "no entry is larger than", "boxes")
    return _grouped("Bounds of |x − x̂| over all states of the box, of every entry", header, rows, cells)
