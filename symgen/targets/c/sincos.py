"""The built-in trigonometry: its C text, and a proof of what its polynomials and its reduction lose."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import factorial

from symgen.targets.c.coefficients import DOUBLE, FLOAT, HALF_RANGE, SINC3_RANGE, TWO_OVER_PI, Kernel
from symgen.targets.c.literals import PRECISIONS, round_to
from symgen.targets.c.templates import render

ENTIRE = ("cos_sqrt", "sinc_sqrt", "sinc3_sqrt")
KERNELS = {"double": DOUBLE, "float": FLOAT}

BOUND = {"double": 100000, "float": 1000}
"""Largest |x| that is reduced in floating point; beyond, integers."""
ULPS = {"double": "1", "float": "1"}
ENTIRE_ULPS = {"double": "2", "float": "2"}
LEAST = {"double": Fraction(1, 2**56), "float": Fraction(1, 2**22)}
"""|r| / |n| below which too little is left of x and the integers take over."""

_BREAK = "\n        "
"""Where a polynomial goes on in the next line."""

_NUMBERS: dict[str, dict[str, str]] = {
    "double": {
        "real": "double",
        "f": "",
        "shifter": "6755399441055744.0",  # 1.5 · 2^52
        "two_over_pi": "0.63661977236758134",
        "bound": "1.0e5",
        "least": "1.3877787807814457e-17",  # 2^-56
        "largest": "1.7976931348623157e308",
        "splitter": "134217729.0",  # 2^27 + 1
        "small": "0.6168",  # below (pi/4)^2
        "sinc3_range": "4.0",
    },
    "float": {
        "real": "float",
        "f": "f",
        "shifter": "12582912.0f",  # 1.5 · 2^23
        "two_over_pi": "0.636619747f",
        "bound": "1.0e3f",
        "least": "2.38418579e-7f",  # 2^-22
        "largest": "3.40282347e38f",
        "splitter": "4097.0f",  # 2^12 + 1
        "small": "0.6168f",
        "sinc3_range": "4.0f",
    },
}


def helper_functions(precision: str, trigonometry: str, called: Collection[str]) -> str:
    """The C text of the static functions that a file needs which calls ``called``. May be empty."""
    built_in = trigonometry == "polynomial"
    macro = render("c/scalar.c.j2")
    macro += render("c/part.c.j2") if "parts" in called else ""
    macro += render("c/step.c.j2") if "steps" in called else ""
    entire = [name for name in ENTIRE if name in called]
    text = ""
    numbers = _NUMBERS[precision]
    kernel = KERNELS[precision]
    if built_in and (entire or {"sines_cosines", "sine_cosine", "sine", "cosine"} & set(called)):
        words = [f"0x{word:08X}u" for word in (TWO_OVER_PI if precision == "double" else TWO_OVER_PI[:11])]
        text += render(f"c/reduce_{precision}.c.j2", words=words)
        text += render(
            "c/sine_cosine.c.j2",
            parts=called,
            ulps=ULPS[precision],
            size=8 if precision == "double" else 4,
            half_pi=kernel.half_pi,
            sine_z=polynomial(kernel.sine, "z", _BREAK),
            cosine_z=polynomial(kernel.cosine, "z", _BREAK),
            **numbers,
        )
    if entire:
        real, f = numbers["real"], numbers["f"]
        own, library = f"{real} s, c;\n        sine_cosine(y, &s, &c);", f"const {real} s = sin{f}(y), c = cos{f}(y);"
        text += render(
            "c/entire.c.j2",
            parts=entire,
            pair=own if built_in else library,
            entire_ulps=ENTIRE_ULPS[precision],
            sine_x=polynomial(kernel.sine, "x", _BREAK + "    "),
            cosine_x=polynomial(kernel.cosine, "x", _BREAK + "    "),
            sinc3_x=polynomial(kernel.sinc3, "x", _BREAK + "    "),
            **numbers,
        )
    return (macro + text).rstrip("\n")


def vector_numbers(precision: str) -> dict[str, object]:
    """What the sine and cosine of vectors are written with: the numbers of `sine_cosine`, and bounds as bits."""
    numbers, kernel = _NUMBERS[precision], KERNELS[precision]
    bits, f = (64 if precision == "double" else 32), numbers["f"]
    bound, least = BOUND[precision], 2 * LEAST[precision]
    return {
        "two_over_pi": numbers["two_over_pi"],
        "shifter": numbers["shifter"],
        "half_pi": kernel.half_pi,
        "sine_z": polynomial(kernel.sine, "z", _BREAK),
        "cosine_z": polynomial(kernel.cosine, "z", _BREAK),
        "bound": numbers["bound"],
        "bound_square": f"{bound**2 * (1 - 1e-6)!r}{f}",
        "least_square": f"{float(least**2)!r}{f}",
        "sign_bit": f"UINT{bits}_C(0x{1 << (bits - 1):X})",
        "quarter": f"UINT{bits}_C(0x{1 << (bits - 2):X})",
        "mask": f"__mmask{512 // bits}",
        "wide_type": "__m512d" if bits == 64 else "__m512",
        "wide_suffix": "pd" if bits == 64 else "ps",
        "unit": f"1.0{f}",
        "point_five": f"0.5{f}",
    }


def device_numbers(precision: str) -> dict[str, object]:
    """What the sine and cosine of other languages than C are written with: the numbers of `sine_cosine`."""
    numbers, kernel = _NUMBERS[precision], KERNELS[precision]
    return {
        **numbers,
        "half_pi": kernel.half_pi,
        "sine_z": polynomial(kernel.sine, "z", _BREAK),
        "cosine_z": polynomial(kernel.cosine, "z", _BREAK),
        "words": [f"0x{word:08X}u" for word in (TWO_OVER_PI if precision == "double" else TWO_OVER_PI[:11])],
    }


def polynomial(coefficients: Sequence[str], x: str, indent: str = " ") -> str:
    """Σ cₖ xᵏ as C: pairs, then Horner in w = x², which is shorter than Horner in x by half its latency."""
    pairs = [
        coefficients[k] if k + 1 == len(coefficients) else f"({coefficients[k]} {_plus(coefficients[k + 1])} * {x})"
        for k in range(0, len(coefficients), 2)
    ]
    text = pairs.pop()
    while pairs:
        text = f"{pairs.pop()}{indent}+ w * {text}"
        text = f"({text})" if pairs else text
    return text


def _plus(literal: str) -> str:
    return f"- {literal[1:]}" if literal.startswith("-") else f"+ {literal}"


@dataclass(frozen=True)
class Enclosure:
    """Proven bounds, not counting the roundings of the evaluation itself (those are measured, in ulp).

    ``sine`` and ``cosine``: |polynomial − function| relative to the function, |y| ≤ ``half_range``.
    ``sinc3``: likewise for y² ≤ 4. ``reduction``: |r − t − (x − n·π/2)| / |r| where the fast path is taken.
    """

    precision: str
    half_range: Fraction
    sine: Fraction
    cosine: Fraction
    sinc3: Fraction
    reduction: Fraction


@cache
def enclosure(precision: str = "double") -> Enclosure:
    """Bounds for the numbers that are emitted, in exact rational arithmetic."""
    kernel = KERNELS[precision]
    half = Fraction(HALF_RANGE)
    z = half * half
    stored = {name: [as_stored(c, precision) for c in getattr(kernel, name)] for name in ("sine", "cosine", "sinc3")}
    # sin y / y ≥ 0.9 and cos y ≥ 0.7 for |y| ≤ 0.7864; sinc3 ≥ 0.13 for y² ≤ 4
    return Enclosure(
        precision,
        half,
        sine=_polynomial_error(stored["sine"], 3, -1, z, power=1) / Fraction(9, 10),
        cosine=_polynomial_error(stored["cosine"], 4, 1, z, power=2) / Fraction(7, 10),
        sinc3=_polynomial_error(stored["sinc3"], 3, 1, Fraction(SINC3_RANGE)) / Fraction(13, 100),
        reduction=_reduction_error(kernel, precision),
    )


def as_stored(literal: str, precision: str) -> Fraction:
    """The number a compiler makes of a literal."""
    return round_to(Fraction(literal.rstrip("f")), PRECISIONS[precision])


def _polynomial_error(
    coefficients: Sequence[Fraction], first: int, sign: int, upper: Fraction, power: int = 0
) -> Fraction:
    """A bound of x^power · |Σ cₖ xᵏ − sign·Σ (−x)ᵏ/(first + 2k)!| on [0, upper].

    The series is cut where its first left-out term, which bounds an alternating remainder, is negligible; the
    difference of polynomials is bounded on short intervals by its Taylor form about their middles.
    """
    terms = len(coefficients)
    while upper**terms / factorial(first + 2 * terms) > Fraction(1, 2**80):
        terms += 1
    remainder = upper ** (terms + power) / factorial(first + 2 * terms)
    series = [Fraction(sign * (-1) ** k, factorial(first + 2 * k)) for k in range(terms)]
    padded = [*coefficients, *[Fraction(0)] * (terms - len(coefficients))]
    difference = [Fraction(0)] * power + [a - b for a, b in zip(padded, series, strict=True)]
    pieces = 32
    scale = 2**160  # integers over one denominator: exact shifts without gcds, each rounded outward
    radius = upper / (2 * pieces)
    worst = 0
    for piece in range(pieces):
        middle = radius * (2 * piece + 1)
        shifted = [int(c * scale) for c in _shift(difference, middle)]
        bound, weight = 0, Fraction(1)
        for value in shifted:
            bound += int((abs(value) + 1) * weight) + 1
            weight *= radius
        worst = max(worst, bound)
    return Fraction(worst, scale) + remainder


def _shift(coefficients: Sequence[Fraction], middle: Fraction) -> list[Fraction]:
    """Coefficients in powers of x − middle (repeated synthetic division)."""
    values = list(coefficients)
    for start in range(len(values)):
        for k in range(len(values) - 2, start - 1, -1):
            values[k] += middle * values[k + 1]
    return values


def _reduction_error(kernel: Kernel, precision: str) -> Fraction:
    """Error of r − t relative to |r| on the fast path.

    n·P1 and n·P2 are exact (the parts are cut so that they are, see the tool), x − n·P1 and the error of its
    difference with n·P2 too. Left: the rounding of n·P3 and of w3, and n times what three parts miss of π/2.
    All are proportional to n, and the fast path asks for |r| ≥ LEAST·|n|.
    """
    bits = 53 if precision == "double" else 24
    parts = [as_stored(p, precision) for p in kernel.half_pi]
    low, high = pi_bounds()
    missed = max(abs(low / 2 - sum(parts)), abs(high / 2 - sum(parts)))
    unit = Fraction(1, 2**bits)
    # |(r1 − r2) − w2| ≤ ulp(1)/2, so |w3| ≤ n·P3 + unit; both roundings are relative to that
    per_turn = missed + unit * parts[2] + unit * (parts[2] + unit * 2 * unit)
    return per_turn / LEAST[precision] + unit**2 * 4


@cache
def pi_bounds() -> tuple[Fraction, Fraction]:
    """Machin: π = 16 arctan(1/5) − 4 arctan(1/239), alternating series cut either way."""

    def arctan(n: int, terms: int) -> Fraction:
        return sum((Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(terms)), Fraction(0))

    low = 16 * arctan(5, 60) - 4 * arctan(239, 21)
    high = 16 * arctan(5, 61) - 4 * arctan(239, 20)
    return low, high
