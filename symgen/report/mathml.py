"""Formulas of the text as MathML, written as one reads them: ``math("M_n ẍ − Ψ_x^T λ = Q")``.

Letters may carry dots (ẋ, R̈) or a tilde; ``_`` and ``^`` take one sign or a group in braces; ``{a}/{b}`` is a fraction;
words in double quotes stay words; two spaces make room. Vectors and matrices are bold, and so is every letter that
`SCALARS` does not list.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from markupsafe import Markup, escape

SCALARS = frozenset("TVEtijkmbℓαφδκN")
ACCENTS = {"\u0307": "˙", "\u0308": "¨", "\u0303": "~", "\u0302": "^"}
RELATIONS = frozenset("=≈≤≥<>+−·×±→⊕⊗∈↦,;:|")
BRACKETS = frozenset("()[]{}")
_TOKEN = re.compile(r'"[^"]*"|\d+(?:\.\d+)?|[^\W\d_][\u0300-\u036f]*|  +|\s|.', re.S)


@dataclass
class _Reader:
    tokens: list[str]
    at: int = 0

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self) -> str:
        self.at += 1
        return self.tokens[self.at - 1]

    def row(self, end: str = "") -> str:
        """Everything up to ``end``."""
        parts: list[str] = []
        while self.peek() and self.peek() != end:
            if self.peek() == " ":
                self.take()
                continue
            parts.append(self.scripted())
        if end and self.peek() == end:
            self.take()
        return parts[0] if len(parts) == 1 else f"<mrow>{''.join(parts)}</mrow>"

    def group(self) -> str:
        """What a script or fraction takes: a braced row or one sign."""
        if self.peek() == "{":
            self.take()
            return self.row("}")
        return _atom(self.take(), upright=True)

    def scripted(self) -> str:
        if self.peek() == "{":
            base = self.group()
            if self.peek() == "/":
                self.take()
                return f"<mfrac>{base}{self.group()}</mfrac>"
        else:
            base = _atom(self.take())
        below = above = ""
        while self.peek() in ("_", "^"):
            if self.take() == "_":
                below = self.group()
            else:
                above = self.group()
        if below and above:
            return f"<msubsup>{base}{below}{above}</msubsup>"
        if below or above:
            name = "msub" if below else "msup"
            return f"<{name}>{base}{below or above}</{name}>"
        return base


def _atom(token: str, upright: bool = False) -> str:
    """A sign by itself; ``upright``: in a script, where letters are indices."""
    if token.startswith('"'):
        return f"<mtext>{escape(token[1:-1])}</mtext>"
    if token[0].isdigit():
        return f"<mn>{token}</mn>"
    if token.startswith("  "):
        return '<mspace width="1.2em"/>'
    letter, accents = token[0], token[1:]
    if letter.isalpha():
        bold = not upright and letter not in SCALARS
        text = f'<mi mathvariant="normal" class="b">{letter}</mi>' if bold else f"<mi>{letter}</mi>"
        for accent in accents:
            text = f'<mover>{text}<mo stretchy="false">{ACCENTS[accent]}</mo></mover>'
        return text
    if letter in BRACKETS:
        return f'<mo stretchy="false">{escape(letter)}</mo>'
    if letter in RELATIONS:
        return f"<mo>{escape(letter)}</mo>"
    return f"<mi>{escape(letter)}</mi>"


def inner(text: str) -> str:
    """The formula without its outer element."""
    return _Reader(_TOKEN.findall(unicodedata.normalize("NFD", text))).row()


def spoken(text: str) -> str:
    """The formula as text for those who cannot see it."""
    return re.sub(r"\s+", " ", re.sub(r'["{}]', "", text)).strip()


def math(text: str, block: bool = False) -> Markup:
    """A formula in a line of text, or in a line of its own."""
    return element(inner(text), spoken(text), block)


def element(content: str, alternative: str, block: bool = True) -> Markup:
    """A math element around MathML."""
    display = ' display="block"' if block else ""
    head = f'<math xmlns="http://www.w3.org/1998/Math/MathML"{display} alttext="{escape(alternative)}">'
    return Markup(f"{head}{content}</math>")
