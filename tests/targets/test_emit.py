"""The emitted files: what they say, and that real compilers take them without a word."""

from __future__ import annotations

import ctypes
import math
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

from symgen.errors import NotSupportedError, SceneError
from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port, count
from symgen.scene.model import Parameter
from symgen.targets.c import Info, emit_c
from symgen.targets.c import emit as emit_module
from tests.targets.programs import (
    COMPILERS,
    DT,
    STRICT,
    P,
    Q,
    all_programs,
    arm,
    compile_library,
    constant,
    emitted_library,
    empty,
    info,
    pointer,
    rotation,
    solver,
    write_files,
)

GOLDEN = Path(__file__).parent / "golden"
OPTIONS = [
    {},
    {"precision": "float", "batch": True},
    {"trigonometry": "libm", "status": True, "batch": True},
    {"precision": "float", "trigonometry": "libm", "status": True},
]


SANITIZERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


@cache
def sanitizes(cc: str) -> bool:
    """Whether the compiler came with its sanitizers' runtime; Debian's clang does not."""
    with tempfile.TemporaryDirectory() as scratch:
        command = [cc, *SANITIZERS, "-x", "c", "-", "-o", str(Path(scratch, "a"))]
        return (
            subprocess.run(
                command, input="int main(void) { return 0; }\n", capture_output=True, text=True, check=False
            ).returncode
            == 0
        )


@pytest.mark.parametrize("name", ["demo.h", "demo.c", "demo_batch.c", "main.c", "CMakeLists.txt"])
def test_golden(name: str, golden: Callable[[Path, str], None]) -> None:
    emitted = emit_c("demo", all_programs(), info(batch=True))
    golden(GOLDEN / f"{name}.txt", emitted.files[name])


@pytest.mark.parametrize("cc", COMPILERS)
@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_compiles_silently_and_runs_clean(options: dict[str, Any], cc: str, tmp_path: Path) -> None:
    """Every file, at -O2 with every warning; then the example under the address and undefined-behaviour
    sanitizers, where the compiler has them."""
    emitted = emit_c("demo", all_programs(), info(**options))
    write_files(emitted, tmp_path)
    files = [*emitted.sources, "main.c"]
    for flags in (["-O2"], ["-O1", *SANITIZERS]) if sanitizes(cc) else (["-O2"],):
        ran = run([cc, *STRICT, *flags, "-o", "example", *files, "-lm"], tmp_path)
        assert not ran.stderr
        shown = run(["./example"], tmp_path).stdout
        assert not re.search("nan|inf", shown.replace("info", ""))
        assert "mass_matrix: M" in shown and "natural_mass_matrix: Mn" in shown and "constraints" not in shown


