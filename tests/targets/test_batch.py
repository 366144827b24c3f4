"""Batches: on vectors of every width the bits of the scalar functions, from both layouts."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Sequence
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port
from symgen.targets.c import emit_c, read_back
from symgen.targets.c.batch import fits
from tests.targets.batches import WIDEST, Caller, certify, library, programs, wide
from tests.targets.programs import COMPILERS, STRICT, Q, info, rotation, solver, write_files

VARIANTS = [
    pytest.param({}, "gcc"),
    pytest.param({"precision": "float", "status": True}, "clang"),
    pytest.param({"trigonometry": "libm"}, "gcc", marks=pytest.mark.slow),
    pytest.param({"precision": "float", "status": True}, "gcc", marks=pytest.mark.slow),
    pytest.param({"status": True}, "clang", marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("options", "cc"), VARIANTS, ids=str)
def test_bits_of_the_scalar_functions(options: dict[str, Any], cc: str, tmp_path: Path) -> None:
    """All widths, forms and lengths of tails, contraction off; angles beyond the range, zeros of both signs and pivots
    that are not positive among the others."""
    if which(cc) is None:
        pytest.skip(f"no {cc}")
    emitted = emit_c("demo", programs(), info(batch=True, **options))
    special = {
        "q": (1e9, -0.0, math.nan, 0.0, math.pi / 2, 3e5, -math.inf, 11 * math.pi, -1e-30, 1e4, 40.0),
        "p": (0.1, -2.0),
    }
    for widest in WIDEST:
        handle = library(emitted, tmp_path, cc, widest, ("-O1",))
        for n in (1, 8, 16, 37) if widest == 64 else (5, 37):
            caller = Caller(emitted, handle, n, **special)
            for function in emitted.functions:
                single = {own: caller.scalar(function, own) for own in (False, True)}
                for form in ("batch", "batch_p", "soa", "soa_p"):
                    results, status = caller.form(function, form)
                    rows, wanted = single[form.endswith("_p")]
                    assert status == wanted
                    for found, row in zip(results, rows, strict=True):
                        same = (found.view(np.uint8) == row.view(np.uint8)).reshape(*found.shape, -1).all(-1)
                        assert (same | (np.isnan(found) & np.isnan(row))).all(), (
                            function.program.name,
                            form,
                            widest,
                            n,
                        )


def test_another_state_changes_nothing(tmp_path: Path) -> None:
    """A state has the same bits beside any others, also where the compiler contracts: only the lanes that are not in
    range go the long way."""
    emitted = emit_c("demo", [solver(), wide()], info(batch=True))
    handle = library(emitted, tmp_path, "gcc", 64, ("-O2", "-ffp-contract=fast", "-march=native"))
    for function in emitted.functions:
        good = Caller(emitted, handle, 24).form(function, "batch")[0]
        mixed = Caller(emitted, handle, 24, q=(1e9, math.nan, 1e300)).form(function, "batch")[0]
        touched = {0, 5, 10}
        for a, b in zip(good, mixed, strict=True):
            assert all((a[i] == b[i]).all() for i in range(24) if i not in touched)
            assert any((a[i] != b[i]).any() for i in touched)


FLAGS = ["", "-march=haswell", "-march=x86-64-v4", "-DSYMGEN_WIDEST=0", "-m32", "-fopenmp", "-O2"]


@pytest.mark.parametrize("cc", COMPILERS)
@pytest.mark.parametrize("precision", ["double", pytest.param("float", marks=pytest.mark.slow)])
def test_compiles_silently_for_every_processor(precision: str, cc: str, tmp_path: Path) -> None:
    emitted = emit_c("demo", [solver(), rotation()], info(batch=True, precision=precision, status=True))
    write_files(emitted, tmp_path)
    for flag in FLAGS:
        command = [cc, *STRICT, *([flag] if flag else []), "-c", "demo_batch.c", "-o", "batch.o"]
        if compiles("int x;", command[:-4]):
            ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
            assert ran.returncode == 0 and not ran.stderr, ran.stderr
        else:
            assert flag in ("-m32", "-fopenmp", "-march=x86-64-v4")


def compiles(text: str, command: Sequence[str]) -> bool:
    source = f"#include <stdint.h>\n#include <math.h>\n{text}\n"
    ran = subprocess.run(
        [*command, "-fsyntax-only", "-xc", "-"], input=source, text=True, capture_output=True, check=False
    )
    return ran.returncode == 0


def test_openmp_gives_the_same_bits(tmp_path: Path) -> None:
    emitted = emit_c("demo", programs(), info(batch=True, status=True))
    one = library(emitted, tmp_path, "gcc", 64)
    (tmp_path / "omp").mkdir()
    many = library(emitted, tmp_path / "omp", "gcc", 64, ("-O0", "-fopenmp"))
    for function in emitted.functions:
        for form in ("batch", "batch_p", "soa", "soa_p"):
            a = Caller(emitted, one, 1500, p=(0.1,)).form(function, form)
            b = Caller(emitted, many, 1500, p=(0.1,)).form(function, form)
            assert a[1] == b[1] and all(x.tobytes() == y.tobytes() for x, y in zip(a[0], b[0], strict=True))


def test_functions_too_large_for_the_stack_run_state_by_state(tmp_path: Path) -> None:
    g = Graph()
    q = g.inputs("q", 2)
    large = extract(g, "large", (Q,), (Port("y", (5000,)),), [[q[0] * k for k in range(1, 5001)]])
    assert not fits(large)
    emitted = emit_c("demo", [large], info(batch=True))
    assert set(read_back(emitted).vectors) == set()
    caller = Caller(emitted, library(emitted, tmp_path, "gcc", 64), 5)
    (function,) = emitted.functions
    for form in ("batch", "soa"):
        assert (caller.form(function, form)[0][0] == caller.scalar(function, False)[0][0]).all()


def test_names_of_the_frame_are_left_to_it(tmp_path: Path) -> None:
    """Labels that are words of the batch file."""
    g = Graph()
    q = g.inputs("q", 2)
    total: Any = 0
    for k, name in enumerate(("reals", "IN", "slow_lanes", "lane_step", "SPLAT", "words", "first", "n", "status")):
        x = q[0] * q[1] + (k + 1)
        g.name_scalar(name, x)
        total = total + x * x
    program = extract(g, "labels", (Q,), (Port("y", ()),), [[total]])
    emitted = emit_c("demo", [program], info(batch=True))
    certify(emitted)
    caller = Caller(emitted, library(emitted, tmp_path, "gcc", 64), 9)
    (function,) = emitted.functions
    assert (caller.form(function, "batch")[0][0] == caller.scalar(function, False)[0][0]).all()


def test_long_batches_are_split(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symgen.targets.c.batch.LINES_PER_FILE", 5)
    emitted = emit_c("demo", programs(), info(batch=True))
    assert [file for file in emitted.sources if "batch" in file] == [
        "demo_batch.c",
        *(f"demo_batch_{k}.c" for k in (1, 2, 3)),
    ]
    certify(emitted)
    library(emitted, tmp_path, "gcc", 64)


def test_functions_too_long_for_compilers_run_state_by_state(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symgen.targets.c.batch.LONGEST", 12)
    emitted = emit_c("demo", programs(), info(batch=True))
    read = read_back(emitted)
    assert "wide" not in read.vectors and "mass_matrix" in read.vectors
    assert "demo_wide_soa" in emitted.files["demo_batch.c"]
