"""How energy fares over a long run of every generated step, in C."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from symgen.simulate.model import Array, Model

BINS = 60
"""Times, evenly spaced on a logarithmic axis, at which the largest error so far is kept."""
FALLEN = 1e3
"""A kinetic energy that grew by more than this is that of something that falls, which says nothing."""
ROUNDING = 1e-12
"""Relative changes of the energy below this are not looked at."""
GROWTH, BURST = 2.0, 10.0
"""An error whose median over the last fifth of a run is less than GROWTH times that over the first fifth, and whose
largest value is less than BURST times that of the first tenth, does not grow."""
LOST = 0.1
"""Relative change of the energy beyond which a run is no motion of the mechanism: too large, though it may not grow."""
BOUNDED = "bounded"


def verdict(first: float, last: float, growth: float) -> str:
    """What is said of a run that did not fail, everywhere: bounded, too large or grows. See `Line`."""
    if last < ROUNDING and first < ROUNDING:
        return BOUNDED
    if not (growth < GROWTH and last < BURST * first):
        return "grows"
    return "too large" if max(first, last) > LOST else BOUNDED


@dataclass(frozen=True)
class Line:
    """One method: ``largest`` relative change of the energy up to each of ``times`` (s). ``first``, ``last``: the
    largest in the first tenth of the run and in the rest; ``growth``: the median over the last fifth divided by that
    over the first; ``failed``: where it ended, if it did."""

    method: str
    times: tuple[float, ...]
    largest: tuple[float, ...]
    first: float
    last: float
    growth: float
    cpu_seconds: float
    failed: str = ""

    @property
    def verdict(self) -> str:
        return self.failed or verdict(self.first, self.last, self.growth)

    @property
    def bounded(self) -> bool:
        return self.verdict == BOUNDED


def long_run(model: Model, method: str, y: Array, dt: float, steps: int) -> Line:
    """``steps`` steps of ``dt`` from y = (q, v) without joint forces."""
    state, nq = y.copy(), model.nq
    every = max(1, steps // 100_000)
    steps -= steps % every
    began = time.process_time()
    kept = model.step(method, steps, every, np.zeros(model.nv), dt, state)
    spent = time.process_time() - began
    rows = np.vstack([y, kept])
    with np.errstate(all="ignore"):
        for place in model.quaternions:
            rows[:, place : place + 4] /= np.linalg.norm(rows[:, place : place + 4], axis=1, keepdims=True)
        kinetic, potential = model.energies(np.ascontiguousarray(rows[:, :nq]), np.ascontiguousarray(rows[:, nq:]))
        energy = kinetic + potential
        good = np.isfinite(energy)
        count = len(energy) if good.all() else max(1, int(np.argmin(good)))
        scale = max(abs(float(energy[0])), float(np.median(kinetic[:count])), 1e-300)
        errors: Array = np.abs(energy[1:count] - energy[0]) / scale
    times: Array = dt * every * np.arange(1, len(errors) + 1, dtype=np.float64)
    failed = "" if count == len(energy) else f"left the numbers at t = {dt * every * count:.3g} s"
    if len(errors) < 10:
        return Line(method, (), (), np.inf, np.inf, np.inf, spent, failed or "too few steps")
    if not failed and np.max(np.abs(potential[:count] - potential[0])) > FALLEN * max(kinetic[0], abs(energy[0])):
        failed = "falls without end"
    tenth, fifth = max(1, len(errors) // 10), max(1, len(errors) // 5)
    growth = float(np.median(errors[-fifth:]) / max(float(np.median(errors[:fifth])), 1e-300))
    first, last = float(errors[:tenth].max()), float(errors[tenth:].max())
    return Line(method, *_envelope(times, errors), first, last, growth, spent, failed)


def _envelope(times: Array, errors: Array) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The largest error so far, at times evenly spaced on a logarithmic axis."""
    so_far = np.maximum.accumulate(errors)
    places = np.unique(np.round(np.geomspace(1, len(times), BINS)).astype(int)) - 1
    return tuple(float(times[k]) for k in places), tuple(float(so_far[k]) for k in places)
