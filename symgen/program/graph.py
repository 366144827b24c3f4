"""The exact arithmetic graph: hash-consed nodes over exact rationals, simplified as they are made.

A `Graph` is a number type (`symgen.algebra.numbers.Numbers`): run any derivation on its inputs and the result
is the program of that derivation. Nodes are numbered in the order they were made, which is the order a reader
of the derivation expects, and does not depend on hashing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from itertools import compress
from typing import Any

from symgen.program.instructions import Instruction, Port, Program
from symgen.program.rules import BINARY, COMMUTATIVE, UNARY


class Node:
    """One value of the graph. Arithmetic on nodes makes nodes."""

    __slots__ = ("args", "core", "graph", "label", "number", "op", "phase", "value")

    def __init__(self, graph: Graph, number: int, op: str, args: tuple[Node, ...], value: Any, core: int) -> None:
        self.graph = graph
        self.number = number
        self.op = op
        self.args = args
        self.value = value
        self.label = ""
        self.phase = graph.current_phase
        self.core = core
        """Number of what a constant is multiplied with here, or of the node itself."""

    def __add__(self, other: Any) -> Node:
        return self.graph.binary("add", self, other if type(other) is Node else self.graph.const(other))

    def __radd__(self, other: Any) -> Node:
        return self.graph.binary("add", self.graph.const(other), self)

    def __sub__(self, other: Any) -> Node:
        return self.graph.binary("sub", self, other if type(other) is Node else self.graph.const(other))

    def __rsub__(self, other: Any) -> Node:
        return self.graph.binary("sub", self.graph.const(other), self)

    def __mul__(self, other: Any) -> Node:
        return self.graph.binary("mul", self, other if type(other) is Node else self.graph.const(other))

    def __rmul__(self, other: Any) -> Node:
        return self.graph.binary("mul", self.graph.const(other), self)

    def __truediv__(self, other: Any) -> Node:
        return self.graph.binary("div", self, other if type(other) is Node else self.graph.const(other))

    def __rtruediv__(self, other: Any) -> Node:
        return self.graph.binary("div", self.graph.const(other), self)

    def __neg__(self) -> Node:
        return self.graph.unary("neg", self)

    def __repr__(self) -> str:
        if self.op == "const":
            return str(self.value)
        if self.op == "input":
            return f"{self.value[0]}[{self.value[1]}]"
        return f"{self.op}({', '.join(f'%{a.number}' for a in self.args)})"


class Graph:
    """Maker and owner of nodes; the exact number type."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._known: dict[tuple[Any, ...], Node] = {}
        self._constants: dict[tuple[int, int], Node] = {}
        self.current_phase = ""

    @contextmanager
    def phase(self, heading: str) -> Iterator[None]:
        """Nodes made inside stand under this heading in the emitted code."""
        before, self.current_phase = self.current_phase, heading
        try:
            yield
        finally:
            self.current_phase = before

    def const(self, value: Fraction | int) -> Node:
        key = value.as_integer_ratio()  # cheaper to hash than the Fraction
        known = self._constants.get(key)
        if known is None:
            number = len(self.nodes)
            known = self._constants[key] = Node(self, number, "const", (), Fraction(value), number)
            self.nodes.append(known)
        return known

    def input(self, name: str, index: int) -> Node:
        key = ("input", name, index)
        known = self._known.get(key)
        if known is None:
            number = len(self.nodes)
            known = self._known[key] = Node(self, number, "input", (), (name, index), number)
            self.nodes.append(known)
        return known

    def inputs(self, name: str, size: int) -> tuple[Node, ...]:
        return tuple(self.input(name, index) for index in range(size))

    def find(self, op: str, x: Node, y: Node) -> Node | None:
        """The node ``op(x, y)`` if it was made before."""
        return self._known.get((op, x.number, y.number))

    def binary(self, op: str, x: Node, y: Node) -> Node:
        if op in COMMUTATIVE and (y.op == "const" or (y.number < x.number and x.op != "const")):
            x, y = y, x
        key = (op, x.number, y.number)
        known = self._known.get(key)
        if known is not None:
            return known
        for rule in BINARY[op][x.op][y.op]:
            simpler = rule(self, x, y)
            if simpler is not None:
                return simpler
        return self._make(key, op, (x, y))

    def unary(self, op: str, x: Node) -> Node:
        key = (op, x.number)
        known = self._known.get(key)
        if known is not None:
            return known
        for rule in UNARY[op][x.op]:
            simpler = rule(self, x)
            if simpler is not None:
                return simpler
        return self._make(key, op, (x,))

    def _make(self, key: tuple[Any, ...], op: str, args: tuple[Node, ...]) -> Node:
        number = len(self.nodes)
        scaled = op == "mul" and args[0].op == "const"
        node = Node(self, number, op, args, None, args[1].number if scaled else number)
        self.nodes.append(node)
        self._known[key] = node
        return node

    def raw(self, op: str, *args: Node) -> Node:
        """A node exactly as written: shared, but not simplified."""
        key = (op, *[x.number for x in args])
        return self._known.get(key) or self._make(key, op, args)

    def adopt(self, program: Program) -> list[Node]:
        """The instructions of a program as nodes, exactly as written, in their order."""
        done: list[Node] = []
        for op, args, value, label, phase in program.instructions:
            self.current_phase = phase
            if args:
                node = self.raw(op, *[done[k] for k in args])
            elif isinstance(value, Fraction):
                node = self.const(value)
            else:
                assert isinstance(value, tuple)
                node = self.input(*value)
            node.label = label
            done.append(node)
        return done

    def drop(self, node: Node) -> None:
        """Forget that a node exists: it will not be found, nor made again as itself."""
        key = (node.op, *[x.number for x in node.args])
        if node.args and self._known.get(key) is node:
            del self._known[key]

    def forget(self) -> None:
        """Let go of all nodes, which otherwise wait for the garbage collector: they and their graph know each other."""
        self.nodes.clear()
        self._known.clear()
        self._constants.clear()

    def add(self, x: Node, y: Node) -> Node:
        return self.binary("add", x, y)

    def sub(self, x: Node, y: Node) -> Node:
        return self.binary("sub", x, y)

    def mul(self, x: Node, y: Node) -> Node:
        return self.binary("mul", x, y)

    def div(self, x: Node, y: Node) -> Node:
        return self.binary("div", x, y)

    def neg(self, x: Node) -> Node:
        return self.unary("neg", x)

    def sqrt(self, x: Node) -> Node:
        return self.unary("sqrt", x)

    def cos(self, x: Node) -> Node:
        return self.unary("cos", x)

    def sin(self, x: Node) -> Node:
        return self.unary("sin", x)

    def cos_sqrt(self, x: Node) -> Node:
        return self.unary("cos_sqrt", x)

    def sinc_sqrt(self, x: Node) -> Node:
        return self.unary("sinc_sqrt", x)

    def sinc3_sqrt(self, x: Node) -> Node:
        return self.unary("sinc3_sqrt", x)

    def name(self, label: str, values: Sequence[Any]) -> None:
        """Give the components of a vector the names label_x, label_y, label_z (the first name a node gets stays)."""
        for suffix, value in zip(("x", "y", "z"), values, strict=False):
            self.name_scalar(f"{label}_{suffix}", value)

    def name_scalar(self, label: str, value: Any) -> None:
        if type(value) is Node and not value.label and value.op not in ("const", "input"):
            value.label = label


