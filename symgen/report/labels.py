"""Labels beside dots of a drawing: each where it hides least, further off with a thin line to its dot, or left out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

LETTER = 6.1
"""Width of a letter of the plots' text, on average."""
HEIGHT = 13.0
RADII = (9.0, 15.0, 23.0, 32.0, 43.0, 56.0, 71.0, 88.0)
DIRECTIONS = tuple(
    math.radians(a) for a in (0, 180, 45, 135, -45, -135, 90, -90, 20, 160, -20, -160, 65, 115, -65, -115)
)
NEAR = 16.0
"""Within this distance a label needs no line to its dot."""
OVER_LABEL, OVER_DOT, OVER_LINE = 1000.0, 400.0, 12.0
TOO_MUCH = 380.0
"""A label that costs more is left out."""


@dataclass(frozen=True)
class Box:
    left: float
    top: float
    right: float
    bottom: float

    def meets(self, other: Box) -> bool:
        across = self.left < other.right and other.left < self.right
        return across and self.top < other.bottom and other.top < self.bottom

    def within(self, other: Box) -> bool:
        across = other.left <= self.left and self.right <= other.right
        return across and other.top <= self.top and self.bottom <= other.bottom


@dataclass(frozen=True)
class Label:
    """Where a text goes. ``line``: from the dot to the text, where they are apart."""

    text: str
    x: float
    y: float
    anchor: str
    line: tuple[tuple[float, float], tuple[float, float]] | None


@dataclass(frozen=True)
class Spot:
    """A dot with the text that it is to have; without one it is only in the way."""

    x: float
    y: float
    text: str = ""
    radius: float = 5.0


def place(spots: Sequence[Spot], frame: Box, lines: Sequence[Box] = ()) -> list[Label | None]:
    """A label for each spot, the first ones first. ``lines``: what is better not written over."""
    dots = [Box(s.x - s.radius, s.y - s.radius, s.x + s.radius, s.y + s.radius) for s in spots]
    taken: list[Box] = []
    found: list[Label | None] = []
    for at, spot in enumerate(spots):
        others = [box for k, box in enumerate(dots) if k != at]
        best, least, where = None, TOO_MUCH, None
        for label, box, distance in _candidates(spot) if spot.text else ():
            if not box.within(frame):
                continue
            cost = distance + _cost(box, label, others, taken, lines)
            if cost < least:
                best, least, where = label, cost, box
        if where is not None:
            taken.append(where)
        found.append(best)
    return found


def _candidates(spot: Spot) -> list[tuple[Label, Box, float]]:
    found = []
    width = LETTER * len(spot.text)
    for radius in RADII:
        for turn, angle in enumerate(DIRECTIONS):
            x, y = spot.x + radius * math.cos(angle), spot.y - radius * math.sin(angle)
            side = math.cos(angle)
            anchor = "start" if side > 0.3 else "end" if side < -0.3 else "middle"
            left = {"start": x, "end": x - width, "middle": x - width / 2}[anchor]
            low = y + 4 if anchor != "middle" else y + (0 if math.sin(angle) > 0 else HEIGHT - 3)
            box = Box(left - 2, low - HEIGHT + 2, left + width + 2, low + 4)
            line = None
            if radius > NEAR:
                start = spot.x + spot.radius * math.cos(angle), spot.y - spot.radius * math.sin(angle)
                end = spot.x + (radius - 2) * math.cos(angle), spot.y - (radius - 2) * math.sin(angle)
                line = (start, end)
            found.append((Label(spot.text, x, low, anchor, line), box, radius + turn))
    return found


def _cost(box: Box, label: Label, dots: Sequence[Box], taken: Sequence[Box], lines: Sequence[Box]) -> float:
    cost = OVER_LABEL * sum(box.meets(other) for other in taken)
    cost += OVER_DOT * sum(box.meets(other) for other in dots)
    cost += OVER_LINE * sum(box.meets(other) for other in lines)
    if label.line is not None:
        for k in range(1, 6):  # the line to the dot runs over nothing either
            (a, b), (c, d) = label.line
            x, y = a + (c - a) * k / 5, b + (d - b) * k / 5
            point = Box(x - 1, y - 1, x + 1, y + 1)
            cost += OVER_DOT * any(point.meets(other) for other in dots)
            cost += OVER_LABEL * any(point.meets(other) for other in taken)
    return cost
