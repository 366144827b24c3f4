"""The functions against each other: identities, and finite differences along the motion.

A direction on the manifold is followed by our own ``integrate``, whose first derivative is itself checked
against q̇ = G(q) v. Derivatives are central differences, extrapolated (Ridders 1982).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from symgen.scene.model import Spring
from symgen.validation.compare import norm, sample_states
from symgen.validation.functions import Bound
from symgen.validation.mechanism import Array, Mechanism, position_rate
from symgen.validation.result import Row, Skip

STATES = 20
DIFFERENCE = 1e-9
"""Criterion of finite differences, relative to the quantity or 1: their own accuracy is about 1e-11."""
ROUNDING = 1e-12
"""Criterion of identities."""
FORCES = 1e-10
"""Criterion of the identity of constraint forces, which are solved for."""

Checker = Callable[["Context"], Iterator[Row]]


class Context:
    """A mechanism, its functions, and states to try them at."""

    def __init__(self, mechanism: Mechanism, functions: Bound, seed: int) -> None:
        self.mechanism = mechanism
        self.f = functions
        q, v, a, tau = sample_states(mechanism, STATES, seed)
        self.states = tuple(zip(q, v, a, tau, strict=True))

    def move(self, q: Array, v: Array, dt: float) -> Array:
        return self.f("integrate", q, v, dt)

    def directional(self, g: Callable[[Array], Array], q: Array, v: Array) -> Array:
        """d g(q(t))/dt at t = 0 along the motion that leaves q with velocity v."""
        return derivative(lambda t: g(self.move(q, v, t)))


def derivative(g: Callable[[float], Array], step: float = 0.1, levels: int = 8) -> Array:
    """g'(0) by central differences with halved steps, extrapolated; of the table, the entry that changed least."""
    rows: list[list[Array]] = []
    best, best_change = np.zeros(0), float("inf")
    for k in range(levels):
        h = step * 0.5**k
        row = [(np.asarray(g(h)) - np.asarray(g(-h))) / (2.0 * h)]
        for j in range(k):
            row.append(row[j] + (row[j] - rows[k - 1][j]) / (4.0 ** (j + 1) - 1.0))
            change = max(norm(row[j + 1] - row[j]), norm(row[j + 1] - rows[k - 1][j]))
            if change < best_change:
                best, best_change = row[j + 1], change
        rows.append(row)
    return best


def relative(error: Array, reference: Array) -> float:
    return norm(error) / max(1.0, norm(reference))


def integrate_rows(context: Context) -> Iterator[Row]:
    worst, drift = 0.0, 0.0
    for q, v, _a, _tau in context.states:
        rate = context.directional(lambda x: x, q, v)
        expected = position_rate(context.mechanism, q, v)
        worst = max(worst, relative(rate - expected, expected))
        drift = max(drift, quaternion_drift(context.mechanism, context.move(q, v, 0.7)))
    yield Row("integrate", "d/dt integrate(q, v, t) = G(q) v", worst, DIFFERENCE, "", "finite differences")
    yield Row("integrate", "| |quaternion| − 1 | after 0.7 s", drift, ROUNDING, "", "identity")


def quaternion_drift(mechanism: Mechanism, q: Array) -> float:
    drift = 0.0
    for link in mechanism.links:
        if link.joint.type in ("spherical", "floating"):
            drift = max(drift, abs(float(np.linalg.norm(q[link.q][-4:])) - 1.0))
    return drift


TRANSFORMATION = "velocity transformation"


def transformation_rows(context: Context) -> Iterator[Row]:
    f, rate, rank = context.f, 0.0, 0
    for q, v, _a, _tau in context.states:
        R = f("velocity_transformation", q)
        xdot = context.directional(lambda x: f("natural_coordinates", x), q, v)
        rate = max(rate, relative(R @ v - xdot, xdot))
        rank = max(rank, context.mechanism.nv - int(np.linalg.matrix_rank(R)))
    yield Row(TRANSFORMATION, "R v = dx/dt along the motion", rate, DIFFERENCE, "", "finite differences")
    yield Row(TRANSFORMATION, "degrees of freedom − rank R", float(rank), 0.0, "", "identity")


