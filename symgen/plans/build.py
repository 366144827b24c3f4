"""Building the exact program of a function by one family of plans.

A family says how rows of the catalogue are computed; rows of one function are built in one graph and share what
they share. Rows that have one way only are the literal ones in every family.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from symgen.algebra.linear import Vec, add, half, mul, sub, total, vadd
from symgen.algebra.numbers import State
from symgen.catalogue import (
    CATALOGUE,
    STATE_INPUTS,
    function_name,
    function_summary,
    input_ports,
    output_ports,
    sizes,
    split_row,
)
from symgen.literal.equations import Literal
from symgen.natural.layout import NaturalCoordinates
from symgen.plans import composite, coriolis, factor, recursive
from symgen.plans.walk import Links, Lowered
from symgen.program.graph import Graph, Node, extract
from symgen.program.instructions import Port, Program
from symgen.program.passes import optimise
from symgen.scene.model import Output, Scene
from symgen.topology.tree import Tree
from symgen.velocity.values import Values

Scalar = Any


@dataclass(frozen=True)
class Family:
    """A way to compute: in which axes, with inertia regrouped or as given, and how accelerations are solved for."""

    literal: bool = False
    regrouped: bool = True
    articulated: bool = False

    def plan(self, output: Output) -> str:
        """What a function's plan is called: the algorithms of its rows."""
        if self.literal:
            return "literal"
        names = [PLAN_NAMES.get(split_row(row)[0], "literal") for row in output.of]
        solver = "articulated" if self.articulated else "factored"
        found = " + ".join(dict.fromkeys(solver if name == "solved" else name for name in names))
        return found if self.regrouped else f"{found}, inertia as given"

    def explanation(self, output: Output) -> str:
        """What that means, for `symgen show`."""
        if self.literal:
            return "ground axes, R and M multiplied out"
        words = ["body axes", "inertia regrouped" if self.regrouped else "inertia as given"]
        if any(split_row(row)[0] in SOLVED for row in output.of):
            words.append("articulated bodies" if self.articulated else "mass matrix factored LᵀDL along the tree")
        return ", ".join(words)


FAMILIES: tuple[Family, ...] = (
    Family(),
    Family(articulated=True),
    Family(regrouped=False),
    Family(regrouped=False, articulated=True),
    Family(literal=True, regrouped=False),
)
PLAN_NAMES = {
    "mass_matrix": "composite",
    "coriolis_matrix": "composite",
    "gravity_force": "composite",
    "potential_energy": "composite",
    "bias_force": "recursive",
    "inverse_dynamics": "recursive",
    "kinetic_energy": "recursive",
    "forward_dynamics": "solved",
}
"""Row → the algorithm that computes it in body axes."""


@dataclass
class Builder:
    """One graph and what rows share in it."""

    lowered: Lowered
    natural: NaturalCoordinates
    family: Family
    graph: Graph = field(default_factory=Graph)
    guards: list[Node] = field(default_factory=list)

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
        return self.lowered.at(self.values, self.state.q, self.family.regrouped)

    @cached_property
    def still(self) -> list[int]:
        return [0] * self.tree.nv

    def passive(self) -> Vec:
        with self.graph.phase("springs and dampers"):
            return self.literal.passive_force()

    @cached_property
    def mass_matrix(self) -> Sequence[Sequence[Scalar]]:
        if self.family.literal:
            return self.literal.mass_matrix()
        m = self.reduce_matrix(composite.mass_matrix(self.links))
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

    def reduce_matrix(self, matrix: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
        return self.lowered.reduce_matrix(self.values, matrix)

    def inverse_dynamics(self, a: Sequence[Scalar]) -> Vec:
        tau = self.reduce(recursive.inverse_dynamics(self.links, self.v, self.rates(a), self.values.gravity()))
        motors = tuple(mul(extra, x) for extra, x in zip(self.armature, a, strict=True))
        return vadd(vadd(tuple(tau), motors), self.passive())

    @cached_property
    def bias_force(self) -> Vec:
        return self.literal.bias_force() if self.family.literal else self.inverse_dynamics(self.still)

    def forward_dynamics(self) -> Sequence[Scalar]:
        rest = [sub(x, y) for x, y in zip(self.state.tau, self.bias_force, strict=True)]
        if self.family.articulated:
            x, pivots = factor.solve_articulated(self.links, self.armature, rest)
        else:
            x, pivots = factor.solve_ltdl(self.links, self.mass_matrix, rest)
        self.guards.extend(pivot for pivot in pivots if isinstance(pivot, Node) and pivot.op != "const")
        return x

    def kinetic_energy(self) -> Scalar:
        motors = total(mul(extra, mul(rate, rate)) for extra, rate in zip(self.armature, self.state.v, strict=True))
        return half(add(coriolis.twice_kinetic_energy(self.links, self.v), motors))

    def potential_energy(self) -> Scalar:
        springs = self.literal.spring_energy()
        return coriolis.gravity_energy(self.links, self.values.gravity()) + springs


PLANNED: dict[str, Callable[[Builder], Any]] = {
    "mass_matrix": lambda b: b.mass_matrix,
    "coriolis_matrix": lambda b: b.reduce_matrix(coriolis.coriolis_matrix(b.links, b.v)),
    "gravity_force": lambda b: b.reduce(coriolis.gravity_force(b.links, b.values.gravity())),
    "bias_force": lambda b: b.bias_force,
    "inverse_dynamics": lambda b: b.inverse_dynamics(b.state.a),
    "forward_dynamics": lambda b: b.forward_dynamics(),
    "kinetic_energy": lambda b: b.kinetic_energy(),
    "potential_energy": lambda b: b.potential_energy(),
}
"""Rows with a plan in body axes, beside the literal one."""
SOLVED = frozenset({"forward_dynamics"})
"""Rows that have no literal expression, only the equation that defines them: some family must solve it."""


def families_of(output: Output, tree: Tree) -> tuple[Family, ...]:
    """The families that differ for this function, cheapest to try first."""
    rows = {split_row(row)[0] for row in output.of}
    planned, solved = rows & PLANNED.keys(), rows & SOLVED
    if not planned:
        return (FAMILIES[-1],)
    articulated = solved and not tree.coupled  # couplings join branches, which articulated bodies cannot
    return tuple(family for family in FAMILIES if articulated or not family.articulated)


def flatten(value: Any) -> list[Scalar]:
    """Row-major scalars of a nested tuple, or the scalar itself."""
    if isinstance(value, tuple | list):
        return [x for row in value for x in flatten(row)]
    return [value]


def build(lowered: Lowered, natural: NaturalCoordinates, output: Output, family: Family) -> Program:
    """The optimised program of one function by one family."""
    builder = Builder(lowered, natural, family)
    size = sizes(lowered.scene, lowered.tree, natural)
    inputs, outputs = input_ports(output.of, size), output_ports(output.of, size)
    for port in sorted(inputs, key=lambda port: STATE_INPUTS.index(port.name)):
        builder.graph.inputs(port.name, port.size)
    results: list[list[Scalar]] = []
    for row in output.of:
        name, frame = split_row(row)
        literal = CATALOGUE[name].literal
        if name in SOLVED or (name in PLANNED and not family.literal):
            results.append(flatten(PLANNED[name](builder)))
        else:
            assert literal is not None
            with builder.graph.phase(""):
                results.extend(flatten(value) for value in literal(builder.literal, frame))
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
    return optimise(program)


__all__ = ["FAMILIES", "PLANNED", "Family", "Port", "build", "families_of", "flatten"]
