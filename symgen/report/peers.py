"""The page of the peers: how many times symgen's instructions and time other programs take, over all scenes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symgen.bench.frontier import NOISE, SAMPLED
from symgen.bench.result import BenchResult, Row
from symgen.bench.variant import OURS, is_ours
from symgen.report.measured.speed import LOOKS, UNKNOWN, broken, left_table, number, thousands
from symgen.report.shell import ALONE, Place, page
from symgen.report.strips import Strip, strips
from symgen.report.tables import Table, scientific
from symgen.report.words import counted

SECTIONS = (
    ("glance", "At a glance"),
    ("losses", "Where others are ahead"),
    ("ratios", "Every function"),
    ("errors", "Errors"),
    ("versions", "What was measured"),
)


@dataclass(frozen=True)
class Pair:
    """One function of a scene by a peer and by us, one state a call."""

    scene: str
    function: str
    peer: str
    theirs: Row
    ours: Row

    @property
    def time(self) -> float:
        return self.theirs.ns_median / self.ours.ns_median

    @property
    def instructions(self) -> float | None:
        if self.theirs.instructions is None or not self.ours.instructions:
            return None
        return self.theirs.instructions / self.ours.instructions

    @property
    def error(self) -> float | None:
        """None where one of the two is exact."""
        return self.theirs.error / self.ours.error if self.ours.error > 0 and self.theirs.error > 0 else None


def peers_page(results: Sequence[Mapping[str, Any]], place: Place = ALONE) -> str:
    """The page. ``results``: what `BenchResult.to_json` gave of each scene."""
    found = sorted((BenchResult.from_json(data) for data in results), key=lambda result: (result.nv, result.scene))
    pairs = [pair for result in found for pair in pairs_of(result)]
    peers = [peer for peer in LOOKS if any(pair.peer == peer for pair in pairs)]
    peers += [peer for peer in dict.fromkeys(pair.peer for pair in pairs) if peer not in LOOKS]
    values = {
        "lead": lead(found, pairs, peers),
        "glance": glance(pairs, peers),
        "times": strip_plot(pairs, peers, lambda pair: pair.time, "time", "times the nanoseconds of symgen"),
        "counts": strip_plot(
            pairs, peers, lambda pair: pair.instructions, "instructions", "times the instructions of symgen"
        ),
        "losses": losses(pairs),
        "finer": finer(pairs),
        "tables": [
            ratio_table(found, pairs, peers, lambda pair: pair.instructions, "Instructions, times symgen's"),
            ratio_table(found, pairs, peers, lambda pair: pair.time, "Nanoseconds (median), times symgen's"),
        ],
        "errors": error_table(found, peers),
        "versions": versions(found),
        "left": left(found),
    }
    return page("report/peers.html.j2", "Beside other programs", SECTIONS, place, it=values)


def pairs_of(result: BenchResult) -> list[Pair]:
    found = []
    for row in result.rows:
        own = result.row(OURS, row.function)
        if own is not None and not row.own and own.precision == row.precision:
            found.append(Pair(result.scene, row.function, row.peer, row, own))
    return found


def lead(results: Sequence[BenchResult], pairs: Sequence[Pair], peers: Sequence[str]) -> str:
    if not pairs:
        return "No other program was measured beside symgen."
    slower = [pair for pair in pairs if pair.time < 1 / (1 + NOISE)]
    more = [pair for pair in pairs if pair.instructions is not None and pair.instructions < 1]
    text = f"{counted(len(results), 'scene').capitalize()}, {counted(len(peers), 'other program')}, "
    text += f"{counted(len(pairs), 'comparison')} in double precision, one state a call. "
    text += f"symgen is slower in {how_many(slower)}"
    return f"{text}, and needs more instructions in {how_many(more)}."


def how_many(pairs: Sequence[Pair]) -> str:
    return counted(len(pairs), "of them", "of them") if pairs else "none"


def spread(values: Sequence[float]) -> tuple[str, str]:
    """The geometric mean, and least and most."""
    if not values:
        return "–", "–"
    mean = math.exp(sum(map(math.log, values)) / len(values))
    return f"{mean:.2f}", f"{min(values):.2f} … {max(values):.2f}"


def glance(pairs: Sequence[Pair], peers: Sequence[str]) -> Table:
    """Per peer: ratios over all comparisons."""
    rows = []
    for peer in peers:
        own = [pair for pair in pairs if pair.peer == peer]
        instructions = [x for pair in own if (x := pair.instructions) is not None]
        errors = [x for pair in own if (x := pair.error) is not None]
        cells = [*spread(instructions), *spread([pair.time for pair in own]), *spread(errors)]
        rows.append((peer, str(len(own)), *cells))
    header = (
        "program", "functions", "instructions", "least … most", "time", "least … most", "max error", "least … most",
    )  # fmt: skip
    caption = "Times symgen's, geometric mean over scenes and functions"
    return Table(caption, header, tuple(rows), frozenset(range(1, 8)))


def strip_plot(
    pairs: Sequence[Pair], peers: Sequence[str], what: Callable[[Pair], float | None], name: str, label: str
) -> Any:
    rows = []
    for peer in peers:
        dots = tuple(
            (x, f"{pair.scene}, {pair.function}: {x:.2f} times")
            for pair in pairs
            if pair.peer == peer and (x := what(pair)) is not None
        )
        style, shape = LOOKS.get(peer, UNKNOWN)
        if dots:
            rows.append(Strip(peer, dots, style, shape))
    return strips(rows, f"Ratios of {name} to symgen's, by program", label)


def losses(pairs: Sequence[Pair]) -> Table:
    """Where another program takes less time, beyond noise, or fewer instructions."""
    rows = []
    for pair in pairs:
        if pair.time < 1 / (1 + NOISE):
            told = (number(pair.ours.ns_median, ".1f"), number(pair.theirs.ns_median, ".1f"), f"{pair.time:.2f}")
            rows.append((pair.scene, pair.function, pair.peer, "ns", *told))
        if pair.instructions is not None and pair.instructions < 1:
            counts = (thousands(pair.ours.instructions), thousands(pair.theirs.instructions))
            rows.append((pair.scene, pair.function, pair.peer, "instructions", *counts, f"{pair.instructions:.2f}"))
    header = ("scene", "function", "program", "of", "symgen", "the other", "ratio")
    return Table("Faster than symgen, or of fewer instructions", header, tuple(rows), frozenset({4, 5, 6}))


def finer(pairs: Sequence[Pair]) -> Table:
    """Where another program is more exact beyond what other states would give."""
    rows = [
        (
            pair.scene, pair.function, pair.peer, scientific(pair.ours.error), scientific(pair.theirs.error),
            number(pair.ours.units, ".1f"), number(pair.theirs.units, ".1f"), f"{pair.time:.2f}",
        )
        for pair in pairs
        if pair.theirs.error * (1 + SAMPLED) < pair.ours.error
    ]  # fmt: skip
    header = ("scene", "function", "program", "error of symgen", "of the other", "units", "units", "time ÷ symgen's")
    return Table("More exact than symgen, largest error", header, tuple(rows), frozenset(range(3, 8)))


def _by_scene(
    results: Sequence[BenchResult], cells: Callable[[BenchResult, str], tuple[Any, ...] | None]
) -> tuple[tuple[tuple[Any, ...], ...], tuple[tuple[str, int], ...]]:
    """Rows of functions, grouped by scene."""
    rows: list[tuple[Any, ...]] = []
    groups = []
    for result in results:
        lines = [(facts.function, line) for facts in result.functions if (line := cells(result, facts.function))]
        if lines:
            groups.append((f"{result.scene} ({counted(result.nv, 'velocity', 'velocities')})", len(rows)))
            rows += [(function, *line) for function, line in lines]
    return tuple(rows), tuple(groups)


def ratio_table(
    results: Sequence[BenchResult], pairs: Sequence[Pair], peers: Sequence[str],
    what: Callable[[Pair], float | None], caption: str,
) -> Table:  # fmt: skip
    known = {(pair.scene, pair.function, pair.peer): what(pair) for pair in pairs}

    def cells(result: BenchResult, function: str) -> tuple[str, ...] | None:
        found = [known.get((result.scene, function, peer)) for peer in peers]
        return None if all(x is None for x in found) else tuple("–" if x is None else f"{x:.2f}" for x in found)

    rows, groups = _by_scene(results, cells)
    return Table(caption, ("function", *map(broken, peers)), rows, frozenset(range(1, 1 + len(peers))), groups)


def error_table(results: Sequence[BenchResult], peers: Sequence[str]) -> Table:
    """Largest errors, with their units."""

    def cells(result: BenchResult, function: str) -> tuple[str, ...] | None:
        rows = [result.row(name, function) for name in (OURS, *peers)]
        return tuple(_error(row) for row in rows) if rows[0] and any(rows[1:]) else None

    rows, groups = _by_scene(results, cells)
    header = ("function", OURS, *map(broken, peers))
    caption = "Largest relative error, and in units of u · max(1, κ)"
    return Table(caption, header, rows, frozenset(range(1, 2 + len(peers))), groups)


def _error(row: Row | None) -> str:
    if row is None:
        return "–"
    return scientific(row.error) + (f" ({row.units:.1f})" if row.units is not None else "")


def versions(results: Sequence[BenchResult]) -> Table:
    """What the peers are made with, on what it was measured; one line for what is the same in several scenes."""
    lines: dict[tuple[str, str], list[str]] = {}
    for result in results:
        for peer, version in result.versions.items():
            if is_ours(peer):
                continue
            lines.setdefault((peer, version), []).append(result.scene)
        flags = f"{result.compiler} {result.flags}"
        for what, text in (("processor", result.processor), ("compiler", flags)):
            lines.setdefault((what, text), []).append(result.scene)
    rows = tuple(
        (what, text, "all scenes" if len(names) == len(results) else ", ".join(names))
        for (what, text), names in sorted(lines.items())
    )
    return Table("Versions and the machine", ("what", "version", "of"), rows)


def left(results: Sequence[BenchResult]) -> Table:
    """What was asked of other programs and not measured."""
    lines: dict[tuple[str, str, str], list[str]] = {}
    for result in results:
        for peer, functions, why in left_table(result).rows:
            if not is_ours(peer):
                lines.setdefault((peer, functions, why), []).append(result.scene)
    rows = tuple((peer, functions, why, ", ".join(names)) for (peer, functions, why), names in lines.items())
    return Table("Left out", ("program", "function", "why", "scenes"), rows)
