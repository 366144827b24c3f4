"""Derivative rows and products: every plan of them, on random trees with couplings and parameters, exactly; and what
they mean, against differences along `integrate`."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from symgen.algebra.dual import Dual, DualNumbers, parts
from symgen.algebra.field import MERSENNE_61, FieldNumbers, Residue
from symgen.algebra.field_dual import FieldDual, FieldDualNumbers
from symgen.algebra.numbers import FloatNumbers, State
from symgen.certificate import Candidate, Certifier
from symgen.errors import CertificateError
from symgen.literal.derivatives import along, change
from symgen.plans.build import build
from symgen.plans.families import DERIVATIVES
from symgen.program.evaluate import evaluate, evaluate_in_field
from symgen.program.instructions import Program, count
from symgen.scene.load import load
from symgen.scene.model import Output, Scene
from symgen.system import System, derive
from tests.plans.test_against_literal import coupled, every_family, scene_of, state_of, with_parameters

ROWS = (
    *sorted(DERIVATIVES),
    "jvp:inverse_dynamics", "vjp:inverse_dynamics", "vjp:forward_dynamics", "jvp:forward_dynamics", "vjp:mass_matrix",
    "jvp:potential_energy", "vjp:kinetic_energy", "vjp:bias_force",
)  # fmt: skip
BY_PARAMETERS = tuple(f"parameter_jacobian:{row}" for row in ("inverse_dynamics", "forward_dynamics"))


def moving(scene: Scene) -> Scene:
    return replace(scene, joints=tuple(replace(j, armature=j.armature + F(1, 9)) for j in scene.joints))


@given(st.integers(0, 2**32), st.booleans(), st.booleans())
@settings(max_examples=4, deadline=None, phases=(Phase.explicit, Phase.generate))
def test_every_plan_of_every_derivative(seed: int, runtime: bool, couplings: bool) -> None:
    rng = random.Random(seed)
    scene = moving(scene_of(seed))
    scene = coupled(scene, rng) if couplings else scene
    system = derive(with_parameters(scene, rng) if runtime else scene)
    certifier = Certifier(system, str(seed))
    for row in (*ROWS, *(BY_PARAMETERS if runtime else ())):
        output = Output(row, (row,))
        for family in every_family(output, system):
            program = build(system.lowered, system.natural, output, family)
            certifier.certify(output, program, [Candidate(f"{row} by {family}", partial(evaluate_in_field, program))])


@pytest.mark.parametrize("row", ["mass_matrix_inverse", "jvp:inverse_dynamics_derivatives", *ROWS, *BY_PARAMETERS])
def test_a_changed_program_is_refused(row: str) -> None:
    """Any operation turned into another one, at places spread over the program."""
    rng = random.Random(row)
    system = derive(with_parameters(moving(scene_of(7)), rng))
    program = system.program(row)
    certifier = Certifier(system, "text")
    output = system.output(row)
    certifier.certify(output, program, [Candidate("right", partial(evaluate_in_field, program))])
    places = [i for i, step in enumerate(program.instructions) if step.op in ("add", "sub", "mul")]
    for index in places[:: max(1, len(places) // 12)]:
        with pytest.raises(CertificateError, match=r"not .* as defined|at no point"):
            certifier.certify(
                output, program, [Candidate("wrong", partial(evaluate_in_field, changed(program, index)))]
            )


def changed(program: Program, index: int) -> Program:
    step = program.instructions[index]
    other = step._replace(op={"add": "sub", "sub": "add", "mul": "add"}[step.op])
    return replace(program, instructions=(*program.instructions[:index], other, *program.instructions[index + 1 :]))


@pytest.mark.parametrize("convention", ["world", "body", "mixed"])
def test_tangents_are_those_of_integrate(convention: str) -> None:
    """∂τ/∂q v = d/dε τ(integrate(q, v, ε)), on a floating tree with a ball joint, by central differences."""
    system = floating_tree(convention)
    numbers, rng = FloatNumbers(), np.random.default_rng(1)
    q = unit_quaternions(system, rng.normal(size=system.tree.nq))
    v, a, x = (rng.normal(size=system.tree.nv) for _ in range(3))
    inputs = {"q": tuple(q), "v": tuple(v), "a": tuple(a)}
    found = evaluate(system.program("inverse_dynamics_derivatives"), numbers, inputs)
    by_position = np.reshape(found["dtau_dq"], (system.tree.nv, system.tree.nv)) @ x

    def torque(step: float) -> Any:
        moved = system.evaluate("integrate", numbers, State(q=tuple(q), v=tuple(x), dt=step))["q_next"]
        return np.array(system.evaluate("inverse_dynamics", numbers, State(moved, tuple(v), tuple(a)))["tau"])

    step = 1e-4
    difference = (8 * (torque(step) - torque(-step)) - (torque(2 * step) - torque(-2 * step))) / (12 * step)
    assert np.allclose(by_position, difference, rtol=1e-9, atol=1e-9 * np.abs(difference).max())


def floating_tree(convention: str) -> System:
    scene = load("examples/fig2.scene.yaml")
    joints = [replace(j, type="spherical", axis=None) if k == 2 else j for k, j in enumerate(scene.joints)]
    options = replace(scene.options, base_velocity=convention)
    return derive(replace(scene, joints=tuple(joints), options=options, outputs=()))


def unit_quaternions(system: System, q: Any) -> Any:
    for body in system.tree.bodies:
        start = body.q + {"spherical": 0, "floating": 3}.get(body.joint.type, 99)
        if start < body.q + 99:
            q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
    return q


def test_second_derivatives_by_velocity_are_symmetric_and_those_by_position_where_coordinates_commute() -> None:
    system, numbers = derive(load("examples/fig1.scene.yaml")), FieldNumbers(MERSENNE_61, 3)
    state = state_of(system, numbers, random.Random(5))
    inputs = {"q": [x.x for x in state.q], "v": [x.x for x in state.v], "a": [x.x for x in state.a], "p": []}
    found = evaluate_in_field(system.program("inverse_dynamics_second_derivatives"), numbers, inputs)
    n = system.tree.nv
    for name in ("d2tau_dqdq", "d2tau_dvdv"):
        tensor = np.array(found[name], dtype=object).reshape(n, n, n)
        assert (tensor == tensor.transpose(0, 2, 1)).all() and tensor.any()


def test_analytic_derivatives_of_a_spatial_arm_cost_less_than_those_of_the_graph() -> None:
    system = derive(load("examples/panda.scene.yaml"))
    choices = {choice.plan: choice for choice in system.plans("inverse_dynamics_derivatives")}
    analytic, graph = choices["analytic"], choices["differentiated"]
    assert analytic.chosen and analytic.counts and graph.counts
    assert analytic.counts.flops <= 2605 < graph.counts.flops
    assert count(system.program("vjp:inverse_dynamics")).flops <= 1500


def test_duals_are_exact() -> None:
    numbers = DualNumbers(FieldNumbers(MERSENNE_61, 1))
    base = numbers.numbers
    x = Dual(Residue(5, MERSENNE_61), Residue(1, MERSENNE_61))
    c, s = base.cos(x.x), base.sin(x.x)
    assert parts(numbers.cos(x) * numbers.sin(x)) == (c * s, c * c - s * s)
    assert parts(1 / x) == (F(1, 5) * base.const(1), F(-1, 25) * base.const(1))
    assert parts(numbers.sqrt(x * x * x * x)) == parts(x * x) or parts(numbers.sqrt(x * x * x * x)) == parts(-(x * x))
    with pytest.raises(NotImplementedError, match="sinc_sqrt is not differentiated"):
        numbers.sinc_sqrt(x)


def test_duals_of_the_field_are_duals() -> None:
    numbers, rng = FieldNumbers(MERSENNE_61, 1), random.Random(3)
    own, plain = FieldDualNumbers(numbers), DualNumbers(numbers)
    parts_of = [[Residue(rng.randrange(MERSENNE_61), MERSENNE_61) for _ in range(2)] for _ in range(6)]
    found: list[Any] = [FieldDual(x.x, d.x, x.p) for x, d in parts_of]
    expected: list[Any] = [Dual(x, d) for x, d in parts_of]
    kinds: tuple[tuple[list[Any], Any], ...] = ((found, own), (expected, plain))
    seven, third = Residue(7, MERSENNE_61), F(1, 3)
    for row, kind in kinds:
        x, y = row[:2]
        row += [x + y, x - y, x * y, x / y, -x, 2 + x, x - 3, third - y, x * seven, x * third, 1 / y, x / seven]
        row += [kind.cos(x), kind.sin(y), kind.sqrt(x * x), kind.const(third), kind.sinc_sqrt(kind.const(5))]
    assert [parts(x) for x in found] == [parts(x) for x in expected]
    assert found[0] == found[0] + 0 and found[0] != found[1] and found[0] != FieldDual(found[0].x, 1, MERSENNE_61)
    with pytest.raises(NotImplementedError, match="cos_sqrt is not differentiated"):
        own.cos_sqrt(found[0])


def test_nested_duals_differentiate_twice() -> None:
    system, numbers = derive(load("examples/pendulum.scene.yaml")), FieldNumbers(MERSENNE_61, 1)
    state = state_of(system, numbers, random.Random(2))
    literal = system.literal(numbers, state)
    one = numbers.const(1)
    twice = along(along(literal, {"dq": [one]}), {"dq": [FieldDual(one.x, 0, one.p)]})
    gravity = literal.gravity_force()
    assert change(change(twice.gravity_force())) == tuple(-x for x in gravity)  # m g l sin q