@pytest.mark.skipif(which("g++") is None, reason="no g++")
def test_header_is_cpp(tmp_path: Path) -> None:
    """Both precisions in one C++ program."""
    for folder, precision in (("d", "double"), ("s", "float")):
        (tmp_path / folder).mkdir()
        write_files(emit_c("demo", all_programs(), info(batch=True, precision=precision)), tmp_path / folder)
    (tmp_path / "use.cpp").write_text(
        '#include "d/demo.h"\n#include "s/demo.h"\n'
        "int main() {\n    const double p[DEMO_NP] = DEMO_P_DEFAULTS; const float r[] = DEMO_P_DEFAULTS_F32;\n"
        "    double q[DEMO_NQ] = {0.1, 0.2}, M[4]; float s[2] = {0.1f, 0.2f}, N[4];\n"
        "    demo_mass_matrix(q, p, M); demo_mass_matrix_f32(s, r, N);\n"
        "    return p[DEMO_P_LINK_COM] == 0.1 && M[1] - N[1] < 1e-6 ? 0 : 1;\n}\n"
    )
    for folder in ("d", "s"):
        run(["gcc", *STRICT, "-c", f"{folder}/demo.c", "-o", f"{folder}.o"], tmp_path)
    run(
        ["g++", "-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "use.cpp", "d.o", "s.o", "-o", "use"],
        tmp_path,
    )
    run(["./use"], tmp_path)


@pytest.mark.skipif(which("cmake") is None, reason="no cmake")
@pytest.mark.parametrize("name", ["demo", "test"])
def test_cmake_builds_and_runs(name: str, tmp_path: Path) -> None:
    """Also for a scene whose name CMake keeps for itself."""
    emitted = emit_c(name, all_programs(), info(batch=True))
    write_files(emitted, tmp_path)
    environment = {**os.environ, "CC": "gcc"}
    run(["cmake", "-S", ".", "-B", "build"], tmp_path, environment)
    run(["cmake", "--build", "build"], tmp_path, environment)
    (example,) = (tmp_path / "build").glob("*_example")
    assert "forward_dynamics: a" in run([str(example)], tmp_path).stdout


def run(command: list[str], folder: Path, env: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=env)
    assert ran.returncode == 0, ran.stderr + ran.stdout
    return ran


def call(function: Any, *arguments: Any) -> Any:
    """Arrays by pointer, numbers by value."""
    return function(*(pointer(x) if isinstance(x, np.ndarray) else x for x in arguments))


def test_values(tmp_path: Path) -> None:
    _, library = emitted_library([arm(), rotation()], tmp_path)
    q, p, m = np.array([0.3, -1.2]), np.array([1.2, 0.1, -0.4, 1 / 3]), np.empty(4)
    call(library.demo_mass_matrix, q, p, m)
    coupling = p[0] * math.cos(q[1]) / 3 - p[1] * 2 / 7
    diagonal = (coupling + 1.25) * (coupling - p[2]) + p[3] ** 2 / 3
    assert np.allclose(m, [diagonal, coupling, coupling, -1 / 3], rtol=1e-15)
    v, step, after = np.array([2.0, -1.5]), 0.25, np.empty(4)
    call(library.demo_integrate, q, v, ctypes.c_double(step), p, after)
    y = step * 2.5
    sinc3 = (y - math.sin(y)) / y**3
    expected = [q[0] + math.cos(y) * v[0], math.sin(y) / y * step - q[1], sinc3, math.cos(q[1]) * math.sin(v[0])]
    assert np.allclose(after, expected, rtol=1e-14)


@pytest.mark.parametrize("status", [False, True])
@pytest.mark.parametrize("precision", ["double", "float"])
def test_guards(precision: str, status: bool, tmp_path: Path) -> None:
    """A pivot that is not positive: every output is NaN, whatever it held; a batch knows too."""
    real = {"double": np.float64, "float": np.float32}[precision]
    suffix = "" if precision == "double" else "_f32"
    _, library = emitted_library([solver()], tmp_path, status=status, batch=True, precision=precision)
    one, many = library[f"demo_forward_dynamics{suffix}"], library[f"demo_forward_dynamics_batch{suffix}"]
    v, tau, p = (np.array(x, real) for x in ([0.1, 0.2], [1, 2], [1, 0, 0, 0]))
    good, bad, zero = (np.array(x, real) for x in ([0.5, 0.5], [10, 10], [7, 1]))
    for q, answer in ((good, True), (bad, False), (zero, False), (np.array([math.nan, 1], real), False)):
        a, f = np.full(2, 7, real), np.full(1, 7, real)
        result = call(one, q, v, tau, p, a, f)
        assert np.isfinite(a).all() == answer and np.isfinite(f).all() == answer
        if status:
            assert result == (0 if answer else 1)
    qs, a, f = np.array([good, bad, good]), np.empty((3, 2), real), np.empty(3, real)
    result = call(many, ctypes.c_size_t(3), qs, np.array([v] * 3), np.array([tau] * 3), p, a, f)
    assert np.isfinite(f).tolist() == [True, False, True]
    assert not status or result == 1


@pytest.mark.parametrize("cc", COMPILERS)
@pytest.mark.parametrize("precision", ["double", "float"])
def test_batch_is_scalar_bitwise(precision: str, cc: str, tmp_path: Path) -> None:
    real = {"double": np.float64, "float": np.float32}[precision]
    suffix = "" if precision == "double" else "_f32"
    programs = [arm(), solver(), rotation()]
    emitted, library = emitted_library(programs, tmp_path, cc, batch=True, precision=precision)
    rng = np.random.default_rng(1)
    n = 37
    inputs = {port.name: rng.uniform(0.5, 1.5, (n, port.size)).astype(real) for pr in programs for port in pr.inputs}
    inputs["dt"][:] = inputs["dt"][0]
    scalar_type = ctypes.c_double if precision == "double" else ctypes.c_float
    for function in emitted.functions:
        program = function.program
        for symbol, own in ((function.symbols.batch, False), (function.symbols.batch_p, True)):
            shared = {"dt"} if own else {"dt", "p"}
            arguments: list[Any] = [ctypes.c_size_t(n)]
            for port in program.inputs:
                whole = inputs[port.name]
                arguments.append(
                    scalar_type(float(whole[0, 0]))
                    if port.name == "dt"
                    else whole[0].copy()
                    if port.name in shared
                    else whole
                )
            outputs = [np.full((n, port.size), 9, real) for port in program.outputs]
            call(library[symbol], *arguments, *outputs)
            for i in range(n):
                row = []
                for port in program.inputs:
                    k = 0 if port.name in shared else i
                    row.append(
                        scalar_type(float(inputs["dt"][0, 0])) if port.name == "dt" else inputs[port.name][k].copy()
                    )
                single = [np.empty(port.size, real) for port in program.outputs]
                call(library[f"demo_{program.name}{suffix}"], *row, *single)
                assert all(x[i].tobytes() == y.tobytes() for x, y in zip(outputs, single, strict=True))


@pytest.mark.parametrize("precision", ["double", "float"])
def test_batch_runs_clean_under_sanitizers(precision: str, tmp_path: Path) -> None:
    """On arrays of exactly the size stated; with no states at all on null pointers."""
    emitted = emit_c("demo", all_programs(), info(batch=True, status=True, precision=precision))
    write_files(emitted, tmp_path)
    lines = ['#include "demo.h"', "#include <stdlib.h>", "int main(void)", "{", "    const size_t n = 5;"]
    lines += [f"    const {precision} p[DEMO_NP] = {{1, 2, 3, 4}};"]
    for function in emitted.functions:
        for symbol, own in ((function.symbols.batch, False), (function.symbols.batch_p, True)):
            if not symbol:
                continue
            lines.append("    {")
            arguments, empty_arguments = [], []
            for port in function.program.inputs + function.program.outputs:
                if port.name == "dt" or (port.name == "p" and not own):
                    arguments.append("1" if port.name == "dt" else "p")
                    empty_arguments.append(arguments[-1])
                    continue
                lines.append(f"        {precision} *x_{port.name} = calloc(n * {port.size}, sizeof *x_{port.name});")
                arguments.append(f"x_{port.name}")
                empty_arguments.append("NULL")
            lines.append(f"        (void){symbol}(n, {', '.join(arguments)});")
            lines.append(f"        {symbol}(0, {', '.join(empty_arguments)});")
            lines += [f"        free({name});" for name in arguments if name.startswith("x_")]
            lines.append("    }")
    (tmp_path / "use.c").write_text("\n".join([*lines, "    return 0;", "}"]) + "\n")
    flags = ["-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    run(["gcc", *flags, "-o", "use", *emitted.sources, "use.c", "-lm"], tmp_path)
    run(["./use"], tmp_path)


def test_functions_without_state_have_no_batch() -> None:
    emitted = emit_c("demo", [constant(), arm()], info(batch=True))
    assert [bool(f.symbols.batch) for f in emitted.functions] == [False, True]
    assert "natural_mass_matrix_batch" not in emitted.files["demo.h"]
    only = emit_c("demo", [constant()], info(batch=True))
    assert "demo_batch.c" not in only.files and only.sources == ("demo.c",)


def test_empty_outputs_are_left_out_and_said_so() -> None:
    emitted = emit_c("demo", [empty(), arm()], info())
    assert [f.program.name for f in emitted.functions] == ["mass_matrix"]
    assert any("Psi" in note for note in emitted.notes) and any("constraints" in note for note in emitted.notes)
    assert "left out, because it has no output: function constraints" in emitted.files["demo.h"]
    assert "demo_constraints" not in emitted.files["demo.h"] + emitted.files["demo.c"]


def test_counts_are_those_of_the_program() -> None:
    """No negation is left over in these, so the text performs what the program counts."""
    for emitted in (emit_c("demo", [arm(), rotation()], info()), emit_c("demo", [arm()], info(trigonometry="libm"))):
        for function in emitted.functions:
            assert function.counts == count(function.program)


def test_negations_fold() -> None:
    g = Graph()
    x = g.inputs("q", 2)
    values = [x[0] - (-x[1]), -(x[0] * x[1]) + x[1], -x[0] * -x[1] + x[0], x[0] + (-x[1]) * 3]
    emitted = emit_c("demo", [extract(g, "f", (Q,), (Port("y", (4,)),), [values])], info())
    assert emitted.functions[0].counts.add == 4
    assert not re.search(r"[(=] ?-", emitted.files["demo.c"].split("void demo_f")[1])


def test_lines_fit() -> None:
    emitted = emit_c("demo", all_programs(), info(batch=True))
    body = emitted.files["demo.c"].split("void demo_")[1:]
    assert max(len(line) for text in body for line in text.splitlines()) <= 110


def test_constants_are_shared_and_used() -> None:
    """One name per rational, whatever its sign and however many functions; no name for what stands inline."""
    emitted = emit_c("demo", [arm(), solver(), constant()], info())
    assert len(set(emitted.constants.values())) == len(emitted.constants)
    assert all(value > 0 for value in emitted.constants.values())
    text = emitted.files["demo.c"]
    for name in emitted.constants:
        assert len(re.findall(rf"\b{name}\b", text)) > 1
    assert Fraction(1, 3) in emitted.constants.values() and Fraction(5, 4) not in emitted.constants.values()


def test_rationals_that_round_alike_keep_their_names() -> None:
    g = Graph()
    (x,) = g.inputs("q", 1)
    a, b = Fraction(1, 3), Fraction(1, 3) + Fraction(1, 10**25)
    program = extract(g, "f", (Port("q", (1,)),), (Port("y", (2,)),), [[x * a, x * b]])
    emitted = emit_c("demo", [program], info())
    assert sorted(emitted.constants.values()) == [a, b]
    literals = re.findall(r"static const double k\d = (\S+);", emitted.files["demo.c"])
    assert len(literals) == 2 and len(set(literals)) == 1


def test_hostile_names_and_texts(tmp_path: Path) -> None:
    """Labels that are keywords, inputs, helpers or library functions; comments that try to end themselves."""
    g = Graph()
    q = g.inputs("q", 2)
    labels = ["double", "q", "M", "sine_cosine", "sin", "i", "I", "t1", "k1", "lambda", "NAN", "j1", "y0", "class"]
    total = g.const(0)
    for k, label in enumerate(labels):
        with g.phase(f"{label} */ #error ??/ \\ é // x"):
            term = q[0] * Fraction(k + 2, 3) + q[1]
            value = term * g.cos(term)
            g.name_scalar(label, value)
            total = total + value * value
    with_text = extract(g, "f", (Q,), (Port("M", ()),), [[total]], summary='*/ #error "x" ??/', plan="\n*/\n#error")
    parameters = (Parameter('a.b */ ??/ "', (Fraction(1, 3),), "*/\n#error", 0),)
    emitted = emit_c("demo", [with_text], Info(2, 2, (), parameters, version="1", notes=("*/\n#error 1",)))
    write_files(emitted, tmp_path)
    for name, text in emitted.files.items():
        if name.endswith((".c", ".h")):
            assert not re.search(r"^\s*#error", text, re.MULTILINE)
            assert "??" not in text
    run(["gcc", *STRICT, "-c", "demo.c"], tmp_path)


@pytest.mark.parametrize(
    ("name", "programs", "fragment"),
    [
        ("math", [arm()], "hide the C library's"),
        ("stdint", [arm()], "hide the C library's"),
    ],
)
def test_names_that_cannot_be(name: str, programs: list[Any], fragment: str) -> None:
    with pytest.raises(SceneError, match=fragment):
        emit_c(name, programs, info())


def test_function_names_that_clash() -> None:
    g = Graph()
    (x,) = g.inputs("q", 1)
    port = Port("q", (1,))
    programs = [extract(g, name, (port,), (Port("y", ()),), [[x]]) for name in ("f", "f_batch")]
    emit_c("demo", programs, info())
    with pytest.raises(SceneError, match="both need the C function demo_f_batch"):
        emit_c("demo", programs, info(batch=True))


def test_arguments_that_clash() -> None:
    g = Graph()
    (x,) = g.inputs("a", 1)
    program = extract(g, "both", (Port("a", (1,)),), (Port("a", (1,)),), [[x * 2]])
    with pytest.raises(SceneError, match="both has two arguments a"):
        emit_c("demo", [program], info())


def test_constants_that_do_not_fit() -> None:
    g = Graph()
    (x,) = g.inputs("q", 1)
    program = extract(g, "f", (Port("q", (1,)),), (Port("y", ()),), [[x * Fraction(1, 10**50)]])
    emit_c("demo", [program], info())
    with pytest.raises(NotSupportedError, match="too small for float"):
        emit_c("demo", [program], info(precision="float"))


def test_long_sources_are_split(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(emit_module, "LINES_PER_FILE", 8)
    emitted, library = emitted_library(all_programs(), tmp_path, batch=True)
    assert emitted.sources[:2] == ("demo.c", "demo_1.c") and emitted.sources[-1] == "demo_batch.c"
    assert {f.source for f in emitted.functions} == set(emitted.sources) - {"demo_batch.c"}
    assert library.demo_mass_matrix and library.demo_natural_mass_matrix


def test_unused_inputs_and_scalar_inputs(tmp_path: Path) -> None:
    g = Graph()
    dt = g.input("dt", 0)
    program = extract(g, "f", (Q, DT, P), (Port("y", ()),), [[dt * 2]])
    _, library = emitted_library([program], tmp_path)
    y = np.empty(1)
    call(library.demo_f, np.zeros(2), ctypes.c_double(0.25), np.zeros(4), y)
    assert y[0] == 0.5


def test_both_precisions_agree(tmp_path: Path) -> None:
    results = []
    for precision, real in (("double", np.float64), ("float", np.float32)):
        folder = tmp_path / precision
        folder.mkdir()
        emitted = emit_c("demo", [arm()], info(precision=precision))
        write_files(emitted, folder)
        library = compile_library(folder, emitted.sources)
        m = np.empty(4, real)
        call(library[emitted.functions[0].symbols.scalar], np.array([0.3, 2], real), np.array([1, 2, 3, 4], real), m)
        results.append(m)
    assert np.allclose(results[0], results[1], rtol=1e-6) and not np.array_equal(results[0], results[1])


def test_same_bytes_under_any_hash_seed() -> None:
    code = (
        "import hashlib, sys; sys.path.insert(0, '.');"
        "from tests.targets.programs import *;"
        "files = emit_c('demo', all_programs(), info(batch=True)).files;"
        "print(hashlib.sha256(repr(sorted(files.items())).encode()).hexdigest())"
    )
    root = Path(__file__).parents[2]
    seen = {
        run([sys.executable, "-c", code], root, {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(root)}).stdout
        for seed in ("0", "1", "77")
    }
    assert len(seen) == 1
