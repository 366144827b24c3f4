"""Errors as ranges over a logarithmic axis: a row each, from small to largest, with lines at the units of rounding."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.plots import Axis, power
from symgen.report.svg import figure, path, tag

LEFT, RIGHT, TOP, BOTTOM = 112.0, 24.0, 34.0, 44.0
ROW, HEAD = 22.0, 30.0


@dataclass(frozen=True)
class Range:
    """A row. ``most``: from the 10 to the 90 percentile; ``beyond``: the 99.9 percentile; ``sought``: the largest that
    a search found."""

    name: str
    most: tuple[float, float]
    median: float
    beyond: float
    largest: float
    sought: float | None
    style: int
    told: str


def ranges(
    groups: Sequence[tuple[str, Sequence[Range]]], title: str, x_label: str, levels: Sequence[tuple[float, str]],
    width: float = 860,
) -> Markup:  # fmt: skip
    """The drawing; empty without a row. Errors below the axis (exact ones too) stand at its start."""
    rows = [row for _, members in groups for row in members]
    ends = [x for row in rows for x in (row.median, row.largest, row.sought or 0.0) if x > 0]
    if not ends:
        return Markup("")
    low, high = math.floor(math.log10(min(*ends, levels[0][0])) - 0.2), math.log10(max(ends)) + 0.15
    x = Axis(low, high, LEFT, width - RIGHT, log=True)
    bottom = TOP + sum(HEAD + ROW * len(members) for _, members in groups) + 4
    parts = [
        part
        for exponent in range(low, math.floor(high) + 1)
        for part in (
            tag("path", class_="grid", d=path([(x.at(10.0**exponent), TOP), (x.at(10.0**exponent), bottom)])),
            tag(
                "text",
                power(exponent) if exponent else "1",
                x=x.at(10.0**exponent),
                y=bottom + 16,
                text_anchor="middle",
            ),
        )
        if (exponent - low) % (1 if high - low <= 14 else 2) == 0
    ]
    for level, text in levels:
        if low <= math.log10(level) <= high:
            parts.append(tag("path", class_="slope", d=path([(x.at(level), TOP - 8), (x.at(level), bottom)])))
            parts.append(tag("text", text, class_="name", x=x.at(level), y=TOP - 14, text_anchor="middle"))
    parts.append(tag("text", x_label, class_="name", x=(LEFT + width - RIGHT) / 2, y=bottom + 36, text_anchor="middle"))
    y = TOP
    for name, members in groups:
        parts.append(tag("text", name, class_="group", x="0", y=y + 20))
        y += HEAD
        for row in members:
            parts += _row(row, x, y + ROW / 2)
            y += ROW
    return figure(parts, width, bottom + BOTTOM, title, class_="plot")


def _row(row: Range, x: Axis, y: float) -> list[Markup]:
    def at(value: float) -> float:
        return x.at(value) if value > 10.0**x.low else x.start

    style = f"s{row.style}"
    start, end = at(row.most[0]), at(row.most[1])
    parts = [
        tag("text", row.name, x=LEFT - 10, y=y + 4, text_anchor="end"),
        tag("path", class_=f"curve {style}", stroke_opacity="0.45", d=path([(end, y), (at(row.largest), y)])),
        tag("path", class_=f"curve {style}", d=path([(at(row.beyond), y - 5), (at(row.beyond), y + 5)])),
        tag("rect", class_=f"mark {style}", x=start, y=y - 5, width=max(end - start, 2.0), height="10", rx="2",
            fill_opacity="0.5"),
        tag("path", class_="axis", stroke_width="2", d=path([(at(row.median), y - 6), (at(row.median), y + 6)])),
        tag("circle", class_=f"mark {style}", cx=at(row.largest), cy=y, r="4"),
    ]  # fmt: skip
    if row.sought:
        parts.append(tag("circle", class_=f"curve {style}", cx=at(row.sought), cy=y, r="5.5"))
    return [tag("g", tag("title", row.told), *parts)]
