"""Looking for the worst state: rounding errors are maximised without derivatives, since they have none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symgen.accuracy.balls import Reference, relative
from symgen.accuracy.states import Array, Box, rounded
from symgen.accuracy.variants import Compiled
from symgen.errors import ToolError

try:
    from scipy.optimize import differential_evolution, minimize
except ImportError as error:  # pragma: no cover
    raise ToolError("SciPy is not installed: pip install 'symgen[accuracy]'") from error

POPULATION = 24
RESTARTS = 3
NEVER = 1e-300


@dataclass(frozen=True)
class Worst:
    """The worst state that was found, as a point of the box's cube, and its error ‖x − x̂‖∞/‖x̂‖∞."""

    point: Array
    error: float
    evaluations: int


class _Objective:
    """−log₁₀ of the error at points of the cube; remembers the worst."""

    def __init__(self, compiled: Compiled, reference: Reference, box: Box) -> None:
        self.compiled, self.reference, self.box = compiled, reference, box
        self.worst, self.error, self.evaluations = np.zeros(box.size), 0.0, 0

    def __call__(self, point: Array) -> float:
        return float(self.many(np.atleast_2d(point))[0])

    def many(self, points: Array) -> Array:
        states = rounded(self.box.states(np.clip(points, -1, 1)), self.compiled.variant.precision)
        # a batch form takes at least four states
        wide = {name: np.repeat(rows, 4, axis=0) for name, rows in states.items()}
        computed = self.compiled.call(wide)[::4]
        high, low = self.reference.over(states)
        found = np.nan_to_num(relative(computed, high, low), nan=0.0, posinf=0.0)
        self.evaluations += len(points)
        best = int(np.argmax(found))
        if found[best] > self.error:
            self.worst, self.error = np.clip(points[best], -1, 1), float(found[best])
        return np.asarray(-np.log10(np.maximum(found, NEVER)))


def worst_state(compiled: Compiled, reference: Reference, box: Box, evaluations: int, seed: int = 1) -> Worst:
    """Differential evolution over the box with half of the evaluations, then Nelder–Mead from the worst states that it
    and further random ones have. The same on every run with the same binary."""
    objective = _Objective(compiled, reference, box)
    rounds = max(evaluations // (2 * POPULATION) - 1, 1)
    rng = np.random.default_rng(seed)
    start = rng.uniform(-1, 1, (POPULATION, box.size))
    differential_evolution(
        lambda points: objective.many(points.T) if points.ndim == 2 else objective(points),
        [(-1.0, 1.0)] * box.size, maxiter=rounds, init=start, rng=rng, polish=False, vectorized=True,
        updating="deferred", tol=0,
    )  # fmt: skip
    for _ in range(RESTARTS):
        left = (evaluations - objective.evaluations) // RESTARTS
        if left > box.size:
            simplex = objective.worst + rng.normal(0, 0.05, (box.size + 1, box.size))
            minimize(
                objective, objective.worst, method="Nelder-Mead",
                options={"maxfev": left, "initial_simplex": np.clip(simplex, -1, 1)},
            )  # fmt: skip
    return Worst(objective.worst, objective.error, objective.evaluations)
