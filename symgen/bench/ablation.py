"""What each transformation saves: operations, instructions and rounding error with one of them switched off.

Only the bench builds such programs: they are compared with the certified ones as numbers, and never written out.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from symgen.algebra.linear import Mat, Vec, matmul
from symgen.artifact.compiler import cache_folder
from symgen.bench.driver import build_driver
from symgen.bench.measure import CONDITION, INVERTED, TOLERANCE, Say, Settings, condition_number, pose
from symgen.bench.multiprecision import exact_outputs, relative_error
from symgen.bench.variant import Array, Problem, Unit, Variant, split
from symgen.bench.workshop import Workshop, open_workshop
from symgen.generate import target_info
from symgen.plans import build as building
from symgen.plans import inertia, links, recursive
from symgen.plans.build import build
from symgen.plans.families import FAMILIES, Family
from symgen.program import passes
from symgen.program.instructions import Program, count
from symgen.scene.model import Scene
from symgen.show import table
from symgen.system import derive
from symgen.targets.c import emit_c

ERROR_STATES = 24
GROWTH = 4.0
"""Rounding error may grow by so much over the plain recursion."""
NOISE = 1e-15
"""Errors below this are not compared: a few roundings either way."""
CHOSEN, PLAIN = "as chosen", "plain recursion"


@dataclass(frozen=True)
class Switch:
    """One transformation switched off."""

    name: str
    family: Callable[[Family], Family] = lambda family: family
    patch: Callable[[], Any] | None = None
    """A context in which the program is derived."""
    trigonometry: str = ""
    flags: tuple[str, ...] = ()
    """For the compiler, where it is about the C alone."""
    applies: Callable[[Family, str], bool] = lambda family, function: True


def _turned_axes(axes_with_z: Callable[[Vec], Mat]) -> Callable[[Vec], Mat]:
    """Link axes turned about the joint's axis by an angle that makes no zeros; not those of balls and free bodies,
    whose coordinates are about the body's own axes."""
    three, four = Fraction(3, 5), Fraction(4, 5)
    turn: Mat = ((three, -four, 0), (four, three, 0), (0, 0, 1))
    return lambda axis: axes_with_z(axis) if axis is links.Z else matmul(axes_with_z(axis), turn)


@contextmanager
def _patched(module: Any, name: str, value: Any) -> Iterator[None]:
    with mock.patch.object(module, name, value):
        yield


@contextmanager
def _plainly() -> Iterator[None]:
    """The recursion of the textbook: nothing shared, turned or moved that need not be."""
    with ExitStack() as stack:
        stack.enter_context(_patched(recursive, "_axis_column", lambda at, parent: None))
        stack.enter_context(_patched(building, "output_lags", lambda output: False))
        stack.enter_context(_patched(inertia, "_tip", lambda *_: 0))
        yield


SWITCHES: tuple[Switch, ...] = (
    Switch(CHOSEN),
    Switch(
        "inertia as given (no base parameters)",
        family=lambda family: replace(family, regrouped=False), applies=lambda family, _: family.regrouped,
    ),
    Switch(
        "parallel axes not merged",
        family=lambda family: replace(family, merged=False), applies=lambda family, _: family.merged,
    ),
    Switch(
        "the other solve: articulated bodies for LᵀDL or back",
        family=lambda family: replace(family, articulated=not family.articulated),
        applies=lambda family, function: function == "forward_dynamics",
    ),
    Switch(
        "the other derivatives: differentiated for analytic or back",
        family=lambda family: replace(family, differentiated=not family.differentiated),
        applies=lambda family, function: function.endswith("_derivatives"),
    ),
    Switch(
        "origins where the joints are (not slid)",
        patch=lambda: _patched(links, "_slide_origins", lambda found: found),
    ),
    Switch(
        "link axes not aligned (turned about the joint)",
        patch=lambda: _patched(links, "axes_with_z", _turned_axes(links.axes_with_z)),
    ),
    Switch(
        "angular acceleration turned (not from a column of U)",
        patch=lambda: _patched(recursive, "_axis_column", lambda at, parent: None),
    ),
    Switch("last links turn their axes", patch=lambda: _patched(building, "output_lags", lambda output: False)),
    Switch("first moments stay (no point masses)", patch=lambda: _patched(inertia, "_tip", lambda *_: 0)),
    Switch("no common factors", patch=lambda: _patched(passes, "common_factor", lambda program: program)),
    Switch("sine and cosine by libm", trigonometry="libm"),
    Switch("no fused multiply-adds", flags=("-ffp-contract=off",)),
    Switch(PLAIN, family=lambda family: replace(family, regrouped=False, merged=False), patch=_plainly),
)  # fmt: skip


