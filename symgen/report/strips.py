"""Ratios of many programs to one: a row of dots for each, over a logarithmic axis with a line at one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.scatter import Scale, shape_mark
from symgen.report.svg import figure, path, tag

ROW, LEFT, RIGHT, TOP, BOTTOM = 46.0, 150.0, 24.0, 10.0, 42.0
SIZE = 4.0
OFFSETS = (0.0, 8.0, -8.0, 16.0, -16.0)
"""Dots that would hide one another stand above or below."""


@dataclass(frozen=True)
class Strip:
    """A row. ``dots``: (ratio, what is told when it is pointed at)."""

    name: str
    dots: tuple[tuple[float, str], ...]
    style: int
    shape: str


def strips(rows: Sequence[Strip], title: str, x_label: str, width: float = 960) -> Markup:
    """The drawing; empty without dots."""
    values = [ratio for row in rows for ratio, _ in row.dots]
    if not values:
        return Markup("")
    low, high = math.log10(min([*values, 0.9])) - 0.05, math.log10(max([*values, 2.0])) + 0.05
    x = Scale(low, high, LEFT, width - RIGHT)
    bottom = TOP + ROW * len(rows)
    parts = []
    crowded = high - low > 2.2
    for value, digit in x.marks():
        parts.append(tag("path", class_="grid", d=path([(x.at(value), TOP), (x.at(value), bottom)])))
        if digit == 1 or not crowded:
            parts.append(tag("text", f"{value:g}", x=x.at(value), y=bottom + 16, text_anchor="middle"))
    parts.append(tag("path", class_="one", d=path([(x.at(1), TOP), (x.at(1), bottom)])))
    parts.append(tag("text", x_label, class_="name", x=(LEFT + width - RIGHT) / 2, y=bottom + 34, text_anchor="middle"))
    for number, row in enumerate(rows):
        y = TOP + ROW * (number + 0.5)
        parts.append(tag("path", class_="grid", d=path([(LEFT, y), (width - RIGHT, y)])))
        parts.append(tag("text", row.name, class_="name", x=LEFT - 12, y=y + 4, text_anchor="end"))
        parts += _dots(row, x, y)
    return figure(parts, width, bottom + BOTTOM, title, class_="plot scatter")


def _dots(row: Strip, x: Scale, y: float) -> list[Markup]:
    taken: list[tuple[float, float]] = []
    parts = []
    for ratio, note in sorted(row.dots):
        place = x.at(ratio)
        free = (d for d in OFFSETS if all(abs(place - a) > 2 * SIZE or abs(d - b) > 2 * SIZE - 1 for a, b in taken))
        offset = next(free, 0.0)
        taken.append((place, offset))
        parts.append(shape_mark(row.shape, f"mark s{row.style}", place, y - offset, SIZE, note))
    return parts
