"""The order of convergence that each generated step shows, beside the one that it states."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from symgen.simulate.model import Array, Model
from symgen.simulate.run import simulate
from symgen.validation.work_precision.setting import FINEST

STATED = {"semi_implicit_euler": 1, "rk4": 4, "lie": 4, "implicit_midpoint": 2, "variational": 2}
COUNTS = {1: (256, 512, 1024, 2048), 2: (64, 128, 256, 512), 4: (16, 32, 64, 128)}
"""Steps of the runs, by order: short enough to converge, long enough to stay above rounding."""
SLACK = 0.3
ROUNDING = 1e-11
"""Errors below say nothing of the order."""


@dataclass(frozen=True)
class Order:
    """``errors``: (step in s, largest error of q and v relative to the largest of either). ``observed``: the logarithm
    of how much the last halving that rounding does not hide gained; None where none is left."""

    method: str
    stated: int
    errors: tuple[tuple[float, float], ...]
    observed: float | None

    @property
    def holds(self) -> bool:
        """Whether the method converges as it should, or is right to rounding."""
        if self.observed is None:
            return all(error <= ROUNDING for _, error in self.errors[1:])
        return self.observed > self.stated - SLACK


def observed_order(errors: list[float]) -> float | None:
    """From errors at halved steps."""
    clear = [(a, b) for a, b in pairwise(errors) if b > ROUNDING and np.isfinite(a)]
    return float(np.log2(clear[-1][0] / clear[-1][1])) if clear else None


def order(model: Model, method: str, q: Array, v: Array, end: float) -> Order:
    """Of one method of ``model`` over a short motion from (q, v)."""
    right = _state(model, q, v, end, **FINEST)
    scale = max(1.0, float(np.abs(right).max()))
    stated = STATED[method]
    errors = []
    for count in COUNTS[stated]:
        found = _state(model, q, v, end, method=method, dt=end / count)
        errors.append(float(np.abs(found - right).max()) / scale)
    steps = [end / count for count in COUNTS[stated]]
    return Order(method, stated, tuple(zip(steps, errors, strict=True)), observed_order(errors))


def _state(model: Model, q: Array, v: Array, end: float, **how: Any) -> Array:
    motion = simulate(model, list(q), list(v), end, samples=2, **how)
    return np.concatenate([motion.q[-1], motion.v[-1]])
