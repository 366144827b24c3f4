"""Passes over a finished program: each takes a program and returns one that computes the same, cheaper.

Every pass is certified on every run with the function it is part of (the emitted text is what is checked).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
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


Rewrite = Callable[[Graph, int, list[Node]], Node]


def _rebuild(program: Program, rewrites: Mapping[int, Rewrite], simplify: bool = True) -> Program:
    """The program again, node by node, with other nodes in place of the instructions in ``rewrites``. Without
    ``simplify`` everything else stays exactly as written."""
    graph = Graph()
    done: list[Node] = []
    for i, instruction in enumerate(program.instructions):
        graph.current_phase = instruction.phase
        args = [done[k] for k in instruction.args]
        if i in rewrites:
            node = rewrites[i](graph, i, done)
        elif instruction.op == "const":
            assert isinstance(instruction.value, Fraction)
            node = graph.const(instruction.value)
        elif instruction.op == "input":
            assert isinstance(instruction.value, tuple)
            node = graph.input(*instruction.value)
        elif not simplify:
            node = graph.raw(instruction.op, *args)
        else:
            node = graph.binary(instruction.op, *args) if len(args) == 2 else graph.unary(instruction.op, *args)
        if instruction.label:
            graph.name_scalar(instruction.label, node)
        done.append(node)
    rebuilt = extract(
        graph,
        program.name,
        program.inputs,
        program.outputs,
        [[done[i] for i in row] for row in program.results],
        [done[i] for i in program.guards],
        program.plan,
        program.summary,
    )
    graph.forget()
    return rebuilt


def common_factor(program: Program) -> Program:
    """x·y ± x·z → x·(y ± z) where neither product is used elsewhere."""
    uses, instructions = _uses(program), program.instructions
    rewrites: dict[int, Rewrite] = {}
    for i, instruction in enumerate(instructions):
        if instruction.op not in ("add", "sub"):
            continue
        first, second = instruction.args
        x, y = instructions[first], instructions[second]
        if first == second or x.op != "mul" or y.op != "mul" or uses[first] != 1 or uses[second] != 1:
            continue
        pairs = ((a, b) for a in (0, 1) for b in (0, 1) if x.args[a] == y.args[b])
        found = next(pairs, None)
        if found is not None:
            shared, one, other = x.args[found[0]], x.args[1 - found[0]], y.args[1 - found[1]]
            rewrites[i] = _factored(instruction.op, shared, one, other)
    return _rebuild(program, rewrites) if rewrites else program


def _factored(op: str, shared: int, one: int, other: int) -> Rewrite:
    return lambda graph, _, done: graph.mul(done[shared], graph.binary(op, done[one], done[other]))


def fold_negations(program: Program) -> Program:
    """−(a·x) → (−a)·x and −(x − y) → y − x where the inner value is used nowhere else."""
    uses, instructions = _uses(program), program.instructions
    rewrites: dict[int, Rewrite] = {}
    for i, instruction in enumerate(instructions):
        if instruction.op != "neg" or uses[instruction.args[0]] != 1:
            continue
        inner = instructions[instruction.args[0]]
        if inner.op == "sub":
            rewrites[i] = _reversed(*inner.args)
        elif inner.op == "mul" and instructions[inner.args[0]].op == "const":
            rewrites[i] = _negative_constant(instructions[inner.args[0]].value, inner.args[1])
    return _rebuild(program, rewrites, simplify=False) if rewrites else program


def _reversed(x: int, y: int) -> Rewrite:
    return lambda graph, _, done: graph.raw("sub", done[y], done[x])


def _negative_constant(value: object, x: int) -> Rewrite:
    assert isinstance(value, Fraction)
    return lambda graph, _, done: graph.raw("mul", graph.const(-value), done[x])


def optimise(program: Program) -> Program:
    """All passes, the first one until it stops paying."""
    while (factored := common_factor(program)) is not program:
        if count(factored).flops >= count(program).flops:
            break
        program = factored
    return fold_negations(program)
