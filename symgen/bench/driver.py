"""The driver: one process that holds every variant, gives values, times them in turn, and is counted by callgrind."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symgen.bench.text import render, template
from symgen.bench.variant import Array, Unit, Variant
from symgen.bench.workshop import NATIVE, CompileError, Workshop
from symgen.errors import ToolError

ALIGNED = 8
"""Arrays start at multiples of so many doubles: a line of the cache."""
COUNTED_STATES = 8


@dataclass(frozen=True)
class Driver:
    """The variants as two executables, for time and for callgrind."""

    variants: tuple[Variant, ...]
    states: int
    data: Path
    timed: Path
    counted: Path | None

    def _run(self, *words: str) -> str:
        ran = subprocess.run([str(self.timed), str(self.data), *words], capture_output=True, text=True, check=False)
        if ran.returncode:
            raise ToolError(f"the bench's driver ended with status {ran.returncode} {ran.stderr.strip()[:200]}")
        return ran.stdout

    def values(self, scratch: Path) -> list[Array]:
        """Per variant the flat outputs at every state: (states, outputs)."""
        found = []
        for index, variant in enumerate(self.variants):
            file = scratch / "values.bin"
            self._run("values", str(file), str(index))
            flat = np.fromfile(file, dtype=np.float32 if variant.real == "float" else np.float64)
            found.append(flat.astype(float).reshape(self.states, variant.outputs))
        return found

    def times(self, chosen: Sequence[int], rounds: int, least_ns: float) -> dict[int, list[float]]:
        """Nanoseconds a call, every round, by variant."""
        times: dict[int, list[float]] = {index: [] for index in chosen}
        for line in self._run("time", str(rounds), str(least_ns), *map(str, chosen)).splitlines():
            index, _, nanoseconds = line.partition(" ")
            times[int(index)].append(float(nanoseconds))
        return times

    def instructions(self, chosen: Sequence[int], scratch: Path) -> dict[int, float]:
        """Instructions of one call by variant, counted by callgrind; empty without valgrind. What valgrind cannot
        run is left out."""
        if self.counted is None or shutil.which("valgrind") is None:
            return {}
        found: dict[int, float] = {}
        for batch, n in ((False, min(COUNTED_STATES, self.states)), (True, self.states)):
            group = [index for index in chosen if self.variants[index].batch == batch]
            totals = count(self.counted, self.data, n, group, scratch)
            if totals is None:  # one of them cannot run there: each for itself
                alone = {index: count(self.counted, self.data, n, [index], scratch) for index in group}
                totals = {index: total[index] for index, total in alone.items() if total is not None}
            found |= {index: total / n for index, total in totals.items()}
        return found


def count(binary: Path, data: Path, n: int, chosen: Sequence[int], scratch: Path) -> dict[int, int] | None:
    """Instructions of n calls of each variant, in one run of valgrind; None where it fails."""
    if not chosen:
        return {}
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        file = Path(folder, "counts")
        options = ["--tool=callgrind", f"--callgrind-out-file={file}", "--zero-before=counted", "--dump-after=counted"]
        command = ["valgrind", *options, str(binary), str(data), "count", str(n), *map(str, chosen)]
        ran = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
        dumps = [Path(f"{file}.{number}") for number in range(1, len(chosen) + 1)]
        if ran.returncode or not all(dump.exists() for dump in dumps):
            return None
        totals = [re.search(r"^summary: (\d+)", dump.read_text(errors="replace"), re.MULTILINE) for dump in dumps]
    return {index: int(total.group(1)) for index, total in zip(chosen, totals, strict=True) if total}


def build_driver(workshop: Workshop, variants: Sequence[Variant], states: int, folder: Path) -> Driver:
    """Link all variants, whose units must compile, into one program for time and one for callgrind."""
    data, offsets = lay_out(variants)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "data.bin").write_bytes(data.tobytes())
    text = driver_text(variants, offsets, states, data.nbytes)
    unit = Unit("driver", text)
    objects, built = [*dict.fromkeys(u for v in variants for u in v.units), unit], []
    words = list(dict.fromkeys(word for variant in variants for word in variant.link))
    cxx = any(u.language == "c++" for u in objects)
    for name, flags in (("timed", NATIVE), ("counted", workshop.counted_flags())):
        compiled = [workshop.compile(u, flags).path for u in objects]
        built.append(workshop.link(compiled, words, folder / name, cxx))
    return Driver(tuple(variants), states, folder / "data.bin", built[0], built[1])


def lay_out(variants: Sequence[Variant]) -> tuple[Array, list[dict[str, int]]]:
    """All input arrays one behind the other, equal ones once; per variant name → offset in doubles."""
    parts: list[Array] = []
    known: dict[bytes, int] = {}
    size, offsets = 0, []
    for variant in variants:
        mine = {}
        for name, array in variant.arrays.items():
            kind = np.float32 if variant.real == "float" else np.float64
            raw = np.ascontiguousarray(array, dtype=kind).tobytes()
            key = variant.real.encode() + raw
            if key not in known:
                padded = raw + bytes(-len(raw) % (8 * ALIGNED))
                known[key] = size
                parts.append(np.frombuffer(padded, dtype=np.float64))
                size += len(padded) // 8
            mine[name] = known[key]
        offsets.append(mine)
    return (np.concatenate(parts) if parts else np.zeros(ALIGNED)), offsets


def driver_text(variants: Sequence[Variant], offsets: Sequence[Mapping[str, int]], states: int, size: int) -> str:
    rows = [_row(variant, mine) for variant, mine in zip(variants, offsets, strict=True)]
    largest = max((v.outputs * (states if v.batch else 1) for v in variants), default=1)
    return render(
        template("driver.c.j2"),
        states=states,
        variants=rows,
        declarations=list(dict.fromkeys(v.declaration for v in variants)),
        setups=list(dict.fromkeys(v.setup for v in variants if v.setup)),
        output_size=math.ceil(largest / ALIGNED) * ALIGNED,
        data_bytes=size,
    )


def _row(variant: Variant, offsets: Mapping[str, int]) -> dict[str, Any]:
    pointers, names = [], {"out": "out" if variant.real == "double" else f"(({variant.real} *)out)"}
    for name, array in variant.arrays.items():
        pointers.append(f"const {variant.real} *const {name}_ = (const {variant.real} *)(data + {offsets[name]});")
        per_state = array.ndim > 1 and not variant.batch
        names[name] = f"({name}_ + {array.shape[1]} * k)" if per_state else f"{name}_"
    return {
        "name": variant.name,
        "pointers": pointers,
        "call": variant.call.format(**names),
        "fetch": variant.fetch.format(**names),
        "outputs": variant.outputs,
        "real": variant.real,
        "batch": variant.batch,
    }


__all__ = ["CompileError", "Driver", "build_driver"]
