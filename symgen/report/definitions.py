"""What every row of the catalogue is: its defining equation, in the letters of the page."""

from __future__ import annotations

from dataclasses import dataclass

from symgen.catalogue import PRODUCTS, function_summary, split_row
from symgen.scene.model import Output, Scene
from symgen.scene.outputs import function_name
from symgen.system import System


@dataclass(frozen=True)
class Definition:
    """``formula``: as `symgen.report.mathml.math` reads it. ``paper``: number of the paper's equation it comes from."""

    formula: str
    paper: str = ""


DEFINITIONS: dict[str, Definition] = {
    "natural_coordinates": Definition('x = x(q) :  r_k = r_b + A_b s_k ,  u_k = A_b e_k'),
    "natural_mass_matrix": Definition("M_n = Σ_b (W_b^{−T} P_b W_b^{−1}) ⊗ 1_3"),
    "constraints": Definition("Ψ(x(q)) = 0", "3.1"),
    "constraint_jacobian": Definition("Ψ_x = {∂Ψ}/{∂x}", "3.2"),
    "velocity_transformation": Definition("ẋ = R θ̇", "3.4"),
    "velocity_transformation_rate": Definition('Ṙ = {"d" R}/{"d" t}', "3.6"),
    "natural_bias_acceleration": Definition("Ṙ θ̇ = ẍ − R θ̈", "3.6"),
    "mass_matrix": Definition("M = R^T M_n R", "3.7"),
    "coriolis_matrix": Definition("C = R^T M_n Ṙ", "3.7"),
    "gravity_force": Definition('g = −R^T Q_g  "with the weight"  Q_g', "3.7"),
    "passive_force": Definition('f = −R^T Q_s + b θ̇  "with springs and dampers"  Q_s'),
    "bias_force": Definition("h = R^T M_n Ṙ θ̇ − R^T Q", "3.7"),
    "inverse_dynamics": Definition("τ = M θ̈ + h", "3.7"),
    "forward_dynamics": Definition("M θ̈ + h = τ", "3.7"),
    "mass_matrix_inverse": Definition("M M^{−1} = 1"),
    "kinetic_energy": Definition("T = {1}/{2} θ̇^T M θ̇ = {1}/{2} ẋ^T M_n ẋ"),
    "potential_energy": Definition('V = −Σ_b m_b g · c_b + {1}/{2} Σ_s k_s (ℓ_s − ℓ_{s 0})^2'),
    "frame_pose": Definition('r = A_f r_{"local"} + r_f'),
    "integrate": Definition('q_{"next"} = q ⊕ θ̇ δt  "(angles add, quaternions multiply)"'),
    "configuration_rate": Definition('{"d" q}/{"d" t} = G(q) θ̇'),
    "inverse_dynamics_derivatives": Definition('{∂τ}/{∂q} , {∂τ}/{∂θ̇}  "of"  τ = M θ̈ + h'),
    "inverse_dynamics_second_derivatives": Definition(
        "{∂^2 τ}/{∂q ∂q} , {∂^2 τ}/{∂q ∂θ̇} , {∂^2 τ}/{∂θ̇ ∂θ̇} , {∂M}/{∂q}"
    ),
    "forward_dynamics_derivatives": Definition(
        "{∂θ̈}/{∂q} = −M^{−1} {∂τ}/{∂q} , {∂θ̈}/{∂θ̇} = −M^{−1} {∂τ}/{∂θ̇} , {∂θ̈}/{∂τ} = M^{−1}"
    ),
    "step": Definition('(q, θ̇)(t) → (q, θ̇)(t + δt)  "with"  M θ̈ + h = τ'),
    "center_of_mass": Definition("c = {Σ_b m_b c_b}/{Σ_b m_b}"),
    "momentum": Definition("p = Σ_b m_b ċ_b ,  l = Σ_b (I_b ω_b + (c_b − c) × m_b ċ_b)"),
    "momentum_matrix": Definition("(p, l) = A θ̇"),
    "joint_momentum": Definition("P = R^T M_n R θ̇ ,  Ṗ = Ṙ^T M_n R θ̇ − g − f"),
    "frame_jacobian": Definition("(ṙ_f, ω_f) = J θ̇"),
    "frame_velocity": Definition("(ṙ_f, ω_f)"),
    "frame_bias_acceleration": Definition("J̇ θ̇ = (r̈_f, ω̇_f) − J θ̈"),
    "regressor": Definition('M θ̈ + h = Y π  "with the inertial parameters"  π'),
    "base_regressor": Definition("Y_b β = Y π"),
    "base_parameters": Definition('β = K π  "with as few entries as the joint forces can tell apart"'),
    "joint_wrenches": Definition('"force and moment that each joint transmits at"  (q, θ̇, θ̈)'),
    "constraint_forces": Definition("Ψ_x^T λ = M_n ẍ − Q", "3.3"),
    "jvp": Definition("δy = {∂y}/{∂z} δz"),
    "vjp": Definition("w^T {∂y}/{∂z}"),
    "parameter_jacobian": Definition("{∂y}/{∂p}"),
}  # fmt: skip


