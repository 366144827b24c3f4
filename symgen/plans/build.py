"""Building the exact program of a function by one family of plans.

A family says how rows of the catalogue are computed; rows of one function are built in one graph and share what
they share. Rows that have one way only are the literal ones in every family.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from symgen.algebra.linear import Vec, add, half, mul, sub, total, vadd, vsub
from symgen.algebra.numbers import State
from symgen.catalogue import (
    CATALOGUE,
    PRODUCTS,
    function_name,
    function_summary,
    input_ports,
    output_ports,
    row_of,
    sizes,
    split_row,
)
from symgen.literal import base_parameters, frames, reactions
from symgen.literal.equations import Literal
from symgen.natural.layout import NaturalCoordinates
from symgen.plans import centroidal, composite, coriolis, factor, products, recursive, sensitivity, singular
from symgen.plans import frames as frame_walks
from symgen.plans import reactions as joint_forces
from symgen.plans import regressor as carried
from symgen.plans.families import OF_MASS, SOLVED, Family, output_forces, output_lags
from symgen.plans.lagging import lagging
from symgen.plans.walk import Links, Lowered
from symgen.program.graph import Graph, Node, extract
from symgen.program.instructions import Program
from symgen.program.passes import optimise
from symgen.scene.model import Output, Scene
from symgen.topology.tree import Tree
from symgen.velocity.values import Values

Scalar = Any


@dataclass
class Builder:
    """One graph and what rows share in it."""

    lowered: Lowered
    natural: NaturalCoordinates
    family: Family
    output: Output
    """What is asked for."""
    graph: Graph = field(default_factory=Graph)
    guards: list[Node] = field(default_factory=list)
    slim: list[tuple[int, Node]] = field(default_factory=list)
    """Pivots of the mass matrix, by coordinate, that need a margin."""

    @property
    def scene(self) -> Scene:
        return self.lowered.scene

    @property
    def tree(self) -> Tree:
        return self.lowered.tree

    @cached_property
    def state(self) -> State:
        size, graph = sizes(self.scene, self.tree, self.natural), self.graph
        return State(
            q=graph.inputs("q", size.nq),
            v=graph.inputs("v", size.nv),
            a=graph.inputs("a", size.nv),
            tau=graph.inputs("tau", size.nv),
            dt=graph.input("dt", 0),
            p=graph.inputs("p", size.np),
        )

    @cached_property
    def values(self) -> Values:
        return Values(self.scene, self.graph, self.state.p)

    @cached_property
    def literal(self) -> Literal:
        return Literal(self.tree, self.natural, self.values, self.state)

    @cached_property
    def links(self) -> Links:
        """Links in axes that are fixed in them."""
        return self.lowered.at(self.values, self.state.q, self.family.regrouped)

    @cached_property
    def shared(self) -> Links:
        """Links in the axes that the family computes dynamics in."""
        family, leaves = self.family, output_lags(self.output)
        if not family.merged and not leaves:
            return self.links
        return self.lowered.at(self.values, self.state.q, family.regrouped, family.merged, leaves)

    @cached_property
    def forces(self) -> Links:
        """The same for plans that go by forces alone, and so know of point masses at links' origins. Where another
        plan needs the inertias too, links whose inertias must be turned keep theirs whole."""
        family, links = self.family, self.lowered.links
        shared = lagging(links) if family.merged and not output_forces(self.output) else frozenset()
        tips, leaves = frozenset(link.index for link in links) - shared, output_lags(self.output)
        return self.lowered.at(self.values, self.state.q, family.regrouped, family.merged, leaves, tips)

    @cached_property
    def still(self) -> list[int]:
        return [0] * self.tree.nv

    def row(self, row: str) -> list[list[Scalar]]:
        """Entries of each output of a row."""
        name, frame = split_row(row)
        if name in PRODUCTS:
            return products.PRODUCT_ROWS[name](self, frame)
        if name in OF_MASS:
            self.guard([self.total_mass])
        if name in PLANNED_OF_A_FRAME and not self.family.literal:
            return [flatten(PLANNED_OF_A_FRAME[name](self, frame))]
        if name in SOLVED or name == "constraint_forces" or (name in PLANNED and not self.family.literal):
            found = PLANNED[name](self)
            return [flatten(value) for value in found] if len(row_of(row).outputs) > 1 else [flatten(found)]
        literal = CATALOGUE[name].literal
        assert literal is not None
        with self.graph.phase(""):
            return [flatten(value) for value in literal(self.literal, frame)]

    def passive(self) -> Vec:
        with self.graph.phase("springs and dampers"):
            return self.literal.passive_force()

    @cached_property
    def mass_matrix(self) -> Sequence[Sequence[Scalar]]:
        if self.family.literal:
            return self.literal.mass_matrix()
        m = self.reduce_matrix(composite.mass_matrix(self.shared))
        for i, extra in enumerate(self.armature):
            m[i][i] = add(m[i][i], extra)
        return m

    @property
    def armature(self) -> tuple[Scalar, ...]:
        return self.literal.armature

    # --- coupled joints: plans work with the velocities of all joints, G v ----------------------------------------

    @cached_property
    def v(self) -> list[Scalar]:
        """Velocities of all joints."""
        return self.rates(self.state.v)

    def rates(self, v: Sequence[Scalar]) -> list[Scalar]:
        return self.lowered.joint_rates(self.values, v)

    def reduce(self, forces: Sequence[Scalar]) -> list[Scalar]:
        """Forces on all joints to forces on the coordinates."""
        return self.lowered.reduce(self.values, forces)

    def reduce_columns(self, matrix: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
        return self.lowered.reduce_columns(self.values, matrix)

    def reduce_matrix(self, matrix: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
        return self.lowered.reduce_matrix(self.values, matrix)

    def inverse_dynamics(self, a: Sequence[Scalar]) -> Vec:
        tau = self.reduce(recursive.inverse_dynamics(self.forces, self.v, self.rates(a), self.values.gravity()))
        motors = tuple(mul(extra, x) for extra, x in zip(self.armature, a, strict=True))
        return vadd(vadd(tuple(tau), motors), self.passive())

    @cached_property
    def bias_force(self) -> Vec:
        return self.literal.bias_force() if self.family.literal else self.inverse_dynamics(self.still)

    @cached_property
    def factored(self) -> factor.Factored:
        """LᵀDL of the mass matrix; its pivots are guarded."""
        with self.graph.phase("factor: LᵀDL"):
            found = factor.factor(self.shared, self.mass_matrix)
        self.guard_pivots(found.pivots)
        return found

    def guard(self, pivots: Sequence[Scalar]) -> None:
        """Where one of these is not positive there is no answer."""
        self.guards.extend(pivot for pivot in pivots if isinstance(pivot, Node) and pivot.op != "const")

    def guard_pivots(self, pivots: Sequence[Scalar]) -> None:
        """Of the mass matrix: where one cannot be told from zero the matrix is singular to working precision."""
        needed = singular.margins(self.lowered).needed
        self.guard([pivot for k, pivot in enumerate(pivots) if not needed[k]])
        self.slim += [(k, x) for k, x in enumerate(pivots) if needed[k] and isinstance(x, Node) and x.op != "const"]

    @cached_property
    def forward_dynamics(self) -> Sequence[Scalar]:
        if not self.family.articulated:
            rest = [sub(x, y) for x, y in zip(self.state.tau, self.bias_force, strict=True)]
            with self.graph.phase("solve"):
                return self.factored.solve(rest)
        load = factor.motion_load(self.forces, self.v, self.values.gravity())
        rest = [sub(x, y) for x, y in zip(self.state.tau, self.passive(), strict=True)]
        x, pivots = factor.solve_articulated(self.shared, self.armature, rest, load)
        self.guard_pivots(pivots)
        return x

    @cached_property
    def total_mass(self) -> Scalar:
        return frames.total_mass(self.literal)

    @cached_property
    def regressor(self) -> Sequence[Sequence[Scalar]]:
        """Y, rows of the coordinates."""
        rows = carried.regressor(self.links, self.v, self.rates(self.state.a), self.values.gravity())
        if not self.tree.coupled:
            return rows
        return list(zip(*(self.reduce(column) for column in zip(*rows, strict=True)), strict=True))

    def base_regressor(self) -> list[list[Scalar]]:
        base = base_parameters.base_parameters(self.scene, self.tree, self.natural)
        return [[row[k] for k in base.independent] for row in self.regressor]

    def joint_wrenches(self) -> list[Vec]:
        links = self.lowered.at(self.values, self.state.q, regrouped=False)
        springs = tuple(reactions.spring_ends(self.literal))
        a = self.rates(self.state.a)
        return joint_forces.joint_wrenches(links, self.v, a, self.values.gravity(), springs)

    def constraint_forces(self) -> list[Scalar]:
        with self.graph.phase("normal equations"):
            found, pivots = reactions.constraint_forces_and_pivots(self.literal)
        self.guard(pivots)
        return found

    def joint_momentum(self) -> tuple[Vec, Vec]:
        momenta, rates = coriolis.joint_momentum(self.shared, self.v)
        weight = coriolis.gravity_force(self.shared, self.values.gravity())
        motors = tuple(mul(extra, rate) for extra, rate in zip(self.armature, self.state.v, strict=True))
        force = self.reduce([sub(x, y) for x, y in zip(rates, weight, strict=True)])
        return vadd(tuple(self.reduce(momenta)), motors), vsub(tuple(force), self.passive())

    def kinetic_energy(self) -> Scalar:
        motors = total(mul(extra, mul(rate, rate)) for extra, rate in zip(self.armature, self.state.v, strict=True))
        return half(add(coriolis.twice_kinetic_energy(self.shared, self.v), motors))

    def potential_energy(self) -> Scalar:
        springs = self.literal.spring_energy()
        return coriolis.gravity_energy(self.shared, self.values.gravity()) + springs


PLANNED: dict[str, Callable[[Builder], Any]] = {
    "mass_matrix": lambda b: b.mass_matrix,
    "coriolis_matrix": lambda b: b.reduce_matrix(coriolis.coriolis_matrix(b.shared, b.v)),
    "gravity_force": lambda b: b.reduce(coriolis.gravity_force(b.shared, b.values.gravity())),
    "bias_force": lambda b: b.bias_force,
    "inverse_dynamics": lambda b: b.inverse_dynamics(b.state.a),
    "forward_dynamics": lambda b: b.forward_dynamics,
    "mass_matrix_inverse": lambda b: b.factored.inverse_matrix(),
    "inverse_dynamics_derivatives": lambda b: sensitivity.inverse_dynamics(b, b.state.a),
    "forward_dynamics_derivatives": sensitivity.forward_dynamics,
    "inverse_dynamics_second_derivatives": sensitivity.second_derivatives,
    "kinetic_energy": lambda b: b.kinetic_energy(),
    "joint_momentum": lambda b: b.joint_momentum(),
    "potential_energy": lambda b: b.potential_energy(),
    "center_of_mass": lambda b: centroidal.center_of_mass(b.links, b.total_mass),
    "momentum": lambda b: centroidal.momentum(b.links, b.v, b.total_mass),
    "momentum_matrix": lambda b: b.reduce_columns(centroidal.momentum_matrix(b.links, b.total_mass)),
    "regressor": lambda b: b.regressor,
    "base_regressor": lambda b: b.base_regressor(),
    "joint_wrenches": lambda b: b.joint_wrenches(),
    "constraint_forces": lambda b: b.constraint_forces(),
}
"""Rows with a plan in body axes, beside the literal one."""
PLANNED_OF_A_FRAME: dict[str, Callable[[Builder, str], Any]] = {
    "frame_jacobian": lambda b, frame: b.reduce_columns(frame_walks.frame_jacobian(b.links, frame)),
    "frame_velocity": lambda b, frame: frame_walks.frame_velocity(b.links, frame, b.v),
    "frame_bias_acceleration": lambda b, frame: frame_walks.frame_bias_acceleration(b.links, frame, b.v),
}
"""Rows of a frame that have one."""


def flatten(value: Any) -> list[Scalar]:
    """Row-major scalars of a nested tuple, or the scalar itself."""
    if isinstance(value, tuple | list):
        return [x for row in value for x in flatten(row)]
    return [value]


def build(lowered: Lowered, natural: NaturalCoordinates, output: Output, family: Family) -> Program:
    """The optimised program of one function by one family."""
    builder = Builder(lowered, natural, family, output)
    size = sizes(lowered.scene, lowered.tree, natural)
    inputs, outputs = input_ports(output.of, size), output_ports(output.of, size)
    for port in inputs:
        builder.graph.inputs(port.name, port.size)
    results = [entries for row in output.of for entries in builder.row(row)]
    if builder.slim:
        slim = dict.fromkeys(builder.slim)
        builder.guards += singular.guards(lowered, builder.graph, builder.values, builder.state.q, list(slim), inputs)
    program = extract(
        builder.graph,
        function_name(output.name),
        inputs,
        outputs,
        results,
        builder.guards,
        family.plan(output),
        function_summary(output),
    )
    builder.graph.forget()
    return optimise(program)


__all__ = ["PLANNED", "Builder", "build", "flatten"]
