"""The built-in trigonometry, compiled, against mpmath; and the enclosure of its polynomials."""

from __future__ import annotations

import ctypes
import math
import random
import subprocess
import sys
from collections.abc import Callable, Iterable
from fractions import Fraction
from pathlib import Path
from shutil import which
from typing import Any

import mpmath
import numpy as np
import pytest

from symgen.targets.c import sincos
from symgen.targets.c.sincos import BOUND, ENTIRE, ENTIRE_ULPS, ULPS, enclosure, helper_functions
from tests.targets.programs import COMPILERS, compile_library, pointer

TYPES = {"double": np.float64, "float": np.float32}
BITS = {"double": (53, -1074), "float": (24, -149)}
PRECISIONS = pytest.mark.parametrize("precision", ["double", "float"])


def source(precision: str, trigonometry: str = "polynomial") -> str:
    """The helpers with a loop around each, as a library."""
    real = precision
    names = [*ENTIRE, "sine", "cosine"] if trigonometry == "polynomial" else [*ENTIRE]
    text = "#include <math.h>\n#include <stddef.h>\n#include <stdint.h>\n"
    text += helper_functions(precision, trigonometry, {*names, "sine_cosine", "sines_cosines"}) + "\n"
    for name in names:
        head = f"void many_{name}(size_t n, const {real} *x, {real} *y)"
        text += f"{head};\n{head}\n{{\n    for (size_t i = 0; i < n; ++i) y[i] = {name}(x[i]);\n}}\n"
    if trigonometry == "polynomial":
        head = f"void many_pairs(size_t n, const {real} *x, {real} *s, {real} *c)"
        text += f"{head};\n{head}\n{{\n    for (size_t i = 0; i < n; ++i) sine_cosine(x[i], s + i, c + i);\n}}\n"
        head = head.replace("many_pairs", "many_fours")
        text += f"{head};\n{head}\n{{\n    sines_cosines(x, s, c, (int)n);\n}}\n"
    return text


Pairs = Callable[[Iterable[float]], tuple[Any, Any, Any]]


@pytest.fixture(scope="module", params=["double", "float"])
def kernel(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, ctypes.CDLL]:
    folder = tmp_path_factory.mktemp("sincos")
    (folder / "s.c").write_text(source(request.param))
    return request.param, compile_library(folder, ["s.c"], flags=["-O2"])


def pairs(kernel: tuple[str, ctypes.CDLL], values: Iterable[float]) -> tuple[Any, Any, Any]:
    precision, library = kernel
    x = np.asarray(list(values), TYPES[precision])
    s, c = np.empty_like(x), np.empty_like(x)
    library.many_pairs(ctypes.c_size_t(len(x)), pointer(x), pointer(s), pointer(c))
    return x, s, c


def ulps(value: float, exact: mpmath.mpf, precision: str) -> float:
    bits, least = BITS[precision]
    if exact == 0:
        return 0.0 if value == 0 else math.inf
    exponent = max(int(mpmath.floor(mpmath.log(abs(exact), 2))) - bits + 1, least)
    return float(abs(mpmath.mpf(float(value)) - exact) / mpmath.mpf(2) ** exponent)


def worst(kernel: tuple[str, ctypes.CDLL], values: Iterable[float]) -> float:
    x, s, c = pairs(kernel, values)
    with mpmath.workprec(1300):
        return max(
            max(
                ulps(b, mpmath.sin(mpmath.mpf(float(a))), kernel[0]),
                ulps(d, mpmath.cos(mpmath.mpf(float(a))), kernel[0]),
            )
            for a, b, d in zip(x, s, c, strict=True)
        )


RANGES = [(0, 1e-300), (0, 1e-8), (0, 0.8), (0.7, 0.9), (0.7, 7), (0, 1e3), (999, 1001), (1e3, 1e5), (99999, 100001)]
RANGES += [(1e5, 1e6), (1e6, 1e9), (1e9, 1e22), (1e22, 1e38), (1e38, 1e300), (1e307, 1.79e308)]


@pytest.mark.parametrize("bounds", RANGES, ids=str)
def test_accuracy(kernel: tuple[str, ctypes.CDLL], bounds: tuple[float, float]) -> None:
    low, high = bounds
    if kernel[0] == "float" and high > 3e38:
        pytest.skip("beyond float")
    rng = random.Random(str(bounds))
    values = [rng.choice((-1, 1)) * rng.uniform(low, high) for _ in range(150)]
    assert worst(kernel, values) < float(ULPS[kernel[0]])


