"""Passes over a finished program: each takes a program and returns one that computes the same, cheaper.

Every pass is certified on every run with the function it is part of (the emitted text is what is checked).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from symgen.program.graph import Graph, Node, extract
from symgen.program.instructions import Instruction, Program


def common_factor(program: Program) -> Program:
    """x·y ± x·z → x·(y ± z) where neither product is used elsewhere, and what follows from it, until there is no such
    sum."""
    if not _has_candidates(program):
        return program
    graph = Graph()
    editor = _Editor(graph, graph.adopt(program), program)
    passes = 0
    while sums := editor.sums_to_factor():
        editor.factor(sums)
        passes += 1
    rebuilt = editor.program() if passes else program
    graph.forget()
    return rebuilt


def _has_candidates(program: Program) -> bool:
    code = program.instructions
    for op, args, _, _, _ in code:
        if op in ("add", "sub"):
            x, y = code[args[0]], code[args[1]]
            if x.op == "mul" and y.op == "mul" and (x.args[0] in y.args or x.args[1] in y.args):
                return True
    return False


class _Editor:
    """A program as the nodes of a graph that has no others. What a change does not reach stays as it is: changes are
    few, and programs long."""

    def __init__(self, graph: Graph, order: list[Node], program: Program) -> None:
        self.graph, self.order, self.written = graph, order, program
        self.results = [[order[i] for i in row] for row in program.results]
        self.guards = [order[i] for i in program.guards]
        self.made = len(graph.nodes)

    def sums_to_factor(self) -> dict[int, tuple[Node, Node, Node]]:
        """Number of a sum → (shared factor, other factor of the first product, of the second)."""
        uses = self.uses()
        found: dict[int, tuple[Node, Node, Node]] = {}
        for node in self.order:
            if node.op not in ("add", "sub"):
                continue
            x, y = node.args
            if x.op != "mul" or y.op != "mul" or x is y or uses[x.number] != 1 or uses[y.number] != 1:
                continue
            pairs = ((a, b) for a in (0, 1) for b in (0, 1) if x.args[a] is y.args[b])
            pair = next(pairs, None)
            if pair is not None:
                found[node.number] = x.args[pair[0]], x.args[1 - pair[0]], y.args[1 - pair[1]]
        return found

    def uses(self) -> list[int]:
        uses = [0] * len(self.graph.nodes)
        for node in self.order:
            for argument in node.args:
                uses[argument.number] += 1
        for row in (*self.results, self.guards):
            for node in row:
                uses[node.number] += 1
        return uses

    def factor(self, sums: dict[int, tuple[Node, Node, Node]]) -> None:
        """Write these sums as products, and again what is made of them."""
        graph, changed = self.graph, dict[int, Node]()
        placed, order = set[int](), list[Node]()

        def place(node: Node) -> None:
            if node.number not in placed:
                placed.add(node.number)
                for argument in node.args:
                    place(argument)
                order.append(node)

        for node in self.order:
            args = node.args
            if node.number in sums:
                shared, one, other = (changed.get(x.number, x) for x in sums[node.number])
            elif not any(x.number in changed for x in args):
                if node.number not in placed:
                    placed.add(node.number)
                    order.append(node)
                continue
            graph.current_phase = node.phase
            if node.number in sums:
                new = graph.mul(shared, graph.binary(node.op, one, other))
            elif len(args) == 2:
                new = graph.binary(node.op, *(changed.get(x.number, x) for x in args))
            else:
                new = graph.unary(node.op, changed.get(args[0].number, args[0]))
            graph.name_scalar(node.label, new)
            changed[node.number] = new
            place(new)
        self.results = [[changed.get(x.number, x) for x in row] for row in self.results]
        self.guards = [changed.get(x.number, x) for x in self.guards]
        self.order = self.living(order)

    def living(self, order: Sequence[Node]) -> list[Node]:
        """Of the nodes those that are needed; the graph forgets the others, so that nothing is made of them again."""
        live = bytearray(len(self.graph.nodes))
        for row in (*self.results, self.guards):
            for node in row:
                live[node.number] = 1
        for node in reversed(order):
            if live[node.number]:
                for argument in node.args:
                    live[argument.number] = 1
        for node in (*self.order, *self.graph.nodes[self.made :]):
            if not live[node.number]:
                self.graph.drop(node)
        self.made = len(self.graph.nodes)
        return [node for node in order if live[node.number]]

    def program(self) -> Program:
        was = self.written
        return extract(
            self.graph,
            was.name,
            was.inputs,
            was.outputs,
            self.results,
            self.guards,
            was.plan,
            was.summary,
            self.order,
        )


def fold_negations(program: Program) -> Program:
    """−(a·x) → (−a)·x and −(x − y) → y − x where the inner value is used nowhere else."""
    code = program.instructions
    if not any(step.op == "neg" for step in code):
        return program
    uses = _uses(program)
    folded: dict[int, tuple[Fraction | None, int, int]] = {}
    for i, (op, args, _, _, _) in enumerate(code):
        if op != "neg" or uses[args[0]] != 1:
            continue
        inner = code[args[0]]
        if inner.op == "sub":
            folded[i] = None, inner.args[1], inner.args[0]
        elif inner.op == "mul" and isinstance(value := code[inner.args[0]].value, Fraction):
            folded[i] = -value, -1, inner.args[1]
    return _folded(program, folded) if folded else program


def _uses(program: Program) -> list[int]:
    uses = [0] * len(program.instructions)
    for _, args, _, _, _ in program.instructions:
        for i in args:
            uses[i] += 1
    for row in (*program.results, program.guards):
        for i in row:
            uses[i] += 1
    return uses


def _folded(program: Program, folded: dict[int, tuple[Fraction | None, int, int]]) -> Program:
    """The program with other instructions in these places: a product with a constant, or a difference. What is alike is
    there once, and what is not needed left out."""
    code = program.instructions
    live = bytearray(len(code))
    for row in (*program.results, program.guards):
        for i in row:
            live[i] = 1
    for i in range(len(code) - 1, -1, -1):
        if live[i]:
            for k in folded[i][1:] if i in folded else code[i].args:
                if k >= 0:
                    live[k] = 1
    found: list[Instruction] = []
    known: dict[tuple[object, ...], int] = {}
    place = [0] * len(code)

    def written(op: str, args: tuple[int, ...], value: object, label: str, phase: str) -> int:
        key = (op, *args) if args else (op, value)
        index = known.get(key)
        if index is None:
            index = known[key] = len(found)
            found.append(Instruction(op, args, value, label, phase))  # type: ignore[arg-type]
        elif label and not found[index].label:
            found[index] = found[index]._replace(label=label)
        return index

    for i, (op, args, value, label, phase) in enumerate(code):
        if not live[i]:
            continue
        if i not in folded:
            place[i] = written(op, tuple([place[k] for k in args]), value, label, phase)
            continue
        factor, x, y = folded[i]
        if factor is None:
            place[i] = written("sub", (place[x], place[y]), None, label, phase)
        else:
            constant = written("const", (), factor, "", phase)
            place[i] = written("mul", (constant, place[y]), None, label, phase)
    return replace(
        program,
        instructions=tuple(found),
        results=tuple(tuple([place[i] for i in row]) for row in program.results),
        guards=tuple(dict.fromkeys(place[i] for i in program.guards)),
    )


def optimise(program: Program) -> Program:
    """All passes."""
    return fold_negations(common_factor(program))
