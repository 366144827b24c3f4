"""The paper's block matrices set in a style."""

from __future__ import annotations

from collections.abc import Sequence

from symgen.targets.sympy.paper import Block, BlockMatrix, Factor, Unit, label_indices
from symgen.targets.sympy.styles import Name, Style, Text, columns


def scripts(letter: str, indices: tuple[str, ...]) -> tuple[str, ...]:
    """D₄₂ has two subscripts; u₃¹ is the first of the two vectors of a joint."""
    return indices if letter == "D" or len(indices) < 2 else (indices[0], f"^{indices[1]}")


def factor_text(style: Style, factor: Factor) -> str:
    if factor.letter == "1":
        return style.number("1", 0)
    bold = factor.letter != "h"
    return style.name((factor.letter, factor.dots, scripts(factor.letter, factor.indices)), bold)


def block_text(style: Style, block: Block) -> str:
    if not block:
        return style.number("0", 0)
    terms = []
    for term in block:
        shown = [factor for factor in term.factors if factor.letter != "1"] or list(term.factors)
        texts = [factor_text(style, factor) for factor in shown]
        terms.append((term.negative, texts[0] if len(texts) == 1 else style.product(texts)))
    return style.sum(terms)


def entity_text(style: Style, label: str, dots: int) -> str:
    """ṙ₃, u̇₃; the angle of a screw joint as φ̇ with the joint's name."""
    if label.startswith("phi_"):
        return style.name(("phi", dots, (label[4:],)))
    return style.name((label[0], dots, scripts(label[0], label_indices(label))), True)


def unit_text(style: Style, unit: Unit) -> str:
    return style.name((unit.letter, unit.dots, scripts(unit.letter, unit.indices)), unit.letter != "theta")


def matrix_text(style: Style, matrix: BlockMatrix, name: Name) -> str:
    """R with its rows and columns labelled: as the product (4.9), (4.13) where the style has room for one."""
    rows = [entity_text(style, entity.label, 1) for entity in matrix.rows]
    heads = [unit_text(style, unit) for unit in matrix.columns]
    cells = [[block_text(style, block) for block in row] for row in matrix.blocks]
    if isinstance(style, Text):
        return _table(style.name(name), rows, heads, cells)
    middle = style.matrix(cells)
    if name[1]:
        return style.equation(style.name(name, True), middle)
    left, right = style.matrix([[row] for row in rows]), style.matrix([[head] for head in heads])
    return style.equation(left, style.product([middle, right]))


def _table(name: str, rows: Sequence[str], heads: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    """Labelled rows and columns; the columns' labels stand above the matrix."""
    table = [[name, *heads], *([row, *line] for row, line in zip(rows, cells, strict=True))]
    widths = [max(columns(line[k]) for line in table) for k in range(len(table[0]))]
    padded = [[x + " " * (w - columns(x)) for x, w in zip(line, widths, strict=True)] for line in table]
    lines = ["  ".join(padded[0]).rstrip()]
    return "\n".join([lines[0], *(f"{line[0]}  " + "  ".join(line[1:]).rstrip() for line in padded[1:])])


__all__ = ["block_text", "entity_text", "factor_text", "matrix_text", "unit_text"]
