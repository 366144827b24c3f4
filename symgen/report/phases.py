"""What the phases of generated functions compute: a sentence and a formula for each heading of the plans.

Headings stand as comments in the C: ``composite inertia: lower``. What follows the colon, or the last ``of``,
``along`` or ``from``, is a body, and the heading without it is what is looked up here.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Phase:
    sentence: str
    formula: str = ""
    """As `symgen.report.mathml.math` reads it. i is the body, p its parent, j what hangs on it; s_i = (w_i, v_i) is
    the motion that the joint of i allows, (f, n) are force and moment at its origin."""


PHASES: dict[str, Phase] = {
    "motion": Phase(
        "How the body turns and accelerates, from its parent outward, in its own axes. The ground accelerates against "
        "gravity, so that weight needs no pass of its own; S makes the skew matrix of a vector.",
        "ω_i = ω_p + w_i θ̇_i ,  U_i = S(ω̇_i) + S(ω_i)^2 ,  a_i = a_p + U_p d_i + …",
    ),
    "force": Phase(
        "What force and moment this motion takes, with what is handed on from everything beyond; its part along the "
        "joint is the joint's force.",
        "f_i = m_i a_i + U_i m_i c_i + Σ_j f_j ,  τ_i = w_i · n_i + v_i · f_i",
    ),
    "composite inertia": Phase(
        "The inertia of the body with everything beyond it, about its own origin and in its own axes, from the leaves "
        "inward.",
        "I_i^c = I_i + Σ_j X_j^T I_j^c X_j",
    ),
    "mass matrix: columns": Phase(
        "The force that moving this joint alone takes, felt by the joint itself and by every joint on the way to the "
        "ground. R factors along paths, so that no R is formed.",
        "M_{i j} = s_i^T X^T I_j^c s_j",
    ),
    "constant entries": Phase("Entries that no state changes."),
    "velocity": Phase(
        "Angular velocity, and velocity of the origin, in the body's own axes.",
        "ω_i = ω_p + w_i θ̇_i ,  ṙ_i = ṙ_p + ω_p × d_i + v_i θ̇_i",
    ),
    "velocity moments": Phase("Moments of the velocities of everything beyond, which the columns of Ṙ feel."),
    "Coriolis matrix: columns and rows": Phase(
        "Entries between this joint and those on the way to the ground, from the composite bodies.",
        "C = R^T M_n Ṙ",
    ),
    "gravity in link axes": Phase("The direction of gravity, seen from the body.", "g_i = A_i^T g"),
    "first moment": Phase("Mass times centre of mass, with everything beyond.", "h_i = m_i c_i + Σ_j h_j"),
    "gravity": Phase(
        "What the weight of everything beyond asks of the joint.",
        "−(w_i · (h_i × g_i) + v_i · m_i g_i)",
    ),
    "articulated inertia": Phase(
        "The inertia that the parent feels when the joints from here on are free to move.",
        "I_i^A = I_i + Σ_j X_j^T (I_j^A − {I_j^A s_j s_j^T I_j^A}/{s_j^T I_j^A s_j}) X_j",
    ),
    "acceleration": Phase(
        "The joint's acceleration, from its parent's outward.",
        "θ̈_i = {τ_i − s_i^T (I_i^A a_p + f_i)}/{s_i^T I_i^A s_i}",
    ),
    "factor: LᵀDL": Phase(
        "The mass matrix factored from the leaves inward: where branches do not meet, L has zeros as M has.",
        "M = L^T D L",
    ),
    "solve": Phase("Back through the factors.", "L^T D L θ̈ = τ − h"),
    "no answer unless these are positive": Phase(
        "The pivots: where one is not positive, the mass matrix has no inverse, and the outputs are NaN.", "D > 0"
    ),
    "springs and dampers": Phase("Forces of springs and dampers at the joints.", "f = −R^T Q_s + b θ̇"),
    "springs": Phase("Springs that pull at the body."),
    "momentum": Phase("Momentum of the body with everything beyond it.", "p_i = m_i ċ_i + Σ_j p_j"),
    "momentum matrix: columns": Phase("The momentum that moving this joint alone makes.", "(p, l) = A θ̇"),
    "centre of mass in link axes": Phase("The centre of mass of everything, seen from the body."),
    "axes": Phase("The body's axes in ground axes.", "A_i = A_p A_{p i}"),
    "columns": Phase("What the frame does when this joint alone moves.", "(ṙ_f, ω_f) = J θ̇"),
    "frame seen": Phase("Place and motion of the frame, one body nearer to the ground."),
    "motions of the joints": Phase("The motions of all joints on the way, in the body's axes."),
    "regressor": Phase("What each inertial parameter of the body asks of the joints.", "τ = Y π"),
    "derivatives: fields": Phase("What moving this joint changes in the accelerations of everything beyond it."),
    "derivatives: columns and rows": Phase(
        "Derivatives between this joint and those on the way to the ground.", "{∂τ}/{∂q} , {∂τ}/{∂θ̇}"
    ),
    "derivatives by velocity: columns and rows": Phase(
        "Derivatives by velocities, between this joint and those on the way to the ground.", "{∂τ}/{∂θ̇}"
    ),
    "derivatives by position: columns and rows": Phase(
        "Derivatives by positions, between this joint and those on the way to the ground.", "{∂τ}/{∂q}"
    ),
    "tangents": Phase("Derivatives by the chain rule, operation by operation."),
    "second derivatives": Phase("The derivatives differentiated again, by the chain rule."),
    "forces of velocities and weight": Phase("h without a pass of its own: what velocities ask is quadratic in them."),
    "solve for every column": Phase("One solution for each variable.", "{∂θ̈}/{∂z} = −M^{−1} {∂τ}/{∂z}"),
    "inverse of the mass matrix": Phase("From the factors.", "M^{−1} = L^{−1} D^{−1} L^{−T}"),
    "change along the directions": Phase("The chain rule forwards, along given directions."),
    "gradient, backwards": Phase("The chain rule backwards, for given weights."),
    "derivatives by the parameters": Phase("The chain rule forwards, along each parameter."),
    "normal equations": Phase("The least squares that define the multipliers.", "Ψ_x Ψ_x^T λ = Ψ_x (M_n ẍ − Q)"),
}


def split_heading(heading: str) -> tuple[str, str]:
    """(kind, body) of a heading, body empty where it has none: the longest kind that is known."""
    if heading in PHASES:
        return heading, ""
    for kind in sorted(PHASES, key=len, reverse=True):
        for joint in (": ", " of ", " along ", " from the parent of "):
            if heading.startswith(kind + joint):
                return kind, heading[len(kind + joint) :]
    return heading, ""
