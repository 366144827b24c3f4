"""Batches against the scalar functions, one core, states in the cache: nanoseconds a state and ratios, from one run.

    python tools/batches.py [SCENE] [--outputs mass_matrix,inverse_dynamics] [--states 256] [--precision float]
        [--widest 32] [--threads]

Scalar calls, `_batch` (states one after the other) and `_soa` (columns on 64-byte boundaries) take turns; minima are
shown. Flags are the release flags. ``--widest``: bytes of the widest vectors; ``--threads``: with OpenMP, whose threads
OMP_NUM_THREADS says (with so many states that every thread has its part).
"""

from __future__ import annotations

import argparse
import ctypes
import json
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from symgen.artifact.compiler import RELEASE_FLAGS, find_compiler, shared_library
from symgen.bench.measure import sample_states
from symgen.generate import generate_files
from symgen.scene.load import load
from symgen.scene.model import Output
from symgen.system import derive
from symgen.targets.c.signatures import SHARED

ROOT = Path(__file__).resolve().parent.parent
OUTPUTS = "mass_matrix,inverse_dynamics,forward_dynamics"
REPEATS = 8
"""Passes over the states between two looks at the clock."""
PAD = 8
"""Numbers between two columns: no stride is a power of two."""
FORMS = ("scalar", "batch", "soa")


def driver(manifest: Mapping[str, Any]) -> str:
    """C with ``time_FUNCTION_FORM(repeats, n, stride, arrays…)``."""
    lines = [f'#include "{header}"' for header in manifest["headers"]] + ["#include <stddef.h>"]
    for row in manifest["functions"]:
        ports = [*row["inputs"], *row["outputs"]]
        arrays = ", ".join(f"{row['precision']} *x{k}" for k in range(len(ports)))
        shared = [port["name"] in SHARED for port in ports]
        given = [f"x{k}" if port["shape"] or k >= len(row["inputs"]) else f"x{k}[0]" for k, port in enumerate(ports)]
        each = [g if s else f"{g} + {prod(p['shape'])}u * i" for g, s, p in zip(given, shared, ports, strict=True)]
        calls = {
            "scalar": f"for (size_t i = 0; i < n; ++i) (void){row['symbol']}({', '.join(each)});",
            "batch": f"(void){row['batch_symbol']}(n, {', '.join(given)});",
            "soa": f"(void){row['soa_symbol']}(n, stride, {', '.join(given)});",
        }
        for form in FORMS:
            lines += [
                f"void time_{row['name']}_{form}(size_t repeats, size_t n, size_t stride, {arrays});",
                f"void time_{row['name']}_{form}(size_t repeats, size_t n, size_t stride, {arrays})",
                f"{{ (void)stride; while (repeats--) {{ {calls[form]} }} }}",
            ]
    return "\n".join(lines) + "\n"


def aligned(rows: int, columns: int, dtype: Any) -> Any:
    """Zeros on a boundary of 64 bytes."""
    size = rows * columns * np.dtype(dtype).itemsize
    memory = np.zeros(size + 64, np.uint8)
    start = -memory.ctypes.data % 64
    return memory[start : start + size].view(dtype).reshape(rows, columns)


def arguments(row: Mapping[str, Any], samples: Sequence[Mapping[str, Any]], form: str) -> list[Any]:
    """The arrays of a call in one form."""
    dtype = np.float32 if row["precision"] == "float" else np.float64
    n, stride = len(samples), len(samples) + PAD
    arrays = []
    for port in row["inputs"]:
        values = np.array([np.ravel(sample[port["name"]]) for sample in samples], dtype)
        if port["name"] in SHARED:
            arrays.append(values[0].copy())
        elif form == "soa":
            columns = aligned(values.shape[1], stride, dtype)
            columns[:, :n] = values.T
            arrays.append(columns)
        else:
            arrays.append(values)
    for port in row["outputs"]:
        size = prod(port["shape"])
        arrays.append(aligned(size, stride, dtype) if form == "soa" else aligned(n, size, dtype))
    return arrays


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scene", nargs="?", default=str(ROOT / "examples/panda.scene.yaml"))
    parser.add_argument("--outputs", default=OUTPUTS)
    parser.add_argument("--states", type=int, default=256)
    parser.add_argument("--rounds", type=int, default=200)
    parser.add_argument("--precision", choices=("double", "float"), default="double")
    parser.add_argument("--widest", type=int, default=64)
    parser.add_argument("--threads", action="store_true")
    given = parser.parse_args()
    scene = load(given.scene)
    outputs = tuple(Output(name, (name,)) for name in given.outputs.split(","))
    options = replace(scene.options, batch=True, targets=("c",), precision=given.precision)
    scene = replace(scene, outputs=outputs, options=options)
    flags = [*RELEASE_FLAGS, f"-DSYMGEN_WIDEST={given.widest}", *(["-fopenmp"] if given.threads else [])]
    system = derive(scene)
    texts = {k: v for k, v in generate_files(system, lambda *_: None).files.items() if isinstance(v, str)}
    manifest = json.loads(texts["manifest.json"])
    texts["driver.c"] = driver(manifest)
    samples = sample_states(scene, system, given.states)
    with tempfile.TemporaryDirectory() as folder:
        sources = [*manifest["sources"], "driver.c"]
        path = shared_library(scene.name, texts, sources, find_compiler(), flags, Path(folder))
        library = ctypes.CDLL(str(path))
        print(f"{'ns a state':32}" + "".join(f"{form:>12}" for form in FORMS))
        for row in manifest["functions"]:
            report(library, row, samples, given.rounds)
    return 0


def report(library: ctypes.CDLL, row: Mapping[str, Any], samples: Sequence[Mapping[str, Any]], rounds: int) -> None:
    """One line: minima of the three forms, and how many times the scalar speed."""
    n = len(samples)
    kept = {form: arguments(row, samples, form) for form in FORMS}
    best = dict.fromkeys(FORMS, float("inf"))
    sizes = [ctypes.c_size_t(k) for k in (REPEATS, n, n + PAD)]
    for _ in range(rounds):
        for form in FORMS:
            function = library[f"time_{row['name']}_{form}"]
            pointers = [ctypes.c_void_p(array.ctypes.data) for array in kept[form]]
            started = time.perf_counter_ns()
            function(*sizes, *pointers)
            best[form] = min(best[form], (time.perf_counter_ns() - started) / (REPEATS * n))
    ratios = "".join(f"{best[form]:8.1f} ns" if form == "scalar" else
                     f"{best[form]:6.1f} {best['scalar'] / best[form]:4.1f}×" for form in FORMS)  # fmt: skip
    print(f"{row['name']:32} {ratios}")


if __name__ == "__main__":
    sys.exit(main())
