"""What the derivation on a page says of its scene: the letters, and the blocks of R for its joints (paper, Table 1)."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.definitions import about, bias_force, function_words, joints_have, mass_matrix
from symgen.report.equations import Equation
from symgen.report.mathml import math
from symgen.report.tables import Table
from symgen.report.words import exact
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import JointSpring, Spring
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
            f"positions of the joints ({system.tree.nq}): {_listed_positions(system)}",
        ),
        (math("θ̇ , θ̈"), math("θ̇ , θ̈"), "v, a", f"velocities and accelerations of the joints ({nv}){_spins(system)}"),
        *_own_letters(system),
        (
            math("Ψ , Ψ_x"),
            math("Ψ , Ψ_q"),
            "Psi, Psi_q",
            f"constraints of natural coordinates{rows_of}, their Jacobian",
        ),
        (math("λ"), math("λ"), "lambda", "multipliers of the constraints"),
        (math("M_n"), math("M"), "Mn", "constant mass matrix of the natural coordinates"),
        (math("R , Ṙ"), math("R , Ṙ"), "R, Rdot", "velocity transformation and its rate"),
        (math("Q"), math("Q"), "–", f"forces on the natural coordinates: {_forces(system)}"),
        *_rotors(system),
        (math("M"), math("R^T M R"), "M", f"mass matrix of the joints ({nv} × {nv})"),
        (math("h"), math("R^T (M Ṙ θ̇ − Q)"), "h", "bias force: what holds the motion at zero acceleration"),
        (math("τ"), "in Q", "tau", "forces and moments of the joints"),
    )
    return Table("Letters", ("here", "in the paper", "in the code", "meaning"), rows)


_SPINNING = ("spherical", "floating")


def _types(system: System) -> set[str]:
    return {body.joint.type for body in system.tree.bodies}


def _listed_positions(system: System) -> str:
    """What the letters of positions mean, of the kinds that the scene has."""
    units = {unit for kind in _types(system) for unit in JOINT_TYPES[kind].q_units}
    found = ["θ with a joint’s name an angle"] if "rad" in units else []
    if "prismatic" in _types(system) or "cylindrical" in _types(system):
        found.append("q with a joint’s name a slide")
    if _types(system) & {"floating", "planar"}:
        found.append("x, y, z with a name a place")
    if _types(system) & set(_SPINNING):
        found.append("q with a name and x, y, z or w an entry of the unit quaternion that turns the child’s axes")
    return ", ".join(found)


def _spins(system: System) -> str:
    """Fewer velocities than positions, where quaternions are."""
    return ": of a quaternion’s four entries the three of ω" if _types(system) & set(_SPINNING) else ""


def _own_letters(system: System) -> list[tuple[Markup, Markup, str, str]]:
    """Letters of what turns any way."""
    found, kinds = [], _types(system)
    if kinds & set(_SPINNING):
        frame = {"world": "ground axes", "body": "its own axes", "mixed": "its own axes"}[
            system.scene.options.base_velocity
        ]
        said = ["of a ball joint’s child against its parent, in the child’s axes"] if "spherical" in kinds else []
        said += [f"of a free body, in {frame}"] if "floating" in kinds else []
        text = f"angular velocity {', '.join(said)}; with a name and x, y or z, a component of it"
        found.append((math("ω_j"), math("ω_j"), "in v", text))
    if "spherical" in kinds or ("floating" in kinds and system.scene.options.base_velocity != "world"):
        text = "axes of the child of joint j, as the columns of a rotation to ground axes"
        found.append((math("A_j"), Markup("–"), "–", text))
    return found


def _forces(system: System) -> str:
    parts = ["weight"] if any(system.scene.gravity) else []
    if any(isinstance(force, Spring) for force in system.scene.forces):
        parts.append("springs and dampers between points")
    if any(isinstance(force, JointSpring) for force in system.scene.forces):
        parts.append("springs of joints")
    return ", ".join(parts) or "none here"


def _rotors(system: System) -> list[tuple[Markup, Markup, str, str]]:
    """Diagonal matrices of the joints."""
    tail = "; of a joint that follows another, times its multiplier squared" if system.tree.coupled else ""
    found = []
    if joints_have(system.scene, "armature"):
        text = f"armatures of the joints (inertia of their rotors), on the diagonal{tail}"
        found.append((math("J_a"), Markup("–"), "in M", text))
    if joints_have(system.scene, "damping"):
        found.append((math("b"), Markup("–"), "in h", f"damping of the joints, on the diagonal{tail}"))
    return found


def motion_equation(system: System) -> str:
    """(2) of this scene."""
    return f"M θ̈ + h = τ ,  {mass_matrix(system.scene)} ,  {bias_force(system.scene)} ,"


def set_apart(system: System) -> Markup:
    """What (2) writes apart from Q."""
    found = [Markup("the forces {} of the joints").format(math("τ"))]
    if joints_have(system.scene, "armature"):
        found.append(Markup("their armatures {}").format(math("J_a")))
    if joints_have(system.scene, "damping"):
        found.append(Markup("their dampers {}").format(math("b")))
    return Markup(" and ").join([Markup(", ").join(found[:-1]), found[-1]]) if len(found) > 1 else found[0]


def couplings(system: System) -> list[str]:
    """``right = left``, ``fold = 20·left − 0.2``: joints that follow others, a condition each."""
    found = []
    for body in system.tree.bodies:
        if body.coupling is None:
            continue
        times, offset = body.coupling.multiplier, body.coupling.offset
        factor = "" if times == 1 else "−" if times == -1 else f"{exact(times)}·"
        master = next(b.joint.name for b in system.tree.bodies if b.coupling is None and b.v == body.v)
        shift = f" {'+' if offset > 0 else '−'} {exact(abs(offset))}" if offset else ""
        found.append(f"{body.joint.name} = {factor}{master}{shift}")
    return found


def besides(system: System) -> Markup:
    """What R holds beside the blocks of the derivation, and where joint springs are."""
    found = []
    if any(isinstance(force, JointSpring) for force in system.scene.forces):
        text = "A joint’s spring pulls both bodies, which is in {}; it leaves its moment or force in {}."
        found.append(Markup(text).format(math("Q"), math("h")))
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
        words = function_words(output, system)
        formulas = tuple((math(definition.formula, block=True), about(row)) for row, definition in words.rows)
        papers = dict.fromkeys(definition.paper for _, definition in words.rows if definition.paper)
        found.append(Numbered(words.name, formulas, words.summary, str(start + k), tuple(papers)))
    return found
