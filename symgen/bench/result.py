"""What a bench measured, as plain data and as text."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from symgen.show import table


@dataclass(frozen=True)
class FunctionRow:
    """One generated function. Times are per state, in a batch; None where there is nothing to measure."""

    function: str
    plan: str
    flops: int
    sincos: int
    derive_ms: float
    """Deriving, choosing the plan and simplifying; certificate and printing not included."""
    ns_min: float | None
    ns_median: float | None
    instructions: float | None
    """Instructions of one call, counted by callgrind."""
    error: float
    """Largest ‖x − x̂‖∞/‖x̂‖∞ over the sampled states against a fifty-digit evaluation (‖x − x̂‖∞ where x̂ is zero)."""


@dataclass(frozen=True)
class PeerRow:
    peer: str
    function: str
    ns_min: float
    ns_median: float


EMPTY_CALL = "empty call"
"""The peer row that measures the cost of calling the peer at all."""


@dataclass(frozen=True)
class BenchResult:
    scene: str
    processor: str
    compiler: str
    flags: str
    states: int
    repeats: int
    generate_s: float
    """Derive, certify, print and write everything."""
    compile_s: float
    functions: tuple[FunctionRow, ...]
    peers: tuple[PeerRow, ...]
    notes: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    def to_text(self) -> str:
        def value(x: float | None, form: str) -> str:
            return "–" if x is None else format(x, form)

        rows = [
            (
                row.function, row.plan, row.flops, row.sincos, f"{row.derive_ms:.1f}", value(row.ns_min, ".1f"),
                value(row.ns_median, ".1f"), value(row.instructions, ".0f"), f"{row.error:.1e}",
            )
            for row in self.functions
        ]  # fmt: skip
        header = ("function", "plan", "flops", "sincos", "derive ms", "ns min", "median", "instr.", "max error")
        parts = [
            f"{self.scene}: {self.states} states a batch, {self.repeats} interleaved repeats, one core",
            f"{self.processor}; {self.compiler} {self.flags}",
            f"derive, certify, print, write: {self.generate_s:.2f} s; compile: {self.compile_s:.2f} s",
            "",
            table(header, rows, right=range(2, 9)),
        ]
        if self.peers:
            parts += ["", self._peer_table()]
        return "\n".join([*parts, *(["", *(f"- {note}" for note in self.notes)] if self.notes else [])])

    def _peer_table(self) -> str:
        """Peers and their ratios to ours, as measured and with the cost of an empty call taken off."""
        ours = {row.function: row.ns_min for row in self.functions}
        calls = {row.peer: row.ns_min for row in self.peers if row.function == EMPTY_CALL}
        rows = []
        for peer in self.peers:
            own = ours.get(peer.function)
            net = peer.ns_min - calls.get(peer.peer, 0.0)
            ratios = (f"{peer.ns_min / own:.1f}", f"{net / own:.1f}") if own else ("–", "–")
            rows.append((peer.peer, peer.function, f"{peer.ns_min:.0f}", f"{peer.ns_median:.0f}", *ratios))
        header = ("peer", "function", "ns min", "median", "peer / ours", "without its call")
        return table(header, rows, right=range(2, 6))
