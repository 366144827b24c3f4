"""A scene in a few numbers, for the table over all scenes."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from markupsafe import Markup

from symgen.bench.result import BenchResult
from symgen.bench.variant import OURS
from symgen.report.tables import Table, scientific
from symgen.report.words import thousands
from symgen.system import System
from symgen.validation.result import ValidationResult


@dataclass(frozen=True)
class Glance:
    """One number of a scene."""

    text: str
    section: str
    """Where on the scene's page it comes from."""
    short: str = ""
    """Its name on a card; empty: it does not stand there."""
    note: str = ""
    """What it is of, for who points at it."""

    def to_json(self) -> dict[str, str]:
        return asdict(self)


@dataclass(frozen=True)
class Subject:
    system: System
    manifest: Mapping[str, Any] | None
    validation: ValidationResult | None
    data: Mapping[str, Any]
    """Measurement → its data."""


def _freedom(subject: Subject) -> Glance | None:
    """Of closed loops those of the open tree are told, as such."""
    tree = subject.system.tree
    text = f"{tree.nv} (open tree)" if tree.cut_joints else str(tree.nv)
    return Glance(text, "natural", "degrees of freedom")


def _functions(subject: Subject) -> Glance | None:
    if not subject.manifest:
        return None
    return Glance(str(len(subject.manifest["functions"])), "certificates", "functions")


def _flops(operations: Mapping[str, int]) -> int:
    return sum(operations.get(kind, 0) for kind in ("add", "mul", "div", "sqrt"))


def _operations(subject: Subject) -> Glance | None:
    """Of forward dynamics where the scene has it, as what simulations call; else of the largest function."""
    rows = subject.manifest["functions"] if subject.manifest else []
    counted = {row["name"]: _flops(row["operations"]) for row in rows}
    if not counted:
        return None
    name = "forward_dynamics" if "forward_dynamics" in counted else max(counted, key=lambda n: counted[n])
    return Glance(thousands(counted[name]), "operations", "", name)


def _simulators(subject: Subject) -> Glance | None:
    """The largest difference to a simulator at the same state."""
    rows = [
        row
        for row in (subject.validation.rows if subject.validation else ())
        if row.check == "same state" and row.source.startswith(("Pinocchio", "Exudyn", "MuJoCo"))
    ]
    if not rows:
        return None
    worst = max(rows, key=lambda row: row.value if row.value == row.value else float("inf"))
    return Glance(scientific(worst.value), "validation", "", f"{worst.quantity}, {worst.source}")


def _rounding(subject: Subject) -> Glance | None:
    """The largest error of the functions as they are emitted, in double, that was sampled or found by a search."""
    rows = subject.data.get("rounding", {}).get("rows", [])
    errors = {
        row["function"]: (max(row["largest"], row["sought"] or 0.0), row["backward"])
        for row in reversed(rows)
        if row["chosen"] and row["variant"] == "double"
    }
    if not errors:
        return None
    name = max(errors, key=lambda function: errors[function][0])
    error, units = errors[name]
    return Glance(scientific(error), "rounding", "", f"{name}, {units:.2g} units of the problem's condition")


def _one_call(subject: Subject) -> list[Mapping[str, Any]]:
    """What was timed of forward dynamics, one state a call in double."""
    rows = subject.data.get("speed", {}).get("rows", [])
    return [
        row
        for row in rows
        if row["function"] == "forward_dynamics" and row["precision"] == "double" and not row["batch"]
    ]


def _digits(value: float, digits: int) -> str:
    """A positive number to so many digits, never as a power of ten."""
    before = len(str(int(value))) if value >= 1.0 else 0
    return thousands(value, max(digits - before, 0))


def _time(subject: Subject) -> Glance | None:
    ours = [row for row in _one_call(subject) if row["peer"] == OURS]
    if not ours:
        return None
    return Glance(
        f"{_digits(ours[0]['ns_median'], 3)} ns", "speed", "forward dynamics", f"forward_dynamics, {ours[0]['plan']}"
    )


def _peers(subject: Subject) -> Glance | None:
    """The fastest other program, as a multiple of our time."""
    if not _one_call(subject):
        return None
    result, function = BenchResult.from_json(subject.data["speed"]), "forward_dynamics"
    ours, best = result.row(OURS, function), result.fastest_other(function)
    if ours is None or best is None:
        return None
    return Glance(f"{_digits(best.ns_median / ours.ns_median, 2)}×", "speed", "", f"{function} by {best.peer}")


Column = Callable[[Subject], Glance | None]
COLUMNS: dict[str, tuple[str, Column]] = {
    "freedom": ("degrees of freedom", _freedom),
    "functions": ("functions", _functions),
    "operations": ("operations", _operations),
    "rounding": ("largest rounding error", _rounding),
    "simulators": ("largest difference to a simulator", _simulators),
    "time": ("time of a call", _time),
    "peers": ("fastest other program", _peers),
}
"""Column → its heading, and its number of a scene."""


def glances(
    system: System, manifest: Mapping[str, Any] | None, validation: ValidationResult | None, data: Mapping[str, Any]
) -> dict[str, Glance]:
    """The numbers that there are of a scene, by column."""
    subject = Subject(system, manifest, validation, data)
    found = {}
    for name, (_, column) in COLUMNS.items():
        with contextlib.suppress(LookupError, TypeError, ValueError):  # data of another form: a dash
            found[name] = column(subject)
    return {name: glance for name, glance in found.items() if glance is not None}


def glance_table(scenes: list[tuple[str, str, str, Mapping[str, Glance]]]) -> Table:
    """``scenes``: (name, address of its page, verdict, numbers)."""
    present = [name for name in COLUMNS if any(name in numbers for _, _, _, numbers in scenes)]
    rows = []
    for name, address, verdict, numbers in scenes:
        linked = Markup('<a href="{}">{}</a>').format(address, name) if address else Markup("{}").format(name)
        rows.append((linked, *(_cell(address, numbers.get(column)) for column in present), verdict))
    header = ("scene", *(COLUMNS[column][0] for column in present), "verdict")
    numeric = frozenset(range(1, len(present) + 1))
    caption = f"Every scene in a row, each number with a link to where it comes from; {_of(present)}"
    return Table(caption, header, tuple(rows), numeric)


def _of(present: list[str]) -> str:
    """What the columns that name no function are of."""
    counted = "operations of forward_dynamics where a scene has it, else of its longest function"
    timed = "; time of one call of it in double, and the fastest other program as a multiple of that"
    return counted + (timed if "time" in present else "")


def _cell(address: str, glance: Glance | None) -> Markup:
    if glance is None:
        return Markup("–")
    if not address:
        return Markup("{}").format(glance.text)
    note = Markup(' title="{}"').format(glance.note) if glance.note else Markup("")
    return Markup('<a href="{}#{}"{}>{}</a>').format(address, glance.section, note, glance.text)
