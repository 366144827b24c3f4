"""Equations for reading: catalogue rows as text, LaTeX or MathML, in joint coordinates or in the paper's symbols."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import sympy

from symgen.catalogue import CATALOGUE, split_row
from symgen.errors import SceneError
from symgen.targets.sympy.blocks import entity_text, matrix_text
from symgen.targets.sympy.matrices import Equation, row_equation
from symgen.targets.sympy.paper import block_matrix, paper_natural
from symgen.targets.sympy.setting import Setter
from symgen.targets.sympy.styles import STYLES, WIDEST, Name, Style, Text, columns
from symgen.targets.sympy.symbols import system_symbols

if TYPE_CHECKING:
    from symgen.system import System

NAMES: dict[str, Name] = {
    "natural_coordinates": ("q", 0, ()),
    "natural_mass_matrix": ("M", 0, ("n",)),
    "constraints": ("Psi", 0, ()),
    "constraint_jacobian": ("Psi", 0, ("q",)),
    "velocity_transformation": ("R", 0, ()),
    "velocity_transformation_rate": ("R", 1, ()),
    "natural_bias_acceleration": ("q", 2, ("bias",)),
    "mass_matrix": ("M", 0, ()),
    "coriolis_matrix": ("C", 0, ()),
    "gravity_force": ("g", 0, ()),
    "passive_force": ("f", 0, ("passive",)),
    "bias_force": ("h", 0, ()),
    "inverse_dynamics": ("tau", 0, ()),
    "forward_dynamics": ("theta", 2, ()),
    "kinetic_energy": ("T", 0, ()),
    "potential_energy": ("V", 0, ()),
    "frame_pose": ("T", 0, ()),
    "integrate": ("q", 0, ("next",)),
    "mass_matrix_inverse": ("M", 0, ("^-1",)),
    "center_of_mass": ("c", 0, ()),
    "momentum": ("h", 0, ("G",)),
    "momentum_matrix": ("A", 0, ()),
    "frame_jacobian": ("J", 0, ()),
    "frame_velocity": ("v", 0, ()),
    "frame_bias_acceleration": ("v", 1, ("bias",)),
    "regressor": ("Y", 0, ()),
    "base_regressor": ("Y", 0, ("b",)),
    "base_parameters": ("beta", 0, ()),
    "joint_wrenches": ("W", 0, ()),
    "constraint_forces": ("lambda", 0, ()),
}
"""How the left-hand sides are written, in the paper's letters."""
JOINT_LETTERS = {"natural_coordinates": "x", "natural_bias_acceleration": "x"}
"""Beside joint coordinates q, the natural coordinates are the catalogue's x."""


def equations(system: System, names: Sequence[str], symbols: str = "joint", format: str = "text") -> str:
    """The equations of catalogue rows (``mass_matrix``, ``frame_pose:tool``) under each other.

    ``symbols``: ``joint`` writes entries in joint coordinates (long ones as definitions and a result); ``paper`` writes
    R and Ṙ in blocks of d and u, and the rest as the paper's products of matrices. ``format``: ``text`` (Unicode),
    ``latex`` (amsmath), ``mathml`` (presentation MathML, no scripts or fonts needed). Numbers are exact as they stand
    unless a remark says that they are rounded. Raises SceneError for names the catalogue has not, and for those without
    a form in the paper's symbols; NotSupportedError for closed loops.
    """
    style = STYLES.get(format)
    if style is None or symbols not in ("joint", "paper"):
        raise ValueError(f"no such format or symbols: {format}, {symbols}")
    system.require_tree()
    written = []
    for name in names:
        for row in system.output(name).of:
            if split_row(row)[0] not in NAMES:
                raise SceneError(f"{row} has no form for reading; the function itself can be generated", "--equations")
            written.append(_paper(system, row, style) if symbols == "paper" else _joint(system, row, style))
    return "\n\n".join(written)


# -- joint coordinates -----------------------------------------------------------------------------------------------


def left_side(style: Style, row: str, letters: Mapping[str, str] = MappingProxyType({})) -> str:
    row_name, frame = split_row(row)
    letter, dots, subscripts = NAMES[row_name]
    letter = letters.get(row_name, letter)
    shape = CATALOGUE[row_name].outputs[0][1]
    return style.name((letter, dots, (*subscripts, *([frame] if frame else []))), bool(shape))


def _joint(system: System, row: str, style: Style) -> str:
    found = row_equation(system, row)
    setter = Setter(style, system_symbols(system.scene, system.tree).order)
    lines = [style.equation(setter.set(symbol), setter.set(value)) for symbol, value in found.definitions]
    lines.append(_result(found, setter))
    if row == "constraints":
        lines.append(style.remark("met by every configuration; in the paper's symbols they are written out"))
    if setter.rounded:
        lines.append(style.remark("numbers rounded to six digits here; they are derived exactly"))
    return style.page(lines)


