"""The function catalogue: for every row its arguments, its outputs and the literal definition it is held to.

To add an output: one row here and the method of `symgen.literal.equations.Literal` that defines it; faster plans,
where there are any, are registered in `symgen.plans.build`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from symgen.literal import base_parameters, derivatives, frames, momenta, reactions, regressor
from symgen.literal.equations import Literal
from symgen.natural.layout import NaturalCoordinates
from symgen.program.instructions import Port
from symgen.scene.model import Output, Scene
from symgen.scene.outputs import function_name
from symgen.topology.tree import Tree
from symgen.velocity.kinematics import configuration_rate

STATE_INPUTS = ("q", "v", "a", "tau", "dt")
"""Arguments of the catalogue's rows, in the order of every signature; directions and weights of products follow, and
the parameters p come last."""


@dataclass(frozen=True)
class Sizes:
    nq: int
    nv: int
    nn: int
    nc: int
    np: int
    moving: int = 0
    """Moving bodies."""
    base: Callable[[], int] = field(default=lambda: 0, repr=False, compare=False)

    @property
    def inertial(self) -> int:
        """Inertial parameters, ten per moving body."""
        return regressor.TEN * self.moving

    @property
    def nbase(self) -> int:
        """Base parameters; found when first asked for."""
        return self.base()


Facts = tuple[str, tuple[str | int, ...], str]
"""Name, shape in terms of `Sizes` fields, unit."""


@dataclass(frozen=True)
class Row:
    """One row: ``inputs`` among `STATE_INPUTS` (without p), ``outputs`` as (name, shape in terms of `Sizes` fields,
    unit), a one-line summary, and ``literal`` (None where the row is defined by an equation, see ``residual``)."""

    inputs: tuple[str, ...]
    outputs: tuple[Facts, ...]
    summary: str
    literal: Callable[[Literal, str], tuple[Any, ...]] | None
    further: tuple[Facts, ...] = ()
    """Further inputs: directions and weights."""


def _one(method: str) -> Callable[[Literal, str], tuple[Any, ...]]:
    return lambda literal, frame: (getattr(literal, method)(),)


MIXED = "SI"
"""Unit of arrays whose entries have different ones (SI throughout)."""

CATALOGUE: dict[str, Row] = {
    "natural_coordinates": Row(
        ("q",), (("x", ("nn",), "m or 1"),), "basic points and unit vectors, ground axes", _one("natural_coordinates")
    ),
    "natural_mass_matrix": Row(
        (), (("Mn", ("nn", "nn"), MIXED),), "constant mass matrix of the natural coordinates",
        _one("natural_mass_matrix"),
    ),
    "constraints": Row(
        ("q",), (("Psi", ("nc",), MIXED),), "constraints at x(q), zero on every configuration", _one("constraints")
    ),
    "constraint_jacobian": Row(
        ("q",), (("Psi_q", ("nc", "nn"), MIXED),), "Jacobian of Psi with respect to x", _one("constraint_jacobian")
    ),
    "velocity_transformation": Row(
        ("q",), (("R", ("nn", "nv"), MIXED),), "R, with dx/dt = R v", _one("velocity_transformation")
    ),
    "velocity_transformation_rate": Row(
        ("q", "v"), (("Rdot", ("nn", "nv"), MIXED),), "dR/dt", _one("velocity_transformation_rate")
    ),
    "natural_bias_acceleration": Row(
        ("q", "v"), (("xddot_bias", ("nn",), MIXED),), "(dR/dt) v, natural accelerations at zero joint acceleration",
        _one("natural_bias_acceleration"),
    ),
    "mass_matrix": Row(("q",), (("M", ("nv", "nv"), MIXED),), "R^T Mn R, full symmetric", _one("mass_matrix")),
    "coriolis_matrix": Row(
        ("q", "v"), (("C", ("nv", "nv"), MIXED),), "R^T Mn dR/dt", _one("coriolis_matrix")
    ),
    "gravity_force": Row(("q",), (("g", ("nv",), "N or N.m"),), "gravity, left-hand side", _one("gravity_force")),
    "passive_force": Row(
        ("q", "v"), (("passive", ("nv",), "N or N.m"),), "springs, dampers and joint damping, left-hand side",
        _one("passive_force"),
    ),
    "bias_force": Row(
        ("q", "v"), (("h", ("nv",), "N or N.m"),), "C v + gravity_force + passive_force", _one("bias_force")
    ),
    "inverse_dynamics": Row(
        ("q", "v", "a"), (("tau", ("nv",), "N or N.m"),), "mass_matrix a + bias_force", _one("inverse_dynamics")
    ),
    "forward_dynamics": Row(
        ("q", "v", "tau"), (("a", ("nv",), "m/s^2 or rad/s^2"),),
        "accelerations that solve mass_matrix a + bias_force = tau", None,
    ),
    "kinetic_energy": Row(("q", "v"), (("T", (), "J"),), "kinetic energy", _one("kinetic_energy")),
    "potential_energy": Row(
        ("q",), (("V", (), "J"),), "potential energy of gravity and springs, zero at the ground origin",
        _one("potential_energy"),
    ),
    "frame_pose": Row(
        ("q",), (("pose", (4, 4), "m or 1"),), "pose of a frame in ground axes",
        lambda literal, frame: (literal.frame_pose(frame),),
    ),
    "integrate": Row(
        ("q", "v", "dt"), (("q_next", ("nq",), "as q"),), "q after moving with v for dt, on the manifold",
        _one("integrate"),
    ),
}  # fmt: skip

CATALOGUE.update({
    "joint_momentum": Row(
        ("q", "v"), (("P", ("nv",), MIXED), ("P_rate", ("nv",), "N or N.m")),
        "momenta R^T Mn R v, and their rates where tau is zero: (dR/dt)^T Mn R v - gravity_force - passive_force",
        lambda literal, frame: momenta.joint_momentum(literal),
    ),
    "mass_matrix_inverse": Row(("q",), (("Minv", ("nv", "nv"), MIXED),), "inverse of mass_matrix", None),
    "inverse_dynamics_derivatives": Row(
        ("q", "v", "a"), (("dtau_dq", ("nv", "nv"), MIXED), ("dtau_dv", ("nv", "nv"), MIXED)),
        "derivatives of inverse_dynamics along the velocities (q on its manifold) and by v",
        lambda literal, frame: derivatives.inverse_dynamics_derivatives(literal),
    ),
    "forward_dynamics_derivatives": Row(
        ("q", "v", "tau"),
        (("da_dq", ("nv", "nv"), MIXED), ("da_dv", ("nv", "nv"), MIXED), ("da_dtau", ("nv", "nv"), MIXED)),
        "derivatives of forward_dynamics along the velocities (q on its manifold), by v and by tau", None,
    ),
    "inverse_dynamics_second_derivatives": Row(
        ("q", "v", "a"),
        tuple((f"d2tau_{name}", ("nv", "nv", "nv"), MIXED) for name in ("dqdq", "dqdv", "dvdv", "dadq")),
        "second derivatives of inverse_dynamics: [i, j, k] of tau_i by j of the first, then by k of the second",
        lambda literal, frame: derivatives.inverse_dynamics_second_derivatives(literal),
    ),
})  # fmt: skip

FORCE = "N or N.m"

CATALOGUE["configuration_rate"] = Row(
    ("q", "v"), (("q_rate", ("nq",), "as q, per second"),), "dq/dt, which is v where there are no quaternions",
    lambda literal, frame: (configuration_rate(literal.tree, literal.values, literal.state.q, literal.state.v),),
)  # fmt: skip
CATALOGUE["step"] = Row(
    ("q", "v", "tau", "dt"), (("q_next", ("nq",), "as q"), ("v_next", ("nv",), "m/s or rad/s")),
    "state after dt with constant tau", None,
)  # fmt: skip

CATALOGUE.update({
    "center_of_mass": Row(
        ("q",), (("com", (3,), "m"),), "centre of mass of the moving bodies, ground axes",
        lambda literal, frame: (frames.center_of_mass(literal),),
    ),
    "momentum": Row(
        ("q", "v"), (("momentum", (6,), MIXED),),
        "linear momentum, then angular momentum about the centre of mass, ground axes",
        lambda literal, frame: (frames.momentum(literal),),
    ),
    "momentum_matrix": Row(
        ("q",), (("A", (6, "nv"), MIXED),), "matrix with momentum = A v",
        lambda literal, frame: (frames.momentum_matrix(literal),),
    ),
    "frame_jacobian": Row(
        ("q",), (("J", (6, "nv"), MIXED),), "matrix with frame_velocity = J v",
        lambda literal, frame: (frames.frame_jacobian(literal, frame),),
    ),
    "frame_velocity": Row(
        ("q", "v"), (("twist", (6,), MIXED),), "velocity of a frame's origin, then angular velocity, ground axes",
        lambda literal, frame: (frames.frame_velocity(literal, frame),),
    ),
    "frame_bias_acceleration": Row(
        ("q", "v"), (("bias", (6,), MIXED),),
        "acceleration of a frame's origin, then angular acceleration, at zero joint acceleration: (dJ/dt) v",
        lambda literal, frame: (frames.frame_bias_acceleration(literal, frame),),
    ),
    "regressor": Row(
        ("q", "v", "a"), (("Y", ("nv", "inertial"), MIXED),),
        "inverse_dynamics without springs, dampers and armature is Y times the inertial parameters",
        lambda literal, frame: (regressor.regressor(literal),),
    ),
    "base_regressor": Row(
        ("q", "v", "a"), (("Yb", ("nv", "nbase"), MIXED),), "columns of Y that the base parameters stand for",
        lambda literal, frame: (base_parameters.base_regressor(literal),),
    ),
    "base_parameters": Row(
        (), (("beta", ("nbase",), MIXED),), "base parameters, with Yb beta = Y times the inertial parameters",
        lambda literal, frame: (base_parameters.base_parameter_values(literal),),
    ),
    "joint_wrenches": Row(
        ("q", "v", "a"), (("W", ("moving", 6), FORCE),),
        "per moving body, force and moment about its origin that its joint transmits to it, body axes",
        lambda literal, frame: (reactions.joint_wrenches(literal),),
    ),
    "constraint_forces": Row(
        ("q", "v", "a"), (("lambda", ("nc",), MIXED),), "least-squares solution of Psi_x^T lambda = Mn xddot - Q",
        lambda literal, frame: (reactions.constraint_forces(literal),),
    ),
})  # fmt: skip

PRODUCTS = ("jvp", "vjp", "parameter_jacobian")
"""Derivatives of any other row, written PRODUCT:ROW."""


def row_of(row: str) -> Row:
    """The row of the catalogue, or the product of one."""
    name, argument = split_row(row)
    return PRODUCT_ROWS[name](row_of(argument)) if name in PRODUCT_ROWS else CATALOGUE[name]


def _jvp(base: Row) -> Row:
    directions = tuple((f"d{name}", ("nv",), "direction") for name in base.inputs)
    outputs = tuple((f"d_{name}", shape, MIXED) for name, shape, _ in base.outputs)
    further: tuple[Facts, ...] = (*directions, ("dp", ("np",), "direction"))
    return Row(base.inputs, outputs, f"change along the directions of: {base.summary}", None, further)


def _vjp(base: Row) -> Row:
    weights = tuple((f"w_{name}", shape, "weight") for name, shape, _ in base.outputs)
    gradients: tuple[Facts, ...] = tuple((f"g_{name}", ("nv",), MIXED) for name in base.inputs)
    outputs: tuple[Facts, ...] = (*gradients, ("g_p", ("np",), MIXED))
    return Row(base.inputs, outputs, f"gradient of the weighted sum of: {base.summary}", None, weights)


def _parameter_jacobian(base: Row) -> Row:
    outputs = tuple((f"d{name}_dp", (*shape, "np"), MIXED) for name, shape, _ in base.outputs)
    return Row(base.inputs, outputs, f"derivatives by the run-time parameters of: {base.summary}", None)


PRODUCT_ROWS: dict[str, Callable[[Row], Row]] = {
    "jvp": _jvp, "vjp": _vjp, "parameter_jacobian": _parameter_jacobian,
}  # fmt: skip

OF_CONSTRAINTS = frozenset({"constraints", "constraint_jacobian", "constraint_forces"})
"""Rows of the constraints between natural coordinates."""

INPUT_UNITS = {"q": "m or rad", "v": "m/s or rad/s", "a": "m/s^2 or rad/s^2", "tau": "N or N.m", "dt": "s", "p": MIXED}


def split_row(row: str) -> tuple[str, str]:
    """``frame_pose:tool`` → (``frame_pose``, ``tool``); ``jvp:frame_pose:tool`` → (``jvp``, ``frame_pose:tool``)."""
    name, _, frame = row.partition(":")
    return name, frame


def sizes(scene: Scene, tree: Tree, natural: NaturalCoordinates) -> Sizes:
    return Sizes(
        tree.nq,
        tree.nv,
        natural.nn,
        natural.nc,
        sum(parameter.size for parameter in scene.parameters),
        len(tree.bodies),
        lambda: len(base_parameters.base_parameters(scene, tree, natural).independent),
    )


def input_ports(rows: tuple[str, ...], size: Sizes) -> tuple[Port, ...]:
    """The union of the rows' inputs in the order of every signature; ``p`` last whenever the scene has parameters."""
    wanted = {name for row in rows for name in row_of(row).inputs}
    shapes = {"q": (size.nq,), "v": (size.nv,), "a": (size.nv,), "tau": (size.nv,), "dt": ()}
    ports = [Port(name, shapes[name], INPUT_UNITS[name]) for name in STATE_INPUTS if name in wanted]
    further = {facts[0]: _port(facts, size) for row in rows for facts in row_of(row).further}
    ports.extend(port for port in further.values() if port.size)
    if size.np:
        ports.append(Port("p", (size.np,), INPUT_UNITS["p"]))
    return tuple(ports)


