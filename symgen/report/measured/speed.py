"""Speed against error: a figure per function, the programs worth having, and every row behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from symgen.bench.frontier import TIE
from symgen.bench.result import BenchResult, Row
from symgen.bench.variant import OURS, STRIPPED, USUAL, is_ours
from symgen.program.rounding import UNITS
from symgen.report import words
from symgen.report.scatter import Dot, Level, Stairs, scatter, shape_mark
from symgen.report.svg import tag
from symgen.report.tables import Table, scientific
from symgen.report.words import counted, listed, minus

LOOKS: dict[str, tuple[int, str]] = {
    "pinocchio": (1, "diamond"),
    "pinocchio-cppadcg": (3, "diamond"),
    "pinocchio-casadi": (4, "triangle"),
    "mujoco": (2, "drop"),
    "adam": (6, "square"),
    "sympy-kane": (1, "cross"),
}
"""Peer → colour and shape."""
UNKNOWN = (6, "cross")
PLAN = "plan: "
LEVELS = (
    Level(UNITS["double"], "u of double, 1.1 × 10⁻¹⁶"),
    Level(UNITS["float"], "u of float, 6.0 × 10⁻⁸"),
)


def values(data: Mapping[str, Any]) -> dict[str, object]:
    """``data``: what `symgen.bench.BenchResult.to_json` gave."""
    result = BenchResult.from_json(data)
    return {
        "scene": result.scene,
        "lead": lead(result),
        "figures": [figure_of(result, facts.function) for facts in result.functions if result.of(facts.function)],
        "legend": legend(result),
        "frontier": frontier_table(result),
        "rows": rows_table(result),
        "functions": functions_table(result),
        "matrices": [matrix(result, *what) for what in MATRICES if matrix_wanted(result, what[0])],
        "left": left_table(result),
        "notes": list(result.notes),
        "machine": machine(result),
    }


def short(name: str) -> str:
    """What a program is called beside its dot."""
    text = name.removeprefix(f"{OURS} ").removeprefix(PLAN)
    return text.replace("parallel axes merged", "merged").replace("inertia as given", "as given")


def rank(row: Row) -> int:
    """Who gets a label first."""
    if row.peer in USUAL:
        return 0
    if not row.own:
        return 1
    return 3 if PLAN in row.peer else 2


def figure_of(result: BenchResult, function: str) -> dict[str, object]:
    """The figure of a function: every program a dot, the frontiers as stairs."""
    kept = {row.peer for row, _, _ in result.frontier(function)}
    rows = sorted((row for row in result.of(function)), key=rank)
    dots = [dot_of(row, row.peer in kept) for row in rows]
    stairs = [
        Stairs(steps, dashed=batch)
        for batch in (False, True)
        if (steps := stairs_of([row for row, _, _ in result.frontier(function) if row.batch == batch]))
    ]
    title = f"Time against error of {function}, {counted(len(dots), 'program')}"
    drawing = scatter(dots, title, "nanoseconds a state, median", "largest error, relative", LEVELS, stairs)
    return {"function": function, "drawing": drawing}


def dot_of(row: Row, kept: bool) -> Dot:
    style, shape = (0, "square" if row.batch else "circle") if row.own else LOOKS.get(row.peer, UNKNOWN)
    label = row.peer if row.peer == OURS or not row.own else short(row.peer)
    told = f"{row.peer}: {row.ns_median:.1f} ns, error {scientific(row.error)}"
    if row.units is not None:
        told += f", {row.units:.1f} units"
    strong = kept or row.peer == OURS
    return Dot(row.ns_median, row.error, label, told, style, shape, row.own and row.peer not in USUAL, strong)


def stairs_of(rows: Sequence[Row]) -> tuple[tuple[float, float], ...]:
    """Corners of the least error within a time, fastest first."""
    corners: list[tuple[float, float]] = []
    for row in rows:
        if not corners or row.error < corners[-1][1]:
            corners.append((row.ns_median, row.error))
    return tuple(corners)


def legend(result: BenchResult) -> list[tuple[str, Markup]]:
    """(text, mark) of what the figures show."""
    found = [(f"{OURS}, one state a call", key(0, "circle"))]
    if any(row.own and row.peer not in USUAL for row in result.rows):
        found.append((f"{OURS} in another form: hollow", key(0, "circle", hollow=True)))
    if any(row.batch for row in result.rows):
        found.append((f"{OURS}, {result.states} states a call", key(0, "square")))
    found += [(peer, key(*LOOKS.get(peer, UNKNOWN))) for peer in result.peers if not is_ours(peer)]
    found.append(("least error within a time", tag("path", class_="stairs", d="M0 6H26")))
    if any(row.batch for row in result.rows):
        found.append(("the same among batches", tag("path", class_="stairs dashed", d="M0 6H26")))
    return found


def key(style: int, shape: str, hollow: bool = False) -> Markup:
    return shape_mark(shape, f"{'ring' if hollow else 'mark'} s{style}", 13.0, 6.0, 4.6)


def lead(result: BenchResult) -> str:
    """The main figures in a sentence or two."""
    ratios: dict[str, float] = {}
    units = [row.units for row in result.rows if row.peer == OURS and row.units is not None]
    for facts in result.functions:
        own = result.row(OURS, facts.function)
        other = result.fastest_other(facts.function)
        if own and other:
            ratios[facts.function] = other.ns_median / own.ns_median
    text = f"{counted(len(result.rows), 'row').capitalize()}: {counted(len(result.programs), 'program')} for "
    text += f"{counted(len(result.functions), 'function')}, timed in turn in one process."
    if ratios:
        text += f" The fastest other program takes {span(ratios)} times the time of {OURS}, one state a call."
    if units:
        text += f" The error of {OURS} is at most {max(units):.1f} units of u · max(1, κ)."
    return text


def span(ratios: Mapping[str, float]) -> str:
    """Least and most, and of what."""
    least, most = (end(ratios, key=lambda function: ratios[function]) for end in (min, max))
    if f"{ratios[least]:.1f}" == f"{ratios[most]:.1f}":
        return f"{ratios[least]:.1f}"
    return f"{ratios[least]:.1f} ({least}) to {ratios[most]:.1f} ({most})"


def _grouped(
    lines: Sequence[tuple[str, tuple[str, ...]]],
) -> tuple[tuple[tuple[str, ...], ...], tuple[tuple[str, int], ...]]:
    """Rows and group headings of (function, cells)."""
    heads: dict[str, int] = {}
    for at, (function, _) in enumerate(lines):
        heads.setdefault(function, at)
    return tuple(cells for _, cells in lines), tuple(heads.items())


def number(x: float | None, form: str = ".0f") -> str:
    return "–" if x is None else minus(format(x, form))


def thousands(x: float | None) -> str:
    return "–" if x is None else words.thousands(x)


def ratio(x: float | None, y: float | None) -> str:
    return "–" if x is None or not y else f"{x / y:.2f}"


def frontier_table(result: BenchResult) -> Table:
    lines: list[tuple[str, tuple[str, ...]]] = []
    for facts in result.functions:
        own = result.row(OURS, facts.function)
        for row, standing, beside in result.frontier(facts.function):
            tie = f"within the noise of {beside.peer}" if standing.verdict == TIE and beside else ""
            lines.append(
                (
                    facts.function,
                    (
                        row.peer, str(result.states) if row.batch else "1", number(row.ns_median, ".1f"),
                        ratio(row.ns_median, own.ns_median if own else None), scientific(row.error),
                        scientific(row.error_median), number(row.units, ".1f"), tie,
                    ),
                )
            )  # fmt: skip
    rows, groups = _grouped(lines)
    header = ("program", "states a call", "ns a state", "× symgen", "max error", "median error", "units", "")
    return Table("Programs worth having", header, rows, frozenset(range(1, 7)), groups)


def rows_table(result: BenchResult) -> Table:
    lines: list[tuple[str, tuple[str, ...]]] = []
    for facts in result.functions:
        own = result.row(OURS, facts.function)
        for row in sorted(result.of(facts.function), key=lambda row: row.ns_median):
            lines.append(
                (
                    facts.function,
                    (
                        row.peer, number(row.ns_median, ".1f"), ratio(row.ns_median, own.ns_median if own else None),
                        number(row.ns_min, ".1f"), thousands(row.instructions),
                        ratio(row.instructions, own.instructions if own else None), thousands(row.operations),
                        thousands(row.text_bytes), number(row.compile_s, ".2f"), number(row.generate_s, ".3f"),
                        scientific(row.error), scientific(row.error_median), number(row.units, ".1f"),
                    ),
                )
            )  # fmt: skip
    rows, groups = _grouped(lines)
    header = (
        "program", "ns, median", "× symgen", "ns, least", "instructions", "× symgen", "operations", "bytes",
        "compile s", "generate s", "max error", "median error", "units",
    )  # fmt: skip
    return Table("Every program, fastest first", header, rows, frozenset(range(1, 13)), groups)


def functions_table(result: BenchResult) -> Table:
    rows = []
    for facts in result.functions:
        own = result.row(OURS, facts.function)
        needed = own.instructions if own else None
        rows.append(
            (
                facts.function, facts.plan, thousands(facts.flops), str(facts.sincos), thousands(facts.floor),
                thousands(needed), ratio(needed, facts.floor),
            )
        )  # fmt: skip
    header = ("function", "plan", "flops", "sincos", "floor", "instructions", "instructions ÷ floor")
    caption = "The functions of symgen; the floor is what straight-line code needs at least"
    if STRIPPED in result.notes:
        caption += "; counted without springs and dampers, which peers lack, so fewer flops than elsewhere on this page"
    return Table(caption, header, tuple(rows), frozenset(range(2, 7)))


MATRICES = (
    ("instructions", "Instructions a state (times symgen's)"),
    ("ns_median", "Nanoseconds a state, median (times symgen's)"),
)


def matrix_wanted(result: BenchResult, what: str) -> bool:
    return len(result.peers) > 1 and any(getattr(row, what) is not None for row in result.rows)


def matrix(result: BenchResult, what: str, caption: str) -> Table:
    """Functions down, programs across, our further forms left out."""
    rows = []
    for facts in result.functions:
        own = result.row(OURS, facts.function)
        cells = [_cell(result.row(peer, facts.function), own, what) for peer in result.peers]
        if own is not None:
            rows.append((facts.function, *cells))
    names = [broken(peer if peer == OURS else peer.removeprefix(f"{OURS} ")) for peer in result.peers]
    return Table(caption, ("function", *names), tuple(rows), frozenset(range(1, len(names) + 1)))


def broken(name: str) -> Markup:
    """A long name that may break at its hyphen."""
    return Markup("-<br/>").join(name.split("-"))


def _cell(row: Row | None, own: Row | None, what: str) -> str | Markup:
    value = getattr(row, what) if row else None
    if value is None or row is None:
        return "–"
    text = thousands(value) if value >= 100 else number(value, ".1f" if what != "instructions" else ".0f")
    base = getattr(own, what) if own else None
    if row is own:
        return Markup("<strong>{}</strong>").format(text)
    return f"{text} ({value / base:.1f})" if base else text


def left_table(result: BenchResult) -> Table:
    """One line for what has one reason."""
    lines: dict[tuple[str, str], list[str]] = {}
    for row in result.left:
        lines.setdefault((row.peer, row.why), []).append(row.function)
    every = len(result.functions)
    rows = tuple(
        (peer, "all" if "" in names or len(names) == every > 1 else ", ".join(names), why)
        for (peer, why), names in lines.items()
    )
    return Table("Left out", ("program", "function", "why"), rows)


def machine(result: BenchResult) -> list[tuple[str, str]]:
    made = [f"{peer}: {version}" for peer, version in result.versions.items()]
    facts = [
        ("processor", result.processor),
        ("compiler", f"{result.compiler} {result.flags}"),
        ("instructions counted with", result.counted_flags),
        ("timed", f"{result.rounds} rounds over {result.states} states"),
        ("errors", f"{result.error_states} states, {result.reference}"),
    ]
    return [*facts, *([("peers", listed(made))] if made else [])]
