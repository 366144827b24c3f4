"""Batches: on vectors of every width the bits of the scalar functions, from both layouts; every mutation is refused."""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

from symgen.algebra.field import NotInField, Residue
from symgen.errors import CertificateError
from symgen.generate import generate_files
from symgen.program.evaluate import evaluate_all
from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port, Program
from symgen.scene.load import load
from symgen.system import derive
from symgen.targets.c import Emitted, emit_c, read_back
from symgen.targets.c.batch import fits
from symgen.targets.c.vector_order import spread_divisions
from tests.targets.programs import (
    COMPILERS,
    STRICT,
    P,
    Q,
    all_programs,
    arm,
    compile_library,
    info,
    pointer,
    rotation,
    solver,
    write_files,
)
from tests.targets.test_read_back import changed, expected, point

WIDEST = (64, 32, 16, 0)
REAL = {"double": np.float64, "float": np.float32}
C_REAL = {"double": ctypes.c_double, "float": ctypes.c_float}


def wide() -> Program:
    """More rows than four, a multiple of four and not; many zeros; one angle more than once."""
    g = Graph()
    q = g.inputs("q", 9)
    p = g.inputs("p", 4)
    c = [g.cos(x) for x in q]
    s = [g.sin(x) for x in q]
    rows = [c[i] * s[j] - p[i % 4] * Fraction(1, 3) for i in range(9) for j in range(2)]
    zeros: list[Any] = [0] * 40
    zeros[3], zeros[17] = s[0] * c[0], Fraction(1, 3)
    ports = (Port("M", (9, 2)), Port("Z", (40,)), Port("few", (3,)))
    return extract(g, "wide", (Port("q", (9,)), P), ports, [rows, zeros, [q[0], -c[1], s[2]]])


def programs() -> list[Program]:
    return [arm(), solver(), rotation(), wide()]


def library(emitted: Emitted, folder: Path, cc: str, widest: int, flags: Sequence[str] = ("-O0",)) -> ctypes.CDLL:
    write_files(emitted, folder)
    target = folder / str(widest)
    target.mkdir()
    for file in emitted.files:
        (target / file).write_text(emitted.files[file])
    return compile_library(target, emitted.sources, cc, [*flags, f"-DSYMGEN_WIDEST={widest}"])


class Caller:
    """Calls the functions of a library in every form, on states at random."""

    def __init__(self, emitted: Emitted, handle: ctypes.CDLL, n: int, **special: Sequence[float]) -> None:
        self.emitted, self.handle, self.n = emitted, handle, n
        self.real = REAL[emitted.info.options.precision]
        self.number = C_REAL[emitted.info.options.precision]
        rng = np.random.default_rng(n)
        ports = {port.name: port for f in emitted.functions for port in f.program.inputs}
        sizes = {
            name: max(p.size for f in emitted.functions for p in f.program.inputs if p.name == name) for name in ports
        }
        self.inputs = {name: rng.uniform(0.5, 1.5, (n, size)).astype(self.real) for name, size in sizes.items()}
        for name, values in special.items():
            for k, value in enumerate(values):
                self.inputs[name][k * 5 % n, k % sizes[name]] = value

    def state(self, port: Port, i: int, own: bool) -> Any:
        row = self.inputs[port.name][i if port.name not in ("dt", "p") or (port.name == "p" and own) else 0]
        return self.number(float(row[0])) if port.name == "dt" else pointer_kept(row[: port.size].copy())

    def scalar(self, function: Any, own: bool) -> tuple[list[Any], int]:
        results = [np.full((self.n, port.size), 9, self.real) for port in function.program.outputs]
        status = 0
        for i in range(self.n):
            arguments = [self.state(port, i, own) for port in function.program.inputs]
            raw = [a if not isinstance(a, np.ndarray) else pointer(a) for a in arguments]
            answer = self.handle[function.symbols.scalar](*raw, *(pointer(r[i]) for r in results))
            status |= answer if self.answers(function) else 0
        return results, status

    def answers(self, function: Any) -> bool:
        return bool(self.emitted.info.options.status and function.program.guards)

    def form(self, function: Any, form: str) -> tuple[list[Any], int]:
        """``form``: batch, batch_p or soa."""
        own, columns = form == "batch_p", form == "soa"
        stride = self.n + 3
        arguments: list[Any] = [ctypes.c_size_t(self.n)] + ([ctypes.c_size_t(stride)] if columns else [])
        kept = []
        for port in function.program.inputs:
            shared = port.name == "dt" or (port.name == "p" and not own)
            if shared:
                kept.append(self.state(port, 0, False))
            else:
                rows = self.inputs[port.name][:, : port.size]
                kept.append(spread(rows, stride) if columns else rows.copy())
        size = stride if columns else self.n
        results = [
            np.full((port.size, size) if columns else (size, port.size), 9, self.real)
            for port in function.program.outputs
        ]
        raw = [a if not isinstance(a, np.ndarray) else pointer(a) for a in [*kept, *results]]
        status = self.handle[getattr(function.symbols, form)](*arguments, *raw)
        if columns:
            assert all((r[:, self.n :] == 9).all() for r in results)
            results = [np.ascontiguousarray(r[:, : self.n].T) for r in results]
        return results, status if self.answers(function) else 0


