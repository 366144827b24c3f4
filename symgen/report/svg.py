"""SVG by hand: elements with escaped text and attributes, and numbers as short as they can be."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

NAMESPACE = "http://www.w3.org/2000/svg"


def num(x: float, digits: int = 1) -> str:
    """A coordinate: fixed decimals without trailing zeros, never ``-0``."""
    text = f"{x:.{digits}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def tag(name: str, *children: str, **attributes: object) -> Markup:
    """``tag("circle", r=3, class_="dot")``: one element. Underscores in attribute names stand for hyphens
    (a last one is dropped); floats are shortened; None leaves an attribute out. Children are escaped unless Markup."""
    parts = []
    for key, value in attributes.items():
        if value is None:
            continue
        text = num(value) if isinstance(value, float) else str(value)
        parts.append(Markup(' {}="{}"').format(Markup(key.rstrip("_").replace("_", "-")), text))
    head = Markup("<{}{}").format(Markup(name), Markup("").join(parts))
    if not children:
        return head + Markup("/>")
    inside = Markup("").join(escape(child) for child in children)
    return head + Markup(">") + inside + Markup("</{}>").format(Markup(name))


def path(points: Iterable[Sequence[float] | NDArray[np.float64]], close: bool = False) -> str:
    """Path data of a polyline."""
    text = "L".join(f"{num(x)} {num(y)}" for x, y in points)
    return f"M{text}{'Z' if close else ''}"


def symbol(label: str) -> Markup:
    """A label of a natural coordinate, ``r3``, ``u2_1``, as mathematics: letter in italics, number below,
    superscript above."""
    letter, rest = label[0], label[1:]
    number, _, superscript = rest.partition("_")
    parts = [tag("tspan", letter, font_style="italic")]
    if number:
        parts.append(tag("tspan", number, dy="0.3em", font_size="72%"))
    if superscript:
        parts.append(tag("tspan", superscript, dy="-0.75em", dx="-0.5em", font_size="72%"))
    return Markup("").join(parts)


def figure(children: Iterable[str], width: float, height: float, title: str, **attributes: object) -> Markup:
    """An inline drawing with a name for those who cannot see it."""
    box = f"0 0 {num(width)} {num(height)}"
    return tag(
        "svg", *children, xmlns=NAMESPACE, viewBox=box, width=num(width), height=num(height), role="img",
        aria_label=title, **attributes,
    )  # fmt: skip