@dataclass(frozen=True)
class AblationRow:
    function: str
    switched_off: str
    plan: str
    flops: int
    instructions: float | None
    error: float
    """Largest relative error over `ERROR_STATES` states."""
    agrees: bool
    """The numbers are those of the certified function."""


@dataclass(frozen=True)
class Ablation:
    scene: str
    rows: tuple[AblationRow, ...]

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    def base(self, function: str, name: str = CHOSEN) -> AblationRow | None:
        return next((row for row in self.rows if (row.function, row.switched_off) == (function, name)), None)

    def growth(self, function: str) -> float | None:
        """Rounding error of the chosen plan over that of the plain recursion; None where there is none, 1 at most where
        both are a few roundings."""
        chosen, plain = self.base(function), self.base(function, PLAIN)
        return None if chosen is None or plain is None else _growth(chosen, plain)

    def _times_plain(self, row: AblationRow) -> str:
        plain = self.base(row.function, PLAIN)
        return "–" if plain is None else f"{_growth(row, plain):.1f}"

    @property
    def passed(self) -> bool:
        """Every form gives the same function, and rounding error grows by no more than `GROWTH`."""
        growths = [self.growth(row.function) for row in self.rows]
        return all(row.agrees for row in self.rows) and all(x is None or x <= GROWTH for x in growths)

    def to_text(self) -> str:
        lines = []
        for row in self.rows:
            base = self.base(row.function)
            assert base is not None
            counted = row.instructions is not None and base.instructions is not None
            lines.append(
                (
                    row.function, row.switched_off, row.flops, _percent(row.flops, base.flops),
                    f"{row.instructions:.0f}" if row.instructions is not None else "–",
                    _percent(row.instructions or 0, base.instructions or 0) if counted else "–",
                    f"{row.error:.1e}", self._times_plain(row), "" if row.agrees else "DIFFERENT NUMBERS",
                )
            )  # fmt: skip
        header = ("function", "switched off", "flops", "", "instr.", "", "max error", "× plain", "")
        parts = [
            f"{self.scene}: one transformation switched off at a time",
            "",
            table(header, lines, right=range(2, 8)),
        ]
        without = [switch.name for switch in SWITCHES if switch.name not in {row.switched_off for row in self.rows}]
        if without:
            parts += ["", f"changes nothing here: {'; '.join(without)}"]
        growths = {row.function: self.growth(row.function) for row in self.rows}
        told = ", ".join(f"{name} {x:.1f}" for name, x in growths.items() if x is not None)
        return "\n".join(
            [*parts, "", f"rounding error over that of the plain recursion (at most {GROWTH:.0f}): {told}"]
        )


def _growth(row: AblationRow, plain: AblationRow) -> float:
    return max(row.error, NOISE) / max(plain.error, NOISE)


def _percent(value: float, base: float) -> str:
    return f"{100 * (value / base - 1):+.0f} %" if base else "–"


def ablation(scene: Scene, settings: Settings, say: Say = lambda what: None) -> Ablation:
    """Every function of the scene with each transformation switched off in turn. ToolError without a C compiler."""
    with ExitStack() as stack:
        scratch = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder = (settings.folder or scratch).resolve() / f"{scene.name}-ablation"
        folder.mkdir(parents=True, exist_ok=True)
        kept = settings.folder / "compiled" if settings.folder else cache_folder() / "bench"
        workshop = open_workshop(kept, settings.limit_s, say)
        problem, _ = pose(scene, replace(settings, states=max(ERROR_STATES, settings.states)), folder)
        programs = [
            (name, switch, program)
            for name in problem.programs
            for switch in SWITCHES
            if (program := ablated(problem, name, switch)) is not None
        ]
        say("compiling")
        return measured(problem, workshop, programs, scratch, say, settings.counting)