def pointer_kept(array: Any) -> Any:
    return array


def spread(rows: Any, stride: int) -> Any:
    columns = np.full((rows.shape[1], stride), np.nan, rows.dtype)
    columns[:, : len(rows)] = rows.T
    return columns


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
                for form in ("batch", "batch_p", "soa"):
                    results, status = caller.form(function, form)
                    rows, wanted = single[form == "batch_p"]
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
        for form in ("batch", "batch_p", "soa"):
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


def certify(emitted: Emitted) -> None:
    """What a certificate does with the functions of the batch file; raises CertificateError."""
    read = read_back(emitted)
    read.check_literals()
    for function in emitted.functions:
        program = function.program
        if program.name not in read.vectors:
            assert not function.symbols.batch
            continue
        numbers, inputs = point(program)
        try:
            found = read.vectors[program.name].evaluate_mod(numbers.p, inputs, numbers.apply)
            guards = read.vectors[program.name].guards_mod(numbers.p, inputs, numbers.apply)
        except NotInField:
            raise CertificateError("no value") from None
        every = evaluate_all(program, numbers, {k: [Residue(x, numbers.p) for x in row] for k, row in inputs.items()})
        if found != expected(program, numbers, inputs) or guards != [every[i].x for i in program.guards]:
            raise CertificateError(f"{program.name} differs")


OPTIONS = [{}, {"precision": "float", "status": True}, {"trigonometry": "libm"}]


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_what_is_emitted_passes(options: dict[str, Any]) -> None:
    emitted = emit_c("demo", [*all_programs(), wide()], info(batch=True, **options))
    certify(emitted)
    read = read_back(emitted)
    for function in emitted.functions:
        if function.symbols.batch:
            assert read.vectors[function.program.name].operations == function.counts


