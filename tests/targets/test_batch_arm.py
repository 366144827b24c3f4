"""Batches on AArch64 (NEON, two doubles or four floats), cross-compiled and run by an emulator where both are here."""

from __future__ import annotations

import subprocess
from pathlib import Path
from shutil import which
from typing import Any

import pytest

from symgen.targets.c import Emitted, EmittedFunction, emit_c
from symgen.targets.c.signatures import SHARED
from tests.targets.batches import programs
from tests.targets.programs import STRICT, info, write_files

CROSS, EMULATOR = "aarch64-linux-gnu-gcc", "qemu-aarch64"
STATES, STRIDE = 37, 40
_HEAD = """#include "demo.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { n = 37, stride = 40 };

static REAL number(unsigned *seed)
{
    *seed = *seed * 1103515245u + 12345u;
    return (REAL)((double)(*seed >> 8) / 8388608.0 + 0.25);
}

static int differs(REAL a, REAL b)
{
    return memcmp(&a, &b, sizeof a) != 0 && !(isnan(a) && isnan(b));
}
"""


def test_bits_of_the_scalar_functions_by_neon(tmp_path: Path) -> None:
    if which(CROSS) is None or which(EMULATOR) is None:
        pytest.skip(f"no {CROSS} or no {EMULATOR}")
    variants: tuple[dict[str, Any], ...] = ({"status": True}, {"precision": "float"})
    for number, options in enumerate(variants):
        folder = tmp_path / str(number)
        folder.mkdir()
        emitted = emit_c("demo", programs(), info(batch=True, **options))
        write_files(emitted, folder)
        (folder / "check.c").write_text(check_text(emitted), encoding="utf-8")
        command = [CROSS, *STRICT, "-O1", "-ffp-contract=off", "check.c", *emitted.sources, "-lm", "-static"]
        ran = subprocess.run([*command, "-o", "check"], cwd=folder, capture_output=True, text=True, check=False)
        assert ran.returncode == 0 and not ran.stderr, ran.stderr
        listing = subprocess.run(
            ["aarch64-linux-gnu-objdump", "-d", "check"], cwd=folder, capture_output=True, text=True, check=False
        )
        lanes = "v0.4s" if options.get("precision") == "float" else "v0.2d"
        assert "_v128>:" in listing.stdout and lanes in listing.stdout
        answer = subprocess.run([EMULATOR, "./check"], cwd=folder, capture_output=True, text=True, check=False)
        assert answer.stdout == f"{len(emitted.functions) * 4} forms, 0 entries differ\n", answer.stdout


def check_text(emitted: Emitted) -> str:
    """C that compares every form of every function with the scalar one, entry by entry."""
    real = emitted.info.options.precision
    lines = [
        _HEAD.replace("REAL", real),
        "int main(void)",
        "{",
        "    int forms = 0, bad = 0;",
        "    unsigned seed = 1;",
    ]
    for function in emitted.functions:
        lines += ["    {", *_function(function, real), "    }"]
    lines += ['    printf("%d forms, %d entries differ\\n", forms, bad);', "    return 0;", "}"]
    return "\n".join(lines) + "\n"


def _function(function: EmittedFunction, real: str) -> list[str]:
    inputs, outputs = function.program.inputs, function.program.outputs
    lines = [f"        static {real} i_{p.name}[n * {p.size}], c_{p.name}[stride * {p.size}];" for p in inputs]
    lines += [f"        static {real} o_{p.name}[n * {p.size}], r_{p.name}[{p.size}];" for p in outputs]
    lines += [f"        static {real} d_{p.name}[stride * {p.size}];" for p in outputs]
    for port in inputs:
        lines.append(f"        for (int k = 0; k < n * {port.size}; ++k) i_{port.name}[k] = number(&seed);")
    angles = next(p for p in inputs if p.name == "q")
    for place, value in ((1, "1e9"), (11, "-0.0"), (20, "3e5"), (25, "NAN"), (30, "-1e-30"), (33, "INFINITY")):
        lines.append(f"        i_q[{place % (STATES * angles.size)}] = ({real}){value};")
    for port in inputs:
        copy = f"c_{port.name}[k * stride + i] = i_{port.name}[i * {port.size} + k]"
        lines.append(f"        for (int i = 0; i < n; ++i) for (int k = 0; k < {port.size}; ++k) {copy};")
    for form in ("batch", "batch_p", "soa", "soa_p"):
        own, columns = form.endswith("_p"), form.startswith("soa")
        prefix = "c" if columns else "i"
        given = ["n", *(["stride"] if columns else [])]
        for port in inputs:
            shared = port.name in SHARED and not (port.name == "p" and own)
            given.append(f"i_{port.name}" if shared and port.shape else f"{prefix}_{port.name}")
            given[-1] += "" if port.shape else "[0]"
        given += [f"{'d' if columns else 'o'}_{port.name}" for port in outputs]
        each = [
            f"i_{port.name}" + (f" + {port.size} * i" if port.name not in SHARED or (port.name == "p" and own) else "")
            for port in inputs
        ]
        each = [text if port.shape else f"{text}[0]" for text, port in zip(each, inputs, strict=True)]
        each += [f"r_{port.name}" for port in outputs]
        lines += [f"        (void){getattr(function.symbols, form)}({', '.join(given)});", "        ++forms;"]
        lines += [
            "        for (int i = 0; i < n; ++i) {",
            f"            (void){function.symbols.scalar}({', '.join(each)});",
        ]
        for port in outputs:
            there = f"d_{port.name}[k * stride + i]" if columns else f"o_{port.name}[i * {port.size} + k]"
            lines.append(
                f"            for (int k = 0; k < {port.size}; ++k) bad += differs({there}, r_{port.name}[k]);"
            )
        lines.append("        }")
    return lines