def test_accuracy_near_multiples_of_half_pi(kernel: tuple[str, ctypes.CDLL]) -> None:
    real = TYPES[kernel[0]]
    rng = random.Random(3)
    last = int(BOUND[kernel[0]] / 1.6)
    turns = [*range(1, 40), *(rng.randrange(1, last) for _ in range(60)), *(rng.randrange(1, 10**9) for _ in range(30))]
    with mpmath.workprec(300):
        nearest = [real(float(mpmath.pi / 2 * n)) for n in turns]
    values = [y for x in nearest for y in (x, np.nextafter(x, real(0)), np.nextafter(x, real(np.inf)))]
    assert worst(kernel, [float(y) for y in values]) < float(ULPS[kernel[0]])


def test_hardest_arguments(kernel: tuple[str, ctypes.CDLL]) -> None:
    """The double and the float that come nearest to a multiple of π/2."""
    hardest = {"double": 6381956970095103 * 2.0**797, "float": 16367173 * 2.0**72}[kernel[0]]
    assert worst(kernel, [hardest, -hardest]) < float(ULPS[kernel[0]])


def test_exact_cases(kernel: tuple[str, ctypes.CDLL]) -> None:
    x, s, c = pairs(kernel, [0.0, -0.0, math.inf, -math.inf, math.nan, 5e-324, 1e-45])
    assert (s[:2] == 0).all() and (np.signbit(s[:2]) == [False, True]).all() and (c[:2] == 1).all()
    assert np.isnan(s[2:5]).all() and np.isnan(c[2:5]).all()
    assert (s[5:] == x[5:]).all() and (c[5:] == 1).all()


def test_odd_and_even(kernel: tuple[str, ctypes.CDLL]) -> None:
    rng = random.Random(4)
    values = [rng.uniform(0, 10.0**k) for k in range(-3, 12) for _ in range(20)]
    _, s, c = pairs(kernel, values)
    _, minus_s, minus_c = pairs(kernel, [-x for x in values])
    assert (s == -minus_s).all() and (c == minus_c).all()


