"""Differentiating the exact graph: forward (tangents) and backward (gradients).

One rule per operation. Tangents of many seeds share every partial derivative, because nodes are shared; a structural
zero (int 0) costs nothing. The results are nodes of the same graph, exact like all others, and certified like them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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


def tangents(graph: Graph, roots: Sequence[Scalar], seeds: Sequence[Mapping[Node, Scalar]]) -> list[list[Scalar]]:
    """Per seed (input node → its rate), the rates of the roots."""
    live = _live(roots)
    found = []
    for seed in seeds:
        rates: dict[int, Scalar] = {node.number: rate for node, rate in seed.items()}
        for node in live:
            if not node.args or all(is_zero(rates.get(arg.number, 0)) for arg in node.args):
                continue
            rate: Scalar = 0
            for arg, partial in zip(node.args, _partials(graph, node), strict=True):
                rate = _accumulate(rate, partial, rates.get(arg.number, 0))
            rates[node.number] = rate
        found.append([rates.get(root.number, 0) if type(root) is Node else 0 for root in roots])
    return found


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
