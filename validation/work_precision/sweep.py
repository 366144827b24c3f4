"""Points of a diagram: every program, from coarse to fine."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.validation.work_precision.programs import Program
from symgen.validation.work_precision.setting import Setting

USELESS = 0.1
"""Errors from here on are listed as failed: not a digit is right."""


@dataclass(frozen=True)
class Point:
    """One run. ``energy``: relative change of the energy, where it is kept and known; ``failed``: why it is not in the
    diagram."""

    program: str
    integrator: str
    knob: str
    setting: float
    error: float | None = None
    energy: float | None = None
    cpu_seconds: float | None = None
    failed: str = ""


def point(at: Setting, program: Program, value: float, repeats: int) -> Point:
    """One point, or why there is none; the least time of ``repeats`` runs."""
    blank = Point(program.name, program.integrator, program.knob, value)
    try:
        found = [program.run(value) for _ in range(repeats)]
    except Exception as gone:  # whatever a solver says when it gives up
        return replace(blank, failed=" ".join(str(gone).split())[:100] or type(gone).__name__)
    error = float(np.abs(found[0].poses - at.right).max())
    if not math.isfinite(error):
        return replace(blank, failed="left the numbers")
    energy = found[0].energy
    return replace(
        blank,
        error=error,
        energy=energy if energy is not None and math.isfinite(energy) else None,
        cpu_seconds=min(outcome.cpu_seconds for outcome in found),
        failed="" if error < USELESS else f"error {error:.1e}",
    )


def sweep(
    at: Setting,
    every: Sequence[Program],
    knobs: dict[str, Sequence[float]],
    repeats: int,
    longest: float,
    say: Callable[[str], None],
) -> Iterator[Point]:
    """All points. A method ends where it no longer gains, or where its runs take longer than ``longest`` s together;
    its coarser points that failed are kept."""
    for program in every:
        say(f"{program.name}: {program.integrator}")
        point(at, program, knobs[program.knob][0], 1)  # what is only paid once
        errors: list[float] = []
        began = time.process_time()
        for value in knobs[program.knob]:
            found = point(at, program, value, repeats)
            yield found
            if not found.failed and found.error is not None:
                errors.append(found.error)
            gained = len(errors) < 3 or not errors[-1] < 10.0 * at.uncertainty > errors[-2] > 0.0
            if not gained or time.process_time() - began > longest:
                break
