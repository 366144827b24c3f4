"""Which plans were chosen because of accuracy: where the cheapest one was refused."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from symgen.plans.choose import PlanChoice, cost
from symgen.scene.builder import SceneBuilder
from symgen.scene.model import Scene
from symgen.system import System

ROWS = ("forward_dynamics", "mass_matrix_inverse")
"""Functions that solve with the mass matrix: the others are not looked at."""
_ERROR = re.compile(r"about (\d+) times the error")


@dataclass(frozen=True)
class Changed:
    """A function whose cheapest plan was refused. ``error``: its estimated error over the best plan's; ``dearer``: the
    cost of the chosen one over its."""

    scene: str
    function: str
    cheapest: str
    error: int
    chosen: str
    dearer: float


def changed(system: System, name: str = "") -> Iterator[Changed]:
    """The functions of ``ROWS`` whose plan accuracy decided."""
    for row in ROWS:
        weighed = [choice for choice in system.plans(row) if choice.counts is not None]
        refused = [choice for choice in weighed if _ERROR.search(choice.why)]
        if not refused:
            continue
        best = next(choice for choice in weighed if choice.chosen)
        worst = min(refused, key=_cost)
        found = _ERROR.search(worst.why)
        assert found is not None
        yield Changed(
            name or system.scene.name, row, worst.plan, int(found[1]), best.plan, _cost(best) / max(_cost(worst), 1)
        )


def _cost(choice: PlanChoice) -> int:
    assert choice.counts is not None
    return cost(choice.counts)


def random_chain(seed: int) -> Scene:
    """A chain of 2 to 8 rods, axes and masses (0.1 to 10 kg) at random: the same for a seed on every machine."""
    rng = random.Random(f"chain {seed}")
    links, before = rng.randrange(2, 9), Fraction(0)
    made = SceneBuilder(f"chain_{seed}_of_{links}")
    for k in range(links):
        mass = Fraction(round(10 ** rng.uniform(-1, 1), 2)).limit_denominator(100)
        length = Fraction(rng.randrange(2, 11), 10)
        across = mass * length**2 / 12
        made.body(f"l{k}", mass, (0, 0, -length / 2), (across, across, across / 50, 0, 0, 0))
        axis = rng.choice(((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 1, 0)))
        made.joint(f"j{k}", "revolute", f"l{k - 1}" if k else "ground", f"l{k}", axis=axis, xyz=(0, 0, -before))
        before = length
    return made.build()
