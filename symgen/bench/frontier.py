"""Which programs are worth having for a function: those that nothing else beats in time and in error.

One beats another when it is faster by more than the noise of timing and not less exact, or more exact and not slower.
Errors are the largest of a sample of states, so they have a tolerance too. Nothing can be beaten in a circle: whatever
beats has the smaller log(time)/log(1 + NOISE) + log(error)/log(1 + SAMPLED).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

NOISE = 0.03
"""Medians of times this close, relatively, are taken for equal."""
SAMPLED = 0.10
"""So are largest errors this close: other states would give others."""
BEST, TIE, BEATEN = "frontier", "tie", ""


class Point(Protocol):
    """A program with its time and its error."""

    @property
    def ns_median(self) -> float: ...

    @property
    def error(self) -> float: ...


@dataclass(frozen=True)
class Standing:
    """What is known of one program of a function."""

    verdict: str
    """``frontier``; ``tie`` where only noise keeps it from there; or empty: something beats it."""
    by: int | None = None
    """Which one it is beaten by or ties with: the fastest of those."""


def beats(one: Point, other: Point) -> bool:
    """Whether ``one`` is better beyond doubt in time or in error, and not worse beyond doubt in the other."""
    faster = one.ns_median * (1 + NOISE) < other.ns_median
    slower = other.ns_median * (1 + NOISE) < one.ns_median
    finer = one.error * (1 + SAMPLED) < other.error
    coarser = other.error * (1 + SAMPLED) < one.error
    return (faster and not coarser) or (finer and not slower)


def dominates(one: Point, other: Point) -> bool:
    """The same by the bare figures."""
    no_worse = one.ns_median <= other.ns_median and one.error <= other.error
    return no_worse and (one.ns_median < other.ns_median or one.error < other.error)


def standings(points: Sequence[Point]) -> list[Standing]:
    """What each of the points is, all programs for one function."""
    found = []
    for point in points:
        ahead = [k for k, other in enumerate(points) if beats(other, point)]
        level = [k for k, other in enumerate(points) if dominates(other, point)]
        first = min(ahead or level, key=lambda k: points[k].ns_median, default=None)
        found.append(Standing(BEATEN if ahead else TIE if level else BEST, first))
    return found


def order(points: Sequence[Point]) -> list[int]:
    """The frontier with its ties, fastest first."""
    verdicts = standings(points)
    kept = [k for k, standing in enumerate(verdicts) if standing.verdict]
    return sorted(kept, key=lambda k: (points[k].ns_median, points[k].error))
