"""Small plots as inline SVG: lines over time, errors over step sizes on logarithmic axes, bars.

Colours come from classes (``s0`` … ``s6``) of the style sheet, so that a plot follows light and dark.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from markupsafe import Markup

from symgen.report.svg import figure, num, path, tag
from symgen.report.words import minus, superscript, thousands

SERIES = 7
"""Colours of the style sheet."""
FLAT = 1e-9
"""A range below this part of the values is drawn as a flat line."""


@dataclass(frozen=True)
class Series:
    name: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    marks: bool = False
    style: int = 0


@dataclass(frozen=True)
class Axis:
    """Values to pixels. ``low`` and ``high`` are exponents of ten where ``log`` is set."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def at(self, value: float) -> float:
        x = math.log10(value) if self.log else value
        return self.start + (self.end - self.start) * (x - self.low) / (self.high - self.low)

    def ticks(self) -> list[tuple[float, str]]:
        """(pixel, text)."""
        if self.log and self.high - self.low < 2:
            marks = [m * 10.0**k for k in range(math.floor(self.low), math.ceil(self.high) + 1) for m in (1, 2, 5)]
            inside = [x for x in marks if self.low <= math.log10(x) <= self.high]
            return [(self.at(x), num(x, max(0, 1 - math.floor(math.log10(x))))) for x in inside]
        if self.log:
            step = max(1, math.ceil((self.high - self.low) / 7))
            exponents = range(math.ceil(self.low - 1e-9), math.floor(self.high + 1e-9) + 1, step)
            return [(self.at(10.0**k), power(k)) for k in exponents]
        step_size = nice_step((self.high - self.low) / 4)
        first, last = math.ceil(self.low / step_size - 1e-9), math.floor(self.high / step_size + 1e-9)
        digits = max(0, -math.floor(math.log10(step_size) + 1e-9))
        return [(self.at(k * step_size), minus(num(k * step_size, digits))) for k in range(first, last + 1)]


def power(exponent: int) -> str:
    return "10" + superscript(exponent)


def nice_step(rough: float) -> float:
    """1, 2 or 5 times a power of ten, at least ``rough``."""
    base = 10.0 ** math.floor(math.log10(rough))
    return next(base * m for m in (1, 2, 5, 10) if base * m >= rough * (1 - 1e-9))


def linear_axis(values: Sequence[float], start: float, end: float) -> Axis:
    low, high = min(values), max(values)
    if high - low <= FLAT * max(abs(low), abs(high), 1e-3):
        middle = (low + high) / 2
        reach = max(abs(middle) * 0.5, 0.5)
        low, high = middle - reach, middle + reach
    room = 0.06 * (high - low)
    return Axis(low - room, high + room, start, end)


def log_axis(values: Sequence[float], start: float, end: float) -> Axis:
    """The decades that hold the values; within two decades no more than a little room."""
    low, high = math.log10(min(values)), math.log10(max(values))
    if high - low < 1.6:
        return Axis(low - 0.15, high + 0.15, start, end, log=True)
    return Axis(math.floor(low - 0.05), math.ceil(high + 0.05), start, end, log=True)


NAMES = (33.0, 4.0, 9.0)
"""How far the names of the axes stand off: below the horizontal axis, left of and above the vertical one."""


def axes(x: Axis, y: Axis, x_label: str, y_label: str, names: tuple[float, float, float] = NAMES) -> list[Markup]:
    """Grid, tick labels, names of the axes."""
    (left, right), bottom, top = sorted((x.start, x.end)), y.start, y.end
    below, aside, above = names
    parts = [tag("path", class_="grid", d=path([(p, bottom), (p, top)])) for p, _ in x.ticks()]
    parts += [tag("path", class_="grid", d=path([(left, p), (right, p)])) for p, _ in y.ticks()]
    parts.append(tag("path", class_="axis", d=path([(left, top), (left, bottom), (right, bottom)])))
    parts += [tag("text", text, x=p, y=bottom + 16, text_anchor="middle") for p, text in x.ticks()]
    parts += [tag("text", text, x=left - 6, y=p + 4, text_anchor="end") for p, text in y.ticks()]
    parts.append(tag("text", x_label, class_="name", x=(left + right) / 2, y=bottom + below, text_anchor="middle"))
    parts.append(tag("text", y_label, class_="name", x=left - aside, y=top - above, text_anchor="start"))
    return parts


def _curve(series: Series, x: Axis, y: Axis) -> list[Markup]:
    points = [(x.at(a), y.at(b)) for a, b in zip(series.x, series.y, strict=True) if math.isfinite(b)]
    style = f"s{series.style % SERIES}"
    parts = [tag("path", class_=f"curve {style}", d=path(points))] if len(points) > 1 else []
    if series.marks:
        parts += [mark(series.style, a, b, style) for a, b in points]
    return parts


def mark(kind: int, x: float, y: float, style: str, title: str = "") -> Markup:
    """Circle, square, diamond, triangle, triangle upside down, bar: series differ by more than colour. ``title`` is
    told when the mark is pointed at."""
    inside = (tag("title", title),) if title else ()
    k = kind % KINDS
    if k == 0:
        return tag("circle", *inside, class_=f"mark {style}", cx=x, cy=y, r="4")
    if k == 1:
        return tag("rect", *inside, class_=f"mark {style}", x=x - 3.6, y=y - 3.6, width="7.2", height="7.2")
    corners = [(x + a, y + b) for a, b in OUTLINES[k]]
    return tag("path", *inside, class_=f"mark {style}", d=path(corners, close=True))


