"""Logarithmic plots of many lines: a colour a group, marks and dashes within it; what a point is says its title."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.plots import SERIES, Axis, log_axis
from symgen.report.svg import figure, path, tag

DASHES = (None, "7 4", "2 3", "9 3 2 3", "4 2")
KINDS = 6
"""Marks that differ in shape."""


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


def shape(kind: int, x: float, y: float, style: str, title: str = "") -> Markup:
    """Circle, square, diamond, triangle, triangle upside down, bar."""
    inside = (tag("title", title),) if title else ()
    k = kind % KINDS
    if k == 0:
        return tag("circle", *inside, class_=f"mark {style}", cx=x, cy=y, r="4")
    if k == 1:
        return tag("rect", *inside, class_=f"mark {style}", x=x - 3.6, y=y - 3.6, width="7.2", height="7.2")
    outlines: dict[int, list[tuple[float, float]]] = {
        2: [(-5, 0), (0, -5), (5, 0), (0, 5)],
        3: [(-4.6, 3.6), (0, -4.8), (4.6, 3.6)],
        4: [(-4.6, -3.6), (4.6, -3.6), (0, 4.8)],
        5: [(-5, -2), (5, -2), (5, 2), (-5, 2)],
    }
    corners = [(x + a, y + b) for a, b in outlines[k]]
    return tag("path", *inside, class_=f"mark {style}", d=path(corners, close=True))


def key(line: Line) -> Markup:
    """What stands before a line's name in a legend."""
    name = f"s{line.style % SERIES}"
    curve = tag("path", class_=f"curve {name}", d="M0 6H30", stroke_dasharray=DASHES[line.kind % len(DASHES)])
    mark = [shape(line.kind, 15.0, 6.0, name)] if line.marks else []
    return tag("svg", curve, *mark, class_="plot", width="30", height="12", viewBox="0 0 30 12", aria_hidden="true")


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
            parts += [shape(line.kind, a, b, name, p[2]) for (a, b), p in zip(places, points, strict=True)]
    return figure(parts, frame.width, frame.height, frame.title, class_="plot")


def _ground(frame: Frame, x: Axis, y: Axis) -> list[Markup]:
    """Grey zone, grid, tick labels and names of the axes."""
    left, right = sorted((x.start, x.end))
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
    parts += [tag("path", class_="grid", d=path([(p, bottom), (p, top)])) for p, _ in x.ticks()]
    parts += [tag("path", class_="grid", d=path([(left, p), (right, p)])) for p, _ in y.ticks()]
    parts.append(tag("path", class_="axis", d=path([(left, top), (left, bottom), (right, bottom)])))
    parts += [tag("text", text, x=p, y=bottom + 16, text_anchor="middle") for p, text in x.ticks()]
    parts += [tag("text", text, x=left - 6, y=p + 4, text_anchor="end") for p, text in y.ticks()]
    parts.append(tag("text", frame.x_label, class_="name", x=(left + right) / 2, y=bottom + 36, text_anchor="middle"))
    parts.append(tag("text", frame.y_label, class_="name", x=left - 40, y=top - 12, text_anchor="start"))
    return parts
