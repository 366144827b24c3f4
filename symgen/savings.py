"""What each restriction of a scene saves: operations of its functions with it and without it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from symgen.errors import SymgenError
from symgen.integrators.plan import without_steps
from symgen.program.instructions import count
from symgen.scene.model import Scene
from symgen.scene.restrictions import restrictions
from symgen.system import System, derive

MAX_VELOCITIES = 40
"""Scenes of more velocities are not derived a second time."""
MAX_FLOPS = 100_000
"""Nor those whose functions have more operations than this, in all scenes together five times as many."""


@dataclass(frozen=True)
class Saving:
    """One restriction: flops of all functions asked for, with and without it; or why they are not counted."""

    restriction: str
    flops: int | None
    without: int | None
    why: str = ""

    @property
    def saved(self) -> int | None:
        return None if self.flops is None or self.without is None else self.without - self.flops


def savings(system: System) -> Iterator[Saving]:
    """One row for each restriction of the system's scene. Work is bounded: what is too large says so."""
    refusal = _too_large(system)
    own = None if refusal else total_flops(system)
    if own is not None and own > MAX_FLOPS:
        refusal = f"the functions have {own} flops as they are"
    spent = 0
    for restriction in restrictions(system.scene):
        if refusal or restriction.scene is None:
            yield Saving(restriction.label, own, None, _not_counted(refusal or restriction.why))
            continue
        other, why = _flops_of(restriction.scene)
        yield Saving(restriction.label, own, other, _not_counted(why))
        spent += other or 0
        if spent > 5 * MAX_FLOPS:
            refusal = "counting takes too long"


def total_flops(system: System) -> int:
    """Flops of all functions asked for, each by its cheapest plan; of steps, those of what they call."""
    return sum(count(system.program(output.name)).flops for output in without_steps(system.outputs))


def _flops_of(scene: Scene) -> tuple[int | None, str]:
    try:
        system = derive(scene)
        why = _too_large(system)
        return (None, why) if why else (total_flops(system), "")
    except SymgenError as error:
        return None, str(error)


def _too_large(system: System) -> str:
    nv = system.tree.nv
    return f"{nv} velocities, more than {MAX_VELOCITIES}" if nv > MAX_VELOCITIES else ""


def _not_counted(why: str) -> str:
    return f"not counted: {why}" if why else ""
