"""Errors of compiled functions against ball arithmetic: sampled states, states sought for, and every plan."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symgen.accuracy.balls import Reference, errors, relative_to
from symgen.accuracy.search import worst_state
from symgen.accuracy.states import Array, Box, States, picked, rounded
from symgen.accuracy.variants import STANDARD, Compiled, Variant, compile_variant, plans_of
from symgen.errors import NotSupportedError, SymgenError
from symgen.plans.build import build
from symgen.plans.families import Family, families_of
from symgen.program.instructions import Program
from symgen.program.rounding import condition
from symgen.scene.model import Output, Scene
from symgen.system import System, derive

Say = Callable[[str], None]
ROWS = ("mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics")
"""What is measured unless asked otherwise."""
CONDITIONED = 512
"""States at which the condition is computed: those with the largest errors and as many others."""


@dataclass(frozen=True)
class Row:
    """Errors of one function in one variant, ‖x − x̂‖∞/‖x̂‖∞."""

    scene: str
    function: str
    variant: str
    plan: str
    chosen: bool
    """Whether this plan is the one that is picked."""
    states: int
    largest: float
    percentile: float
    """The 99.9 percentile."""
    median: float
    tenth: float
    ninetieth: float
    """The 10 and the 90 percentile."""
    absolute: float
    """The largest error of an entry, |x − x̂|, in the units of the function."""
    operations: int
    """Of the plan."""
    sought: float | None
    """The largest that a search found, if one was made."""
    condition: float
    """Of the problem, at the state with the largest error: relative movement of the exact result per relative movement
    of its data."""
    backward: float
    """The largest error in units of u · max(1, condition), u half a unit in the last place."""
    wrong: int
    """States where there is an answer and none was given, or none and one was given."""

    def to_json(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True)
class Settings:
    states: int = 10000
    seed: int = 1
    search: int = 0
    """Evaluations that a search for the worst state may take; 0: none is made."""
    plans: bool = True
    """Whether every plan is measured beside the chosen one."""
    variants: tuple[Variant, ...] = STANDARD
    rows: tuple[str, ...] = ROWS


def measure(scene: Scene, settings: Settings = Settings(), say: Say = lambda what: None) -> list[Row]:
    """Errors of every function that ``settings`` names, in every variant and plan.

    Raises SymgenError where the scene cannot be derived or there is no C compiler.
    """
    system = derive(scene)
    system.require_tree()
    outputs = tuple(system.output(name) for name in settings.rows)
    problems = {output.name: Problem(system, output, settings) for output in outputs}
    found: list[Row] = []
    with tempfile.TemporaryDirectory() as scratch:
        work = jobs(system, outputs, settings)
        for number, (variant, wanted) in enumerate(work):
            say(f"{scene.name}: {variant.name}{', other plans' if variant.family else ''}, {number + 1} of {len(work)}")
            for compiled in compile_variant(system, wanted, variant, Path(scratch, f"v{number}")):
                found.append(problems[compiled.function].row(compiled))
    return found


def jobs(system: System, outputs: tuple[Output, ...], settings: Settings) -> list[tuple[Variant, tuple[Output, ...]]]:
    """What to compile: the chosen plans in every variant, then every plan in double."""
    found: list[tuple[Variant, tuple[Output, ...]]] = [(variant, outputs) for variant in settings.variants]
    if settings.plans:
        families: dict[Family, list[Output]] = {}
        for output in outputs:
            own = plans_of(system, output)
            for family in own if len(own) > 1 else ():
                families.setdefault(family, []).append(output)
        found += [(Variant(family=family), tuple(wanted)) for family, wanted in families.items()]
    return found


class Problem:
    """One function of a scene: its states, its exact values there, and how well conditioned they are."""

    def __init__(self, system: System, output: Output, settings: Settings) -> None:
        self.system, self.output, self.settings = system, output, settings
        self.program = system.program(output.name)
        self.box = Box(system, self.program)
        self.reference = Reference(self.program)
        self.datum = as_given(system, output)
        self._known: dict[str, tuple[States, Array, Array]] = {}

    def known(self, precision: str) -> tuple[States, Array, Array]:
        """States and exact values, as high and low parts."""
        if precision not in self._known:
            states = rounded(self.box.sample(self.settings.states, self.settings.seed), precision)
            self._known[precision] = (states, *self.reference.over(states))
        return self._known[precision]

    def row(self, compiled: Compiled) -> Row:
        variant = compiled.variant
        states, high, low = self.known(variant.precision)
        judged = judge(compiled, self.datum, states, high, low)
        sought = None
        if self.settings.search and variant.family is None:
            sought = worst_state(compiled, self.reference, self.box, self.settings.search, self.settings.seed).error
        quantiles = np.quantile(judged.errors, (0.999, 0.5, 0.1, 0.9)) if len(judged.errors) else np.zeros(4)
        return Row(
            scene=self.system.scene.name,
            function=self.output.name,
            variant=variant.name,
            plan=compiled.plan,
            chosen=compiled.plan == self.system.code(self.output.name).program.plan,
            states=len(high),
            largest=float(np.max(judged.errors, initial=0.0)),
            percentile=float(quantiles[0]),
            median=float(quantiles[1]),
            tenth=float(quantiles[2]),
            ninetieth=float(quantiles[3]),
            absolute=judged.absolute,
            operations=compiled.operations,
            sought=sought,
            condition=judged.condition,
            backward=judged.units,
            wrong=judged.wrong,
        )


@dataclass(frozen=True)
class Judged:
    """A compiled function held against exact values at states."""

    errors: Array
    """‖x − x̂‖∞/‖x̂‖∞ where there is an answer and one was given."""
    condition: float
    """Of the problem, where the error is largest."""
    units: float
    """The largest error in units of u · max(1, condition)."""
    wrong: int
    """States with an answer and none given, or the other way round."""
    absolute: float
    """The largest |x − x̂| of an entry where there is an answer and one was given."""


def judge(compiled: Compiled, datum: Program, states: States, high: Array, low: Array) -> Judged:
    """``high``, ``low``: the exact values (see `Reference.over`); ``datum``: what the condition is measured with (see
    `as_given`)."""
    entries = errors(compiled.call(states), high, low)
    error = relative_to(entries, high)
    good = np.isfinite(error) & np.isfinite(high).all(axis=1)
    wrong = int(np.sum(~np.isfinite(error)))
    if not good.any():
        return Judged(np.zeros(0), 1.0, 0.0, wrong, 0.0)
    few = np.argsort(-np.where(good, error, -1.0), kind="stable")[: min(CONDITIONED, int(good.sum()))]
    kappa = condition(datum, picked(states, few)) if states else np.ones(1)
    units = error[few] / (compiled.variant.unit * np.fmax(kappa, 1.0))
    absolute = float(np.max(entries[good], initial=0.0))
    return Judged(error[good], float(kappa[0]), float(np.max(units)), wrong, absolute)


def as_given(system: System, output: Output) -> Program:
    """The program whose constants are the scene's own as far as may be: what the condition is measured with, whatever
    plan is looked at, so that constants which a plan made up excuse nothing."""
    families = [family for family in families_of(output, system.tree) if not (family.regrouped or family.literal)]
    if not families:
        return system.program(output.name)
    articulated = [family for family in families if family.articulated]  # LᵀDL of a long chain has far too many
    return build(system.lowered, system.natural, output, (articulated or families)[0])


def measurable(scene: Scene, rows: Sequence[str]) -> tuple[str, ...]:
    """Those of the rows that a scene can have. Empty where it cannot be derived."""
    found = []
    try:
        system = derive(scene)
        system.require_tree()
    except NotSupportedError:
        return ()
    for row in rows:
        try:
            system.program(row)
        except SymgenError:
            continue
        found.append(row)
    return tuple(found)
