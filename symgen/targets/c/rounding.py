"""Proof that a printed literal is a rational correctly rounded. Shares nothing with the code that prints literals."""

from __future__ import annotations

import math
import re
import struct
from fractions import Fraction
from functools import lru_cache

from symgen.errors import CertificateError

LITERAL = re.compile(r"(\d+)\.(\d+)(?:e(-?\d+))?(f?)", re.ASCII)
"""The only form of number that emitted arithmetic may hold."""

_RANGE = {
    "double": (Fraction(1, 2**1074), Fraction(2**1024 - 2**970)),
    "float": (Fraction(1, 2**149), Fraction(2**128 - 2**103)),
}
"""Smallest number a format holds, and where overflow begins."""


@lru_cache(maxsize=1 << 14)  # long functions say few numbers often
def literal_value(text: str, precision: str) -> Fraction:
    """The decimal a literal spells, exactly. Raises CertificateError for other forms."""
    match = LITERAL.fullmatch(text)
    if match is None or (match[4] == "f") != (precision == "float"):
        raise CertificateError(f"{text} is no literal of {precision} precision")
    whole, part, exponent, _ = match.groups()
    places = int(exponent or 0) - len(part)
    value = Fraction(int(whole + part)) * Fraction(10) ** (places if abs(places) < 1000 else 1000)
    low, high = _RANGE[precision]
    if value and not low <= value < high:
        raise CertificateError(f"{text} is out of range")
    return value


def _float_bits(x: float) -> int:
    return int.from_bytes(struct.pack("<f", x), "little")


def _float_of(bits: int) -> float:
    (x,) = struct.unpack("<f", bits.to_bytes(4, "little"))
    return float(x)


def _neighbours(x: float, precision: str) -> tuple[float, float]:
    """The next numbers of the format below and above x ≥ 0."""
    if precision == "double":
        return math.nextafter(x, -math.inf), math.nextafter(x, math.inf)
    bits = _float_bits(x)
    return -_float_of(1) if bits == 0 else _float_of(bits - 1), _float_of(bits + 1)


def _is_even(x: float, precision: str) -> bool:
    bits = int.from_bytes(struct.pack("<d", x), "little") if precision == "double" else _float_bits(x)
    return bits % 2 == 0


def rounds_to(value: Fraction, x: float, precision: str) -> bool:
    """True if x is ``value`` rounded to nearest, ties to even: value lies between the midpoints to x's neighbours."""
    below, above = _neighbours(x, precision)
    if math.isinf(above) or math.isinf(x):
        return False
    low, high = (Fraction(below) + Fraction(x)) / 2, (Fraction(x) + Fraction(above)) / 2
    return low < value < high or (_is_even(x, precision) and value in (low, high))


def check_literal(text: str, value: Fraction, precision: str) -> None:
    """Raise CertificateError unless a compiler reads ``text`` as ``value`` ≥ 0 correctly rounded."""
    spelled = literal_value(text, precision)
    x = float(text.rstrip("f"))
    if precision == "float":
        x = _float_of(_float_bits(x))
    if not (rounds_to(spelled, x, precision) and rounds_to(value, x, precision)):
        raise CertificateError(f"{text} is not {value} correctly rounded to {precision}")