def family_of(problem: Problem, name: str) -> Family | None:
    """The family that the function's program was built by; None where its plan is literal or not of a family."""
    output, plan = problem.system.output(name), problem.programs[name].plan
    families = [replace(family, merged=merged) for merged in (False, True) for family in FAMILIES if not family.literal]
    return next((family for family in families if family.plan(output) == plan), None)


def ablated(problem: Problem, name: str, switch: Switch) -> Program | None:
    """The program of a function with one transformation switched off; None where that changes nothing of it."""
    family = family_of(problem, name)
    if switch.name == CHOSEN:
        return problem.programs[name]
    if family is None or not switch.applies(family, name):
        return None
    with switch.patch() if switch.patch else ExitStack():
        system = derive(problem.scene)  # a fresh one: what is derived is kept in it
        program = build(system.lowered, system.natural, system.output(name), switch.family(family))
    same = program.instructions == problem.programs[name].instructions
    in_c = bool(switch.trigonometry or switch.flags)
    return None if same and not in_c and switch.name != PLAIN else program


def measured(
    problem: Problem,
    workshop: Workshop,
    programs: Sequence[tuple[str, Switch, Program]],
    scratch: Path,
    say: Say,
    counting: bool,
) -> Ablation:
    """Compile, compare and count them."""
    variants = [variant_of(problem, k, name, program, switch) for k, (name, switch, program) in enumerate(programs)]
    driver = build_driver(workshop, variants, len(problem.states), problem.folder / "driver")
    values = driver.values(scratch)
    say("counting instructions")
    counts = driver.instructions(range(len(variants)), scratch) if counting else {}
    few = problem.states[:ERROR_STATES]
    condition = condition_number(problem, few[:3])
    exact = {name: [_exact(program, state) for state in few] for name, program in problem.programs.items()}
    rows = []
    for k, (name, switch, program) in enumerate(programs):
        error = _error(values[k], exact[name], problem.shapes(name))
        bound = TOLERANCE + (CONDITION * condition if name in INVERTED else 0.0)
        rows.append(
            AblationRow(name, switch.name, program.plan, count(program).flops, counts.get(k), error, error <= bound)
        )
    return Ablation(problem.scene.name, tuple(rows))


def _exact(program: Program, state: Any) -> list[Any]:
    found = exact_outputs(program, {port.name: np.ravel(state[port.name]).tolist() for port in program.inputs})
    return list(found.values())


def _error(values: Array, exact: Sequence[Any], sizes: Sequence[int]) -> float:
    return max(
        relative_error(got.tolist(), truth)
        for flat, outputs in zip(values, exact, strict=False)
        for got, truth in zip(split(flat, sizes), outputs, strict=True)
    )


def variant_of(problem: Problem, number: int, name: str, program: Program, switch: Switch) -> Variant:
    """A program as C, under a name of its own."""
    info = target_info(problem.system)
    if switch.trigonometry:
        info = replace(info, options=replace(info.options, trigonometry=switch.trigonometry))
    emitted = emit_c(f"form{number}", [program], info)
    headers = tuple((file, text) for file, text in emitted.files.items() if file.endswith(".h"))
    units = tuple(
        Unit(Path(file).stem, emitted.files[file], flags=switch.flags, headers=headers) for file in emitted.sources
    )
    symbol, sizes = f"form{number}_{program.name}", problem.shapes(name)
    starts = np.cumsum([0, *sizes])[:-1]
    inputs = [port.name for port in program.inputs]
    pointers = ", ".join(["const double *"] * len(inputs) + ["double *"] * len(sizes))
    call = ", ".join([*(f"{{{key}}}" for key in inputs), *(f"{{out}} + {start}" for start in starts)])
    arrays = {key: problem.column(key)[0] if key == "p" else problem.column(key) for key in inputs}
    return Variant(
        switch.name, name, f"void {symbol}({pointers});", f"{symbol}({call});", arrays, sum(sizes),
        lambda flat, state: split(flat, sizes), units,
    )  # fmt: skip
