"""Benchmark problems with known answers: ``python -m symgen.validation.benchmarks [--json] [NAME …]``.

Prints the error reached, the drift of the energy and the CPU time of every problem beside what is published;
``--report FILE.html`` writes a page of them. Ends with status 1 where an error is above its bar.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from symgen.errors import SceneError, SymgenError
from symgen.scene.schema import did_you_mean
from symgen.simulate import benchmark_systems, benchmarks
from symgen.simulate.answers import Answer, Problem
from symgen.simulate.statements import STATEMENTS

PROBLEMS: tuple[Problem, ...] = (*benchmarks.PROBLEMS, *benchmark_systems.PROBLEMS)
NAMES = tuple(problem.__name__ for problem in PROBLEMS)


def answers(names: Sequence[str] = (), say: Callable[[str], None] = lambda text: None) -> Iterator[Answer]:
    """Every line of the problems named (their functions' names), or of all. ``say`` is told of every problem. Raises
    SceneError for a name that is none."""
    for name in names:
        if name not in NAMES:
            raise SceneError(f"no problem {name!r}{did_you_mean(name, NAMES)}", "NAME")
    return _answers(names, say)


def _answers(names: Sequence[str], say: Callable[[str], None]) -> Iterator[Answer]:
    for problem in PROBLEMS:
        if not names or problem.__name__ in names:
            say(problem.__name__.replace("_", " "))
            yield from problem()


def row_data(row: Answer) -> dict[str, Any]:
    """A line as JSON values: the problem's statement with it, None for a drift that says nothing."""
    statement = STATEMENTS[row.problem]
    drift = row.drift if math.isfinite(row.drift) else None
    error = row.error if math.isfinite(row.error) else None
    return {**asdict(row), "drift": drift, "error": error, "passed": bool(row.passed), "statement": asdict(statement)}


def benchmark_data(say: Callable[[str], None], *, names: Sequence[str] = ()) -> list[dict[str, Any]]:
    """All lines as plain data, for `symgen.report.benchmarks.benchmarks_page`; about 30 s of CPU time.

    Raises ToolError without SciPy or a C compiler."""
    return [row_data(row) for row in answers(names, say)]


def table(rows: Sequence[Answer]) -> str:
    """Columns for people."""
    head = ("problem", "quantity", "method", "error", "allowed", "against", "energy drift", "CPU s", "published")
    cells = [head]
    for row in rows:
        mark = "" if row.passed else "  FAILED"
        numbers = (
            f"{row.error:.1e}{mark}",
            f"{row.bar:.0e}",
            row.against,
            f"{row.drift:.1e}" if math.isfinite(row.drift) else "–",
            f"{row.cpu_seconds:.3g}",
        )
        cells.append((row.problem, row.quantity, row.method, *numbers, row.published))
    widths = [max(len(line[k]) for line in cells) for k in range(len(head))]
    return "\n".join("  ".join(x.ljust(w) for x, w in zip(line, widths, strict=True)).rstrip() for line in cells)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="symgen.validation.benchmarks", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print a list of objects")
    parser.add_argument("--report", metavar="FILE.html", help="write a page")
    parser.add_argument("names", nargs="*", metavar="NAME", help="of problems; all without")
    options = parser.parse_args(arguments)
    try:
        rows = list(answers(options.names, _say))
        _say("")
        data = [row_data(row) for row in rows]
        if options.report:
            from symgen.report.benchmarks import benchmarks_page
            from symgen.report.page import write_text
            from symgen.report.shell import ALONE

            write_text(Path(options.report), benchmarks_page(data, ALONE))
    except SymgenError as error:
        print(f"symgen: {error}", file=sys.stderr)
        return error.exit_status
    print(json.dumps(data, indent=2) if options.json else table(rows))
    return 0 if all(row.passed for row in rows) else 1


def _say(what: str) -> None:
    """On a terminal, what is being run."""
    if sys.stderr.isatty():
        print(f"\r\033[K{what}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
