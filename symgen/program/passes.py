"""Passes over a finished program: each takes a program and returns one that computes the same, cheaper.

Every pass is certified on every run with the function it is part of (the emitted text is what is checked).
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from symgen.program.graph import Graph, Node, extract
from symgen.program.instructions import Program, count


def _uses(program: Program) -> list[int]:
    uses = [0] * len(program.instructions)
    for instruction in program.instructions:
        for i in instruction.args:
            uses[i] += 1
    for row in program.results:
        for i in row:
            uses[i] += 1
    for i in program.guards:
        uses[i] += 1
    return uses


def rebuild(program: Program, rewrite: Callable[[Graph, int, list[Node]], Node | None]) -> Program:
    """The program again, node by node; ``rewrite(graph, i, done)`` may return another node for instruction i."""
    graph = Graph()
    done: list[Node] = []
    for i, instruction in enumerate(program.instructions):
        graph.current_phase = instruction.phase
        node = rewrite(graph, i, done)
        if node is None:
            if instruction.op == "const":
                assert isinstance(instruction.value, Fraction)
                node = graph.const(instruction.value)
            elif instruction.op == "input":
                assert isinstance(instruction.value, tuple)
                node = graph.input(*instruction.value)
            elif len(instruction.args) == 2:
                node = graph.binary(instruction.op, done[instruction.args[0]], done[instruction.args[1]])
            else:
                node = graph.unary(instruction.op, done[instruction.args[0]])
        if instruction.label:
            graph.name_scalar(instruction.label, node)
        done.append(node)
    return extract(
        graph,
        program.name,
        program.inputs,
        program.outputs,
        [[done[i] for i in row] for row in program.results],
        [done[i] for i in program.guards],
        program.plan,
        program.summary,
    )


def common_factor(program: Program) -> Program:
    """x·y ± x·z → x·(y ± z) where neither product is used elsewhere."""
    uses, instructions = _uses(program), program.instructions

    def rewrite(graph: Graph, i: int, done: list[Node]) -> Node | None:
        instruction = instructions[i]
        if instruction.op not in ("add", "sub"):
            return None
        first, second = instruction.args
        if first == second or uses[first] != 1 or uses[second] != 1:
            return None
        x, y = instructions[first], instructions[second]
        if x.op != "mul" or y.op != "mul":
            return None
        for a in (0, 1):
            for b in (0, 1):
                if x.args[a] == y.args[b]:
                    rest = graph.binary(instruction.op, done[x.args[1 - a]], done[y.args[1 - b]])
                    return graph.mul(done[x.args[a]], rest)
        return None

    return rebuild(program, rewrite)


def fold_negations(program: Program) -> Program:
    """−(a·x) → (−a)·x and −(x − y) → y − x where the inner value is used nowhere else; x·(−a) stays as written."""
    uses, instructions = _uses(program), program.instructions
    graph = Graph()
    done: list[Node] = []
    for instruction in instructions:
        graph.current_phase = instruction.phase
        args = [done[i] for i in instruction.args]
        if instruction.op == "const":
            assert isinstance(instruction.value, Fraction)
            node = graph.const(instruction.value)
        elif instruction.op == "input":
            assert isinstance(instruction.value, tuple)
            node = graph.input(*instruction.value)
        else:
            inner = instructions[instruction.args[0]]
            alone = uses[instruction.args[0]] == 1
            if instruction.op == "neg" and alone and inner.op == "sub":
                node = graph.raw("sub", done[inner.args[1]], done[inner.args[0]])
            elif instruction.op == "neg" and alone and inner.op == "mul" and instructions[inner.args[0]].op == "const":
                value = instructions[inner.args[0]].value
                assert isinstance(value, Fraction)
                node = graph.raw("mul", graph.const(-value), done[inner.args[1]])
            else:
                node = graph.raw(instruction.op, *args)
        if instruction.label:
            graph.name_scalar(instruction.label, node)
        done.append(node)
    return extract(
        graph,
        program.name,
        program.inputs,
        program.outputs,
        [[done[i] for i in row] for row in program.results],
        [done[i] for i in program.guards],
        program.plan,
        program.summary,
    )


def optimise(program: Program) -> Program:
    """All passes, the first ones until they stop paying."""
    cost = count(program).flops
    while True:
        program, before = common_factor(program), cost
        cost = count(program).flops
        if cost >= before:
            break
    return fold_negations(program)
