"""How mathematics is set: text, LaTeX, MathML. The same few pieces in each; nothing here knows what they mean."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Protocol

Name = tuple[str, int, tuple[str, ...]]
"""(letter, dots above it, subscripts; one that starts with ^ is a superscript)"""

GREEK = {
    "alpha": "α", "theta": "θ", "lambda": "λ", "pi": "π", "tau": "τ", "phi": "φ", "Phi": "Φ", "Psi": "Ψ", "omega": "ω",
    "gamma": "γ", "beta": "β",
}  # fmt: skip
SUFFIXES = frozenset({"x", "y", "z", "w", "xx", "yy", "zz", "xy", "xz", "yz", *"0123456789"})
_HEAD = re.compile(r"([A-Za-z]+?)(ddot|dot)?(\d*)$")
SPOKEN = {"w": ("omega", 0), "dw": ("omega", 1), "a": ("a", 0)}
"""Labels of programs that stand for a Greek letter."""


def parsed(name: str) -> Name:
    """``thetadot_elbow`` → (theta, 1, (elbow,)); ``w_link3_x`` → (omega, 0, (link3, x)); ``t12`` → (t, 0, (12,))."""
    head, *rest = name.split("_")
    match = _HEAD.match(head)
    if match is None:
        return name, 0, ()
    letter, dots, digits = match[1], {"": 0, "dot": 1, "ddot": 2}[match[2] or ""], match[3]
    if rest and not dots and letter in SPOKEN:
        letter, dots = SPOKEN[letter]
    last: list[str] = []
    while len(rest) > 1 and rest[-1] in SUFFIXES:
        last.insert(0, rest.pop())
    stem = "_".join(rest)
    return letter, dots, (*([digits] if digits else []), *([stem] if stem else []), *last)


def split_scripts(scripts: tuple[str, ...]) -> tuple[tuple[str, ...], str]:
    """(subscripts, superscript)"""
    above = "".join(part[1:] for part in scripts if part.startswith("^"))
    return tuple(part for part in scripts if not part.startswith("^")), above


class Style(Protocol):
    """One way of setting. Arguments are pieces already set, except names and texts."""

    def name(self, name: Name, bold: bool = False) -> str: ...
    def number(self, mantissa: str, exponent: int) -> str: ...
    def product(self, factors: Sequence[str]) -> str: ...
    def fraction(self, above: str, below: str, simple: bool) -> str:
        """``simple``: neither needs parentheses on one line."""
        ...

    def power(self, base: str, exponent: str) -> str: ...
    def root(self, inside: str) -> str: ...
    def call(self, function: str, argument: str, exponent: str) -> str:
        """``exponent`` may be empty."""
        ...

    def parentheses(self, inside: str) -> str: ...
    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        """(negative, term) …"""
        ...

    def matrix(self, rows: Sequence[Sequence[str]]) -> str: ...
    def equation(self, left: str, right: str) -> str: ...
    def transposed(self, base: str) -> str: ...
    def remark(self, text: str) -> str: ...
    def words(self, text: str) -> str:
        """A line of words that belongs to the equations."""
        ...

    def page(self, lines: Sequence[str]) -> str:
        """Several equations and remarks under each other."""
        ...


SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
WIDEST = 110
"""Columns of text a matrix may take before its entries are listed."""


def columns(text: str) -> int:
    """Columns of a terminal: combining dots take none."""
    return sum(1 for c in text if c not in "\u0307\u0308\u0304")


@dataclass(frozen=True)
class Text:
    """Unicode for terminals."""

    def name(self, name: Name, bold: bool = False) -> str:
        letter, dots, scripts = name
        subscripts, above = split_scripts(scripts)
        text = GREEK.get(letter, letter)
        text = text[0] + ("", "\u0307", "\u0308")[dots] + text[1:]
        if subscripts and all(part.isdigit() for part in subscripts):
            apart = "," if any(len(part) > 1 for part in subscripts) and len(subscripts) > 1 else ""
            text += apart.join(subscripts).translate(SUBSCRIPTS)
        else:
            text = "_".join((text, *subscripts))
        return text + above.translate(SUPERSCRIPTS)

    def number(self, mantissa: str, exponent: int) -> str:
        return f"{mantissa}e{exponent}" if exponent else mantissa

    def product(self, factors: Sequence[str]) -> str:
        return "·".join(factors)

    def fraction(self, above: str, below: str, simple: bool) -> str:
        return f"{above}/{below}"

    def power(self, base: str, exponent: str) -> str:
        return base + (exponent.translate(SUPERSCRIPTS) if re.fullmatch(r"-?\d+", exponent) else f"^({exponent})")

    def root(self, inside: str) -> str:
        return f"√({inside})"

    def call(self, function: str, argument: str, exponent: str) -> str:
        return function + exponent.translate(SUPERSCRIPTS) + f"({argument})"

    def parentheses(self, inside: str) -> str:
        return f"({inside})"

    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        (negative, first), *rest = terms
        return ("-" if negative else "") + first + "".join((" - " if n else " + ") + term for n, term in rest)

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        """Aligned, in brackets drawn over the lines."""
        widths = [max(columns(row[k]) for row in rows) for k in range(len(rows[0]))]
        lines = ["  ".join(x + " " * (w - columns(x)) for x, w in zip(row, widths, strict=True)) for row in rows]
        if len(lines) == 1:
            return f"[{lines[0]}]"
        ends = [("⎡", "⎤"), *[("⎢", "⎥")] * (len(lines) - 2), ("⎣", "⎦")]
        return "\n".join(f"{left}{line}{right}" for (left, right), line in zip(ends, lines, strict=True))

    def equation(self, left: str, right: str) -> str:
        lines = right.split("\n")
        head, indent = f"{left} = ", " " * (columns(left) + 3)
        middle = (len(lines) - 1) // 2
        return "\n".join((head if k == middle else indent) + line for k, line in enumerate(lines))

    def transposed(self, base: str) -> str:
        return f"{base}ᵀ"

    def remark(self, text: str) -> str:
        return f"({text})"

    def words(self, text: str) -> str:
        return text

    def page(self, lines: Sequence[str]) -> str:
        return "\n".join(lines)


@dataclass(frozen=True)
class Latex:
    """LaTeX with amsmath."""

    def name(self, name: Name, bold: bool = False) -> str:
        letter, dots, scripts = name
        subscripts, above = split_scripts(scripts)
        text = f"\\{letter}" if letter in GREEK else letter if len(letter) == 1 else f"\\mathrm{{{letter}}}"
        text = f"\\boldsymbol{{{text}}}" if bold and letter in GREEK else f"\\mathbf{{{text}}}" if bold else text
        text = ("{}", "\\dot{{{}}}", "\\ddot{{{}}}")[dots].format(text)
        apart = "," if any(len(part) > 1 for part in subscripts) else ""
        parts = [part if part.isdigit() or len(part) == 1 else self._upright(part) for part in subscripts]
        return text + (f"_{{{apart.join(parts)}}}" if parts else "") + (f"^{{{above}}}" if above else "")

    def _upright(self, text: str) -> str:
        return "\\mathrm{" + text.replace("_", "\\_") + "}"

    def number(self, mantissa: str, exponent: int) -> str:
        return f"{mantissa} \\cdot 10^{{{exponent}}}" if exponent else mantissa

    def product(self, factors: Sequence[str]) -> str:
        return " \\, ".join(factors)

    def fraction(self, above: str, below: str, simple: bool) -> str:
        return f"\\frac{{{above}}}{{{below}}}"

    def power(self, base: str, exponent: str) -> str:
        return f"{base}^{{{exponent}}}"

    def root(self, inside: str) -> str:
        return f"\\sqrt{{{inside}}}"

    def call(self, function: str, argument: str, exponent: str) -> str:
        head = f"\\{function}" if function in ("cos", "sin") else f"\\operatorname{{{function}}}"
        return head + (f"^{{{exponent}}}" if exponent else "") + f"\\left({argument}\\right)"

    def parentheses(self, inside: str) -> str:
        return f"\\left({inside}\\right)"

    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        (negative, first), *rest = terms
        return ("-" if negative else "") + first + "".join((" - " if n else " + ") + term for n, term in rest)

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        body = " \\\\\n".join("  " + " & ".join(row) for row in rows)
        return f"\\begin{{bmatrix}}\n{body}\n\\end{{bmatrix}}"

    def equation(self, left: str, right: str) -> str:
        return f"\\[\n{left} = {right}\n\\]"

    def transposed(self, base: str) -> str:
        return f"{base}^{{\\mathsf{{T}}}}"

    def remark(self, text: str) -> str:
        return f"% {text}"

    def words(self, text: str) -> str:
        return "\\[\\text{" + text.replace("_", "\\_") + "}\\]"

    def page(self, lines: Sequence[str]) -> str:
        return "\n".join(lines)


@dataclass(frozen=True)
class MathMl:
    """Presentation MathML of the Core set, which browsers show without help. (SymPy's own printer drops the parentheses
    of a negated sum.)"""

    def name(self, name: Name, bold: bool = False) -> str:
        letter, dots, scripts = name
        subscripts, above = split_scripts(scripts)
        letter = GREEK.get(letter, letter)
        text = self._letter(letter, bold)
        if dots:  # no accent="true": fonts without a table for mathematics would draw the dot into the letter
            text = f'<mover>{text}<mo stretchy="false">{"˙" if dots == 1 else "¨"}</mo></mover>'
        if not subscripts:
            return text
        apart = "<mo>,</mo>" if any(len(part) > 1 for part in subscripts) else ""
        parts = apart.join(f"<mn>{part}</mn>" if part.isdigit() else self._word(part) for part in subscripts)
        if above:
            return f"<msubsup>{text}<mrow>{parts}</mrow><mn>{above}</mn></msubsup>"
        return f"<msub>{text}<mrow>{parts}</mrow></msub>"

    def _letter(self, letter: str, bold: bool) -> str:
        if bold:
            return f'<mi mathvariant="normal" style="font-weight:bold">{escape(letter)}</mi>'
        return f"<mi>{escape(letter)}</mi>"

    def _word(self, text: str) -> str:
        return f"<mi>{escape(text)}</mi>" if len(text) == 1 else f"<mtext>{escape(text)}</mtext>"

    def number(self, mantissa: str, exponent: int) -> str:
        if not exponent:
            return f"<mn>{mantissa}</mn>"
        return f"<mrow><mn>{mantissa}</mn><mo>·</mo><msup><mn>10</mn><mn>{exponent}</mn></msup></mrow>"

    def product(self, factors: Sequence[str]) -> str:
        return "<mrow>" + "<mo>\u2062</mo>".join(factors) + "</mrow>"

    def fraction(self, above: str, below: str, simple: bool) -> str:
        return f"<mfrac>{above}{below}</mfrac>"

    def power(self, base: str, exponent: str) -> str:
        return f"<msup>{base}<mn>{exponent}</mn></msup>"

    def root(self, inside: str) -> str:
        return f"<msqrt>{inside}</msqrt>"

    def call(self, function: str, argument: str, exponent: str) -> str:
        head = f"<mi>{function}</mi>"
        head = f"<msup>{head}<mn>{exponent}</mn></msup>" if exponent else head
        return f"<mrow>{head}<mo>\u2061</mo>{self.parentheses(argument)}</mrow>"

    def parentheses(self, inside: str) -> str:
        return f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>"

    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        (negative, first), *rest = terms
        parts = ("<mo>−</mo>" if negative else "") + first
        return "<mrow>" + parts + "".join(f"<mo>{'−' if n else '+'}</mo>{term}" for n, term in rest) + "</mrow>"

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        body = "".join("<mtr>" + "".join(f"<mtd>{x}</mtd>" for x in row) + "</mtr>" for row in rows)
        return f"<mrow><mo>[</mo><mtable>{body}</mtable><mo>]</mo></mrow>"

    def equation(self, left: str, right: str) -> str:
        return (
            '<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">'
            f"<mrow>{left}<mo>=</mo>{right}</mrow></math>"
        )

    def transposed(self, base: str) -> str:
        return f"<msup>{base}<mi>T</mi></msup>"

    def remark(self, text: str) -> str:
        return f'<p class="equation-note">{escape(text)}</p>'

    def words(self, text: str) -> str:
        return f"<p>{escape(text)}</p>"

    def page(self, lines: Sequence[str]) -> str:
        return "\n".join(lines)


STYLES: dict[str, Style] = {"text": Text(), "latex": Latex(), "mathml": MathMl()}