OUTLINES: dict[int, tuple[tuple[float, float], ...]] = {
    2: ((-5, 0), (0, -5), (5, 0), (0, 5)),
    3: ((-4.6, 3.6), (0, -4.8), (4.6, 3.6)),
    4: ((-4.6, -3.6), (4.6, -3.6), (0, 4.8)),
    5: ((-5, -2), (5, -2), (5, 2), (-5, 2)),
}
KINDS = 2 + len(OUTLINES)
"""Marks that differ in shape."""


def line_plot(
    series: Sequence[Series], title: str, x_label: str, name: str, unit: str, width: float = 330, height: float = 190,
    cursor: bool = False,
) -> Markup:  # fmt: skip
    """Values over time, of a named quantity; very small and very large ones are given in a power of ten. ``cursor``:
    with a line that a script moves by up to ``data-span`` pixels."""
    most = max((abs(b) for s in series for b in s.y if math.isfinite(b)), default=0.0)
    exponent = 3 * math.floor(math.log10(most) / 3) if most > 0 and not 0.01 <= most < 1e5 else 0
    if exponent:
        series = [replace(s, y=tuple(b / 10.0**exponent for b in s.y)) for s in series]
        unit = f"{power(exponent)} {unit}".rstrip()
    x = linear_axis_exact([a for s in series for a in s.x], 58, width - 14)
    y = linear_axis([b for s in series for b in s.y if math.isfinite(b)] or [0.0], height - 42, 26)
    curves = [part for s in series for part in _curve(s, x, y)]
    label = f"{name}, {unit}" if unit else name
    parts = [*axes(x, y, x_label, label), *curves]
    if not cursor:
        return figure(parts, width, height, title, class_="plot")
    parts.append(tag("path", class_="cursor", d=path([(x.start, y.start), (x.start, y.end)])))
    return figure(parts, width, height, title, class_="plot", data_start=num(x.start), data_span=num(x.end - x.start))


def linear_axis_exact(values: Sequence[float], start: float, end: float) -> Axis:
    """From the first value to the last, without room at the ends."""
    low, high = min(values), max(values)
    return Axis(low, high if high > low else low + 1.0, start, end)


def loglog_plot(
    series: Sequence[Series], title: str, x_label: str, y_label: str, slopes: Sequence[int] = (), width: float = 560,
    height: float = 340,
) -> Markup:  # fmt: skip
    """Errors over step sizes, with a reference line for each order in ``slopes``."""
    xs = [a for s in series for a in s.x if a > 0]
    ys = [b for s in series for b in s.y if b > 0 and math.isfinite(b)]
    if not xs or not ys:
        return Markup("")
    x, y = log_axis(xs, 66, width - 26), log_axis([min(ys) / BESIDE, *ys], height - 46, 30)
    parts = axes(x, y, x_label, y_label)
    for s in series:
        kept = [(a, b) for a, b in zip(s.x, s.y, strict=True) if b > 0]
        clean = Series(s.name, tuple(a for a, _ in kept), tuple(b for _, b in kept), True, s.style)
        parts += _curve(clean, x, y)
        if s.style < len(slopes) and len(kept) > 1:
            parts += _slope(kept[0], kept[-1][0], slopes[s.style], x, y)
    return figure(parts, width, height, title, class_="plot")


BESIDE = 4.0
"""How far below the data the line of the expected order is drawn, as a factor."""


def _slope(first: tuple[float, float], last: float, order: int, x: Axis, y: Axis) -> list[Markup]:
    """A dashed line of the expected order under the points from ``first`` to the step ``last``, cut at the frame."""
    a, b = first[0], first[1] / BESIDE
    decades = min((math.log10(b) - y.low) / order, math.log10(a / last))
    if decades <= 0:
        return []
    start, end = (x.at(a), y.at(b)), (x.at(a * 10**-decades), y.at(b * 10 ** (-order * decades)))
    middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    text = tag("text", f"order {order}", x=middle[0] + 8, y=middle[1] + 16, class_="name")
    return [tag("path", class_="slope", d=path([start, end])), text]


@dataclass(frozen=True)
class Bar:
    label: str
    value: int
    chosen: bool


def bar_chart(groups: Sequence[tuple[str, Sequence[Bar]]], title: str, unit: str) -> Markup:
    """Horizontal bars in groups; within a group lengths are in proportion, the longest fills the width."""
    longest = max((len(bar.label) for _, bars in groups for bar in bars), default=0)
    left, full, step, gap = max(120.0, 6.5 * longest + 16), 330.0, 20.0, 30.0
    parts: list[Markup] = []
    y = 6.0
    for name, bars in groups:
        parts.append(tag("text", name, class_="group", x="0", y=y + 13))
        y += 22
        most = max(bar.value for bar in bars) or 1
        for bar in bars:
            length = max(2.0, full * bar.value / most)
            style = "bar chosen" if bar.chosen else "bar"
            parts.append(tag("text", bar.label, x=left - 8, y=y + 12, text_anchor="end"))
            parts.append(tag("rect", class_=style, x=left, y=y + 1, width=length, height=step - 6, rx="2"))
            note = thousands(bar.value) + (f" {unit}, chosen" if bar.chosen else "")
            parts.append(tag("text", note, class_="value", x=left + length + 7, y=y + 12))
            y += step
        y += gap - step
    return figure(parts, left + full + 150, y, title, class_="plot bars")