def constraint_rows(context: Context) -> Iterator[Row]:
    f, closed, tangent, nullity = context.f, 0.0, 0.0, 0
    couplings = sum(link.coupling is not None for link in context.mechanism.links)  # Ψ does not hold mimic joints
    for q, _v, _a, _tau in context.states:
        psi, J = f("constraints", q), f("constraint_jacobian", q)
        R = f("velocity_transformation", q)
        size = max(1.0, norm(f("natural_coordinates", q))) ** 2
        closed = max(closed, norm(psi) / size)
        tangent = max(tangent, norm(J @ R) / (max(1.0, norm(J)) * max(1.0, norm(R))))
        free = J.shape[1] - int(np.linalg.matrix_rank(J, tol=1e-9 * norm(J)))
        nullity = max(nullity, abs(free - R.shape[1] - couplings))
    yield Row("constraints", "Ψ(x) = 0", closed, ROUNDING, "relative to |x|²", "identity")
    yield Row("constraints", "Ψ_q R = 0", tangent, ROUNDING, "relative to |Ψ_q||R|", "identity")
    yield Row(
        "constraints",
        "nullity Ψ_q − degrees of freedom" + (" − couplings" if couplings else ""),
        float(nullity),
        0.0,
        "",
        "identity",
    )


def transformation_rate_rows(context: Context) -> Iterator[Row]:
    f, worst, joined = context.f, 0.0, 0.0
    for q, v, _a, _tau in context.states:
        Rdot = f("velocity_transformation_rate", q, v)
        difference = context.directional(lambda x: f("velocity_transformation", x), q, v)
        worst = max(worst, relative(Rdot - difference, difference))
        if f.has("natural_bias_acceleration"):
            joined = max(joined, relative(f("natural_bias_acceleration", q, v) - Rdot @ v, Rdot @ v))
    yield Row(TRANSFORMATION, "Ṙ = dR/dt along the motion", worst, DIFFERENCE, "", "finite differences")
    if f.has("natural_bias_acceleration"):
        yield Row(TRANSFORMATION, "natural_bias_acceleration = Ṙ v", joined, ROUNDING, "", "identity")


def reduction_rows(context: Context) -> Iterator[Row]:
    """RᵀMR with the exported R and M, armature added on the diagonal (theory: paper (3.7))."""
    f, worst = context.f, 0.0
    Mn = f("natural_mass_matrix")
    armature = np.zeros(context.mechanism.nv)
    values = {joint.name: joint.armature for joint in context.mechanism.scene.joints}
    for link in context.mechanism.links:
        armature[link.v] += link.factor**2 * float(values[link.joint.name])
    for q, _v, _a, _tau in context.states:
        R, M = f("velocity_transformation", q), f("mass_matrix", q)
        worst = max(worst, norm(R.T @ Mn @ R + np.diag(armature) - M) / norm(M))
    yield Row("reduced equations", "mass_matrix = RᵀMR + armature", worst, ROUNDING, "", "paper (3.7)")


def coriolis_rows(context: Context) -> Iterator[Row]:
    f, skew = context.f, 0.0
    for q, v, _a, _tau in context.states:
        C = f("coriolis_matrix", q, v)
        Mdot = context.directional(lambda x: f("mass_matrix", x), q, v)
        skew = max(skew, relative(Mdot - C - C.T, Mdot))
    yield Row("reduced equations", "Ṁ − 2C is skew", skew, DIFFERENCE, "", "finite differences")


def bias_rows(context: Context) -> Iterator[Row]:
    f, worst = context.f, 0.0
    for q, v, _a, _tau in context.states:
        parts = (f("coriolis_matrix", q, v) @ v, f("gravity_force", q), f("passive_force", q, v))
        worst = max(worst, norm(f("bias_force", q, v) - sum(parts)) / max(1.0, *(norm(part) for part in parts)))
    yield Row("reduced equations", "bias_force = C v + gravity + passive", worst, ROUNDING, "", "identity")


def potential_rows(context: Context) -> Iterator[Row]:
    f, worst, n = context.f, 0.0, context.mechanism.nv
    for q, _v, _a, _tau in context.states[:5]:
        force = f("gravity_force", q) + f("passive_force", q, np.zeros(n))
        gradient = [context.directional(lambda x: f("potential_energy", x), q, e).reshape(()) for e in np.eye(n)]
        worst = max(worst, relative(np.array(gradient) - force, force))
    yield Row("energy", "gravity + springs = ∂V", worst, DIFFERENCE, "", "finite differences")