def extract(
    graph: Graph,
    name: str,
    inputs: tuple[Port, ...],
    outputs: tuple[Port, ...],
    results: Sequence[Sequence[Any]],
    guards: Sequence[Node] = (),
    plan: str = "",
    summary: str = "",
    order: Sequence[Node] | None = None,
) -> Program:
    """The program that computes ``results`` (scalars per output, row-major): live nodes only, in the order made or in
    ``order``, where arguments come first too."""
    wanted = [[x if type(x) is Node else graph.const(x) for x in row] for row in results]
    nodes = graph.nodes if order is None else order
    live = bytearray(len(graph.nodes))
    for row in (*wanted, guards):
        for node in row:
            live[node.number] = 1
    for node in reversed(nodes):  # arguments come before what is made of them
        if live[node.number]:
            for argument in node.args:
                live[argument.number] = 1
    place = [0] * len(live)
    instructions: list[Instruction] = []
    new: Any = tuple.__new__  # what the named tuple's own constructor does, at a third of its time
    for node in compress(nodes, live) if order is None else [node for node in order if live[node.number]]:
        place[node.number] = len(instructions)
        args = tuple([place[a.number] for a in node.args])
        instructions.append(new(Instruction, (node.op, args, node.value, node.label, node.phase)))
    return Program(
        name=name,
        inputs=inputs,
        outputs=outputs,
        instructions=tuple(instructions),
        results=tuple(tuple([place[node.number] for node in row]) for row in wanted),
        guards=tuple(dict.fromkeys(place[node.number] for node in guards)),
        plan=plan,
        summary=summary,
    )
