"""What the derivation on a page says of its scene: the letters, and the blocks of R for its joints (paper, Table 1)."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.definitions import about, function_words
from symgen.report.equations import Equation
from symgen.report.mathml import math
from symgen.report.tables import Table
from symgen.scene.joints import JOINT_TYPES
from symgen.system import System

FIRST = 3
"""Number of the first equation that is the scene's own; (1) and (2) stand in the derivation."""

_FLOATING = {
    "world": ("ṙ_j , ω_j", "[ 1  −D_{k j} ]", "[ 0  −U_k ]"),
    "body": ("v_j , ω_j", "[ A_j  −D_{k j} A_j ]", "[ 0  −U_k A_j ]"),
    "mixed": ("ṙ_j , ω_j", "[ 1  −D_{k j} A_j ]", "[ 0  −U_k A_j ]"),
}
BLOCKS = {
    "revolute": ("θ̇_j", "−D_{k j} u_j", "−U_k u_j"),
    "prismatic": ("q̇_j", "u_j", "0"),
    "helical": ("θ̇_j", "h_j u_j − D_{k j} u_j", "−U_k u_j"),
    "cylindrical": ("θ̇_j , q̇_j", "[ −D_{k j} u_j  u_j ]", "[ −U_k u_j  0 ]"),
    "universal": ("θ̇_j^1 , θ̇_j^2", "[ −D_{k j} u_j^1  −D_{k j} u_j^2 ]", "[ −U_k u_j^1  −U_k u_j^2 ]"),
    "planar": ("ẋ_j , ẏ_j , θ̇_j", "[ e_1  e_2  −D_{k j} n ]", "[ 0  0  −U_k n ]"),
    "spherical": ("ω_j", "−D_{k j} A_j", "−U_k A_j"),
}
"""Joint velocities, block of a point k, block of a vector k: v + w × d and w × u (theory of the joint table)."""
_PAPERS = frozenset({"revolute", "prismatic", "universal", "floating"})
"""What the paper's Table 1 has."""


def blocks(system: System) -> Table:
    """Blocks of R for the joint types of a scene."""
    rows = []
    for kind in dict.fromkeys(body.joint.type for body in system.tree.bodies):
        own = "revolute" if kind == "continuous" else kind
        row = _FLOATING[system.scene.options.base_velocity] if own == "floating" else BLOCKS[own]
        source = "Table 1" if own in _PAPERS else "its motion subspace"
        name = f"{kind} ({JOINT_TYPES[kind].letter})"
        rows.append((name, *(math(text) for text in row), source))
    header = ("joint j", "joint velocities", "block of a point k", "block of a vector k", "from")
    return Table("Blocks of R for the joints of this mechanism (paper, Table 1)", header, tuple(rows))


def letters(system: System) -> Table:
    """The letters of the page beside those of the paper and of the code."""
    n, nv = system.natural.nn, system.tree.nv
    rows_of = "" if system.scene.runtime_origins else f" ({system.natural.nc})"
    rows = (
        (math("x"), math("q"), "x", f"natural coordinates: points and unit vectors in ground axes ({n})"),
        (
            math("q"),
            math("θ"),
            "q",
            f"positions of the joints ({system.tree.nq}): θ with its name an angle, q with its name a slide",
        ),
        (math("θ̇ , θ̈"), math("θ̇ , θ̈"), "v, a", f"velocities and accelerations of the joints ({nv})"),
        (
            math("Ψ , Ψ_x"),
            math("Ψ , Ψ_q"),
            "Psi, Psi_q",
            f"constraints of natural coordinates{rows_of}, their Jacobian",
        ),
        (math("λ"), math("λ"), "lambda", "multipliers of the constraints"),
        (math("M_n"), math("M"), "Mn", "constant mass matrix of the natural coordinates"),
        (math("R , Ṙ"), math("R , Ṙ"), "R, Rdot", "velocity transformation and its rate"),
        (math("Q"), math("Q"), "–", "forces on the natural coordinates: weight, springs, dampers"),
        (math("M"), math("R^T M R"), "M", f"mass matrix of the joints ({nv} × {nv})"),
        (math("h"), math("R^T(M Ṙ θ̇ − Q)"), "h", "bias force: what holds the motion at zero acceleration"),
        (math("τ"), "in Q", "tau", "forces and moments of the joints"),
    )
    return Table("Letters", ("here", "in the paper", "in the code", "meaning"), rows)


def besides(system: System) -> Markup:
    """What M, h and R hold beside the products of the derivation."""
    scene = system.scene
    found = []
    if any(joint.armature for joint in scene.joints):
        found.append(Markup("Armatures stand on the diagonal of {} besides.").format(math("M")))
    if any(joint.damping for joint in scene.joints):
        found.append(Markup("Dampers in joints add {} to {}.").format(math("b θ̇"), math("h")))
    if scene.forces:
        found.append(Markup("Springs are in {}.").format(math("Q")))
    if system.tree.coupled:
        text = "Joints that follow another have no velocity of their own in {}: their columns of {}, times the "
        text += "multiplier, are added to those of the joint they follow."
        found.append(Markup(text).format(math("θ̇"), math("R")))
    return Markup(" ").join(found)


@dataclass(frozen=True)
class Numbered:
    """A function of the code with its defining equations: (formula, what it is about, number)."""

    name: str
    formulas: tuple[tuple[Markup, str], ...]
    summary: str
    number: str
    paper: tuple[str, ...]


def numbered(found: list[Equation], start: int = FIRST) -> dict[str, str]:
    """Row → number of the equation in which the page writes it out."""
    own = start
    numbers = {}
    for equation in found:
        if equation.number:
            numbers[equation.row] = equation.number
        elif equation.lines:
            numbers[equation.row] = str(own)
            own += 1
    return numbers


def functions(system: System, start: int) -> list[Numbered]:
    """Every function that is asked for with its definition, numbered from ``start``."""
    found = []
    for k, output in enumerate(system.outputs):
        words = function_words(output, system.natural.plane is not None)
        formulas = tuple((math(definition.formula, block=True), about(row)) for row, definition in words.rows)
        papers = dict.fromkeys(definition.paper for _, definition in words.rows if definition.paper)
        found.append(Numbered(words.name, formulas, words.summary, str(start + k), tuple(papers)))
    return found
