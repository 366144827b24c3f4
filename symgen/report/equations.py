"""Equations for the page: MathML where it can be read, else how many operations the function takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from markupsafe import Markup

from symgen.program.instructions import count
from symgen.system import System

LONGEST = 70_000
"""Characters of MathML of one equation; nobody reads more."""
SHOWN = {"joint": 8_000, "paper": 24_000}
"""Shorter ones are shown unfolded; R in d and u is for reading."""


LARGE = 16
"""Degrees of freedom beyond which matrices are not written out."""
SHORT = ("bias_force", "mass_matrix")
"""Rows that in the paper's symbols are one product of matrices."""


@dataclass(frozen=True)
class Equation:
    """``math`` None: ``note`` says why it is not printed."""

    title: str
    math: Markup | None
    note: str = ""
    open: bool = True


@dataclass(frozen=True)
class _Wanted:
    row: str
    title: str
    symbols: str
    most: int
    """Operations of the function beyond which its equation is not tried."""


WANTED = (
    _Wanted("velocity_transformation", "Velocity transformation R, in d and u", "paper", 10**9),
    _Wanted("velocity_transformation_rate", "Its rate Ṙ, in d and u", "paper", 10**9),
    _Wanted("mass_matrix", "Mass matrix, from R", "paper", 10**9),
    _Wanted("bias_force", "Bias force, from R", "paper", 10**9),
    _Wanted("mass_matrix", "Mass matrix, in joint coordinates", "joint", 600),
    _Wanted("gravity_force", "Gravity force, in joint coordinates", "joint", 300),
    _Wanted("bias_force", "Bias force, in joint coordinates", "joint", 600),
    _Wanted("kinetic_energy", "Kinetic energy, in joint coordinates", "joint", 150),
    _Wanted("potential_energy", "Potential energy, in joint coordinates", "joint", 300),
    _Wanted("forward_dynamics", "Forward dynamics, in joint coordinates", "joint", 120),
)


def equations(system: System) -> Sequence[Equation]:
    """The equations of a system without closed loops, in reading order; of a large one those it asks for."""
    asked = {row for output in system.outputs for row in output.of}
    large = system.tree.nv > LARGE
    wanted = [_in_reach(system, one) for one in WANTED]
    return [_equation(system, one) for one in wanted if not large or one.row in asked]


def _in_reach(system: System, wanted: _Wanted) -> _Wanted:
    """The paper's blocks are of independent joints; with others R is written in joint coordinates."""
    if system.tree.coupled and wanted.row.startswith("velocity_transformation"):
        return replace(wanted, title=wanted.title.replace("in d and u", "in joint coordinates"), symbols="joint")
    return wanted


def _equation(system: System, wanted: _Wanted) -> Equation:
    counts = count(system.program(wanted.row))
    math = ""
    if counts.flops <= wanted.most and (system.tree.nv <= LARGE or wanted.row in SHORT):
        from symgen.targets.sympy import equations as written

        math = written(system, [wanted.row], symbols=wanted.symbols, format="mathml")
    if not math or len(math) > LONGEST:
        note = f"the generated code takes {counts.flops} operations and {_sines(counts.sincos)}."
        return Equation(wanted.title, None, note)
    return Equation(wanted.title, Markup(_bracketed(math)), open=len(math) <= SHOWN[wanted.symbols])


def _bracketed(math: str) -> str:
    """Brackets of matrices as borders: a browser without a mathematical font cannot stretch the characters."""
    opened = math.replace("<mo>[</mo><mtable>", '<mtable class="brackets">')
    return opened.replace("</mtable><mo>]</mo>", "</mtable>")


def _sines(pairs: int) -> str:
    return f"{pairs} sine{'s' if pairs != 1 else ''} with {'their cosines' if pairs != 1 else 'its cosine'}"
