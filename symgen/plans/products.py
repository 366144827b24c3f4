"""Products with derivatives of any row: along a direction, of weights, and by the run-time parameters.

They differentiate the graph of the row's plan; what they give is certified against dual numbers run through the
literal definition.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from symgen.algebra.linear import dot
from symgen.catalogue import row_of
from symgen.plans.sensitivity import seeds
from symgen.program.derivative import gradient, tangents
from symgen.program.graph import Node
from symgen.velocity.kinematics import configuration_rate

if TYPE_CHECKING:
    from symgen.plans.build import Builder

Scalar = Any


def jvp(b: Builder, row: str) -> list[list[Scalar]]:
    """Changes of the row's outputs along dq, dv, da, dtau (those the row has) and dp."""
    outputs = b.row(row)
    seed: dict[Node, Scalar] = {}
    for name in row_of(row).inputs:
        direction: tuple[Scalar, ...] = b.graph.inputs(f"d{name}", b.tree.nv)
        if name == "q":
            direction = configuration_rate(b.tree, b.values, b.state.q, direction)
        seed.update(zip(getattr(b.state, name), direction, strict=True))
    seed.update(zip(b.state.p, b.graph.inputs("dp", len(b.state.p)), strict=True))
    with b.graph.phase("change along the directions"):
        rates = iter(tangents(b.graph, [x for entries in outputs for x in entries], [seed])[0])
    return [[next(rates) for _ in entries] for entries in outputs]


def vjp(b: Builder, row: str) -> list[list[Scalar]]:
    """Gradients of Σ weights · outputs with respect to each input of the row (q: along its manifold) and to p."""
    outputs, weights = b.row(row), list[Scalar]()
    for (name, _, _), entries in zip(row_of(row).outputs, outputs, strict=True):
        weights.extend(b.graph.inputs(f"w_{name}", len(entries)))
    names = (*row_of(row).inputs, "p")
    inputs = [getattr(b.state, name) for name in names]
    with b.graph.phase("gradient, backwards"):
        flat = iter(
            gradient(b.graph, [x for entries in outputs for x in entries], weights, [x for n in inputs for x in n])
        )
        found = [[next(flat) for _ in nodes] for nodes in inputs]
        if names[0] == "q":
            found[0] = [dot([seed[node] for node in b.state.q], found[0]) for seed in seeds(b, "q")]
    return found


def parameter_jacobian(b: Builder, row: str) -> list[list[Scalar]]:
    """Each output entry by every run-time parameter, row-major: by tangents, or backwards if that is less."""
    outputs = b.row(row)
    flat = [x for entries in outputs for x in entries]
    with b.graph.phase("derivatives by the parameters"):
        if len(b.state.p) <= 2 * len(flat):
            columns = tangents(b.graph, flat, seeds(b, "p"))
            rows = [[column[i] for column in columns] for i in range(len(flat))]
        else:
            rows = [gradient(b.graph, [root], [1], b.state.p) for root in flat]
    place = iter(rows)
    return [[x for _ in entries for x in next(place)] for entries in outputs]


PRODUCT_ROWS: dict[str, Callable[[Builder, str], list[list[Scalar]]]] = {
    "jvp": jvp, "vjp": vjp, "parameter_jacobian": parameter_jacobian,
}  # fmt: skip
