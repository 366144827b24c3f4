"""The scene's own equations: R in blocks, and what is short enough in joint coordinates, in lines that fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy
from markupsafe import Markup

from symgen.program.instructions import count
from symgen.report.breaking import WIDEST, Breaking, width
from symgen.report.mathml import element
from symgen.report.words import counted
from symgen.system import System

LONGEST = 70_000
"""Characters of MathML of one equation; nobody reads more."""
SHOWN = {"joint": 9_000, "paper": 24_000}
"""Shorter ones are shown unfolded; R in d and u is for reading."""
LARGE = 16
"""Degrees of freedom beyond which matrices are not written out."""


@dataclass(frozen=True)
class Equation:
    """``lines`` empty: ``note`` says why it is not printed. ``number``: the paper's or the page's."""

    row: str
    title: str
    words: str
    lines: tuple[Markup, ...] = ()
    remarks: tuple[str, ...] = ()
    note: str = ""
    open: bool = True
    wide: int = 0
    """Characters of its widest line."""
    number: str = ""


@dataclass(frozen=True)
class _Wanted:
    row: str
    title: str
    words: str
    symbols: str
    most: int
    """Operations of the function beyond which its equation is not tried."""


WANTED = (
    _Wanted("velocity_transformation", "Velocity transformation R", "Entries of π* replaced by blocks", "paper", 0),
    _Wanted("velocity_transformation_rate", "Its rate Ṙ", "The same blocks differentiated", "paper", 0),
    _Wanted("mass_matrix", "Mass matrix M", "As in (2), multiplied out in joint coordinates", "joint", 600),
    _Wanted("gravity_force", "Gravity force g", "The part of h that is weight", "joint", 300),
    _Wanted("bias_force", "Bias force h", "As in (2), multiplied out in joint coordinates", "joint", 600),
    _Wanted("kinetic_energy", "Kinetic energy T", "Half of the rates times M times the rates", "joint", 150),
    _Wanted("potential_energy", "Potential energy V", "Zero at the ground’s origin", "joint", 300),
    _Wanted("forward_dynamics", "Accelerations", "The equations of motion (2) solved", "joint", 120),
)
FIG1 = ("revolute revolute prismatic revolute", "r2 u2 r3 u3 r4 r5 u5 r6 u6", (-1, 0, 1, 2))
FIG2 = (
    "floating revolute revolute prismatic revolute", "r1 u1 r2 u2 r3 u3 r4 u4 r5 r6 u6 r7 u7 r8 u8", (-1, 0, 1, 2, 0)
)  # fmt: skip
PLANE = "Two rows for each point, in the order of x, as the function gives it"
COUPLED = "In joint coordinates: here joints follow others, in the paper they do not"
PRINTED = {FIG1: "4.9", FIG2: "4.13"}
"""Systems whose R the paper prints: joints, entities, parents."""
ERRATA = {
    "4.9": "In the paper as scanned the row of u̇₃ stands as a second row of ṙ₃, and θ̇ on the right is missing.",
    "4.13": "In the paper as scanned there are seven block columns, six being meant, and a row is missing.",
}


def paper_number(system: System) -> str:
    """Under which number the paper prints this R; empty where it does not."""
    bodies = system.tree.bodies
    kinds = " ".join(body.joint.type for body in bodies)
    labels = " ".join(system.natural.entities[k].label for k in system.natural.moving)
    return PRINTED.get((kinds, labels, tuple(body.parent for body in bodies)), "")


def equations(system: System) -> Sequence[Equation]:
    """The equations of a system without closed loops, in reading order; of a large one those it asks for."""
    asked = {row for output in system.outputs for row in output.of}
    large = system.tree.nv > LARGE
    found = []
    for wanted in WANTED:
        planar = system.natural.plane is not None
        joint = wanted.symbols == "joint" or system.tree.coupled or planar
        if large and (wanted.row not in asked or not joint):
            continue
        if wanted.row == "gravity_force" and not any(system.scene.gravity):
            continue
        if not joint:
            found.append(_paper(system, wanted))
            continue
        # The paper's R of a planar mechanism is one in space, with vectors that are no coordinates here.
        words = wanted.words if wanted.symbols == "joint" else PLANE if planar else COUPLED
        found.append(_joint(system, replace(wanted, words=words)))
    return found


def _unprinted(system: System, wanted: _Wanted) -> Equation:
    counts = count(system.program(wanted.row))
    sines = f"{counted(counts.sincos, 'sine')} with {'its cosine' if counts.sincos == 1 else 'their cosines'}"
    note = f"too long to print: the generated code takes {counts.flops} operations and {sines}."
    return Equation(wanted.row, wanted.title, wanted.words, note=note)


def _paper(system: System, wanted: _Wanted) -> Equation:
    from symgen.targets.sympy import equations as written

    text = written(system, [wanted.row], symbols="paper", format="mathml")
    math = text.partition("</math>")[0].partition(">")[2]
    if len(math) > LONGEST:
        return _unprinted(system, wanted)
    line = element(bracketed(math), f"{wanted.title} in blocks of the paper's vectors")
    wide = 18 * len(_columns(system)) if wanted.row.endswith("rate") else 9 * len(_columns(system)) + 20
    own = paper_number(system) if wanted.row == "velocity_transformation" else ""
    remarks = [ERRATA[own]] if own else []
    return Equation(wanted.row, wanted.title, wanted.words, (line,), tuple(remarks), wide=wide, number=own)


def _columns(system: System) -> list[int]:
    return [body.v for body in system.tree.bodies if body.coupling is None for _ in range(min(2, body.nv))]


def bracketed(math: str) -> str:
    """Brackets of matrices as borders: a browser without a mathematical font cannot stretch the characters."""
    opened = math.replace("<mo>[</mo><mtable>", '<mtable class="brackets">')
    return opened.replace("</mtable><mo>]</mo>", "</mtable>")


def _joint(system: System, wanted: _Wanted) -> Equation:
    """A row in joint coordinates, where that is short enough."""
    most = wanted.most or 600
    if count(system.program(wanted.row)).flops > most or system.tree.nv > LARGE:
        return _unprinted(system, wanted)
    from symgen.targets.sympy.equations import JOINT_LETTERS, left_side
    from symgen.targets.sympy.matrices import row_equation
    from symgen.targets.sympy.setting import Setter
    from symgen.targets.sympy.symbols import system_symbols

    style = Breaking()
    setter = Setter(style, system_symbols(system.scene, system.tree).order)
    found = row_equation(system, wanted.row)
    left = left_side(style, wanted.row, JOINT_LETTERS)
    pairs = [(setter.set(symbol), setter.set(value)) for symbol, value in found.definitions]
    remarks: list[str] = []
    if isinstance(found.value, sympy.Expr):
        pairs += _opened(style, [(left, setter.set(found.value))])
    else:
        rows = [[setter.set(found.value[i, j]) for j in range(found.value.cols)] for i in range(found.value.rows)]
        wide = sum(max(width(row[k]) for row in rows) + 3 for k in range(len(rows[0]))) + width(left)
        if wide <= WIDEST:
            texts = [style.aligned(pairs)] if pairs else []
            texts.append(f"<mrow>{left}<mo>=</mo>{bracketed(style.matrix(rows))}</mrow>")
            return _finished(system, wanted, texts, remarks, wide, setter.rounded)
        listed, remark = _listed(left, rows)
        pairs += _opened(style, listed)
        remarks += [remark] if remark else []
    texts = [style.aligned(pairs)]
    wide = max(max(width(line) for line in style.lines(right)) + width(name) for name, right in pairs)
    return _finished(system, wanted, texts, remarks, wide, setter.rounded)


def _finished(
    system: System, wanted: _Wanted, texts: Sequence[str], remarks: Sequence[str], wide: float, rounded: bool
) -> Equation:
    size = sum(map(len, texts))
    if size > LONGEST:
        return _unprinted(system, wanted)
    lines = [element(text, wanted.title) for text in texts]
    if rounded:
        remarks = [*remarks, "numbers rounded to six digits here; they are derived exactly"]
    shown = size <= SHOWN[wanted.symbols]
    return Equation(wanted.row, wanted.title, wanted.words, tuple(lines), tuple(remarks), open=shown, wide=int(wide))


def _opened(style: Breaking, pairs: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Fractions too wide for a line as N/Δ, with N and Δ in lines of their own."""
    found: list[tuple[str, str]] = []
    below: dict[str, str] = {}
    for k, (left, right) in enumerate(pairs):
        fraction = style.fractions.get(right)
        if fraction is None or max(map(width, fraction)) < WIDEST - 12:
            found.append((left, right))
            continue
        above = f"<msub><mi>N</mi><mn>{k + 1}</mn></msub>"
        if fraction[1] not in below:
            below[fraction[1]] = "<mi>Δ</mi>" if not below else f"<msub><mi>Δ</mi><mn>{len(below) + 1}</mn></msub>"
            found.append((below[fraction[1]], fraction[1]))
        found += [(above, fraction[0]), (left, f"<mfrac>{above}{below[fraction[1]]}</mfrac>")]
    return found


def _listed(left: str, rows: Sequence[Sequence[str]]) -> tuple[list[tuple[str, str]], str]:
    """Entry by entry, zeros left out; of a symmetric matrix the upper triangle."""
    size, zero = len(rows), "<mn>0</mn>"
    symmetric = size == len(rows[0]) > 1 and all(rows[i][j] == rows[j][i] for i in range(size) for j in range(i))
    found = []
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            if entry == zero or (symmetric and j < i):
                continue
            place = f"<mn>{i + 1}</mn>" if len(row) == 1 else f"<mn>{i + 1}</mn><mo>,</mo><mn>{j + 1}</mn>"
            found.append((f"<msub>{left}<mrow>{place}</mrow></msub>", entry))
    if len(found) == size * len(rows[0]):
        return found, ""
    return found, "entries not listed are zero" + (", the matrix is symmetric" if symmetric else "")
