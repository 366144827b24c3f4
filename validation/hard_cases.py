"""The hard cases in one command: python -m symgen.validation.hard_cases [--json] [NAME …]

Every case says what is right; a table says what was found, in double, in float and with each plan. Ends with status 1
when one fails, 2 when it cannot run.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from symgen.errors import SceneError, SymgenError, ToolError

if TYPE_CHECKING:
    from symgen.validation.hard.case import Case, Finding


def all_cases() -> tuple[Case, ...]:
    """Raises ToolError without python-flint or SciPy."""
    try:
        from symgen.validation.hard import configurations, masses, motions, places
    except ModuleNotFoundError as error:
        raise ToolError(f"{error.name} is not installed: pip install 'symgen[accuracy]'") from error

    return (*masses.CASES, *configurations.CASES, *places.CASES, *motions.CASES)


def picked(names: Sequence[str]) -> list[Case]:
    """Cases whose names contain one of ``names``; all without any. Raises SceneError where one names nothing."""
    cases = all_cases()
    for name in names:
        if not any(name in case.name for case in cases):
            raise SceneError(f"no hard case is called so; there are: {', '.join(case.name for case in cases)}", name)
    return [case for case in cases if not names or any(name in case.name for name in names)]


def table(case: Case, findings: Sequence[Finding]) -> str:
    """One case for people."""
    lines = [f"{case.name}: {case.right}"]
    for row in findings:
        allowed = "" if row.allowed is None else f"≤ {row.allowed:g}"
        verdict = "      " if row.allowed is None else "ok    " if row.passed else "FAILED"
        told = [f"error {row.error:.1e}, condition {row.condition:.1e}"] if row.error is not None else []
        told += [row.note] if row.note else []
        figure = f"{row.figure:9.2g} {allowed:8s} {row.unit}"
        lines.append(f"  {verdict} {row.what:44.90s} {row.variant:58.58s} {figure} {'; '.join(told)}")
    return "\n".join(line.rstrip() for line in lines)


def hard_data(say: Callable[[str], None] = lambda what: None) -> dict[str, Any]:
    """All cases and what was found, with the figures of the hard-case page, as plain data. Raises ToolError without
    python-flint, SciPy or a C compiler."""
    from symgen.validation.hard.case import ran
    from symgen.validation.hard.figures import figures

    found = []
    for case in all_cases():
        say(case.name)
        found.append((case, ran(case)))
    return {**as_data(found), "figures": figures(say)}


def as_data(found: Sequence[tuple[Case, Sequence[Finding]]]) -> dict[str, Any]:
    return {
        "passed": all(row.passed for _, findings in found for row in findings),
        "cases": [
            {
                "name": case.name, "hard": case.hard, "right": case.right,
                "findings": [row.to_json() for row in findings],
            }
            for case, findings in found
        ],
    }  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="symgen.validation.hard_cases", description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true", help="print a machine-readable result")
    parser.add_argument("names", nargs="*", metavar="NAME", help="cases whose name contains this; all without")
    asked = parser.parse_args(arguments)
    try:
        from symgen.validation.hard.case import ran

        found = []
        for case in picked(asked.names):
            findings = ran(case)
            found.append((case, findings))
            if not asked.json:
                print(table(case, findings), flush=True)
    except SymgenError as error:
        print(f"symgen: {error}", file=sys.stderr)
        return error.exit_status
    rows = [row for _, findings in found for row in findings]
    failed = [row for row in rows if not row.passed]
    if asked.json:
        print(json.dumps(as_data(found), indent=2, ensure_ascii=False, allow_nan=False))
    else:
        demanded = sum(row.allowed is not None for row in rows)
        print(f"{len(found)} hard cases, {demanded} findings, {len(failed)} failed; the rest is for comparison")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