def _result(found: Equation, setter: Setter) -> str:
    style, left = setter.style, left_side(setter.style, found.row, JOINT_LETTERS)
    if isinstance(found.value, sympy.Expr):
        return style.equation(left, setter.set(found.value))
    rows = [[setter.set(found.value[i, j]) for j in range(found.value.cols)] for i in range(found.value.rows)]
    if not rows:
        return style.remark("no rows")
    if isinstance(style, Text) and _width(rows) > WIDEST:
        return _listed(left, rows)
    return style.equation(left, style.matrix(rows))


def _width(rows: Sequence[Sequence[str]]) -> int:
    return sum(max(columns(row[k]) for row in rows) + 2 for k in range(len(rows[0])))


def _listed(left: str, rows: Sequence[Sequence[str]]) -> str:
    """Entry by entry, zeros left out; of a symmetric matrix the upper triangle."""
    size = len(rows)
    symmetric = size == len(rows[0]) > 1 and all(rows[i][j] == rows[j][i] for i in range(size) for j in range(i))
    lines = []
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            if entry == "0" or (symmetric and j < i):
                continue
            place = f"{i + 1}" if len(row) == 1 else f"{i + 1},{j + 1}"
            lines.append(f"{left}[{place}] = {entry}")
    if len(lines) == size * len(rows[0]):
        return "\n".join(lines)
    rest = "entries not listed are zero" + (", the matrix is symmetric" if symmetric else "")
    return "\n".join([*lines, f"({rest})"])


# -- the paper's symbols ---------------------------------------------------------------------------------------------


def _paper(system: System, row: str, style: Style) -> str:
    name, _ = split_row(row)
    if name in ("velocity_transformation", "velocity_transformation_rate"):
        if system.tree.coupled:
            raise SceneError(f"'{name}' has no form in the paper's symbols: {COUPLED}", "--symbols")
        rate = name.endswith("rate")
        lines = [matrix_text(style, block_matrix(system, rate), NAMES[name]), style.remark(SKEW)]
        if system.natural.plane is not None:
            lines.append(style.remark(IN_SPACE))
        return style.page(lines)
    if name == "natural_coordinates":
        natural = paper_natural(system)
        entities = [[entity_text(style, natural.entities[k].label, 0)] for k in natural.moving]
        return style.equation(left_side(style, row), style.transposed(style.matrix(list(zip(*entities, strict=True)))))
    if name == "constraints":
        lines = [style.words(constraint.name + " = constant") for constraint in paper_natural(system).constraints]
        return style.page(lines)
    if name not in PRODUCTS:
        raise SceneError(f"'{name}' has no form in the paper's symbols; ask for it in joint coordinates", "--symbols")
    return style.equation(left_side(style, row), style.sum([_product(style, *term) for term in PRODUCTS[name]]))


COUPLED = "a joint follows another one here, the paper's joints are independent; ask for it in joint coordinates"
SKEW = "d_ij = r_i - r_j; D and U are the skew matrices of d and u"
IN_SPACE = "written in space; the natural coordinates of this planar system are points in its plane only"
R, RDOT, MN = NAMES["velocity_transformation"], NAMES["velocity_transformation_rate"], NAMES["natural_mass_matrix"]
RATES: Name = ("theta", 1, ())
PRODUCTS: dict[str, tuple[tuple[bool, tuple[tuple[Name, bool], ...]], ...]] = {
    "mass_matrix": ((False, ((R, True), (MN, False), (R, False))),),
    "coriolis_matrix": ((False, ((R, True), (MN, False), (RDOT, False))),),
    "gravity_force": ((True, ((R, True), (("Q", 0, ()), False))),),
    "natural_bias_acceleration": ((False, ((RDOT, False), (RATES, False))),),
    "bias_force": (
        (False, ((R, True), (MN, False), (RDOT, False), (RATES, False))),
        (True, ((R, True), (("Q", 0, ()), False))),
    ),
    "inverse_dynamics": (
        (False, ((R, True), (MN, False), (R, False), (("theta", 2, ()), False))),
        (False, ((R, True), (MN, False), (RDOT, False), (RATES, False))),
        (True, ((R, True), (("Q", 0, ()), False))),
    ),
}
"""Sums of products, (negative, ((matrix, transposed), …)): paper (3.4)–(3.7)."""


def _product(style: Style, negative: bool, parts: Sequence[tuple[Name, bool]]) -> tuple[bool, str]:
    texts = [style.transposed(style.name(name, True)) if turned else style.name(name, True) for name, turned in parts]
    return negative, style.product(texts)


__all__ = ["equations", "left_side"]