def body_mutants(text: str) -> Iterator[str]:
    """Every single change, of many kinds, to the statements over vectors."""
    changes: dict[str, Sequence[str]] = {
        r"(?<![\w.])\d+\.\d+(?:e-?\d+)?": ("7.25", "7"),
        r"(?<= )\+(?= )": ("-", "*", "=="),
        r"(?<= )-(?= )": ("+", "/", "--"),
        r"(?<= )\*(?= )": ("/", "+", "&", "%"),
        r"(?<== )-": ("", "~"),
        r"\b(?:IN|TILE)\((?=[a-z])": ("OUT(", "", "SPLAT(", "("),
        r"\bIN\(": ("TILE(",),
        r"\bTILE\(": ("IN(",),
        r"\bOUT\(": ("IN(", "TILE("),
        r"\bSPLAT\(": ("IN(", "COS("),
        r"(?<=, )\d+(?=\))": ("99", "i", "-1"),
        r"(?<=\()q(?=, )": ("p", "v", "M"),
        r"\bk1\b": ("k2", "k999", "1.0"),
        r"\bt1\b": ("t2", "slow_lanes", "q"),
        r"\bCOS\(": ("SIN(", "cos(", "cosine("),
        r"\bSQRT\(": ("COS(", "sqrt("),
        r"SINE_COSINE\(": ("sine_cosine(", "COS("),
        r"&(\w+), &(\w+)\)": ("&sin_q0, &sin_q0)", "0, 0)"),
        r"REQUIRE\(": ("SQRT(", "(void)("),
        r"\n    REQUIRE[^;]*;": ("", "\n    REQUIRE(1.0);"),
        r"\n    const reals \w+ = [^;]*;": ("",),
        r"\n    OUT[^;]*;": ("", "\n    slow_lanes = 1;", "\n    return 0;", "\n    if (n) return 0;"),
        r"const reals": ("reals", "const words", "const double", "static const reals"),
        r";(?=\n)": (",", "; ;", " #x;"),
    }
    bodies = [m.span(1) for m in re.finditer(r"\(void\)lane_step;\n(.*?)    SYMGEN_IN_MEMORY", text, re.DOTALL)]
    assert len(bodies) == 3
    comments = [match.span() for match in re.finditer(r"/\*.*?\*/", text, re.DOTALL)]
    for pattern, news in changes.items():
        found = 0
        for match in re.finditer(pattern, text):
            inside = any(a - 1 <= match.start() and match.end() <= b for a, b in bodies)
            if not inside or any(a <= match.start() < b for a, b in comments):
                continue
            for new in news:
                if new != match[0]:
                    found += 1
                    yield text[: match.start()] + new + text[match.end() :]
        assert found, pattern


@pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.slow)])
def test_mutated_statements_are_refused(every: int) -> None:
    emitted = emit_c("demo", [arm(), solver(), wide()], info(batch=True))
    text = emitted.files["demo_batch.c"]
    for mutant in list(body_mutants(text))[::every]:
        try:
            certify(changed(emitted, mutant, "demo_batch.c"))
        except CertificateError:
            continue
        where = next(k for k, (a, b) in enumerate(zip(text, mutant, strict=False)) if a != b)
        raise AssertionError(f"not caught: {mutant[max(0, where - 80) : where + 80]!r}")


@pytest.mark.parametrize("status", [False, True])
def test_mutated_frames_are_refused(status: bool) -> None:
    """Any number, name or operator outside the statements: it is compared with what it must be."""
    emitted = emit_c("demo", [arm(), solver()], info(batch=True, status=status))
    text = emitted.files["demo_batch.c"]
    start = text.index("#ifdef SYMGEN_LANES")
    comments = [match.span() for match in re.finditer(r"/\*.*?\*/", text, re.DOTALL)]
    bodies = [m.span(1) for m in re.finditer(r"\(void\)lane_step;\n(.*?)    SYMGEN_IN_MEMORY", text, re.DOTALL)]
    words = list(re.finditer(r"\w+|[-+*/<>=&|!~?,;(){}\[\]#\"]", text))
    checked = 0
    for match in words[status::29]:
        if match.start() < start or any(a <= match.start() < b for a, b in [*comments, *bodies]):
            continue
        mutant = text[: match.start()] + ("x" if match[0] != "x" else "y") + text[match.end() :]
        with pytest.raises(CertificateError):
            read_back(changed(emitted, mutant, "demo_batch.c")).check_literals()
        checked += 1
    assert checked > 80
    for mutant in (text + "int x;\n", text.replace('"demo.h"', '"other.h"'), f"int x;\n{text}"):
        with pytest.raises(CertificateError):
            read_back(changed(emitted, mutant, "demo_batch.c"))