@pytest.mark.parametrize("cc", COMPILERS)
@pytest.mark.parametrize("march", ["", "-march=native"])
@PRECISIONS
def test_four_at_a_time_have_the_bits_of_one(precision: str, march: str, cc: str, tmp_path: Path) -> None:
    """In range, beyond it, near multiples of pi/2, zeros of both signs, infinities and NaN, in every lane."""
    (tmp_path / "s.c").write_text(source(precision))
    library = compile_library(tmp_path, ["s.c"], cc, ["-O3", *[march] * bool(march)])
    rng = random.Random(7)
    values = [rng.uniform(-(10.0**k), 10.0**k) for k in range(-9, 12) for _ in range(40)]
    values += [k * math.pi / 2 for k in range(-40, 40)] + [0.0, -0.0, math.inf, -math.inf, math.nan, 1e-320, -1e30]
    values += [float(BOUND[precision]) * sign for sign in (1, -1, 1.0001)]
    rng.shuffle(values)
    x = np.resize(np.array(values, TYPES[precision]), 4 * (len(values) // 4 + 1))
    _, s, c = pairs((precision, library), x)
    fours = np.empty_like(x), np.empty_like(x)
    library.many_fours(ctypes.c_size_t(len(x)), pointer(x), pointer(fours[0]), pointer(fours[1]))
    for one, four in zip((s, c), fours, strict=True):
        same = (one == four) & (np.signbit(one) == np.signbit(four)) | np.isnan(one) & np.isnan(four)
        assert same.all(), x[~same]


@pytest.mark.skipif(which("clang") is None, reason="no clang")
@PRECISIONS
def test_same_bits_from_every_compiler(precision: str, tmp_path: Path) -> None:
    """With contraction off; also at other optimisation levels."""
    (tmp_path / "s.c").write_text(source(precision))
    rng = random.Random(5)
    values = [rng.uniform(-(10.0**k), 10.0**k) for k in range(-6, 30) for _ in range(30)]
    results = []
    for cc, flags in (("gcc", ["-O0"]), ("gcc", ["-O3", "-march=native"]), ("clang", ["-O2"])):
        (tmp_path / f"lib_{cc}.so").unlink(missing_ok=True)
        folder = tmp_path / f"{cc}{flags[0]}"
        folder.mkdir()
        (folder / "s.c").write_text(source(precision))
        results.append(pairs((precision, compile_library(folder, ["s.c"], cc, flags)), values))
    for _, s, c in results[1:]:
        assert s.tobytes() == results[0][1].tobytes() and c.tobytes() == results[0][2].tobytes()


@pytest.mark.parametrize("cc", COMPILERS)
@pytest.mark.parametrize("trigonometry", ["polynomial", "libm"])
@PRECISIONS
def test_entire_functions(precision: str, trigonometry: str, cc: str, tmp_path: Path) -> None:
    """cos √x, sin √x/√x and (√x − sin √x)/√x³, small and large, also at the joints of their pieces."""
    (tmp_path / "s.c").write_text(source(precision, trigonometry))
    library = compile_library(tmp_path, ["s.c"], cc, ["-O2"])
    rng = random.Random(6)
    values = [0.0, 1e-30, 0.6168, 0.61685, 4.0, 4.0000001, math.pi**2, 4 * math.pi**2]
    values += [rng.uniform(0, top) for top in (1e-4, 0.7, 5, 40, 1e4) for _ in range(100)]
    x = np.asarray(values, TYPES[precision])
    exact: dict[str, Callable[[Any], Any]] = {
        "cos_sqrt": mpmath.cos,
        "sinc_sqrt": mpmath.sinc,
        "sinc3_sqrt": lambda y: (y - mpmath.sin(y)) / y**3 if y else mpmath.mpf(1) / 6,
    }
    for name, function in exact.items():
        y = np.empty_like(x)
        getattr(library, f"many_{name}")(ctypes.c_size_t(len(x)), pointer(x), pointer(y))
        with mpmath.workprec(200):
            for a, b in zip(x, y, strict=True):
                value = function(mpmath.sqrt(mpmath.mpf(float(a))))
                error = ulps(b, value, precision)
                if name == "cos_sqrt":  # stated in ulp of 1
                    error = float(abs(mpmath.mpf(float(b)) - value)) * 2.0 ** (BITS[precision][0] - 1)
                assert error < float(ENTIRE_ULPS[precision]), (name, a)


@PRECISIONS
def test_enclosure_bounds_what_is_measured(precision: str) -> None:
    """The proven bound lies above the error of the exact polynomial, and below a quarter of an ulp."""
    bound = enclosure(precision)
    kernel = sincos.KERNELS[precision]
    coefficients = [sincos.as_stored(c, precision) for c in kernel.sine]
    with mpmath.workprec(250):
        measured = mpmath.mpf(0)
        for k in range(1, 200):
            y = mpmath.mpf("0.7864") * k / 199
            tail = sum(mpmath.mpf(c.numerator) / c.denominator * y ** (2 * i + 3) for i, c in enumerate(coefficients))
            measured = max(measured, abs((y + tail) / mpmath.sin(y) - 1))
    assert measured <= mpmath.mpf(bound.sine.numerator) / bound.sine.denominator < 4 * measured
    unit = Fraction(1, 2 ** BITS[precision][0])
    assert bound.sine < unit / 4 and bound.cosine < unit / 4 and bound.reduction < unit / 4 and bound.sinc3 < unit


@PRECISIONS
def test_enclosure_can_fail(precision: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A digit changed in a coefficient or a part of π/2 shows."""
    kernel = sincos.KERNELS[precision]
    honest = enclosure(precision)
    enclosure.cache_clear()
    try:
        for field in ("sine", "cosine", "sinc3", "half_pi"):
            values = list(getattr(kernel, field))
            digits = values[1]
            place = next(i for i, c in enumerate(digits) if c in "123456789") + 4
            values[1] = digits[:place] + str((int(digits[place]) + 5) % 10) + digits[place + 1 :]
            changed = {**sincos.KERNELS, precision: type(kernel)(**{**vars(kernel), field: tuple(values)})}
            monkeypatch.setattr(sincos, "KERNELS", changed)
            enclosure.cache_clear()
            name = "reduction" if field == "half_pi" else field
            assert getattr(enclosure(precision), name) > 8 * getattr(honest, name)
    finally:
        monkeypatch.undo()
        enclosure.cache_clear()


def test_pi_is_enclosed() -> None:
    low, high = sincos.pi_bounds()
    with mpmath.workprec(400):
        assert mpmath.mpf(low.numerator) / low.denominator < mpmath.pi < mpmath.mpf(high.numerator) / high.denominator
    assert 0 < high - low < Fraction(1, 2**180)


def test_bits_of_two_over_pi() -> None:
    low, high = sincos.pi_bounds()
    shown = Fraction(int("".join(f"{w:08X}" for w in sincos.TWO_OVER_PI[3:8]), 16), 2**160)
    assert abs(shown - 2 / low) < Fraction(1, 2**158) and abs(shown - 2 / high) < Fraction(1, 2**158)
    with mpmath.workprec(1400):
        exact = int(mpmath.floor(2 / mpmath.pi * mpmath.mpf(2) ** (32 * 38)))
    assert int("".join(f"{w:08X}" for w in sincos.TWO_OVER_PI[3:]), 16) == exact


@pytest.mark.slow
def test_the_tool_writes_these_coefficients() -> None:
    tool = Path(__file__).parents[2] / "tools" / "sincos_coefficients.py"
    assert subprocess.run([sys.executable, str(tool), "--check"], check=False).returncode == 0
