"""C expressions as text with a binding level and a sign, joined without changing a single rounding.

The tree of floating-point operations stays exactly that of the program. Only exact rewrites are made: signs move
through products, quotients and sums; a negation becomes a subtraction; the constant of a product goes first.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from symgen.program.instructions import Counts

SUM, PRODUCT, ATOM = 1, 2, 3


class Expression(NamedTuple):
    """Text of a magnitude, and a sign that the consumer may fold into its own operator. (A named tuple: texts have
    hundreds of thousands.)"""

    text: str
    level: int = ATOM
    negative: bool = False
    depth: int = 0
    """Parentheses within parentheses."""
    constant: bool = False
    """A literal or a named constant."""

    def signed(self) -> str:
        if not self.negative:
            return self.text
        return f"-{self.within(PRODUCT)}"

    def within(self, level: int) -> str:
        """The magnitude as an operand of an operator that binds like ``level``."""
        return self.text if self.level >= level else f"({self.text})"

    def negated(self) -> Expression:
        return Expression(self.text, self.level, not self.negative, self.depth, self.constant)


def total(a: Expression, b: Expression) -> Expression:
    """a + b."""
    if a.negative and b.negative:
        return total(a.negated(), b.negated()).negated()
    if a.negative:
        a, b = b, a
    sign = "-" if b.negative else "+"
    right, depth = (b.text, b.depth) if b.level >= PRODUCT else (f"({b.text})", b.depth + 1)
    return Expression(f"{a.text} {sign} {right}", SUM, False, depth if depth > a.depth else a.depth)


def product(a: Expression, b: Expression) -> Expression:
    """a · b."""
    if b.constant and not a.constant:
        a, b = b, a
    return _scaled(a, "*", b)


def quotient(a: Expression, b: Expression) -> Expression:
    """a / b."""
    return _scaled(a, "/", b)


def _scaled(a: Expression, operator: str, b: Expression) -> Expression:
    left, depth = (a.text, a.depth) if a.level >= PRODUCT else (f"({a.text})", a.depth + 1)
    right, other = (b.text, b.depth) if b.level >= ATOM else (f"({b.text})", b.depth + 1)
    return Expression(
        f"{left} {operator} {right}", PRODUCT, a.negative != b.negative, other if other > depth else depth
    )


def call(function: str, argument: Expression) -> Expression:
    return Expression(f"{function}({argument.signed()})", depth=argument.depth + 1)


_UNARY = re.compile(r"-(?:(?<=[=(,]-)|(?<=[-=(,+*/] -))([A-Za-z_(][A-Za-z0-9_]*)")
"""Begins with a character that is searched for at once: texts are long."""
_ANGLES = re.compile(r"angles\[\d+\] = \{([^}]*)\}")
_TURNS = ("sine_cosine(", "sine(", "cosine(", "sin(", "sinf(", "cos(", "cosf(")
_ENTIRE = ("cos_sqrt(", "sinc_sqrt(", "sinc3_sqrt(")


def count_operations(text: str, constants: Iterable[str]) -> Counts:
    """What statements perform. A unary minus counts as an addition, unless a constant takes it;
    a sine and a cosine of one argument count as one pair."""
    known = set(constants)
    negations = sum(name not in known for name in _UNARY.findall(text))
    pairs = {argument for call in _TURNS for argument in _arguments(text, call)} - {"angles"}
    pairs |= {angle.strip() for angles in _ANGLES.findall(text) for angle in angles.split(",")} - {"0.0", "0.0f"}
    entire = sum(text.count(call) for call in _ENTIRE)
    return Counts(
        add=text.count(" + ") + text.count(" - ") + negations,
        mul=text.count(" * "),
        div=text.count(" / "),
        sqrt=text.count("sqrt(") - entire + text.count("sqrtf("),
        sincos=len(pairs) + entire,
    )


def _arguments(text: str, call: str) -> Iterator[str]:
    """The first argument of every call that is a statement or a definition of its own."""
    start = text.find(call)
    while start >= 0:
        inside = start + len(call)
        end = text.find(";", inside)
        if not _is_of_a_name(text[start - 1 : start]):
            yield text[inside:end].partition(", &")[0].removesuffix(")")
        start = text.find(call, inside)


def _is_of_a_name(character: str) -> bool:
    return character.isalnum() or character == "_"
