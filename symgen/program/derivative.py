"""Differentiating the exact graph: forward (tangents) and backward (gradients).

One rule per operation. Tangents of many seeds share every partial derivative, because nodes are shared; a structural
zero (int 0) costs nothing. The results are nodes of the same graph, exact like all others, and certified like them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from operator import or_
from typing import Any

from symgen.algebra.linear import add, is_zero, mul, neg, sub
from symgen.program.graph import Graph, Node

Scalar = Any


def _sqrt(graph: Graph, node: Node) -> tuple[Scalar, ...]:
    return (graph.div(graph.const(1), graph.mul(graph.const(2), node)),)


def _div(graph: Graph, node: Node) -> tuple[Scalar, ...]:
    over = graph.div(graph.const(1), node.args[1])
    return over, neg(mul(node, over))


PARTIALS: dict[str, Callable[[Graph, Node], tuple[Scalar, ...]]] = {
    "add": lambda graph, node: (1, 1),
    "sub": lambda graph, node: (1, -1),
    "mul": lambda graph, node: (node.args[1], node.args[0]),
    "div": _div,
    "neg": lambda graph, node: (-1,),
    "sqrt": _sqrt,
    "cos": lambda graph, node: (neg(graph.sin(node.args[0])),),
    "sin": lambda graph, node: (graph.cos(node.args[0]),),
}
"""Operation → its partial derivatives with respect to its arguments."""


def _live(roots: Sequence[Scalar]) -> list[Node]:
    """The nodes that roots depend on, in the order made."""
    found: dict[int, Node] = {}
    stack = [root for root in roots if type(root) is Node]
    while stack:
        node = stack.pop()
        if node.number not in found:
            found[node.number] = node
            stack.extend(node.args)
    return [found[number] for number in sorted(found)]


def _partials(graph: Graph, node: Node) -> tuple[Scalar, ...]:
    rule = PARTIALS.get(node.op)
    if rule is None:
        raise NotImplementedError(f"{node.op} is not differentiated")
    return rule(graph, node)


def tangents(
    graph: Graph,
    roots: Sequence[Scalar],
    seeds: Sequence[Mapping[Node, Scalar]],
    wanted: Sequence[int] | None = None,
) -> list[list[Scalar]]:
    """Per seed (input node → its rate), the rates of the roots. ``wanted``: per root, the seeds along which its rate is
    asked for, as the bits of a number (all of them if left out); where it is not, 0 stands."""
    live = _live(roots)
    needed = _needed(live, roots, seeds, wanted)
    found = []
    for k, seed in enumerate(seeds):
        rates: dict[int, Scalar] = {node.number: rate for node, rate in seed.items()}
        for node in needed[k]:
            rates[node.number] = _rate(graph, node, rates)
        bit = 1 << k
        asked = [wanted is None or wanted[i] & bit for i in range(len(roots))]
        found.append(
            [
                rates.get(root.number, 0) if ask and type(root) is Node else 0
                for root, ask in zip(roots, asked, strict=True)
            ]
        )
    return found


def _needed(
    live: Sequence[Node],
    roots: Sequence[Scalar],
    seeds: Sequence[Mapping[Node, Scalar]],
    wanted: Sequence[int] | None,
) -> list[list[Node]]:
    """Per seed, the nodes that have a rate along it which a root that asks for it depends on, in the order made."""
    every = (1 << len(seeds)) - 1
    moved: dict[int, int] = {}
    for k, seed in enumerate(seeds):
        for node, rate in seed.items():
            if not is_zero(rate):
                moved[node.number] = moved.get(node.number, 0) | 1 << k
    for node in live:
        if node.args:
            moved[node.number] = reduce(or_, [moved.get(arg.number, 0) for arg in node.args])
    asked: dict[int, int] = {}
    for root, mask in zip(roots, wanted or [every] * len(roots), strict=True):
        if type(root) is Node:
            asked[root.number] = asked.get(root.number, 0) | mask
    found: list[list[Node]] = [[] for _ in seeds]
    for node in reversed(live):
        both = asked.get(node.number, 0) & moved.get(node.number, 0)
        if not both or not node.args:
            continue
        for arg in node.args:
            asked[arg.number] = asked.get(arg.number, 0) | both
        while both:
            found[both.bit_length() - 1].append(node)
            both &= ~(1 << both.bit_length() - 1)
    for nodes in found:
        nodes.reverse()
    return found


def _rate(graph: Graph, node: Node, rates: Mapping[int, Scalar]) -> Scalar:
    op = node.op
    if op in ("add", "sub", "mul"):
        x, y = node.args
        dx, dy = rates.get(x.number, 0), rates.get(y.number, 0)
        if op == "mul":
            return add(mul(y, dx), mul(x, dy))
        return add(dx, dy) if op == "add" else sub(dx, dy)
    rate: Scalar = 0
    for arg, partial in zip(node.args, _partials(graph, node), strict=True):
        rate = _accumulate(rate, partial, rates.get(arg.number, 0))
    return rate


def _accumulate(total: Scalar, partial: Scalar, x: Scalar) -> Scalar:
    if type(partial) is int and partial == -1:
        return sub(total, x)
    return add(total, mul(partial, x))


def gradient(graph: Graph, roots: Sequence[Scalar], weights: Sequence[Scalar], inputs: Sequence[Node]) -> list[Scalar]:
    """Σ weights · ∂roots/∂inputs, by one backward sweep."""
    wanted = _depends_on(_live(roots), inputs)
    adjoint: dict[int, Scalar] = {}
    for root, weight in zip(roots, weights, strict=True):
        if type(root) is Node:
            adjoint[root.number] = add(adjoint.get(root.number, 0), weight)
    for node in reversed(wanted):
        own = adjoint.get(node.number, 0)
        if is_zero(own) or not node.args:
            continue
        for arg, partial in zip(node.args, _partials(graph, node), strict=True):
            if arg.op != "const":
                adjoint[arg.number] = _accumulate(adjoint.get(arg.number, 0), partial, own)
    return [adjoint.get(node.number, 0) for node in inputs]


def _depends_on(live: Sequence[Node], inputs: Sequence[Node]) -> list[Node]:
    """The nodes that depend on one of the inputs."""
    found = {node.number for node in inputs}
    kept = []
    for node in live:
        if node.number in found or any(arg.number in found for arg in node.args):
            found.add(node.number)
            kept.append(node)
    return kept
