"""What a bench measured, as plain data and as text."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from symgen.bench.frontier import TIE, Standing, order, standings
from symgen.bench.variant import OURS, PRINTED, USUAL, Left, is_ours
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
    """Largest ‖x − x̂‖∞/‖x̂‖∞ over the states (‖x − x̂‖∞ where x̂ is zero)."""
    error_median: float
    """The median of the same."""
    units: float | None
    """The largest error in units of u · max(1, κ), u half a unit in the last place of its precision and κ the condition
    of the problem at that state; None where the condition was not computed."""
    precision: str = "double"
    plan: str = ""
    """How it computes, for ours."""
    own: bool = False
    """Whether it is symgen's, in whatever form (see `symgen.bench.variant.is_ours`)."""
    batch: bool = False
    """Whether one call does all states."""


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
    error_states: int
    """States that errors are taken over."""
    reference: str
    """What they are taken against: ``ball arithmetic`` or ``fifty digits``."""
    functions: tuple[FunctionFacts, ...]
    rows: tuple[Row, ...]
    left: tuple[Left, ...]
    """What was not measured, and why."""
    notes: tuple[str, ...]
    versions: Mapping[str, str] = field(default_factory=dict)
    """Peer → the version of what it is made with."""

    def to_json(self) -> dict[str, Any]:
        """Everything as plain data, and ``frontier``: function → rows worth having, fastest first."""
        named = {
            facts.function: [
                {"peer": row.peer, "standing": standing.verdict} for row, standing, _ in self.frontier(facts.function)
            ]
            for facts in self.functions
        }
        return {**asdict(self), "versions": dict(self.versions), "frontier": named}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> BenchResult:
        """What ``to_json`` gave, again."""
        own = {name: data[name] for name in (f.name for f in fields(cls))}
        lists = {
            "functions": tuple(FunctionFacts(**row) for row in data["functions"]),
            "rows": tuple(Row(**{**row, "own": is_ours(row["peer"])}) for row in data["rows"]),
            "left": tuple(Left(**row) for row in data["left"]),
            "notes": tuple(data["notes"]),
        }
        return cls(**{**own, **lists})

    @property
    def programs(self) -> list[str]:
        """All that have a row, ours first."""
        return list(dict.fromkeys([OURS, *(row.peer for row in self.rows)]))

    @property
    def peers(self) -> list[str]:
        """Those that tables have a column of: the same without our further forms."""
        forms = {row.peer for row in self.rows if row.own and row.peer not in (*USUAL, PRINTED)}
        return [name for name in self.programs if name not in forms]

    def of(self, function: str) -> list[Row]:
        """The rows of a function."""
        return [row for row in self.rows if row.function == function]

    def frontier(self, function: str) -> list[tuple[Row, Standing, Row | None]]:
        """The rows that nothing beats (see `symgen.bench.frontier`), fastest first: those that do one state a call,
        then batches, which are held against one another. With a tie what it ties with."""
        found = []
        for batch in (False, True):
            rows = [row for row in self.of(function) if row.batch == batch]
            verdicts = standings(rows)
            beside = [None if standing.by is None else rows[standing.by] for standing in verdicts]
            found += [(rows[k], verdicts[k], beside[k]) for k in order(rows)]
        return found

    def fastest_other(self, function: str) -> Row | None:
        """The peer of the least median time; None where there is none."""
        others = [row for row in self.of(function) if not row.own]
        return min(others, key=lambda row: row.ns_median, default=None)

    def row(self, peer: str, function: str) -> Row | None:
        return next((row for row in self.rows if (row.peer, row.function) == (peer, function)), None)

    def to_csv(self) -> str:
        """One line a row, with the scene, ratios and the floor."""
        text = io.StringIO()
        names = [field.name for field in fields(Row)]
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["scene", "nv", *names, "ns_ratio", "instructions_ratio", "floor", "standing"])
        verdicts = {
            (row.peer, row.function): standing.verdict
            for facts in self.functions
            for row, standing, _ in self.frontier(facts.function)
        }
        for row in self.rows:
            own = self.row(OURS, row.function)
            ratios = [
                _ratio(row.ns_min, own.ns_min if own else None),
                _ratio(row.instructions, own.instructions if own else None),
            ]
            floor = self.facts(row.function).floor if row.peer == OURS else None
            cells = [*(_plain(getattr(row, name)) for name in names), *map(_plain, [*ratios, floor])]
            writer.writerow([self.scene, self.nv, *cells, verdicts.get((row.peer, row.function), "")])
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
            "",
            "worth having: nothing for as many states a call is faster without being less exact; only noise keeps what "
            "has a star",
            self.frontier_table(),
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
            for row in self.of(facts.function):
                rows.append(
                    (
                        row.function, row.peer, _number(row.ns_min, ".1f"), _number(row.ns_median, ".1f"),
                        _number(_ratio(row.ns_min, ns), ".2f"), _number(row.instructions, ".0f"),
                        _number(_ratio(row.instructions, instructions), ".2f"), _number(row.operations, "d"),
                        _number(row.text_bytes, "d"), _number(row.compile_s, ".2f"), _number(row.generate_s, ".3f"),
                        f"{row.error:.1e}", f"{row.error_median:.1e}", _number(row.units, ".1f"),
                    )
                )  # fmt: skip
        header = (
            "function", "by", "ns min", "median", "× ours", "instr.", "× ours", "ops", "bytes", "compile s",
            "generate s", "max error", "median", "units",
        )  # fmt: skip
        return table(header, rows, right=range(2, 14))

    def frontier_table(self) -> str:
        """Per function the programs that nothing beats, fastest first."""
        return table(FRONTIER, self._frontier_cells(), right=range(2, 8))

    def frontier_markdown(self) -> str:
        """The same as a Markdown table."""
        rules = ["---", "---", *["--:"] * 6]
        return "\n".join(f"| {' | '.join(line)} |" for line in (FRONTIER, rules, *self._frontier_cells()))

    def _frontier_cells(self) -> list[list[str]]:
        lines = []
        for facts in self.functions:
            own = self.row(OURS, facts.function)
            for row, standing, _ in self.frontier(facts.function):
                star = " *" if standing.verdict == TIE else ""
                ratio = _ratio(row.ns_median, own.ns_median if own else None)
                lines.append(
                    [
                        facts.function, row.peer + star, str(self.states if row.batch else 1),
                        f"{row.ns_median:.1f}", _number(ratio, ".2f"), f"{row.error:.1e}",
                        f"{row.error_median:.1e}", _number(row.units, ".1f"),
                    ]
                )  # fmt: skip
        return lines

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


FRONTIER = ("function", "by", "states a call", "ns median", "× ours", "max error", "median", "units")


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
