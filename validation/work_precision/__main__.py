"""``python -m symgen.validation.work_precision SCENE … [-o DIR] [--full] [--json]``; `make work-precision`.

CPU time against error of the generated steps and of SciPy's solvers on generated functions, beside Pinocchio and
Exudyn; the orders of the steps; their energy over long runs. Ends with status 1 where a step has not the order that it
states.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from symgen.errors import SceneError, SymgenError
from symgen.scene.document import clean
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.validation.work_precision.data import FULL, QUICK, precision_data
from symgen.validation.work_precision.written import summary, write

NAMED = "examples"
"""Folder in which a scene may be called by its name alone."""

LONGEST = 100.0
"""Seconds of motion at most."""


def found(name: str) -> Scene:
    """A scene by its path, or by the name of an example where there is a folder of them."""
    path = Path(name)
    example = Path(NAMED, f"{name}.scene.yaml")
    return load(example if not path.exists() and example.exists() else path)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(
        prog="symgen.validation.work_precision", description=(__doc__ or "").split("\n\n")[1]
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="leave NAME.json, NAME.csv and NAME.html there"
    )
    parser.add_argument("--time", default=1.0, type=float, help="seconds of motion (1)")
    parser.add_argument("--full", action="store_true", help="all settings, least of three times: minutes a scene")
    parser.add_argument("--json", action="store_true", help="print a list of objects, one a scene")
    parser.add_argument("scenes", nargs="+", metavar="SCENE", help="a file, or the name of an example")
    options = parser.parse_args(arguments)
    documents = []
    try:
        if not (math.isfinite(options.time) and options.time > 0.0):
            raise SceneError("the time must be positive", "--time")
        if options.time > LONGEST:
            raise SceneError(f"at most {LONGEST:g} s: over longer times errors only grow", "--time")
        for name in options.scenes:
            data = precision_data(found(name), _say, seconds=options.time, effort=FULL if options.full else QUICK)
            _say("")
            documents.append(data)
            if options.output is not None:
                write(options.output, data)
            if not options.json:
                print("\n".join(summary(data)), flush=True)
    except SymgenError as error:
        print(f"symgen: {error}", file=sys.stderr)
        return error.exit_status
    except OSError as error:
        print(f"symgen: {clean(str(options.output), 300)}: {error.strerror or error}", file=sys.stderr)
        return 2
    if options.json:
        print(json.dumps(documents, indent=1))
    return 0 if all(row["holds"] for data in documents for row in data["orders"]) else 1


def _say(what: str) -> None:
    """On a terminal, what is being run."""
    if sys.stderr.isatty():
        print(f"\r\033[K{what}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