def test_header_of_batches_is_checked() -> None:
    emitted = emit_c("demo", [arm(), solver()], info(batch=True))
    header = emitted.files["demo.h"]
    for old, new in (
        ("demo_mass_matrix_batch(size_t n, ", "demo_mass_matrix_batch(int n, "),
        ("_soa(size_t n, size_t stride", "_soa(size_t stride, size_t n"),
        ("_batch_p(", "_batch_q("),
    ):
        assert old in header
        with pytest.raises(CertificateError):
            read_back(changed(emitted, header.replace(old, new, 1), "demo.h"))


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
    moved = replace(emitted, files={**emitted.files, "demo_batch_1.c": emitted.files["demo_batch_2.c"]})
    with pytest.raises(CertificateError):
        read_back(moved)


def test_functions_too_long_for_compilers_run_state_by_state(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symgen.targets.c.batch.LONGEST", 12)
    emitted = emit_c("demo", programs(), info(batch=True))
    read = read_back(emitted)
    assert "wide" not in read.vectors and "mass_matrix" in read.vectors
    assert "demo_wide_soa" in emitted.files["demo_batch.c"]


def test_divisions_are_spread() -> None:
    """What needs no quotient stands between them; the program stays the same function."""
    g = Graph()
    q, tau = g.inputs("q", 4), g.inputs("tau", 4)
    free: Any = 0
    for k in range(40):
        free = (free + tau[k % 4]) * tau[(k + 1) % 4]
    x: Any = q[0]
    for k in range(1, 4):
        x = q[k] + g.const(Fraction(1)) / (x * x + 1)
    program = extract(g, "chain", (Port("q", (4,)), Port("tau", (4,))), (Port("y", ()),), [[x + free]])
    moved = spread_divisions(program)
    places = [k for k, instruction in enumerate(moved.instructions) if instruction.op == "div"]
    assert len(places) == 3 and min(b - a for a, b in pairwise(places)) > 15
    assert sorted(i.op for i in moved.instructions) == sorted(i.op for i in program.instructions)
    assert all(k < n for n, instruction in enumerate(moved.instructions) for k in instruction.args)
    numbers, inputs = point(program)
    assert expected(moved, numbers, inputs) == expected(program, numbers, inputs)
    assert spread_divisions(wide()) == wide()


def test_generation_refuses_wrong_vectors(monkeypatch: pytest.MonkeyPatch) -> None:
    """One sign in the statements over vectors, the scalar file as it should be."""
    scene = load(Path(__file__).parents[2] / "examples/double_pendulum.scene.yaml")
    scene = replace(scene, options=replace(scene.options, batch=True, targets=("c",)))

    def tampered(*arguments: Any) -> Emitted:
        emitted = emit_c(*arguments)
        text = emitted.files["double_pendulum_batch.c"]
        line = next(line for line in text.splitlines() if line.startswith("    OUT(M, 0) = "))
        assert " + " in line
        return changed(emitted, text.replace(line, line.replace(" + ", " - ")), "double_pendulum_batch.c")

    generated = generate_files(derive(scene), lambda done, total, what: None)
    assert "(C, C on vectors)" in generated.certificates["mass_matrix"].method
    monkeypatch.setattr(sys.modules["symgen.generate"], "emit_c", tampered)  # symgen.generate is the function
    with pytest.raises(CertificateError, match="the emitted C on vectors is not mass_matrix"):
        generate_files(derive(scene), lambda done, total, what: None)


def test_a_guard_may_be_an_argument_itself() -> None:
    """As where the mass of the last, sliding body is a run-time parameter."""
    graph = Graph()
    tau, p = graph.inputs("tau", 2), graph.inputs("p", 4)
    ports = (Port("tau", (2,)), Port("p", (4,))), (Port("a", (1,)),)
    program = extract(graph, "forward_dynamics", *ports, [[tau[0] / p[3]]], [p[3]])
    emitted = emit_c("demo", [program], info(batch=True))
    read_back(emitted)
    assert "REQUIRE(TILE(p, 3))" in emitted.files["demo_batch.c"]
