"""Benchmark problems with known answers: ``python -m symgen.validation.benchmarks [--json] [NAME …]``.

Prints the error reached, the drift of the energy and the CPU time of every problem beside what is published. Ends with
status 1 where an error is above its bar.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict

from symgen.errors import SymgenError
from symgen.simulate import benchmark_systems, benchmarks
from symgen.simulate.answers import Answer, Problem

PROBLEMS: tuple[Problem, ...] = (*benchmarks.PROBLEMS, *benchmark_systems.PROBLEMS)


def answers(names: Sequence[str] = ()) -> Iterator[Answer]:
    """Every line of the problems named (their functions' names), or of all."""
    for problem in PROBLEMS:
        if not names or problem.__name__ in names:
            yield from problem()


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
            f"{row.drift:.1e}",
            f"{row.cpu_seconds:.3g}",
        )
        cells.append((row.problem, row.quantity, row.method, *numbers, row.published))
    widths = [max(len(line[k]) for line in cells) for k in range(len(head))]
    return "\n".join("  ".join(x.ljust(w) for x, w in zip(line, widths, strict=True)).rstrip() for line in cells)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="symgen.validation.benchmarks", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print a list of objects")
    parser.add_argument("names", nargs="*", choices=[[], *(x.__name__ for x in PROBLEMS)], metavar="NAME")
    options = parser.parse_args(arguments)
    try:
        rows = list(answers(options.names))
    except SymgenError as error:
        print(f"symgen: {error}", file=sys.stderr)
        return error.exit_status
    print(json.dumps([asdict(row) for row in rows], indent=2) if options.json else table(rows))
    return 0 if all(row.passed for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
