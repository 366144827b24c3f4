"""Long expressions in several lines: sums are broken before a sign, also inside of parentheses.

Browsers do not break MathML. So the style below remembers what each piece was made of; a piece that is too wide for a
line is opened again where a line may end.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from symgen.targets.sympy.styles import MathMl

WIDEST = 92.0
"""Characters of a line, roughly what is seen on a screen and on A4."""
_TAG = re.compile(r"<[^>]*>")
_SMALL = re.compile(r"<m(?:sub|sup)><m[ion](?: [^>]*)?>.*?</m[ion]>(.*?)</m(?:sub|sup)>", re.S)


def width(text: str) -> float:
    """Characters that a piece of MathML takes; scripts are small."""
    scripts = sum(len(_TAG.sub("", found)) for found in _SMALL.findall(text))
    signs = text.count("<mo>+</mo>") + text.count("<mo>−</mo>") + text.count("<mo>=</mo>")
    return len(_TAG.sub("", text).replace("\u2062", "").replace("\u2061", "")) - 0.35 * scripts + 1.2 * signs


@dataclass(frozen=True)
class Breaking(MathMl):
    """MathML that knows what its pieces were made of."""

    sums: dict[str, tuple[tuple[bool, str], ...]] = field(default_factory=dict, compare=False, repr=False)
    products: dict[str, tuple[str, ...]] = field(default_factory=dict, compare=False, repr=False)
    closed: dict[str, str] = field(default_factory=dict, compare=False, repr=False)
    fractions: dict[str, tuple[str, str]] = field(default_factory=dict, compare=False, repr=False)

    def number(self, mantissa: str, exponent: int) -> str:
        """Powers of ten with ×, as in the tables."""
        return super().number(mantissa, exponent).replace("<mo>·</mo>", "<mo>×</mo>")

    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        text = super().sum(terms)
        self.sums[text] = tuple(terms)
        return text

    def product(self, factors: Sequence[str]) -> str:
        text = super().product(factors)
        self.products[text] = tuple(factors)
        return text

    def parentheses(self, inside: str) -> str:
        text = super().parentheses(inside)
        self.closed[text] = inside
        return text

    def fraction(self, above: str, below: str, simple: bool) -> str:
        text = super().fraction(above, below, simple)
        self.fractions[text] = (above, below)
        return text

    def _pieces(self, text: str, room: float) -> Iterator[tuple[bool, str]]:
        """(whether a line may end before it, piece)."""
        if text in self.sums and (width(text) > room or len(self.sums[text]) > 1):
            for k, (negative, term) in enumerate(self.sums[text]):
                sign = "<mo>−</mo>" if negative else "<mo>+</mo>" if k else ""
                pieces = list(self._pieces(term, room)) if width(term) > room else [(False, term)]
                yield k > 0, sign + pieces[0][1]
                yield from pieces[1:]
        elif text in self.products and width(text) > room:
            for k, factor in enumerate(self.products[text]):
                pieces = list(self._pieces(factor, room))
                yield False, ("<mo>\u2062</mo>" if k else "") + pieces[0][1]
                yield from pieces[1:]
        elif text in self.closed and width(text) > room:
            pieces = list(self._pieces(self.closed[text], room))
            yield False, '<mo stretchy="false">(</mo>' + pieces[0][1]
            yield from pieces[1:]
            yield False, '<mo stretchy="false">)</mo>'
        else:
            yield False, text

    def lines(self, text: str, room: float = WIDEST) -> list[str]:
        """The pieces of an expression in lines that fit, as far as it can be broken."""
        if width(text) <= room:
            return [text]
        found, line, used = [], "", 0.0
        together = ""
        for may, piece in [*self._pieces(text, room), (True, "")]:
            if may and together:
                if line and used + width(together) > room:
                    found.append(line)
                    line, used = "", 0.0
                line, used = line + together, used + width(together)
                together = ""
            together += piece
        return [*found, line]

    def rows(self, left: str, right: str) -> list[str]:
        """``left = right`` as rows of a table: further lines of the right side stand under its first."""
        lines = self.lines(right, max(30.0, WIDEST - width(left) - 3))
        found = [f"<mtr><mtd>{left}</mtd><mtd><mo>=</mo></mtd><mtd><mrow>{lines[0]}</mrow></mtd></mtr>"]
        return found + [f"<mtr><mtd></mtd><mtd></mtd><mtd><mrow>{line}</mrow></mtd></mtr>" for line in lines[1:]]

    def aligned(self, pairs: Sequence[tuple[str, str]]) -> str:
        """Equations under each other, aligned at their signs of equality."""
        if len(pairs) == 1 and width(pairs[0][1]) <= WIDEST - width(pairs[0][0]) - 3:
            return f"<mrow>{pairs[0][0]}<mo>=</mo>{pairs[0][1]}</mrow>"
        rows = [row for pair in pairs for row in self.rows(*pair)]
        return f'<mtable class="lines">{"".join(rows)}</mtable>'
