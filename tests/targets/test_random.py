"""Random programs: the compiled C against Python's own floating point, bit for bit; the read-back against GF(p)."""

from __future__ import annotations

import ctypes
import math
import subprocess
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.algebra.field import MERSENNE_61, FieldNumbers, NotInField, Residue
from symgen.program.evaluate import evaluate
from symgen.program.instructions import Program
from symgen.targets.c import emit_c, read_back
from tests.targets.programs import (
    COMPILERS,
    compile_library,
    emitted_library,
    info,
    pointer,
    random_program,
    write_files,
)

ARITHMETIC = ("add", "sub", "mul", "mul", "div", "neg", "sqrt")
EVERYTHING = (*ARITHMETIC, "cos", "sin", "cos", "sin", "cos_sqrt", "sinc_sqrt", "sinc3_sqrt")
FIELD_ONLY = tuple(op for op in EVERYTHING if op != "sqrt")


class NumpyNumbers:
    """IEEE arithmetic of one format, constants rounded once."""

    def __init__(self, real: Any) -> None:
        self.real = real

    def const(self, value: Fraction) -> Any:
        return (
            self.real(float(value))
            if self.real is np.float64
            else np.float32(np.longdouble(value.numerator) / value.denominator)
        )

    def sqrt(self, x: Any) -> Any:
        return np.sqrt(x)

    cos = sin = cos_sqrt = sinc_sqrt = sinc3_sqrt = None


@pytest.mark.parametrize("cc", COMPILERS)
@pytest.mark.parametrize("precision", ["double", "float"])
def test_compiled_arithmetic_bit_for_bit(precision: str, cc: str, tmp_path: Path) -> None:
    """The tree of operations in the C is that of the program: same roundings, NaNs and infinities included."""
    real = {"double": np.float64, "float": np.float32}[precision]
    programs = [random_program(seed, 40, ARITHMETIC, f"f{seed}") for seed in range(60)]
    emitted, library = emitted_library(programs, tmp_path, cc, precision=precision)
    rng = np.random.default_rng(2)
    scalar = ctypes.c_double if precision == "double" else ctypes.c_float
    numbers: Any = NumpyNumbers(real)
    finite = 0
    with np.errstate(all="ignore"):
        for function in emitted.functions:
            for _ in range(3):
                x, dt = rng.normal(size=4).astype(real), real(rng.normal())
                y = np.empty(5, real)
                library[function.symbols.scalar](pointer(x), scalar(float(dt)), pointer(y))
                expected = np.array(evaluate(function.program, numbers, {"x": x, "dt": [dt]})["y"], real)
                assert np.array_equal(y, expected, equal_nan=True), function.program.name
                finite += int(np.isfinite(y).sum())
    assert finite > 200  # the comparison is about numbers


@pytest.mark.parametrize("trigonometry", ["polynomial", "libm"])
def test_compiled_functions_under_sanitizers(trigonometry: str, tmp_path: Path) -> None:
    """Near the same program in Python floats, where a change in the 13th digit of its functions changes little."""
    operations = ("add", "sub", "mul", "cos", "sin", "cos_sqrt", "sinc_sqrt", "sinc3_sqrt", "neg")
    programs = [random_program(seed, 12, operations, f"f{seed}") for seed in range(30)]
    emitted = emit_c("demo", programs, info(trigonometry=trigonometry))
    write_files(emitted, tmp_path)
    main = ['#include "demo.h"', "#include <stdio.h>", "int main(void)", "{"]
    main += ["    const double x[4] = {0.3, -1.7, 0.01, 2.9};", "    double y[5];"]
    for function in emitted.functions:
        main += [f"    {function.symbols.scalar}(x, 0.7, y);"]
        main += ['    for (int i = 0; i < 5; ++i) { printf("%.17g\\n", y[i]); }']
    (tmp_path / "use.c").write_text("\n".join([*main, "    return 0;", "}"]) + "\n")
    command = ["gcc", "-std=c99", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "demo.c", "use.c"]
    subprocess.run([*command, "-lm", "-o", "use"], cwd=tmp_path, check=True)
    shown = subprocess.run(["./use"], cwd=tmp_path, check=True, capture_output=True, text=True)
    found = iter(float(line) for line in shown.stdout.split())
    close = 0
    for program in programs:
        exact = evaluate(program, MathNumbers(), {"x": [0.3, -1.7, 0.01, 2.9], "dt": [0.7]})["y"]
        moved = evaluate(program, MathNumbers(1e-13), {"x": [0.3, -1.7, 0.01, 2.9], "dt": [0.7]})["y"]
        for value, other in zip(exact, moved, strict=True):
            compiled = next(found)
            if value == pytest.approx(other, rel=1e-8):
                assert compiled == pytest.approx(value, rel=1e-9, abs=1e-9)
                close += 1
    assert close > 60


