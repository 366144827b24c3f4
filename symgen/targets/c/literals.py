"""Exact rationals as C literals, and the table of those that no short decimal can say.

A rational that is a decimal of at most 17 digits stands inline, and its text *is* the rational. Any other
one gets a name in a table at the top of the file, and its literal is the rational correctly rounded, straight
to the precision of the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from symgen.errors import NotSupportedError
from symgen.program.instructions import Program
from symgen.targets.c.names import Names

DIGITS = 17
"""Significant digits of a decimal that may stand inline; also what tells two doubles apart."""


@dataclass(frozen=True)
class Precision:
    """A C floating type: its keyword, literal suffix, function suffix and IEEE 754 format."""

    name: str
    c_type: str
    literal_suffix: str
    symbol_suffix: str
    bits: int
    min_exponent: int
    """Exponent of the last bit of the smallest normal number."""
    max_exponent: int
    digits: int
    """Decimal digits that tell two values apart."""


PRECISIONS = {
    "double": Precision("double", "double", "", "", 53, -1074, 1024, 17),
    "float": Precision("float", "float", "f", "_f32", 24, -149, 128, 9),
}


@dataclass(frozen=True)
class Constant:
    """A named constant of the file: ``name`` stands for exactly ``value``, printed as ``literal``."""

    name: str
    value: Fraction
    literal: str

    @property
    def comment(self) -> str:
        if self.value.numerator.bit_length() + self.value.denominator.bit_length() > 160:
            return ""  # along a long chain constants have thousands of digits
        text = str(self.value)
        return text if len(text) <= 45 else ""


def round_to(value: Fraction, precision: Precision) -> Fraction:
    """``value`` rounded to nearest, ties to even, in the format of ``precision`` (no double rounding).

    Raises NotSupportedError where the format has no nearest non-zero finite number.
    """
    if value == 0:
        return value
    magnitude = abs(value)
    exponent = magnitude.numerator.bit_length() - magnitude.denominator.bit_length() - precision.bits
    if magnitude >= Fraction(2) ** (exponent + precision.bits):
        exponent += 1
    exponent = max(exponent, precision.min_exponent)
    unit = Fraction(2) ** exponent
    mantissa = round(magnitude / unit)  # Fraction rounds ties to even
    result = mantissa * unit
    if mantissa == 0:
        raise NotSupportedError(f"the constant {_short(value)} is too small for {precision.name} precision")
    if result >= Fraction(2) ** precision.max_exponent:
        raise NotSupportedError(f"the constant {_short(value)} is too large for {precision.name} precision")
    return result if value > 0 else -result


def _short(value: Fraction) -> str:
    if value.numerator.bit_length() + value.denominator.bit_length() > 120:
        magnitude = (value.numerator.bit_length() - value.denominator.bit_length()) * 0.30103
        return f"of the size of 1e{magnitude:.0f}"
    return str(value)


def exact_decimal(value: Fraction) -> tuple[int, int] | None:
    """(digits, exponent) with |value| = digits · 10^exponent and at most 17 digits; None if there is none."""
    numerator, denominator = abs(value.numerator), value.denominator
    if numerator == 0:
        return 0, 0
    twos = (denominator & -denominator).bit_length() - 1
    rest = denominator >> twos
    fives = 0
    while rest % 5 == 0:
        rest //= 5
        fives += 1
    if rest != 1 or max(twos, fives) > 400:
        return None
    places = max(twos, fives)
    digits = numerator * 2 ** (places - twos) * 5 ** (places - fives)
    exponent = -places
    while digits % 10 == 0:
        digits //= 10
        exponent += 1
    return (digits, exponent) if digits < 10**DIGITS else None


def spell(digits: int, exponent: int) -> str:
    """digits · 10^exponent as a C literal, always with a decimal point."""
    text = str(digits)
    point = len(text) + exponent  # digits before the point
    if 0 < point <= 16:
        whole, part = text[:point].ljust(point, "0"), text[point:]
        return f"{whole}.{part or '0'}"
    if -4 <= point <= 0:
        return f"0.{'0' * -point}{text}" if digits else "0.0"
    return f"{text[0]}.{text[1:] or '0'}e{point - 1}"


def rounded_literal(value: Fraction, precision: Precision) -> str:
    """The correctly rounded literal of ``value`` ≥ 0, with as many digits as tell neighbours apart."""
    rounded = float(round_to(value, precision))  # exact: every format here lies inside double
    mantissa, _, exponent = f"{rounded:.{precision.digits - 1}e}".partition("e")
    digits = mantissa.replace(".", "").rstrip("0") or "0"
    return spell(int(digits), int(exponent) - len(digits) + 1) + precision.literal_suffix


def inline_literal(value: Fraction, precision: Precision) -> str | None:
    """The literal of ``value`` ≥ 0 that says it exactly, or None if it needs a name."""
    decimal = exact_decimal(value)
    if decimal is None:
        return None
    round_to(value, precision)  # refuses what the format cannot hold
    return spell(*decimal) + precision.literal_suffix


@dataclass(frozen=True)
class ConstantTable:
    """The named constants of one file, by magnitude: a negative one is written −name."""

    precision: Precision
    by_value: dict[Fraction, Constant]

    def __iter__(self) -> Iterator[Constant]:
        return iter(self.by_value.values())

    def text(self, magnitude: Fraction) -> str:
        constant = self.by_value.get(magnitude)
        if constant is not None:
            return constant.name
        literal = inline_literal(magnitude, self.precision)
        assert literal is not None, magnitude
        return literal


def constant_table(programs: Iterable[Program], precision: Precision, names: Names) -> ConstantTable:
    """Names, in order of first use, for the constants of ``programs`` that need one."""
    table: dict[Fraction, Constant] = {}
    seen: set[Fraction] = set()
    for program in programs:
        for instruction in program.instructions:
            if instruction.op != "const":
                continue
            assert isinstance(instruction.value, Fraction)
            magnitude = abs(instruction.value)
            if magnitude in seen:
                continue
            seen.add(magnitude)
            if inline_literal(magnitude, precision) is None:
                name = names.take(f"k_{instruction.label}" if instruction.label else f"k{len(table) + 1}")
                table[magnitude] = Constant(name, magnitude, rounded_literal(magnitude, precision))
    return ConstantTable(precision, table)
