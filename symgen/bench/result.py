"""What a bench measured, as plain data and as text."""

from __future__ import annotations

import csv
import io
from dataclasses import asdict, dataclass, fields
from typing import Any

from symgen.bench.variant import OURS, Left
from symgen.show import table


@dataclass(frozen=True)
class FunctionFacts:
    """What is known of one of our functions before anything runs."""

    function: str
    plan: str
    flops: int
    sincos: int
    derive_ms: float
    """Deriving, choosing the plan and simplifying; certificate and printing not included."""
    floor: float | None
    """Instructions at least (see `symgen.bench.floor`); None where nothing was counted."""


@dataclass(frozen=True)
class Row:
    """One function by one program. Times and instructions are per state; None where there is nothing to measure."""

    peer: str
    function: str
    ns_min: float
    ns_median: float
    instructions: float | None
    """Instructions of one call, counted by callgrind."""
    operations: int | None
    """Additions, multiplications, divisions and roots in the code, where that is known."""
    text_bytes: int | None
    """Machine code of the function alone."""
    compile_s: float | None
    generate_s: float | None
    """CPU seconds that made the source; ours with its certificates."""
    error: float
    """Largest ‖x − x̂‖∞/‖x̂‖∞ over a few states against a fifty-digit evaluation (‖x − x̂‖∞ where x̂ is zero)."""


@dataclass(frozen=True)
class BenchResult:
    scene: str
    nq: int
    nv: int
    processor: str
    compiler: str
    flags: str
    counted_flags: str
    states: int
    rounds: int
    functions: tuple[FunctionFacts, ...]
    rows: tuple[Row, ...]
    left: tuple[Left, ...]
    """What was not measured, and why."""
    notes: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    @property
    def peers(self) -> list[str]:
        """Those that have a row, ours first."""
        return list(dict.fromkeys([OURS, *(row.peer for row in self.rows)]))

    def row(self, peer: str, function: str) -> Row | None:
        return next((row for row in self.rows if (row.peer, row.function) == (peer, function)), None)

    def to_csv(self) -> str:
        """One line a row, with the scene, ratios and the floor."""
        text = io.StringIO()
        names = [field.name for field in fields(Row)]
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["scene", "nv", *names, "ns_ratio", "instructions_ratio", "floor"])
        for row in self.rows:
            own = self.row(OURS, row.function)
            ratios = [
                _ratio(row.ns_min, own.ns_min if own else None),
                _ratio(row.instructions, own.instructions if own else None),
            ]
            floor = self.facts(row.function).floor if row.peer == OURS else None
            writer.writerow(
                [self.scene, self.nv, *(_plain(getattr(row, name)) for name in names), *map(_plain, [*ratios, floor])]
            )
        return text.getvalue()

    def facts(self, function: str) -> FunctionFacts:
        return next(facts for facts in self.functions if facts.function == function)

    def to_text(self) -> str:
        parts = [
            f"{self.scene}: nv = {self.nv}, {self.states} states, {self.rounds} rounds, one core",
            f"{self.processor}; {self.compiler} {self.flags}; counted with {self.counted_flags}",
            "",
            self.functions_table(),
            "",
            self.rows_table(),
        ]
        if len(self.peers) > 1:
            parts += ["", "instructions (× ours)", self.matrix("instructions")]
            parts += ["", "ns, minimum (× ours)", self.matrix("ns_min")]
        if self.left:
            parts += ["", "not measured:", *(f"- {_who(left)}: {left.why}" for left in self.left)]
        return "\n".join([*parts, "", *(f"- {note}" for note in self.notes)])

    def functions_table(self) -> str:
        rows = []
        for facts in self.functions:
            own = self.row(OURS, facts.function)
            counted = own.instructions if own else None
            rows.append(
                (
                    facts.function, facts.plan, facts.flops, facts.sincos, _number(facts.derive_ms, ".0f"),
                    _number(facts.floor, ".0f"), _number(counted, ".0f"), _number(_ratio(counted, facts.floor), ".2f"),
                )
            )  # fmt: skip
        header = ("function", "plan", "flops", "sincos", "derive ms", "floor", "instr.", "instr. / floor")
        return table(header, rows, right=range(2, 8))

    def rows_table(self) -> str:
        rows = []
        for facts in self.functions:
            own = self.row(OURS, facts.function)
            ns, instructions = (own.ns_min, own.instructions) if own else (None, None)
            for row in (row for row in self.rows if row.function == facts.function):
                rows.append(
                    (
                        row.function, row.peer, _number(row.ns_min, ".1f"), _number(row.ns_median, ".1f"),
                        _number(_ratio(row.ns_min, ns), ".2f"), _number(row.instructions, ".0f"),
                        _number(_ratio(row.instructions, instructions), ".2f"), _number(row.operations, "d"),
                        _number(row.text_bytes, "d"), _number(row.compile_s, ".2f"), _number(row.generate_s, ".3f"),
                        f"{row.error:.1e}",
                    )
                )  # fmt: skip
        header = (
            "function", "by", "ns min", "median", "× ours", "instr.", "× ours", "ops", "bytes", "compile s",
            "generate s", "max error",
        )  # fmt: skip
        return table(header, rows, right=range(2, 12))

    def matrix(self, what: str) -> str:
        """Functions down, peers across; each entry with its ratio to ours."""
        return table(("function", *self.peers), self._cells(what), right=range(1, len(self.peers) + 1))

    def markdown(self, what: str) -> str:
        """The same as a Markdown table."""
        lines = [("function", *self.peers), ("---", *["--:"] * len(self.peers)), *self._cells(what)]
        return "\n".join(f"| {' | '.join(line)} |" for line in lines)

    def _cells(self, what: str) -> list[list[str]]:
        rows = []
        for facts in self.functions:
            own = self.row(OURS, facts.function)
            if own is None:
                continue
            cells = [_cell(self.row(peer, facts.function), own, what) for peer in self.peers]
            if any(cell != "–" for cell in cells[1:]):
                rows.append([facts.function, *cells])
        return rows


def _cell(row: Row | None, own: Row, what: str) -> str:
    value = getattr(row, what) if row else None
    if value is None:
        return "–"
    ratio = _ratio(value, getattr(own, what))
    return f"{value:.0f}" if row is own or ratio is None else f"{value:.0f} ({ratio:.1f})"


def _who(left: Left) -> str:
    return f"{left.peer} {left.function}".strip()


def _ratio(x: float | None, y: float | None) -> float | None:
    return x / y if x is not None and y else None


def _number(x: float | None, form: str) -> str:
    return "–" if x is None else format(x, form)


def _plain(x: Any) -> Any:
    return "" if x is None else f"{x:.6g}" if isinstance(x, float) else x
