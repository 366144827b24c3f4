"""What the page shows of a validation: the checks, the motion, and the error against step size."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from symgen.report import tables, words
from symgen.report.plots import SERIES, Series, line_plot, loglog_plot, mark
from symgen.report.svg import tag
from symgen.validation.result import Refinement, Trajectory, ValidationResult

MAX_PANELS = 24


def validation_values(result: ValidationResult | None, refusal: str, units: Sequence[str]) -> dict[str, object]:
    """Values of the template ``sections/validation``. ``units``: of the entries of q."""
    empty: dict[str, object] = {
        "validation": None,
        "skipped": None,
        "panels": [],
        "refinement": "",
        "refinement_legend": [],
    }
    if result is None or not (result.rows or result.skipped):
        note = refusal or "This page was made without a validation; `symgen validate SCENE --report` makes one with it."
        return {**empty, "validation_note": note.replace("`", ""), "validation_words": ""}
    values: dict[str, object] = {
        **empty,
        "validation": tables.validation(result),
        "skipped": tables.skipped(result),
        "validation_note": "",
        "validation_words": _words(result),
    }
    if result.trajectory is not None:
        values |= _plots(result.trajectory, units)
    return values


def _words(result: ValidationResult) -> str:
    peers = words.listed([name.capitalize() for name in result.against])
    against = f"against {peers}, " if result.against else ""
    text = f"The generated C was compared {against}with finite differences, closed forms and first integrals"
    states = f", at {result.states} random states where states are compared." if result.rows else "."
    failed = len(result.failures())
    if not result.rows:
        return f"{text}{states} Nothing could be checked."
    verdict = "All checks passed." if result.passed else f"{failed} of {len(result.rows)} checks failed."
    return f"{text}{states} {verdict}"


def _plots(trajectory: Trajectory, units: Sequence[str]) -> dict[str, object]:
    panels = []
    for k, name in list(enumerate(trajectory.coordinates))[:MAX_PANELS]:
        values = tuple(row[k] for row in trajectory.q)
        curve = Series(name, trajectory.times, values, style=k % SERIES)
        unit = units[k] if k < len(units) and units[k] != "1" else ""
        panels.append(line_plot([curve], f"{name} over time", "time, s", name, unit))
    if trajectory.energy:
        first = trajectory.energy[0]
        drift = Series("energy", trajectory.times, tuple(e - first for e in trajectory.energy), style=0)
        panels.append(
            line_plot([drift], "Change of the total energy over time", "time, s", "change of total energy", "J")
        )
    refinements = trajectory.refinements
    series = [Series(r.formulation, r.steps, r.errors, marks=True, style=k) for k, r in enumerate(refinements)]
    chart = loglog_plot(
        series, "Error against step size, logarithmic", "step, s", "error", [r.expected_order for r in refinements]
    )
    legend = [(_legend(r), _key(k)) for k, r in enumerate(refinements)]
    return {"panels": panels, "refinement": chart, "refinement_legend": legend}


def _legend(refinement: Refinement) -> str:
    order = f"{refinement.order:.2f}" if refinement.order == refinement.order else "not observable"
    left = tables.scientific(refinement.extrapolated)
    return (
        f"Exudyn {refinement.formulation}, {refinement.solver}: observed order {order} (expected "
        f"{refinement.expected_order}), extrapolated error {left}"
    )


def _key(style: int) -> Markup:
    name = f"s{style % SERIES}"
    return tag("path", class_=f"curve {name}", d="M0 6H26") + mark(style, 13.0, 6.0, name)
