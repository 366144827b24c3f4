"""Instructions of one call, counted by valgrind's callgrind: repeatable whatever else the machine does."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from symgen.errors import ToolError

FLAGS = ("-O3", "-ffp-contract=fast", "-fno-math-errno")
"""The release flags without ``-march=native``, which may emit what valgrind does not know."""


def available() -> bool:
    return shutil.which("valgrind") is not None


def _array(values: Sequence[float]) -> str:
    return "{" + ", ".join(float(x).hex() for x in np.ravel(values)) + "}"


def _call(function: Mapping[str, Any], states: Sequence[Mapping[str, Any]]) -> list[str]:
    """The C block that calls one function at every state; scalars are those of the first state."""
    lines = ["{"]
    arguments = []
    for port in function["inputs"]:
        name = port["name"]
        if port["shape"]:
            rows = ", ".join(_array(state[name]) for state in states)
            lines.append(f"static const double {name}[{len(states)}][{prod(port['shape'])}] = {{{rows}}};")
            arguments.append(f"{name}[k]")
        else:
            arguments.append(float(states[0][name]).hex())
    for port in function["outputs"]:
        size = 1
        for n in port["shape"]:
            size *= n
        lines.append(f"static double {port['name']}_out[{size}];")
        arguments.append(f"{port['name']}_out")
    lines.append(f"for (int k = 0; k < {len(states)}; ++k) {function['symbol']}({', '.join(arguments)});")
    return [*lines, "}"]


def count_instructions(
    directory: Path, manifest: Mapping[str, Any], states: Sequence[Mapping[str, Any]], cc: str
) -> dict[str, float]:
    """Mean instructions per call over the states, by function name. Double precision functions only.

    Raises ToolError when the driver does not compile or valgrind fails.
    """
    functions = [function for function in manifest["functions"] if function["precision"] == "double"]
    driver = ["#include <stdlib.h>", *(f'#include "{header}"' for header in manifest["headers"])]
    driver += ["int main(int argc, char **argv) {", "switch (argc > 1 ? atoi(argv[1]) : -1) {"]
    for index, function in enumerate(functions):
        driver += [f"case {index}:", *_call(function, states), "break;"]
    driver += ["default: return 1;", "}", "return 0; }"]
    with tempfile.TemporaryDirectory() as scratch:
        source, binary = Path(scratch, "driver.c"), str(Path(scratch, "driver"))
        source.write_text("\n".join(driver) + "\n")
        sources = [str(directory / name) for name in manifest["sources"]]
        built = _run([cc, "-std=c99", *FLAGS, f"-I{directory}", "-o", binary, str(source), *sources, "-lm"])
        if built.returncode:
            raise ToolError(f"the callgrind driver does not compile: {built.stderr.strip().splitlines()[0]}")
        counts = {}
        for index, function in enumerate(functions):
            options = ["--tool=callgrind", "--callgrind-out-file=/dev/null", f"--toggle-collect={function['symbol']}"]
            ran = _run(["valgrind", *options, binary, str(index)])
            found = re.search(r"Collected : (\d+)", ran.stderr)
            if ran.returncode or found is None:
                raise ToolError(f"valgrind could not run {function['symbol']}")
            counts[function["name"]] = int(found.group(1)) / len(states)
        return counts


def _run(command: Sequence[str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False)
