"""Axes shared along parallel joints: sums of angles are certified, wrong ones refused; what it saves on a UR5."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F
from functools import partial

import pytest

from symgen.algebra.field import MERSENNE_61, FieldNumbers
from symgen.certificate import Candidate, Certifier
from symgen.errors import CertificateError
from symgen.plans.build import build
from symgen.plans.families import FAMILIES
from symgen.plans.lagging import lagging
from symgen.program.angles import register_sums
from symgen.program.evaluate import evaluate_in_field
from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port, Program, count
from symgen.scene.load import load
from symgen.scene.model import Body, Joint, Output, Scene, Transform
from symgen.system import System, derive

Y, MINUS_Y, Z = (F(0), F(1), F(0)), (F(0), F(-1), F(0)), (F(0), F(0), F(1))
INERTIA = (F(1, 2), F(1, 3), F(2, 5), F(1, 100), F(1, 50), F(-1, 40))


def chain(*axes: tuple[F, F, F]) -> System:
    bodies = tuple(Body(f"b{k}", F(2), (F(1, 10), F(1, 5), F(1, 7)), INERTIA) for k in range(len(axes)))
    names = ["ground", *(body.name for body in bodies)]
    joints = tuple(
        Joint(f"j{k}", "revolute", names[k], names[k + 1], Transform(translation=(F(1, 3), F(0), F(1, 4))), axis)
        for k, axis in enumerate(axes)
    )
    return derive(Scene("chain", bodies, joints))


@pytest.mark.parametrize(
    "axes",
    [(Z, Y, Y, Y), (Z, Y, MINUS_Y, Y, Z), (Y, Y, Z, Z), (Z, Y, Y, Z, Y, MINUS_Y)],
    ids=lambda axes: str(len(axes)),
)
@pytest.mark.parametrize("row", ["mass_matrix", "inverse_dynamics", "forward_dynamics", "coriolis_matrix"])
def test_merged_plans_are_certified(axes: tuple[tuple[F, F, F], ...], row: str) -> None:
    system, output = chain(*axes), Output(row, (row,))
    assert lagging(system.lowered.links)
    merged = build(system.lowered, system.natural, output, MERGED)
    assert any(_of_angles(merged, k) for k, step in enumerate(merged.instructions) if step.op in ("add", "sub"))
    Certifier(system, row).certify(output, merged, [Candidate("merged", partial(evaluate_in_field, merged))])


MERGED = replace(FAMILIES[0], merged=True)


def test_a_wrong_sum_of_angles_is_refused() -> None:
    system = chain(Z, Y, Y, Y)
    output = Output("mass_matrix", ("mass_matrix",))
    program = build(system.lowered, system.natural, output, MERGED)
    sums = [k for k, step in enumerate(program.instructions) if step.op in ("add", "sub") and _of_angles(program, k)]
    assert sums
    for k in sums:
        step = program.instructions[k]
        other = step._replace(op="sub" if step.op == "add" else "add")
        wrong = replace(program, instructions=(*program.instructions[:k], other, *program.instructions[k + 1 :]))
        with pytest.raises(CertificateError):
            Certifier(system, "x").certify(output, wrong, [Candidate("wrong", partial(evaluate_in_field, wrong))])


def _of_angles(program: Program, k: int) -> bool:
    return any(step.op in ("cos", "sin") and step.args[0] == k for step in program.instructions)


def test_the_addition_theorem_holds_in_the_field() -> None:
    numbers, graph = FieldNumbers(MERSENNE_61, 4), Graph()
    q = graph.inputs("q", 3)
    results = [graph.sin(q[0] + q[1] - q[2]), graph.cos(q[1] - q[2]), graph.sin(-(q[0] + q[1]))]
    program = extract(graph, "f", (Port("q", (3,)),), (Port("y", (3,)),), [results])
    inputs = {"q": [5, 77, 123456]}
    register_sums(program, numbers, inputs)
    p = numbers.p
    (c0, s0), (c1, s1), (c2, s2) = ((numbers.apply("cos", x), numbers.apply("sin", x)) for x in inputs["q"])
    found = evaluate_in_field(program, numbers, inputs)["y"]
    c01, s01 = (c0 * c1 - s0 * s1) % p, (s0 * c1 + c0 * s1) % p
    assert found[0] == (s01 * c2 - c01 * s2) % p
    assert found[1] == (c1 * c2 + s1 * s2) % p
    assert found[2] == -s01 % p


def test_ur5_has_three_parallel_axes() -> None:
    system = derive(load("examples/ur5.scene.yaml"))
    bars = {"mass_matrix": 100, "bias_force": 210, "inverse_dynamics": 275, "forward_dynamics": 420}
    for row, bar in bars.items():
        program = system.program(row)
        assert count(program).flops <= bar and "parallel axes merged" in program.plan