class MathNumbers:
    """Python floats; NaN where a root does not exist. ``error``: what functions add to their values, relatively."""

    def __init__(self, error: float = 0.0) -> None:
        self.scale = 1 + error

    def const(self, value: Fraction | int) -> float:
        return float(value)

    def sqrt(self, x: float) -> float:
        return self.scale * math.sqrt(x) if x >= 0 else math.nan

    def cos(self, x: float) -> float:
        return self.scale * math.cos(x) if math.isfinite(x) else math.nan

    def sin(self, x: float) -> float:
        return self.scale * math.sin(x) if math.isfinite(x) else math.nan

    def cos_sqrt(self, x: float) -> float:
        return self._series(x, math.cos, 0)

    def sinc_sqrt(self, x: float) -> float:
        return self._series(x, lambda y: math.sin(y) / y, 1)

    def sinc3_sqrt(self, x: float) -> float:
        return self._series(x, lambda y: (y - math.sin(y)) / y**3, 3)

    def _series(self, x: float, closed: Any, first: int) -> float:
        if -0.6 < x < 0.6:
            return self.scale * sum((-x) ** k / math.factorial(2 * k + first) for k in range(12))
        return self.scale * closed(math.sqrt(x)) if 0 < x < math.inf else math.nan


@settings(deadline=None, max_examples=60)
@given(
    st.integers(0, 10**9),
    st.integers(1, 120),
    st.sampled_from(["double", "float"]),
    st.sampled_from(["polynomial", "libm"]),
)
def test_read_back_is_the_program(seed: int, size: int, precision: str, trigonometry: str) -> None:
    program = random_program(seed, size, FIELD_ONLY)
    emitted = emit_c("demo", [program], info(precision=precision, trigonometry=trigonometry))
    read = read_back(emitted)
    read.check_literals()
    function = read.functions["f"]
    assert function.operations == emitted.functions[0].counts
    numbers = FieldNumbers(MERSENNE_61, seed)
    rng = np.random.default_rng(seed)
    inputs = {"x": [int(k) for k in rng.integers(1, 2**60, 4)], "dt": [int(rng.integers(1, 2**60))]}
    try:
        expected = evaluate(program, numbers, {k: [Residue(x, numbers.p) for x in row] for k, row in inputs.items()})
        found = function.evaluate_mod(numbers.p, inputs, numbers.apply)
    except NotInField:
        return
    assert found == {"y": [x.x for x in expected["y"]]}


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**9))
def test_read_back_over_rationals(seed: int) -> None:
    program: Program = random_program(seed, 15, ("add", "sub", "mul", "neg", "div"))
    emitted = emit_c("demo", [program], info())
    inputs = {"x": [Fraction(1, 7), Fraction(-3, 11), Fraction(2), Fraction(5, 13)], "dt": [Fraction(17, 19)]}

    class Rationals:
        def const(self, value: Fraction | int) -> Fraction:
            return Fraction(value)

        sqrt = cos = sin = cos_sqrt = sinc_sqrt = sinc3_sqrt = None

    numbers: Any = Rationals()
    try:
        expected = evaluate(program, numbers, inputs)
    except ZeroDivisionError:
        return
    assert read_back(emitted).functions["f"].evaluate(numbers, inputs)["y"] == list(expected["y"])


def test_other_compiler_flags_change_nothing(tmp_path: Path) -> None:
    """-O3 gives the bits of -O0."""
    programs = [random_program(seed, 60, ("add", "sub", "mul", "div"), f"f{seed}") for seed in range(20)]
    emitted = emit_c("demo", programs, info())
    results = []
    for level in ("-O0", "-O3"):
        folder = tmp_path / level
        folder.mkdir()
        write_files(emitted, folder)
        library = compile_library(folder, emitted.sources, flags=[level])
        x, rows = np.array([0.3, -1.7, 0.01, 2.9]), []
        for function in emitted.functions:
            y = np.empty(5)
            library[function.symbols.scalar](pointer(x), ctypes.c_double(0.7), pointer(y))
            rows.append(y)
        results.append(np.array(rows))
    assert np.array_equal(results[0], results[1], equal_nan=True)
