"""The data of the section "Work and precision": plain JSON values."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any

from symgen.errors import SymgenError
from symgen.scene.canonical import with_hash
from symgen.scene.model import Scene
from symgen.simulate.model import Model
from symgen.validation.work_precision.energies import LOST, long_run
from symgen.validation.work_precision.orders import order
from symgen.validation.work_precision.programs import OURS_C, pinocchio_end, programs, versions
from symgen.validation.work_precision.setting import FINEST, Setting, checked, prepare, undamped
from symgen.validation.work_precision.sweep import Point, sweep

GOOD = 1e-5
"""The long run takes the longest steps with which ``rk4`` ends within this of the reference."""
SLIDING = ("prismatic", "cylindrical", "planar", "helical")


@dataclass(frozen=True)
class Effort:
    """How much is run. ``longest``: seconds of CPU time after which a method is left."""

    steps: tuple[int, ...]
    tolerances: tuple[float, ...]
    repeats: int
    longest: float
    energy_steps: int


QUICK = Effort(tuple(2**k for k in range(4, 13)), tuple(10.0**-k for k in range(3, 13, 2)), 1, 0.4, 100_000)
"""A few seconds of CPU time a scene."""
FULL = Effort(tuple(2**k for k in range(4, 15)), tuple(10.0**-k for k in range(2, 14)), 3, 20.0, 1_000_000)
"""One to three minutes a scene."""
EFFORTS = {"quick": QUICK, "full": FULL}


def precision_data(
    scene: Scene, say: Callable[[str], None], *, seconds: float = 1.0, effort: Effort | str = QUICK
) -> dict[str, Any]:
    """Measure one scene over ``seconds`` of motion. ``say`` is told what is being run; ``effort`` is "quick" or "full",
    or settings of one's own.

    Raises SymgenError for scenes without such functions (closed loops), ToolError without SciPy or a C compiler; peers
    that are missing or cannot hold the scene are listed under ``skipped``.
    """
    effort = EFFORTS[effort] if isinstance(effort, str) else effort
    say("reference")
    at = prepare(scene, seconds)
    with contextlib.suppress(SymgenError):  # listed under ``skipped`` below
        at = checked(at, "Pinocchio in DOP853", partial(pinocchio_end, at, FINEST["rtol"]))
    every, lost = programs(at)
    knobs: dict[str, Sequence[float]] = {"steps": effort.steps, "rtol": effort.tolerances}
    points = list(sweep(at, every, knobs, effort.repeats, effort.longest, say))
    say("orders")
    orders = [order(at.model, name, at.q, at.v, seconds / 8.0) for name in at.model.steps]
    return {
        "scene": at.scene.name,
        "seconds": seconds,
        "start": {"q": [float(x) for x in at.q], "v": [float(x) for x in at.v]},
        "reference": {
            "method": f"DOP853, rtol {FINEST['rtol']:g}",
            "uncertainty": at.uncertainty,
            "checks": [{"what": what, "difference": by} for what, by in at.checks],
        },
        "energy_kept": at.energy.kept,
        "versions": versions(),
        "repeats": effort.repeats,
        "points": [asdict(x) for x in points],
        "skipped": [{"program": name, "reason": why} for name, why in lost],
        "orders": [{**asdict(x), "holds": x.holds} for x in orders],
        "energy": _energy(at, points, effort.energy_steps, say),
    }


def _energy(at: Setting, points: Sequence[Point], steps: int, say: Callable[[str], None]) -> dict[str, Any]:
    """Long runs of all steps, or why there are none."""
    mine = [x for x in points if (x.program, x.integrator) == (OURS_C, "step:rk4") and not x.failed]
    good = [x.setting for x in mine if x.error is not None and x.error < GOOD]
    if not good:
        return {"reason": "No step is short enough to begin with."}
    dt = at.end / good[0]
    scene, without = at.scene, list[str]()
    if not at.energy.kept:
        scene, without = undamped(scene), ["dampers"]
    if any(link.joint.type == "floating" for link in at.mechanism.links):
        scene, without = replace(scene, gravity=(Fraction(0),) * 3), ["weight", *without]
    model = Model(with_hash(scene), at.model.steps) if without else at.model
    lines = []
    for method in model.steps:
        say(f"energy over {steps:,} steps: {method}")
        lines.append(long_run(model, method, model.start(list(at.q), list(at.v)), dt, steps))
    if all(line.failed == "falls without end" for line in lines):
        return {"reason": "The mechanism falls without end."}
    sliding = [link.joint.name for link in at.mechanism.links if link.joint.type in SLIDING]
    if sliding and all(line.failed or line.last > LOST for line in lines):
        names = ", ".join(sliding)
        return {
            "reason": f"Nothing holds {names}: bodies slide away and whip round, which no step of one length follows."
        }
    found = [{**asdict(line), "bounded": line.bounded, "verdict": line.verdict} for line in lines]
    return {"dt": dt, "steps": steps, "without": without, "lines": [_finite(row) for row in found]}


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    """Infinities, which JSON has not, as None."""
    return {key: None if isinstance(x, float) and x in (float("inf"),) else x for key, x in row.items()}
