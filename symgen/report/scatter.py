"""Dots over two logarithmic axes, the upper one broken where nothing is: time against error of many programs.

Shapes and colours come from classes of the style sheet. Every dot has a name that shows when it is pointed at.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.labels import Box, Spot, place
from symgen.report.plots import SERIES, power
from symgen.report.svg import figure, path, tag
from symgen.report.words import thousands

BREAK = 2.5
"""Decades without a dot at which the vertical axis is broken."""
LEAST = 1e-19
"""What is smaller is drawn there: exact results have no logarithm."""
ROOM_X, ROOM_Y = 0.09, 0.16
"""Decades around the outermost dots."""
SHORTEST = 0.9
"""Decades that a piece of the axis has at least."""
LEFT, RIGHT, TOP, BOTTOM, GAP = 66.0, 28.0, 28.0, 46.0, 20.0
TAIL = 24.0
"""How far dashed stairs go on behind their last corner; the others go to the end."""


@dataclass(frozen=True)
class Dot:
    """One program. ``note`` is what is told when it is pointed at; an empty ``label`` leaves it without one."""

    x: float
    y: float
    label: str
    note: str
    style: int = 0
    shape: str = "circle"
    hollow: bool = False
    strong: bool = False


@dataclass(frozen=True)
class Level:
    """A horizontal line at a value, with what it is."""

    y: float
    text: str


@dataclass(frozen=True)
class Stairs:
    """The least error within a time: corners (time, error) from the fastest on."""

    corners: tuple[tuple[float, float], ...]
    dashed: bool = False


@dataclass(frozen=True)
class Scale:
    """Logarithms to pixels; ``low`` and ``high`` are exponents of ten."""

    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        return self.start + (self.end - self.start) * (math.log10(max(value, LEAST)) - self.low) / (
            self.high - self.low
        )

    def holds(self, value: float) -> bool:
        return self.low <= math.log10(max(value, LEAST)) <= self.high

    def marks(self) -> list[tuple[float, int]]:
        """1, 2 and 5 times the powers of ten inside, with the first digit."""
        exponents = range(math.floor(self.low), math.ceil(self.high) + 1)
        return [(m * 10.0**k, m) for k in exponents for m in (1, 2, 5) if self.holds(m * 10.0**k)]


def scatter(
    dots: Sequence[Dot], title: str, x_label: str, y_label: str, levels: Sequence[Level] = (),
    stairs: Sequence[Stairs] = (), width: float = 960, height: float = 450,
) -> Markup:  # fmt: skip
    """The drawing; empty without dots."""
    if not dots:
        return Markup("")
    logs = [math.log10(dot.x) for dot in dots]
    x = Scale(min(logs) - ROOM_X, max(logs) + ROOM_X, LEFT, width - RIGHT)
    bands = bands_of(dots, levels, TOP, height - BOTTOM)
    parts = _grid(x, bands, x_label, y_label)
    for level in levels:
        parts += _level(level, x, bands)
    walked = [(stair, corners) for stair in stairs for corners in _walk(stair, x, bands)]
    for stair, corners in walked:
        parts.append(tag("path", class_="stairs dashed" if stair.dashed else "stairs", d=path(corners)))
    order = sorted(range(len(dots)), key=lambda k: not dots[k].strong)
    spots = [Spot(x.at(dots[k].x), _y(bands, dots[k].y), dots[k].label) for k in order]
    frame = Box(LEFT + 2, TOP - 8, width - 2, height - BOTTOM - 2)
    labels = place(spots, frame, _boxes([corners for _, corners in walked], levels, x, bands))
    for k, label in zip(order, labels, strict=True):
        if label is not None:
            weight = " strong" if dots[k].strong else ""
            parts += [tag("path", class_="leader", d=path(label.line))] if label.line else []
            parts.append(
                tag("text", label.text, class_=f"label{weight}", x=label.x, y=label.y, text_anchor=label.anchor)
            )
    parts += [dot_mark(dots[k], s.x, s.y) for k, s in reversed(list(zip(order, spots, strict=True)))]
    return figure(parts, width, height, title, class_="plot scatter")


def bands_of(dots: Sequence[Dot], levels: Sequence[Level], top: float, bottom: float) -> list[Scale]:
    """The vertical axis from below, in pieces where there are dots; a level near the dots of a piece is inside it."""
    values = sorted(math.log10(max(dot.y, LEAST)) for dot in dots)
    pieces = [[values[0]]]
    for value in values[1:]:
        if value - pieces[-1][-1] > BREAK:
            pieces.append([])
        pieces[-1].append(value)
    spans = []
    for piece in pieces:
        near = [y for y in (math.log10(level.y) for level in levels) if piece[0] - 1.5 <= y <= piece[-1] + 1.5]
        low, high = min(piece + near) - ROOM_Y, max(piece + near) + ROOM_Y
        more = max(0.0, SHORTEST - (high - low)) / 2
        spans.append((low - more, high + more))
    weights = [1.0 + 0.12 * len(piece) for piece in pieces]
    free = bottom - top - GAP * (len(pieces) - 1)
    bands, start = [], bottom
    for (low, high), weight in zip(spans, weights, strict=True):
        end = start - free * weight / sum(weights)
        bands.append(Scale(low, high, start, end))
        start = end - GAP
    return bands


def _y(bands: Sequence[Scale], value: float) -> float:
    return next((band for band in bands if band.holds(value)), bands[0]).at(value)


def _grid(x: Scale, bands: Sequence[Scale], x_label: str, y_label: str) -> list[Markup]:
    bottom, top = bands[0].start, bands[-1].end
    parts = []
    crowded = x.high - x.low > 2.6
    for value, digit in x.marks():
        place_ = x.at(value)
        parts += [tag("path", class_="grid", d=path([(place_, band.start), (place_, band.end)])) for band in bands]
        if digit == 1 or not crowded:
            text = thousands(value) if value >= 1 else f"{value:g}"
            parts.append(tag("text", text, x=place_, y=bottom + 16, text_anchor="middle"))
    for band in bands:
        few = band.high - band.low < 1.3
        for value, digit in band.marks():
            parts.append(tag("path", class_="grid", d=path([(x.start, band.at(value)), (x.end, band.at(value))])))
            if digit == 1 or few:
                exponent = math.floor(math.log10(value) + 1e-9)
                text = power(exponent) if digit == 1 else f"{digit}·{power(exponent)}"
                parts.append(tag("text", text, x=x.start - 6, y=band.at(value) + 4, text_anchor="end"))
        parts.append(tag("path", class_="axis", d=path([(x.start, band.end), (x.start, band.start)])))
    for below, above in itertools.pairwise(bands):
        for edge in (below.end, above.start):  # the axis is broken here
            parts.append(tag("path", class_="axis", d=path([(x.start - 5, edge + 3), (x.start + 5, edge - 3)])))
    parts.append(tag("path", class_="axis", d=path([(x.start, bottom), (x.end, bottom)])))
    parts.append(tag("text", x_label, class_="name", x=(x.start + x.end) / 2, y=bottom + 34, text_anchor="middle"))
    parts.append(tag("text", y_label, class_="name", x=4.0, y=top - 13, text_anchor="start"))
    return parts


def _level(level: Level, x: Scale, bands: Sequence[Scale]) -> list[Markup]:
    band = next((band for band in bands if band.holds(level.y)), None)
    if band is None:
        return []
    y = band.at(level.y)
    line = tag("path", class_="unit", d=path([(x.start, y), (x.end, y)]))
    return [line, tag("text", level.text, x=x.end - 4, y=y - 4, text_anchor="end", class_="unit-name")]


def _walk(stair: Stairs, x: Scale, bands: Sequence[Scale]) -> list[list[tuple[float, float]]]:
    """The stairs in pixels, band by band: down at each corner, then along to the next one."""
    found = []
    for at, band in enumerate(bands):
        points: list[tuple[float, float]] = []
        for (time, error), after in zip(stair.corners, (*stair.corners[1:], None), strict=True):
            if band.holds(error):
                if not points:  # from above, where less exact ones are; else the stairs begin here
                    points.append((x.at(time), band.end if at + 1 < len(bands) else band.at(error)))
                points.append((x.at(time), band.at(error)))
                beyond = min(x.at(time) + TAIL, x.end) if stair.dashed else x.end
                points.append((x.at(after[0]) if after else beyond, band.at(error)))
        if points:
            last = stair.corners[-1]
            if not band.holds(last[1]):
                points.append((points[-1][0], band.start))
            found.append(points)
    return found


def _boxes(
    walked: Sequence[Sequence[tuple[float, float]]], levels: Sequence[Level], x: Scale, bands: Sequence[Scale]
) -> list[Box]:
    """Lines as thin boxes, which labels had better not cross; what a level is called, which they may not."""
    found = []
    for corners in walked:
        for (a, b), (c, d) in itertools.pairwise(corners):
            found.append(Box(min(a, c) - 1, min(b, d) - 1, max(a, c) + 1, max(b, d) + 1))
    for level in levels:
        band = next((band for band in bands if band.holds(level.y)), None)
        if band is not None:
            y = band.at(level.y)
            found += [Box(x.end - 6.2 * len(level.text) - 8, y - 16, x.end, y)] * 30
    return found


def dot_mark(dot: Dot, x: float, y: float) -> Markup:
    """A dot with what is told when it is pointed at."""
    size = 5.4 if dot.strong else 4.2
    look = f"{'ring' if dot.hollow else 'mark'} s{dot.style % SERIES}"
    return shape_mark(dot.shape, look, x, y, size, dot.note)


def shape_mark(shape: str, look: str, x: float, y: float, size: float, note: str = "") -> Markup:
    told = (tag("title", note),) if note else ()
    r = size
    if shape == "circle":
        return tag("circle", *told, class_=look, cx=x, cy=y, r=r)
    if shape == "square":
        return tag("rect", *told, class_=look, x=x - 0.9 * r, y=y - 0.9 * r, width=1.8 * r, height=1.8 * r)
    corners = {
        "diamond": [(-1.25, 0), (0, -1.25), (1.25, 0), (0, 1.25)],
        "triangle": [(0, -1.2), (1.15, 0.9), (-1.15, 0.9)],
        "drop": [(0, 1.2), (1.15, -0.9), (-1.15, -0.9)],
        "cross": [
            (-0.35, -1.2), (0.35, -1.2), (0.35, -0.35), (1.2, -0.35), (1.2, 0.35), (0.35, 0.35), (0.35, 1.2),
            (-0.35, 1.2), (-0.35, 0.35), (-1.2, 0.35), (-1.2, -0.35), (-0.35, -0.35),
        ],
    }[shape]  # fmt: skip
    return tag("path", *told, class_=look, d=path([(x + r * a, y + r * b) for a, b in corners], close=True))
