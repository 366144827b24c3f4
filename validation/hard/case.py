"""What a hard case is, and the ways to hold one against its right answer."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.accuracy.balls import Reference
from symgen.accuracy.measure import as_given, judge
from symgen.accuracy.states import picked, rounded
from symgen.accuracy.variants import Compiled, Variant, compile_variant, plans_of
from symgen.errors import SymgenError
from symgen.generate import generate
from symgen.plans.families import Family
from symgen.scene.canonical import with_hash
from symgen.scene.model import Output, Scene
from symgen.system import System, derive

Array = NDArray[np.float64]
States = Mapping[str, Array]
UNITS = 32.0
"""An error of so many u · max(1, condition) is right, u half a unit in the last place: what rounding of the data alone
may do, and a few operations more."""


@dataclass(frozen=True)
class Finding:
    """One line of the table."""

    case: str
    what: str
    variant: str
    figure: float
    """What was measured."""
    allowed: float | None
    """None: shown for comparison, nothing is demanded; 0: it is so (0) or it is not."""
    note: str = ""
    unit: str = ""
    """Of ``figure``: ``units`` of u · max(1, condition), ``u``, or words; empty: what ``note`` says."""
    error: float | None = None
    condition: float | None = None
    """Where ``unit`` is ``units``: the error and the condition of the problem there."""

    @property
    def passed(self) -> bool:
        return self.allowed is None or bool(self.figure <= self.allowed)

    def to_json(self) -> dict[str, Any]:
        figure = self.figure if np.isfinite(self.figure) else None
        return {**asdict(self), "figure": figure, "passed": self.passed}


@dataclass(frozen=True)
class Case:
    name: str
    hard: str
    """What is hard, in words."""
    right: str
    """The right answer."""
    run: Callable[[Bench], Iterator[Finding]]


class Bench:
    """What a case works with: its name, and a folder for generated files."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name, self.folder, self._made = name, folder, 0
        self._kept: dict[tuple[Scene, str, Variant], tuple[Hard, Compiled]] = {}

    def place(self) -> Path:
        self._made += 1
        return self.folder / f"{self.name.replace(' ', '_')}_{self._made}"

    def compiled(self, scene: Scene, row: str, variant: Variant) -> tuple[Hard, Compiled]:
        """One function of a scene and its problem; made once."""
        key = (scene, row, variant)
        if key not in self._kept:
            problem = Hard(scene, row)
            (made,) = compile_variant(problem.system, (problem.output,), variant, self.place())
            self._kept[key] = problem, made
        return self._kept[key]

    def finding(
        self, what: str, variant: str, figure: float, allowed: float | None, note: str = "", unit: str = ""
    ) -> Finding:
        return Finding(self.name, what, variant, figure, allowed, note, unit)

    def accurate(
        self, scene: Scene, row: str, states: States, what: str = "", *, units: float = UNITS, plans: bool = False,
        variants: Sequence[Variant] = (Variant(), Variant("float")), refusing: str = "",
    ) -> Iterator[Finding]:  # fmt: skip
        """The chosen plan has a small error in every variant, relative to the condition of the problem. With
        ``plans`` the others are shown. ``refusing``: a precision in which NaN is right too."""
        problem = Hard(scene, row)
        jobs = [(variant, units) for variant in variants]
        jobs += [(Variant(family=family), None) for family in problem.families] if plans else []  # type: ignore[misc]
        for variant, allowed in jobs:
            for compiled in compile_variant(problem.system, (problem.output,), variant, self.place()):
                yield self.judged(problem, compiled, states, what or row, allowed, refusing)

    def judged(
        self, problem: Hard, compiled: Compiled, states: States, what: str, allowed: float | None, refusing: str = ""
    ) -> Finding:
        given = rounded(states, compiled.variant.precision)
        refused = np.isnan(compiled.call(given)).all(axis=1) & (compiled.variant.precision == refusing)
        if refused.all():
            return self.finding(what, f"{compiled.variant.name}, {compiled.plan}", 0.0, allowed, "NaN")
        given = picked(given, np.flatnonzero(~refused))
        high, low = problem.reference.over(given)
        found = judge(compiled, problem.datum, given, high, low)
        error = float(np.max(found.errors, initial=0.0))
        note = f"NaN at {refused.sum()} of {refused.size} states" if refused.any() else ""
        note += f"; {found.wrong} of {len(high)} states with a wrong kind of answer" if found.wrong else ""
        figure = np.inf if found.wrong else found.units
        line = self.finding(
            what, f"{compiled.variant.name}, {compiled.plan}", figure, allowed, note.removeprefix("; "), "units"
        )
        return replace(line, error=error, condition=found.condition)

    def none(self, scene: Scene, row: str, states: States, what: str, precision: str = "double") -> Iterator[Finding]:
        """Where the mass matrix is singular to the precision there is no answer: NaN, with each plan."""
        options = replace(scene.options, precision=precision)
        problem = Hard(with_hash(replace(scene, options=options)), row)
        kept = [family for family in problem.families if not family.merged and family.regrouped]
        families: list[Family | None] = [*kept] or [None]
        for family in families:
            for compiled in compile_variant(
                problem.system, (problem.output,), Variant(precision, family=family), self.place()
            ):
                found = compiled.call(rounded(states, precision))
                answers = int(np.sum(np.isfinite(found).any(axis=1)))
                size = float(np.max(np.abs(found[np.isfinite(found)]), initial=0.0))
                said = "NaN" if not answers else f"numbers up to {size:.0e}"
                yield self.finding(what, f"{precision}, {compiled.plan}", float(answers), 0.0, said)

    def loaded(self, scene: Scene, *rows: str, **options: Any) -> Any:
        """Compiled functions of a scene."""
        outputs = tuple(Output(row, (row,)) for row in rows)
        asked = replace(scene, outputs=outputs, options=replace(scene.options, targets=("c",), **options))
        return generate(with_hash(asked), self.place()).load()

    def refused(self, what: str, make: Callable[[], object], words: str) -> Finding:
        """A scene without an answer is refused, in one line that says why."""
        try:
            make()
        except SymgenError as error:
            said = str(error)
            return self.finding(what, "", 0.0 if words in said and "\n" not in said else 1.0, 0.0, said)
        return self.finding(what, "", 1.0, 0.0, "was not refused")


class Hard:
    """A function of a scene with its reference."""

    def __init__(self, scene: Scene, row: str) -> None:
        self.system: System = derive(with_hash(replace(scene, outputs=(Output(row, (row,)),))))
        self.output = self.system.output(row)

    @cached_property
    def reference(self) -> Reference:
        return Reference(self.system.program(self.output.name))

    @cached_property
    def datum(self) -> Any:
        return as_given(self.system, self.output)

    @property
    def families(self) -> list[Family]:
        return plans_of(self.system, self.output)


def ran(case: Case) -> list[Finding]:
    """What a case finds; an error of symgen is a finding that failed."""
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(case.name, Path(folder))
        try:
            return list(case.run(bench))
        except SymgenError as error:
            return [bench.finding("the case itself", "", np.inf, 0.0, str(error))]


def states(**inputs: Sequence[Sequence[float]] | Array) -> dict[str, Array]:
    """Inputs by name, one state per row."""
    return {name: np.array(rows, dtype=float) for name, rows in inputs.items()}
