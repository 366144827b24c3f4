"""The exact graph: simplification never changes a value, programs are deterministic, passes keep what is computed."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from fractions import Fraction as F
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.algebra.field import MERSENNE_61, FieldNumbers, Residue
from symgen.program.evaluate import evaluate, evaluate_all, evaluate_residues
from symgen.program.graph import Graph, Node, extract
from symgen.program.instructions import OPERATIONS, Instruction, Port, Program, count
from symgen.program.passes import common_factor, fold_negations, optimise
from symgen.program.rules import COMMUTATIVE, RULES

CONSTANTS = (F(0), F(1), F(-1), F(2), F(-2), F(1, 3), F(-5, 7))
BINARY = ("add", "sub", "mul", "div")
UNARY = ("neg", "cos", "sin", "cos_sqrt", "sinc_sqrt", "sinc3_sqrt")


def random_recipe(rng: random.Random, length: int) -> list[tuple[str, Any]]:
    """(operation, operands) of a straight-line computation with many coincidences."""
    recipe: list[tuple[str, Any]] = [("input", k) for k in range(4)]
    recipe += [("const", rng.choice(CONSTANTS)) for _ in range(3)]
    for _ in range(length):
        n = len(recipe)
        near = [rng.randrange(max(0, n - 8), n) for _ in range(2)]
        if rng.random() < 0.75:
            recipe.append((rng.choices(BINARY, (4, 4, 5, 1))[0], near))
        else:
            recipe.append((rng.choices(UNARY, (5, 1, 1, 1, 1, 1))[0], near[:1]))
    return recipe


def run(recipe: list[tuple[str, Any]], numbers: Any, inputs: Any) -> list[Any]:
    values: list[Any] = []
    for op, operands in recipe:
        if op == "input":
            values.append(inputs[operands])
        elif op == "const":
            values.append(numbers.const(operands))
        else:
            args = [values[k] for k in operands]
            if op == "add":
                values.append(args[0] + args[1])
            elif op == "sub":
                values.append(args[0] - args[1])
            elif op == "mul":
                values.append(args[0] * args[1])
            elif op == "div":
                # A divisor that is no zero of the field whatever its operand is.
                values.append(args[0] / (args[1] * args[1] + numbers.const(F(3))))
            elif op == "neg":
                values.append(-args[0])
            else:
                values.append(getattr(numbers, op)(args[0]))
    return values


def program_of(recipe: list[tuple[str, Any]], outputs: int = 4) -> Program:
    graph = Graph()
    values = run(recipe, graph, graph.inputs("x", 4))[-outputs:]
    return extract(graph, "f", (Port("x", (4,)),), (Port("y", (outputs,)),), [values])


@given(st.integers(0, 2**32), st.integers(1, 60))
@settings(max_examples=200, deadline=None)
def test_simplified_programs_compute_the_same(seed: int, length: int) -> None:
    recipe = random_recipe(random.Random(seed), length)
    numbers = FieldNumbers(MERSENNE_61, seed)
    inputs = [Residue(random.Random(seed + k).randrange(MERSENNE_61), MERSENNE_61) for k in range(4)]
    expected = run(recipe, numbers, inputs)[-4:]
    program = program_of(recipe)
    for version in (program, common_factor(program), fold_negations(program), optimise(program)):
        assert list(evaluate(version, numbers, {"x": inputs})["y"]) == expected
    assert count(optimise(program)).flops <= count(program).flops


@given(st.integers(0, 2**32))
@settings(max_examples=30, deadline=None)
def test_rules_that_are_not_tried_would_not_apply(seed: int) -> None:
    rng = random.Random(seed)
    graph = Graph()
    run(random_recipe(rng, 60), graph, graph.inputs("x", 4))
    for _ in range(400):
        op, x, y = rng.choice(BINARY), rng.choice(graph.nodes), rng.choice(graph.nodes)
        if op in COMMUTATIVE and y.op == "const":
            x, y = y, x
        for row in RULES[op]:
            assert row.may(x.op, y.op) or row.rule(graph, x, y) is None
        for op in UNARY:
            for row in RULES[op]:
                assert row.may(x.op, "") or row.rule(graph, x) is None


@given(st.integers(0, 2**32))
@settings(max_examples=30, deadline=None)
def test_programs_are_legal(seed: int) -> None:
    """Topological order, right number of arguments, nothing dead, nothing twice."""
    program = optimise(program_of(random_recipe(random.Random(seed), 40)))
    used = {i for row in program.results for i in row}
    seen: set[tuple[Any, ...]] = set()
    for place, instruction in enumerate(program.instructions):
        assert len(instruction.args) == OPERATIONS[instruction.op]
        assert all(i < place for i in instruction.args)
        used.update(instruction.args)
        key = (instruction.op, instruction.args, instruction.value)
        assert key not in seen
        seen.add(key)
    assert used == set(range(len(program.instructions)))


@pytest.fixture
def graph() -> Graph:
    return Graph()


def test_rules_do_what_they_say(graph: Graph) -> None:
    x, y = graph.inputs("x", 2)
    zero, one, two = (graph.const(k) for k in (0, 1, 2))
    cases: list[tuple[Node, Node]] = [
        (x + zero, x), (x - zero, x), (x * one, x), (x * zero, zero), (zero - x, -x), (graph.neg(-x), x), (x - x, zero),
        (x + (-y), x - y), (x - (-y), x + y), ((-x) * y, -(x * y)), ((-x) * (-y), x * y), (x + x, two * x),
        (two * x + x, graph.const(3) * x), ((x - y) + y, x), ((x + y) - y, x), (two * (two * x), graph.const(4) * x),
        (x / two, graph.const(F(1, 2)) * x), (x / x, one), (zero / x, zero), (graph.cos(-x), graph.cos(x)),
        (graph.sin(-x), -graph.sin(x)), (graph.cos(zero), one), (graph.sin(zero), zero), (x + y, y + x), (x * y, y * x),
        (graph.sinc3_sqrt(zero), graph.const(F(1, 6))),
        ((-two) * x, -(two * x)), (x - y, -(y - x)), (-(x - y), y - x), (x - (x - y), y), ((x - y) - x, -y),
    ]  # fmt: skip
    for place, (found, wanted) in enumerate(cases):
        assert found is wanted, place


def test_every_operation_has_its_rules() -> None:
    assert RULES.keys() == OPERATIONS.keys() - {"const", "input"}


def test_negations_are_folded(graph: Graph) -> None:
    x, y, z = graph.inputs("x", 3)
    ports = (Port("x", (3,)),), (Port("y", (2,)),)
    program = fold_negations(extract(graph, "f", *ports, [[-(x * y - z), -(graph.const(F(1, 3)) * z)]]))
    assert [instruction.op for instruction in program.instructions if instruction.op == "neg"] == []
    assert count(program).flops == 3


def test_common_factors_are_taken_out(graph: Graph) -> None:
    x, y, z = graph.inputs("x", 3)
    program = extract(graph, "f", (Port("x", (3,)),), (Port("y", ()),), [[x * y + x * z]])
    assert count(common_factor(program)).flops == 2


def test_counting_pairs_sine_and_cosine(graph: Graph) -> None:
    (x,) = graph.inputs("x", 1)
    program = extract(graph, "f", (Port("x", (1,)),), (Port("y", ()),), [[graph.cos(x) * graph.sin(x) + graph.sqrt(x)]])
    counts = count(program)
    assert (counts.add, counts.mul, counts.sqrt, counts.sincos, counts.flops) == (1, 1, 1, 1, 3)


def test_a_mutation_of_any_instruction_is_seen() -> None:
    """The field tells every single changed instruction from the original (this is what certificates rest on)."""
    rng = random.Random(5)
    program = optimise(program_of(random_recipe(rng, 40)))
    numbers = FieldNumbers(MERSENNE_61, 1)
    inputs = {"x": [Residue(rng.randrange(MERSENNE_61), MERSENNE_61) for _ in range(4)]}
    expected = evaluate(program, numbers, inputs)
    swap = {"add": "sub", "sub": "add", "mul": "add", "cos": "sin", "sin": "cos", "div": "mul", "neg": "sin"}
    for place, instruction in enumerate(program.instructions):
        if instruction.op == "const":
            changed = instruction._replace(value=instruction.value + F(1, 10**30))  # type: ignore[operator]
        elif instruction.op in swap:
            changed = Instruction(swap[instruction.op], instruction.args)
        else:
            continue
        instructions = (*program.instructions[:place], changed, *program.instructions[place + 1 :])
        mutant = Program("f", program.inputs, program.outputs, instructions, program.results)
        assert evaluate(mutant, numbers, inputs) != expected, (place, instruction)


def test_the_same_bytes_under_any_hash_seed() -> None:
    script = (
        "from symgen import load; from symgen.system import derive; import hashlib;"
        "s = derive(load('examples/fig2.scene.yaml'));"
        "print(hashlib.sha256(repr([s.program(n) for n in ('forward_dynamics', 'velocity_transformation')])"
        ".encode()).hexdigest())"
    )
    digests = set()
    for seed in ("0", "1", "4242"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", script]
        result = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
        digests.add(result.stdout)
    assert len(digests) == 1


@given(st.integers(0, 2**32))
@settings(max_examples=30, deadline=None)
def test_the_fast_evaluation_in_the_field_is_the_plain_one(seed: int) -> None:
    program = program_of(random_recipe(random.Random(seed), 40))
    numbers = FieldNumbers(MERSENNE_61, seed)
    inputs = [random.Random(seed + k).randrange(MERSENNE_61) for k in range(4)]
    plain = evaluate_all(program, numbers, {"x": [Residue(x, MERSENNE_61) for x in inputs]})
    assert [value.x for value in plain] == evaluate_residues(program, numbers, {"x": inputs})