def _port(facts: Facts, size: Sizes) -> Port:
    name, shape, unit = facts
    return Port(name, tuple(n if isinstance(n, int) else int(getattr(size, n)) for n in shape), unit)


def output_ports(rows: tuple[str, ...], size: Sizes) -> tuple[Port, ...]:
    """One port per output of the rows; a name that would come twice (two frame poses) takes its frame's name too."""
    names = [facts[0] for row in rows for facts in row_of(row).outputs]
    found = []
    for row in rows:
        frame = function_name(split_row(row)[1])
        for facts in row_of(row).outputs:
            port = _port(facts, size)
            several = frame and names.count(port.name) > 1
            found.append(replace(port, name=f"{port.name}_{frame}") if several else port)
    return tuple(found)


def function_summary(output: Output) -> str:
    """The comment above a function: what each of its outputs is."""
    parts = []
    for row in output.of:
        name, frame = split_row(row)
        facts = row_of(row)
        names = ", ".join(port for port, _, _ in facts.outputs)
        named = f" ({frame})" if frame and name not in PRODUCTS else ""
        parts.append(f"{names} = {facts.summary}{named}")
    return "; ".join(parts)


__all__ = [
    "CATALOGUE",
    "PRODUCTS",
    "STATE_INPUTS",
    "Row",
    "Sizes",
    "function_name",
    "function_summary",
    "input_ports",
    "output_ports",
    "row_of",
    "sizes",
]