@dataclass(frozen=True)
class FunctionWords:
    """A function of the scene: its name, its rows with what they are, in words."""

    name: str
    rows: tuple[tuple[str, Definition], ...]
    summary: str


PLANE: dict[str, Definition] = {
    "natural_mass_matrix": Definition('M_n = Σ_b W_b^{−H} P_b W_b^{−1}  "in complex numbers"'),
}
"""What is defined otherwise where two coordinates make a point."""


def joints_have(scene: Scene, quantity: str) -> bool:
    """Whether a joint has ``armature`` or ``damping``, as a number or as a parameter."""
    given = any(getattr(joint, quantity) for joint in scene.joints)
    joints = {f"{joint.name}.{quantity}" for joint in scene.joints}
    return given or any(parameter.name in joints for parameter in scene.parameters)


def mass_matrix(scene: Scene) -> str:
    return "M = R^T M_n R" + (" + J_a" if joints_have(scene, "armature") else "")


def bias_force(scene: Scene) -> str:
    return "h = R^T M_n Ṙ θ̇ − R^T Q" + (" + b θ̇" if joints_have(scene, "damping") else "")


def scene_definitions(system: System) -> dict[str, Definition]:
    """The definitions with what this scene's joints add: rotors and dampers move no natural coordinate."""
    scene, found = system.scene, dict(DEFINITIONS)
    if system.natural.plane is not None:
        found |= PLANE
    found["mass_matrix"] = Definition(mass_matrix(scene), "3.7")
    found["bias_force"] = Definition(bias_force(scene), "3.7")
    if joints_have(scene, "armature"):
        found["kinetic_energy"] = Definition("T = {1}/{2} θ̇^T M θ̇ = {1}/{2} (ẋ^T M_n ẋ + θ̇^T J_a θ̇)")
        found["joint_momentum"] = Definition("P = M θ̇ ,  Ṗ = Ṙ^T M_n R θ̇ − g − f")
    if joints_have(scene, "damping"):
        found["passive_force"] = Definition('f = −R^T Q_s + b θ̇  "with springs"  Q_s')
    if scene.forces or joints_have(scene, "armature") or joints_have(scene, "damping"):
        text = 'R^T (M_n ẍ − Q_g) = Y π  "with the weight"  Q_g  "and the inertial parameters"  π'
        found["regressor"] = Definition(text)
    return found


def function_words(output: Output, system: System) -> FunctionWords:
    known = scene_definitions(system)
    rows = tuple((row, known[split_row(row)[0]]) for row in output.of)
    return FunctionWords(function_name(output.name), rows, function_summary(output))


def about(row: str) -> str:
    """``of mass_matrix`` behind the formula of a product of derivatives, the frame's name behind that of a frame."""
    name, argument = split_row(row)
    if not argument:
        return ""
    return f"y: {argument}" if name in PRODUCTS else argument
