"""Logarithmic plots of many lines: a colour a group, marks and dashes within it; what a point is says its title."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.plots import SERIES, Axis, axes, log_axis, mark
from symgen.report.svg import figure, path, tag

DASHES = (None, "7 4", "2 3", "9 3 2 3", "4 2")
NAMES = (36.0, 40.0, 12.0)


@dataclass(frozen=True)
class Line:
    """``points``: (x, y, title), from one end to the other. ``style``: colour; ``kind``: mark and dashes; without
    ``marks`` it is a curve."""

    name: str
    points: tuple[tuple[float, float, str], ...]
    style: int
    kind: int = 0
    marks: bool = True


@dataclass(frozen=True)
class Frame:
    """``backwards``: large x on the left, better on the right. ``zone``: x up to which the ground is grey."""

    title: str
    x_label: str
    y_label: str
    backwards: bool = False
    zone: float = 0.0
    width: float = 1000
    height: float = 500


def key(line: Line) -> Markup:
    """What stands before a line's name in a legend."""
    name = f"s{line.style % SERIES}"
    curve = tag("path", class_=f"curve {name}", d="M0 6H30", stroke_dasharray=DASHES[line.kind % len(DASHES)])
    sign = [mark(line.kind, 15.0, 6.0, name)] if line.marks else []
    return tag("svg", curve, *sign, class_="plot", width="30", height="12", viewBox="0 0 30 12", aria_hidden="true")


def loglog(lines: Sequence[Line], frame: Frame) -> Markup:
    """The plot; nothing where no line has a point."""
    clean = [[p for p in line.points if p[0] > 0 and p[1] > 0 and math.isfinite(p[1])] for line in lines]
    xs, ys = [p[0] for points in clean for p in points], [p[1] for points in clean for p in points]
    if not xs:
        return Markup("")
    left, right = 66.0, frame.width - 22.0
    ends = (right, left) if frame.backwards else (left, right)
    x = log_axis([*xs, frame.zone] if frame.zone else xs, *ends)
    y = log_axis(ys, frame.height - 48.0, 30.0)
    parts = _ground(frame, x, y)
    for line, points in zip(lines, clean, strict=True):
        name = f"s{line.style % SERIES}"
        places = [(x.at(a), y.at(b)) for a, b, _ in points]
        dash = DASHES[line.kind % len(DASHES)]
        if len(places) > 1:
            parts.append(tag("path", class_=f"curve {name}", d=path(places), stroke_dasharray=dash))
        if line.marks:
            parts += [mark(line.kind, a, b, name, p[2]) for (a, b), p in zip(places, points, strict=True)]
    return figure(parts, frame.width, frame.height, frame.title, class_="plot")


def _ground(frame: Frame, x: Axis, y: Axis) -> list[Markup]:
    """Grey zone, grid, tick labels and names of the axes."""
    bottom, top = y.start, y.end
    parts = []
    if frame.zone:
        edges = sorted((x.at(frame.zone), x.at(10.0**x.low)))
        parts.append(
            tag(
                "rect",
                x=edges[0],
                y=top,
                width=edges[1] - edges[0],
                height=bottom - top,
                fill="currentColor",
                fill_opacity="0.09",
            )
        )
    return parts + axes(x, y, frame.x_label, frame.y_label, NAMES)
