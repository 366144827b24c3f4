#!/usr/bin/env python3
"""Derive the numbers of the built-in trigonometry and write symgen/targets/c/coefficients.py.

Minimax polynomials by Remez' exchange in 60 digits, coefficients rounded one after the other (the ones that weigh
most first), each time refitting the rest; π/2 in parts for the argument reduction; the bits of 2/π. Needs mpmath.

    python tools/sincos_coefficients.py            (--check: only say by the exit status whether the file is up to date)
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from mpmath import cos, cospi, floor, lu_solve, matrix, mp, mpf, pi, sin, sqrt

mp.dps = 60
HALF_RANGE = mpf("0.7864")  # a little over pi/4: the rounding of x/(pi/2) may be off by that much
RANGE = HALF_RANGE**2
SINC3_RANGE = mpf(4)
GRID = 1500

Function = Callable[[mpf], mpf]


def series(x: mpf, first: int) -> mpf:
    """Σ (−1)^k x^k / (first + 2k)!, k = 0…: what is left of sine and cosine after their leading terms."""
    term = mpf(1)
    for i in range(2, first + 1):
        term /= i
    total, k = mpf(0), 0
    while abs(term) > mpf(10) ** -58:
        total += term
        term *= -x / ((first + 2 * k + 1) * (first + 2 * k + 2))
        k += 1
    return total


def sine_tail(x: mpf) -> mpf:
    """(sin y / y − 1) / y², x = y²."""
    return -series(x, 3)


def cosine_tail(x: mpf) -> mpf:
    """(cos y − 1 + y²/2) / y⁴."""
    return series(x, 4)


def sinc3(x: mpf) -> mpf:
    """(y − sin y) / y³."""
    return series(x, 3)


def remez(f: Function, weight: Function, upper: mpf, known: list[mpf], degree: int) -> list[mpf]:
    """Coefficients len(known)…degree of the polynomial that starts with ``known``, minimal in max |weight·(p − f)|."""
    skip = len(known)
    unknowns = degree + 1 - skip

    def residual(x: mpf) -> mpf:
        return f(x) - sum((c * x**k for k, c in enumerate(known)), mpf(0))

    points = [upper * (1 - cospi(mpf(2 * i + 1) / (2 * unknowns + 2))) / 2 for i in range(unknowns + 1)]
    grid = [upper * (1 - cospi(mpf(i) / GRID)) / 2 for i in range(GRID + 1)][1:]
    values = [(x, residual(x), weight(x)) for x in grid]
    solution: list[mpf] = []
    for _ in range(12):
        rows = [[x ** (skip + k) for k in range(unknowns)] + [(-1) ** i / weight(x)] for i, x in enumerate(points)]
        solved = lu_solve(matrix(rows), matrix([residual(x) for x in points]))
        solution = [solved[k] for k in range(unknowns)]
        errors = [w * (sum((c * x ** (skip + k) for k, c in enumerate(solution)), mpf(0)) - r) for x, r, w in values]
        points = _extrema(grid, errors, unknowns + 1) or points
    return solution


def _extrema(grid: list[mpf], errors: list[mpf], wanted: int) -> list[mpf] | None:
    """The largest error of each run of one sign."""
    runs: list[tuple[mpf, mpf]] = []
    for x, e in zip(grid, errors, strict=True):
        if runs and runs[-1][1] * e > 0:
            runs[-1] = max(runs[-1], (x, e), key=lambda run: abs(run[1]))
        else:
            runs.append((x, e))
    while len(runs) > wanted:
        runs.pop(0 if abs(runs[0][1]) < abs(runs[-1][1]) else -1)
    return [x for x, _ in runs] if len(runs) == wanted else None


def rounded(value: mpf, bits: int) -> mpf:
    """To nearest with that many bits."""
    if value == 0:
        return value
    exponent = floor(mp.log(abs(value), 2)) - bits + 1
    return mpf(mp.nint(value / mpf(2) ** exponent)) * mpf(2) ** exponent


def fit(f: Function, weight: Function, upper: mpf, degree: int, bits: int) -> list[mpf]:
    known: list[mpf] = []
    while len(known) <= degree:
        known.append(rounded(remez(f, weight, upper, known, degree)[0], bits))
    return known


def parts(value: mpf, bits: list[int]) -> list[mpf]:
    """``value`` as a sum: each part but the last is cut to so many bits, the last is rounded."""
    result = []
    for i, n in enumerate(bits):
        if i + 1 == len(bits):
            result.append(rounded(value, n))
        else:
            exponent = floor(mp.log(value, 2)) - n + 1
            result.append(floor(value / mpf(2) ** exponent) * mpf(2) ** exponent)
        value -= result[-1]
    return result


def exact(value: mpf) -> Fraction:
    sign, mantissa, exponent, _ = value._mpf_
    return Fraction(int(mantissa)) * Fraction(2) ** exponent * (-1 if sign else 1)


def spelled(values: list[mpf], suffix: str, digits: int) -> str:
    rows = []
    for value in values:
        text = mp.nstr(value, digits, strip_zeros=False, min_fixed=-5, max_fixed=5).replace("e-", "e-")
        read = mpf(text)
        assert abs(read - value) < abs(value) * mpf(10) ** (1 - digits)
        rows.append(f'    "{text}{suffix}",\n')
    return "(\n" + "".join(rows) + ")"


def kernel(name: str, bits: int, degrees: tuple[int, int, int], half_pi: list[int], suffix: str, digits: int) -> str:
    sine = fit(sine_tail, lambda x: x * sqrt(x) / sin(sqrt(x)), RANGE, degrees[0], bits)
    cosine = fit(cosine_tail, lambda x: x * x / cos(sqrt(x)), RANGE, degrees[1], bits)
    third = [rounded(c, bits) for c in remez(sinc3, lambda x: 1 / sinc3(x), SINC3_RANGE, [], degrees[2])]
    reduction = parts(pi / 2, half_pi)
    return (
        (
            f"{name} = Kernel(\n"
            f"    sine={spelled(sine, suffix, digits)},\n    cosine={spelled(cosine, suffix, digits)},\n"
            f"    sinc3={spelled(third, suffix, digits)},\n    half_pi={spelled(reduction, suffix, digits)},\n)\n"
        )
        .replace('\n    "', '\n        "')
        .replace("\n),", "\n    ),")
    )


HEADER = '''"""Numbers of the built-in trigonometry. Written by tools/sincos_coefficients.py: change that, not this."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kernel:
    """C literals: polynomials in y² by rising power, and the parts of π/2."""

    sine: tuple[str, ...]
    """(sin y / y − 1) / y² for |y| ≤ HALF_RANGE."""
    cosine: tuple[str, ...]
    """(cos y − 1 + y²/2) / y⁴ for |y| ≤ HALF_RANGE."""
    sinc3: tuple[str, ...]
    """(y − sin y) / y³ for y² ≤ SINC3_RANGE."""
    half_pi: tuple[str, ...]


HALF_RANGE = "0.7864"
SINC3_RANGE = "4"

'''


def main() -> None:
    words = floor(2 / pi * 0) or 0
    with mp.workprec(1400):
        scaled = int(floor(2 / pi * mpf(2) ** (32 * 38)))
        words = [0, 0, 0] + [(scaled >> (32 * (37 - i))) & 0xFFFFFFFF for i in range(38)]
    text = HEADER
    text += kernel("DOUBLE", 53, (5, 5, 10), [35, 34, 53], "", 17) + "\n"
    text += kernel("FLOAT", 24, (2, 2, 5), [13, 12, 24], "f", 9) + "\n"
    text += "TWO_OVER_PI = (\n" + "".join(f"    0x{word:08X},\n" for word in words) + ")\n"
    text += '"""2/π in words of 32 bits, after three words of nothing."""\n'
    path = Path(__file__).resolve().parents[1] / "symgen" / "targets" / "c" / "coefficients.py"
    if "--check" in sys.argv[1:]:
        sys.exit(text != path.read_text(encoding="utf-8"))
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