def energy_rows(context: Context) -> Iterator[Row]:
    """d(T + V)/dt = vᵀτ − vᵀ(damping) along the motion that forward_dynamics gives, at random states and loads."""
    f, worst = context.f, 0.0
    for q, v, _a, tau in context.states:
        a = f("forward_dynamics", q, v, tau)

        def energy(t: float, q: Array = q, v: Array = v, a: Array = a) -> Array:
            here = context.move(q, v, t)
            return f("kinetic_energy", here, v + t * a).reshape(()) + f("potential_energy", here).reshape(())

        # The motion bends away from v + t a and move(q, v, t) by O(t²) only, which T + V feels at O(t²).
        scale = max(1.0, norm(a) / max(1.0, norm(v)))
        rate = derivative(energy, 0.1 / scale)
        friction = f("passive_force", q, v) - f("passive_force", q, np.zeros_like(v))
        power = v @ (tau - friction)
        parts = norm(v * tau) + norm(v * f("bias_force", q, v)) + norm(v * (f("mass_matrix", q) @ a))
        worst = max(worst, abs(float(rate) - float(power)) / max(1.0, parts))
    yield Row("energy", "d(T + V)/dt = power of loads − dissipation", worst, DIFFERENCE, "", "finite differences")


def inverse_rows(context: Context) -> Iterator[Row]:
    f, worst = context.f, 0.0
    for q, v, a, _tau in context.states:
        M, h = f("mass_matrix", q), f("bias_force", q, v)
        tau = f("inverse_dynamics", q, v, a)
        worst = max(worst, norm(M @ a + h - tau) / max(1.0, norm(h), norm(M @ a)))
    yield Row("reduced equations", "inverse_dynamics = M a + bias_force", worst, ROUNDING, "", "identity")


def constraint_force_rows(context: Context) -> Iterator[Row]:
    """Ψ_x(M ẍ − Q − Ψ_xᵀλ) = 0, for the difference of two motions through one configuration: Q cancels where no
    damper acts between points."""
    f, worst = context.f, 0.0
    forces = context.mechanism.scene.forces
    if any(isinstance(force, Spring) and force.damping for force in forces):
        return
    Mn, zero = f("natural_mass_matrix"), np.zeros(context.mechanism.nv)
    for q, v, a, _tau in context.states:
        J, R = f("constraint_jacobian", q), f("velocity_transformation", q)
        load = Mn @ (R @ a + f("natural_bias_acceleration", q, v))
        held = J.T @ (f("constraint_forces", q, v, a) - f("constraint_forces", q, zero, zero))
        worst = max(worst, norm(J @ (load - held)) / max(1.0, norm(J) * norm(load)))
    yield Row("constraints", "Ψ_x(M ẍ − Q − Ψ_xᵀλ) = 0", worst, FORCES, "between two motions", "paper (3.2)")


CHECKS: tuple[tuple[str, tuple[str, ...], Checker], ...] = (
    ("integrate", ("integrate",), integrate_rows),
    ("R v = dx/dt", ("velocity_transformation", "natural_coordinates", "integrate"), transformation_rows),
    (
        "Ψ and Ψ_q R",
        ("constraints", "constraint_jacobian", "velocity_transformation", "natural_coordinates"),
        constraint_rows,
    ),
    ("Ṙ", ("velocity_transformation_rate", "velocity_transformation", "integrate"), transformation_rate_rows),
    ("RᵀMR", ("natural_mass_matrix", "velocity_transformation", "mass_matrix"), reduction_rows),
    ("Ṁ − 2C", ("coriolis_matrix", "mass_matrix", "integrate"), coriolis_rows),
    ("bias_force", ("bias_force", "coriolis_matrix", "gravity_force", "passive_force"), bias_rows),
    ("inverse_dynamics", ("inverse_dynamics", "mass_matrix", "bias_force"), inverse_rows),
    ("∂V", ("potential_energy", "gravity_force", "passive_force", "integrate"), potential_rows),
    (
        "energy balance",
        (
            "forward_dynamics",
            "kinetic_energy",
            "potential_energy",
            "passive_force",
            "bias_force",
            "mass_matrix",
            "integrate",
        ),
        energy_rows,
    ),
)
"""Name, the functions it needs, the check."""

OF_ROWS_ASKED_FOR: tuple[tuple[tuple[str, ...], Checker], ...] = (
    (
        ("constraint_forces", "constraint_jacobian", "velocity_transformation", "natural_bias_acceleration"),
        constraint_force_rows,
    ),
)
"""Checks of rows that only some scenes ask for: without them there is nothing to skip."""


def check_differences(mechanism: Mechanism, functions: Bound, seed: int) -> tuple[list[Row], list[Skip]]:
    """Every check whose functions exist; the others are named as skipped."""
    context = Context(mechanism, functions, seed)
    rows: list[Row] = []
    skipped: list[Skip] = []
    for name, needs, check in CHECKS:
        missing = [need for need in needs if not functions.has(need)]
        if missing:
            skipped.append(Skip(name, f"needs {', '.join(missing)}"))
        else:
            rows.extend(check(context))
    for needs, check in OF_ROWS_ASKED_FOR:
        if all(functions.has(need) for need in needs):
            rows.extend(check(context))
    return rows, skipped
