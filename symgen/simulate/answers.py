"""Lines of the table of benchmark problems."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from symgen.simulate.motion import Motion

FINE: dict[str, Any] = {"rtol": 1e-13, "atol": 1e-14}
"""As fine as SciPy's solvers go."""
GRAVITY = 9.81


@dataclass(frozen=True)
class Answer:
    """One line of the table."""

    problem: str
    quantity: str
    method: str
    error: float
    """As ``quantity`` says."""
    bar: float
    """What it must not exceed."""
    against: str
    """Where the right answer comes from."""
    drift: float
    """Of the energy, relative; NaN where it is not kept."""
    cpu_seconds: float
    published: str = ""
    """Accuracy or time that others print."""

    @property
    def passed(self) -> bool:
        return self.error <= self.bar


Problem = Callable[[], Iterator[Answer]]


def answer(
    motion: Motion,
    problem: str,
    quantity: str,
    error: float,
    bar: float,
    against: str,
    published: str = "",
    *,
    kept: bool = True,
) -> Answer:
    """``kept``: whether energy should be."""
    drift = motion.monitors.energy_drift if kept else math.nan
    return Answer(problem, quantity, motion.method, error, bar, against, drift, motion.cpu_seconds, published)


def largest(*errors: float) -> float:
    """Of the magnitudes."""
    return float(max(abs(x) for x in errors))
