"""The page of the hard cases: what is hard, what is right, what was found."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from symgen.report.measured.loglog import Frame, Line, key, loglog
from symgen.report.shell import ALONE, Place, page
from symgen.report.tables import Table, bound, scientific
from symgen.report.words import counted, minus, slug, ten_to, thousands

Finding = Mapping[str, Any]


@dataclass(frozen=True)
class Plot:
    """A figure of a case: which curves, and how they are drawn."""

    case: str
    curves: str
    frame: Frame
    told: str
    bar: float = 0.0
    """What is allowed, where one number says it."""


PLOTS = (
    Plot(
        "long chains", "chains",
        Frame("Error of forward dynamics over the number of links", "links", "largest error, relative", height=360),
        "Forward dynamics near the straight line: factoring the mass matrix loses what its condition says, articulated "
        "bodies do not. The plan is chosen by that.",
    ),
    Plot(
        "far from the origin", "places",
        Frame("Error of the mass matrix over the distance from the origin", "distance of the chain from the origin, m",
              "largest error, relative", height=360),
        "The mass matrix of a chain of three links somewhere else: the generated code works in body axes and knows "
        "nothing of the place. The definition itself, in ground axes, loses a digit with every zero.",
    ),
    Plot(
        "huge angles", "angles",
        Frame("Error of a sine over the size of its angle", "angle, rad", "largest error, u", height=300),
        "The weight's moment on a pendulum, in roundings u of the precision: the sine has the same error for angles of "
        "every size, small or huge, in the built-in form, in the C library's, and in float.",
        bar=4.0,
    ),
)  # fmt: skip


def hard_page(data: Mapping[str, Any], place: Place = ALONE) -> str:
    """The page. ``data``: what `symgen.validation.hard_cases.hard_data` gave."""
    cases = [_case(case, data.get("figures", {})) for case in data["cases"]]
    sections = [("glance", "At a glance"), *((case["id"], case["name"]) for case in cases)]
    values = {"lead": lead(data["cases"]), "glance": glance(data["cases"]), "cases": cases}
    return page("report/hard.html.j2", "Hard cases", sections, place, it=values)


def lead(cases: Sequence[Mapping[str, Any]]) -> str:
    findings = [row for case in cases for row in case["findings"]]
    demanded = [row for row in findings if row["allowed"] is not None]
    failed = [row for row in demanded if not row["passed"]]
    text = (
        f"{counted(len(cases), 'case').capitalize()} where code goes wrong first, each with the answer that is right: "
    )
    text += (
        f"{len(demanded)} findings are held to it, and {len(findings) - len(demanded)} more are there for comparison. "
    )
    return text + ("None failed." if not failed else f"{len(failed)} failed.")


_POWER = re.compile(r"\b(\d+(?:\.\d+)?)e([+-]?\d+)\b")


def powers(text: str) -> str:
    """1e6 as it is written: 10⁶."""
    return _POWER.sub(lambda found: ten_to(found[1], int(found[2])), text)


def _case(case: Mapping[str, Any], curves: Mapping[str, Any]) -> dict[str, Any]:
    demanded = [row for row in case["findings"] if row["allowed"] is not None]
    others = [row for row in case["findings"] if row["allowed"] is None]
    return {
        "id": slug(case["name"]),
        "name": case["name"][0].upper() + case["name"][1:],
        "hard": powers(case["hard"]),
        "right": powers(case["right"][0].upper() + case["right"][1:].rstrip(".")),
        "verdict": verdict(all(row["passed"] for row in demanded)),
        "figures": [
            _drawn(plot, curves[plot.curves]) for plot in PLOTS if plot.case == case["name"] and plot.curves in curves
        ],
        "table": findings_table(f"What was found: {case['name']}", demanded),
        "others": findings_table("Not held to anything", others) if others else None,
        "others_title": f"For comparison: {counted(len(others), 'finding')} of other plans and forms",
    }


def _drawn(plot: Plot, curves: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    styles = (3, 0) if plot.curves == "chains" else (0, 3, 2)
    lines = [
        Line(
            curve["name"], tuple((x, y, f"{curve['name']}: {scientific(y)} at {x:g}") for x, y in curve["points"]),
            styles[k % len(styles)], k,
        )
        for k, curve in enumerate(curves)
    ]  # fmt: skip
    if plot.bar:
        ends = [x for line in lines for x, _, _ in line.points]
        told = f"allowed: {plot.bar:g}"
        bar = ((min(ends), plot.bar, told), (max(ends), plot.bar, told))
        lines.append(Line("allowed", bar, 1, 4, marks=False))
    return {
        "drawing": loglog(lines, plot.frame),
        "legend": [(line.name, key(line)) for line in lines],
        "told": plot.told,
        "title": plot.frame.title,
    }


def verdict(passed: bool) -> Markup:
    """Words and a mark, not colour alone."""
    if passed:
        return Markup('<span class="pass">✓ right</span>')
    return Markup('<span class="fail">✗ wrong</span>')


def glance(cases: Sequence[Mapping[str, Any]]) -> Table:
    rows = []
    for case in cases:
        demanded = [row for row in case["findings"] if row["allowed"] is not None]
        name = Markup('<a href="#{}">{}</a>').format(slug(case["name"]), case["name"])
        parts = [row["figure"] / row["allowed"] for row in demanded if row["allowed"] and row["figure"] is not None]
        used = "–" if not parts else f"{100 * max(parts):.0f} %" if max(parts) >= 0.01 else "below 1 %"
        passed = all(row["passed"] for row in demanded)
        rows.append((name, verdict(passed), str(len(demanded)), used))
    header = ("case", "verdict", "findings", "of what is allowed, at most")
    return Table("All cases", header, tuple(rows), frozenset({2, 3}))


Column = tuple[str, Callable[[Finding], "str | Markup"], bool]
"""Heading, what stands there, whether it is a number."""


def findings_table(caption: str, rows: Sequence[Finding]) -> Table:
    """Rows with one subject stand together under it; columns that would be empty are left out."""
    columns: list[Column] = [
        ("program", lambda row: row["variant"] or "–", False),
        ("found", found, True),
        ("allowed", allowed, True),
        ("error", lambda row: "" if row["error"] is None else scientific(row["error"]), True),
        ("κ", lambda row: "" if row["condition"] is None else scientific(row["condition"]), True),
        ("verdict", lambda row: "" if row["allowed"] is None else verdict(row["passed"]), False),
        ("", lambda row: "" if _short(row) else powers(row["note"]), False),
    ]
    kept = [column for column in columns if any(column[1](row) for row in rows)]
    groups, lines, before = list[tuple[str, int]](), list[tuple[str, ...]](), ""
    for row in rows:
        if row["what"] != before:
            before = row["what"]
            groups.append((powers(before), len(lines)))
        lines.append(tuple(cell(row) for _, cell, _ in kept))
    numeric = frozenset(k for k, (_, _, number) in enumerate(kept) if number)
    return Table(caption, tuple(name for name, _, _ in kept), tuple(lines), numeric, tuple(groups))


SHORT = 24


def _short(row: Finding) -> bool:
    """What was found is a word or two, not a number."""
    return row["allowed"] == 0 and len(row["note"]) <= SHORT


def found(row: Finding) -> str:
    if row["allowed"] == 0 and row["figure"] in (0, 1):
        return powers(row["note"]) if _short(row) else ""
    if row["figure"] is None:
        return "∞"
    if row["unit"] in ("units", "u"):
        return f"{number(row['figure'])} {row['unit']}"
    return f"{scientific(row['figure'])} {row['unit']}".rstrip()


def allowed(row: Finding) -> str:
    if not row["allowed"]:
        return ""
    bar = row["allowed"]
    return f"≤ {bar:g}" if 1e-3 <= bar < 1e5 else f"≤ {bound(bar)}"


def number(x: float) -> str:
    if 0 < x < 0.05:
        return "below 0.1"
    return minus(f"{x:.1f}") if 0 < x < 100 else thousands(x) if x < 1e5 else scientific(x)
