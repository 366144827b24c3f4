"""What is shown of `symgen.validation.work_precision`: diagrams, times to reach an error, orders, energy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from markupsafe import Markup

from symgen.report.measured.loglog import Frame, Line, key, loglog
from symgen.report.plots import power
from symgen.report.tables import Table, scientific
from symgen.report.words import listed, thousands
from symgen.validation.work_precision.energies import BOUNDED
from symgen.validation.work_precision.energies import verdict as said

STYLES = {
    "symgen (C)": 0,
    "symgen (SciPy)": 2,
    "Pinocchio ABA (SciPy)": 1,
    "Exudyn KinematicTree": 3,
    "Exudyn redundant": 6,
}
STEP_STYLES = {"semi_implicit_euler": 3, "rk4": 1, "lie": 4, "implicit_midpoint": 2, "variational": 0}
BARS = (1e-4, 1e-7, 1e-10)
SMALLEST = 1e-17
"""Errors of zero are drawn here."""
Points = Sequence[Mapping[str, Any]]


def values(data: Mapping[str, Any]) -> dict[str, object]:
    """What ``sections/precision.html.j2`` lays out."""
    points, reference = data["points"], data["reference"]
    lines = _lines(points, "error")
    frame = Frame(
        f"CPU time against error, {data['scene']}",
        "error of positions (m) and rotation matrices at the end; better to the right",
        "CPU time, s",
        backwards=True,
        zone=reference["uncertainty"],
    )
    energies = _lines(points, "energy")
    energy_frame = Frame(
        f"CPU time against change of energy, {data['scene']}",
        "relative change of the energy at the end; better to the right",
        "CPU time, s",
        backwards=True,
        height=380,
    )
    return {
        "seconds": f"{data['seconds']:g}",
        "reference": reference["method"],
        "uncertainty": scientific(reference["uncertainty"]),
        "checks": [(row["what"], scientific(row["difference"])) for row in reference["checks"]],
        "diagram": loglog(lines, frame),
        "legend": _legend(lines),
        "energy_diagram": loglog(energies, energy_frame) if data["energy_kept"] else "",
        "reached": _reached(points),
        "failed": _failed(points),
        "skipped": [(row["program"], row["reason"]) for row in data["skipped"]],
        "orders": _orders(data["orders"]),
        "order_diagram": _order_diagram(data["orders"]),
        "order_legend": [(row["method"], key(_step_line(row["method"], ()))) for row in data["orders"]],
        **_energy(data["energy"]),
    }


def _methods(points: Points) -> Iterable[tuple[str, str]]:
    return dict.fromkeys((p["program"], p["integrator"]) for p in points)


def _of(points: Points, program: str, integrator: str) -> list[Mapping[str, Any]]:
    return [p for p in points if (p["program"], p["integrator"]) == (program, integrator)]


def _lines(points: Points, what: str) -> list[Line]:
    """One a method; ``what``: "error" or "energy"."""
    found: list[Line] = []
    counts: dict[str, int] = {}
    for program, integrator in _methods(points):
        mine = [p for p in _of(points, program, integrator) if not p["failed"] and p[what] is not None]
        kind = counts[program] = counts.get(program, -1) + 1
        own = integrator.removeprefix("step:")
        kind = list(STEP_STYLES).index(own) if own in STEP_STYLES else kind
        places = tuple(
            (max(p[what], SMALLEST), p["cpu_seconds"], f"{program}, {integrator}: {_knob(p)}, {scientific(p[what])}, "
             f"{1e3 * p['cpu_seconds']:.3g} ms")
            for p in mine
        )  # fmt: skip
        if places:
            found.append(Line(f"{program}: {integrator}", places, STYLES.get(program, 4), kind))
    return found


def _knob(p: Mapping[str, Any]) -> str:
    return f"{p['setting']:g} steps" if p["knob"] == "steps" else f"rtol {p['setting']:g}"


def _legend(lines: Sequence[Line]) -> list[tuple[str, list[tuple[str, Markup]]]]:
    """(program, its integrators with their keys)."""
    groups: dict[str, list[tuple[str, Markup]]] = {}
    for line in lines:
        program, _, integrator = line.name.partition(": ")
        groups.setdefault(program, []).append((integrator, key(line)))
    return list(groups.items())


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.3g}"


def _reached(points: Points) -> Table:
    """Per method the least CPU time with an error up to each of `BARS`, and the least error of all."""
    rows: list[tuple[str, ...]] = []
    groups: list[tuple[str, int]] = []
    for program, integrator in _methods(points):
        mine = [p for p in _of(points, program, integrator) if not p["failed"]]
        cells = []
        for bar in BARS:
            good = [p["cpu_seconds"] for p in mine if p["error"] <= bar]
            cells.append(_milliseconds(min(good)) if good else "–")
        least = scientific(min(p["error"] for p in mine)) if mine else "–"
        if program not in [name for name, _ in groups]:
            groups.append((program, len(rows)))
        rows.append((integrator, *cells, least))
    header = ("integrator", *(f"ms to {power(round(math.log10(bar)))}" for bar in BARS), "least error")
    caption = "CPU time, ms, of the cheapest run whose error is at most …"
    return Table(caption, header, tuple(rows), frozenset({1, 2, 3, 4}), tuple(groups))


def _ended(reason: str) -> str:
    return reason.replace("left the numbers", "was no longer finite (infinity or NaN)")


def _failed(points: Points) -> Table | None:
    lost = [p for p in points if p["failed"]]
    if not lost:
        return None
    rows = tuple((p["program"], p["integrator"], _knob(p), _ended(p["failed"])) for p in lost)
    header = ("program", "integrator", "setting", "what happened")
    return Table("Points that are not in the diagram (errors from 0.1 on count as failed)", header, rows)


# --- orders ----------------------------------------------------------------------------------------------------------


def _orders(rows: Points) -> Table:
    cells = []
    for row in rows:
        observed = row["observed"]
        text = "exact to rounding" if observed is None and row["holds"] else "not observable"
        step, error = row["errors"][-1]
        verdict = Markup('<span class="{}">{}</span>').format(*(("pass", "✓") if row["holds"] else ("fail", "✗")))
        cells.append(
            (row["method"], str(row["stated"]), text if observed is None else f"{observed:.3f}", verdict,
             f"{step:.2g}", scientific(error))
        )  # fmt: skip
    header = ("step", "order stated", "observed", "", "shortest dt, s", "error there")
    return Table("Order of convergence of the generated steps, q and v", header, tuple(cells), frozenset({1, 2, 4, 5}))


def _step_line(method: str, points: tuple[tuple[float, float, str], ...], marks: bool = True) -> Line:
    kind = list(STEP_STYLES).index(method) if method in STEP_STYLES else 5
    return Line(method, points, STEP_STYLES.get(method, 6), kind, marks)


def _order_diagram(rows: Points) -> Markup:
    lines = [
        _step_line(
            row["method"], tuple((dt, error, f"{row['method']}: {scientific(error)}") for dt, error in row["errors"])
        )
        for row in rows
    ]
    return loglog(lines, Frame("Error against step", "step, s", "error of q and v", width=640, height=360))


# --- energy ----------------------------------------------------------------------------------------------------------


def _energy(data: Mapping[str, Any]) -> dict[str, object]:
    if "reason" in data:
        return {
            "energy_reason": data["reason"],
            "long_run": "",
            "long_table": None,
            "long_legend": [],
            "long_words": "",
        }
    lines = [
        _step_line(
            row["method"],
            tuple((t, max(e, SMALLEST), "") for t, e in zip(row["times"], row["largest"], strict=True)),
            False,
        )
        for row in data["lines"]
    ]
    less = f", here without {listed(data['without'])}" if data["without"] else ""
    words = f"{thousands(data['steps'])} steps of {data['dt']:.3g} s from the same start{less}"
    frame = Frame(
        "Largest change of energy so far", "time, s", "largest relative change of the energy so far", height=380
    )
    return {
        "energy_reason": "",
        "long_run": loglog(lines, frame),
        "long_table": _long_table(data["lines"]),
        "long_legend": [(line.name, key(line)) for line in lines],
        "long_words": words,
    }


_RUN = ("first", "last", "growth")


def _times(growth: float) -> str:
    return f"{growth:.2f}" if growth < 100 else scientific(growth)


def _long_table(rows: Points) -> Table:
    cells = []
    for row in rows:
        numbers = tuple("–" if x is None else scientific(x) for x in (row["first"], row["last"]))
        growth = "–" if row["failed"] or row["growth"] is None else _times(row["growth"])
        verdict = _ended(row["failed"]) or said(*(math.inf if row[key] is None else row[key] for key in _RUN))
        style = "pass" if verdict == BOUNDED else "fail"
        cells.append((row["method"], *numbers, growth, Markup('<span class="{}">{}</span>').format(style, verdict),
                      f"{row['cpu_seconds']:.3g}"))  # fmt: skip
    header = ("step", "first tenth", "the rest", "growth", "", "CPU s")
    caption = (
        "Largest relative change of the energy in the first tenth of the run and in the rest; growth of its median"
    )
    return Table(caption, header, tuple(cells), frozenset({1, 2, 3, 5}))
