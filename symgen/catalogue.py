"""The function catalogue: for every row its arguments, its outputs and the literal definition it is held to.

To add an output: one row here and the method of `symgen.literal.equations.Literal` that defines it; faster plans,
where there are any, are registered in `symgen.plans.build`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from symgen.literal.equations import Literal
from symgen.natural.layout import NaturalCoordinates
from symgen.program.instructions import Port
from symgen.scene.model import Output, Scene
from symgen.scene.outputs import function_name
from symgen.topology.tree import Tree

STATE_INPUTS = ("q", "v", "a", "tau", "dt", "p")
"""Every argument a function may have, in the order of every signature."""


@dataclass(frozen=True)
class Sizes:
    nq: int
    nv: int
    nn: int
    nc: int
    np: int


@dataclass(frozen=True)
class Row:
    """One row: ``inputs`` among `STATE_INPUTS` (without p), ``outputs`` as (name, shape in terms of `Sizes` fields,
    unit), a one-line summary, and ``literal`` (None where the row is defined by an equation, see ``residual``)."""

    inputs: tuple[str, ...]
    outputs: tuple[tuple[str, tuple[str | int, ...], str], ...]
    summary: str
    literal: Callable[[Literal, str], tuple[Any, ...]] | None


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

OF_CONSTRAINTS = frozenset({"constraints", "constraint_jacobian", "constraint_forces"})
"""Rows of the constraints between natural coordinates."""

INPUT_UNITS = {"q": "m or rad", "v": "m/s or rad/s", "a": "m/s^2 or rad/s^2", "tau": "N or N.m", "dt": "s", "p": MIXED}


def split_row(row: str) -> tuple[str, str]:
    """``frame_pose:tool`` → (``frame_pose``, ``tool``)."""
    name, _, frame = row.partition(":")
    return name, frame


def sizes(scene: Scene, tree: Tree, natural: NaturalCoordinates) -> Sizes:
    return Sizes(tree.nq, tree.nv, natural.nn, natural.nc, sum(parameter.size for parameter in scene.parameters))


def input_ports(rows: tuple[str, ...], size: Sizes) -> tuple[Port, ...]:
    """The union of the rows' inputs in the order of every signature; ``p`` last whenever the scene has parameters."""
    wanted = {name for row in rows for name in CATALOGUE[split_row(row)[0]].inputs}
    shapes = {"q": (size.nq,), "v": (size.nv,), "a": (size.nv,), "tau": (size.nv,), "dt": (), "p": (size.np,)}
    if size.np:
        wanted.add("p")
    return tuple(Port(name, shapes[name], INPUT_UNITS[name]) for name in STATE_INPUTS if name in wanted)


def output_ports(rows: tuple[str, ...], size: Sizes) -> tuple[Port, ...]:
    """One port per output of the rows; a name that would come twice (two frame poses) takes its frame's name too."""
    found = []
    several = len([row for row in rows if row.startswith("frame_pose")]) > 1
    for row in rows:
        name, frame = split_row(row)
        for output, shape, unit in CATALOGUE[name].outputs:
            numbers = tuple(n if isinstance(n, int) else int(getattr(size, n)) for n in shape)
            found.append(Port(f"{output}_{frame}" if frame and several else output, numbers, unit))
    return tuple(found)


def function_summary(output: Output) -> str:
    """The comment above a function: what each of its outputs is."""
    parts = []
    for row in output.of:
        name, frame = split_row(row)
        names = ", ".join(port for port, _, _ in CATALOGUE[name].outputs)
        parts.append(f"{names} = {CATALOGUE[name].summary}" + (f" ({frame})" if frame else ""))
    return "; ".join(parts)


__all__ = [
    "CATALOGUE",
    "STATE_INPUTS",
    "Row",
    "Sizes",
    "function_name",
    "function_summary",
    "input_ports",
    "output_ports",
    "sizes",
]
