"""Families of plans: the ways a function can be computed, which differ for it, and what they are called."""

from __future__ import annotations

from dataclasses import dataclass

from symgen.catalogue import PRODUCTS, split_row
from symgen.scene.model import Output
from symgen.topology.tree import Tree


@dataclass(frozen=True)
class Family:
    """A way to compute: in which axes, with inertia regrouped or as given, and how accelerations are solved for."""

    literal: bool = False
    regrouped: bool = True
    articulated: bool = False
    merged: bool = False
    """Links along parallel axes share axes."""
    differentiated: bool = False
    """Derivatives by differentiating the graph of what is derived, instead of by an algorithm of their own."""

    def plan(self, output: Output) -> str:
        """What a function's plan is called: the algorithms of its rows."""
        if self.literal:
            return "literal"
        found = " + ".join(dict.fromkeys(self._name(row) for row in output.of))
        found = f"{found}, parallel axes merged" if self.merged else found
        return found if self.regrouped else f"{found}, inertia as given"

    def _name(self, row: str) -> str:
        name, argument = split_row(row)
        if name in PRODUCTS:
            return f"{PRODUCT_NAMES[name]} of {self._name(argument)}"
        if self.differentiated and name in DERIVATIVES:
            return "differentiated"
        found = PLAN_NAMES.get(name, "literal")
        return ("articulated" if self.articulated else "factored") if found == "solved" else found

    def explanation(self, output: Output) -> str:
        """What that means, for `symgen show`."""
        if self.literal:
            return "ground axes, R and M multiplied out"
        rows = {innermost(row) for row in output.of}
        if rows == {"constraint_forces"}:
            return "natural coordinates, Ψ Ψᵀ factored LDLᵀ in an order of little fill"
        words = ["body axes"]
        if not rows <= EITHER_WAY:
            words.append("inertia regrouped" if self.regrouped else "inertia as given")
        if self.merged:
            words.append("axes shared along parallel joints")
        if self.differentiated:
            words.append("every tangent of the graph")
        elif any(innermost(row) in SOLVED for row in output.of):
            words.append("articulated bodies" if self.articulated else "mass matrix factored LᵀDL along the tree")
        return ", ".join(words)


FAMILIES: tuple[Family, ...] = (
    Family(),
    Family(articulated=True),
    Family(regrouped=False),
    Family(regrouped=False, articulated=True),
    Family(differentiated=True),
    Family(literal=True, regrouped=False),
)
PRODUCT_NAMES = {"jvp": "tangent", "vjp": "gradient", "parameter_jacobian": "differentiated"}
PLAN_NAMES = {
    "mass_matrix": "composite",
    "coriolis_matrix": "composite",
    "gravity_force": "composite",
    "potential_energy": "composite",
    "bias_force": "recursive",
    "inverse_dynamics": "recursive",
    "kinetic_energy": "recursive",
    "joint_momentum": "recursive",
    "forward_dynamics": "solved",
    "mass_matrix_inverse": "factored",
    "inverse_dynamics_derivatives": "analytic",
    "forward_dynamics_derivatives": "analytic",
    "inverse_dynamics_second_derivatives": "tangents of analytic",
    "center_of_mass": "composite",
    "momentum": "recursive",
    "momentum_matrix": "composite",
    "frame_jacobian": "walk",
    "frame_velocity": "walk",
    "frame_bias_acceleration": "walk",
    "regressor": "recursive",
    "base_regressor": "recursive",
    "joint_wrenches": "recursive",
    "constraint_forces": "normal equations",
}
"""Row → the algorithm that computes it in body axes."""


EITHER_WAY = frozenset({
    "frame_jacobian", "frame_velocity", "frame_bias_acceleration", "regressor", "base_regressor", "joint_wrenches",
    "constraint_forces",
})  # fmt: skip
"""Rows whose plan does not depend on how inertia is grouped."""
OF_MASS = frozenset({"center_of_mass", "momentum", "momentum_matrix"})
"""Rows that divide by the mass of everything."""
DERIVATIVES = frozenset({
    "inverse_dynamics_derivatives", "forward_dynamics_derivatives", "inverse_dynamics_second_derivatives",
})  # fmt: skip
SOLVED = frozenset({"forward_dynamics", "mass_matrix_inverse", "forward_dynamics_derivatives"})
"""Rows that have no literal expression, only the equation that defines them: some family must solve it."""


def families_of(output: Output, tree: Tree) -> tuple[Family, ...]:
    """The families that differ for this function, cheapest to try first."""
    rows = {innermost(row) for row in output.of}
    planned = rows & PLAN_NAMES.keys()
    if not planned:
        return (FAMILIES[-1],)
    if rows == {"constraint_forces"}:
        return (FAMILIES[0],)
    articulated = "forward_dynamics" in rows and not tree.coupled  # couplings join branches
    derivatives = bool(rows & DERIVATIVES)
    literal = not derivatives and not any(split_row(row)[0] in PRODUCTS for row in output.of)
    return tuple(
        family
        for family in FAMILIES
        if (articulated or not family.articulated)
        and (not planned <= EITHER_WAY or family.regrouped or family.literal)
        and (derivatives or not family.differentiated)
        and (literal or not family.literal)
    )


MERGED = frozenset({
    "mass_matrix", "coriolis_matrix", "gravity_force", "bias_force", "inverse_dynamics", "forward_dynamics",
    "mass_matrix_inverse", "inverse_dynamics_derivatives", "forward_dynamics_derivatives", "kinetic_energy",
    "inverse_dynamics_second_derivatives", "joint_momentum",
})  # fmt: skip
"""Rows that gain where parallel axes are merged."""


LAGGING = frozenset({
    "coriolis_matrix", "bias_force", "inverse_dynamics", "forward_dynamics", "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives", "inverse_dynamics_second_derivatives", "joint_momentum",
})  # fmt: skip
"""Rows that turn motion and forces to the last links and back, and so gain where these leave their axes behind."""


def output_lags(output: Output) -> bool:
    return any(innermost(row) in LAGGING for row in output.of)


def output_forces(output: Output) -> bool:
    """True for functions that are forces of a motion and nothing else."""
    return all(innermost(row) in ("bias_force", "inverse_dynamics") for row in output.of)


def output_merges(output: Output) -> bool:
    return any(innermost(row) in MERGED for row in output.of)


def innermost(row: str) -> str:
    """The row that products are taken of: ``jvp:frame_pose:tool`` → ``frame_pose``."""
    name, argument = split_row(row)
    return innermost(argument) if name in PRODUCTS else name
