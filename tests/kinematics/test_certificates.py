"""Certificates of these rows can fail: mutations of the C and of the programs, and wrong plans, are refused."""

from __future__ import annotations

import random
from dataclasses import replace
from functools import partial
from typing import Any

import pytest

from symgen.algebra.linear import mul
from symgen.certificate import Candidate, Certifier
from symgen.errors import CertificateError, NotSupportedError, SceneError
from symgen.literal import base_parameters
from symgen.plans import centroidal, frames, reactions, regressor
from symgen.plans.build import build
from symgen.plans.families import FAMILIES
from symgen.program.evaluate import evaluate_in_field
from symgen.scene.load import load
from symgen.scene.model import Joint, Output, Scene
from symgen.system import System, derive
from tests.certificate.mutations import Bench
from tests.kinematics.scenes import OF_FRAMES, ROWS, kinematic_scene

SEED = 5


@pytest.fixture(scope="module")
def system() -> System:
    return derive(kinematic_scene(SEED))


def test_mutations_of_emitted_c_are_refused() -> None:
    rows = ("center_of_mass", "momentum", "joint_wrenches", "regressor", "constraint_forces", "frame_jacobian:tip")
    bench = Bench("examples/double_pendulum.scene.yaml", rows)
    assert bench.accepts(bench.source)
    made, survived = bench.survivors(6)
    assert sum(made.values()) > 40
    assert [kind for kind, _ in survived] == []


@pytest.mark.parametrize("row", [row for row in (*ROWS, *OF_FRAMES) if row != "base_parameters"])
def test_mutations_of_programs_are_refused(system: System, row: str) -> None:
    """One operation of the program changed."""
    program, output = system.program(row), Output(row, (row,))
    places = [i for i, x in enumerate(program.instructions) if x.op in ("add", "sub", "mul")]
    certifier = Certifier(system, row)
    certifier.certify(output, program, [Candidate("as built", partial(evaluate_in_field, program))])
    for i in random.Random(row).sample(places, min(4, len(places))):
        old = program.instructions[i]
        changed = old._replace(op={"add": "sub", "sub": "add", "mul": "add"}[old.op])
        mutant = replace(program, instructions=(*program.instructions[:i], changed, *program.instructions[i + 1 :]))
        with pytest.raises(CertificateError, match=row.partition(":")[0]):
            certifier.certify(output, program, [Candidate("mutant", partial(evaluate_in_field, mutant))])


def test_changed_constants_of_base_parameters_are_refused(system: System) -> None:
    program, output = system.program("base_parameters"), Output("base_parameters", ("base_parameters",))
    certifier = Certifier(system, "beta")
    for k in range(len(program.results[0])):
        inner = partial(evaluate_in_field, program)

        def wrong(numbers: Any, inputs: Any, k: int = k, inner: Any = inner) -> Any:
            values = inner(numbers, inputs)
            return {"beta": [x + (i == k) for i, x in enumerate(values["beta"])]}

        with pytest.raises(CertificateError):
            certifier.certify(output, program, [Candidate("changed", wrong)])


WRONG = {
    "center_of_mass": (centroidal, "center_of_mass"),
    "momentum": (centroidal, "momentum"),
    "momentum_matrix": (centroidal, "momentum_matrix"),
    "regressor": (regressor, "regressor"),
    "joint_wrenches": (reactions, "joint_wrenches"),
    "frame_jacobian:tool": (frames, "frame_jacobian"),
    "frame_velocity:tool": (frames, "frame_velocity"),
    "frame_bias_acceleration:tool": (frames, "frame_bias_acceleration"),
}


@pytest.mark.parametrize("row", WRONG)
def test_wrong_plans_are_refused(monkeypatch: pytest.MonkeyPatch, row: str) -> None:
    """The first entry that is not zero has the other sign."""
    module, name = WRONG[row]
    right = getattr(module, name)

    def wrong(*arguments: Any) -> Any:
        done = False

        def turn(x: Any) -> Any:
            nonlocal done
            if isinstance(x, list | tuple):
                return [turn(y) for y in x]
            if done or type(x) is int:
                return x
            done = True
            return mul(-1, x)

        return turn(right(*arguments))

    monkeypatch.setattr(module, name, wrong)
    system = derive(kinematic_scene(SEED))
    program = build(system.lowered, system.natural, Output(row, (row,)), FAMILIES[0])
    with pytest.raises(CertificateError, match=row.partition(":")[0]):
        Certifier(system, "").certify(
            Output(row, (row,)), program, [Candidate("plan", partial(evaluate_in_field, program))]
        )


def test_a_wrong_combination_of_base_parameters_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """K is verified at fresh points: a wrong entry is never given out."""
    right = base_parameters._rational

    def wrong(*arguments: Any) -> Any:
        rows = right(*arguments)
        longest = max(rows, key=len)
        longest[max(longest)] += 1
        return rows

    monkeypatch.setattr(base_parameters, "_rational", wrong)
    with pytest.raises(CertificateError, match="base parameters"):
        derive("examples/double_pendulum.scene.yaml").base_parameters  # noqa: B018


def test_without_mass_there_is_no_centre_of_mass() -> None:
    scene = load("examples/double_pendulum.scene.yaml")
    light = replace(scene, bodies=tuple(replace(body, mass=body.mass * 0) for body in scene.bodies))
    for row in ("center_of_mass", "momentum", "momentum_matrix"):
        with pytest.raises(SceneError, match="no moving body has mass"):
            derive(light).program(row)


def test_multipliers_need_constant_origins() -> None:
    scene: Scene = kinematic_scene(SEED, runtime=True)
    assert any(parameter.name.endswith(".xyz") for parameter in scene.parameters)
    with pytest.raises(NotSupportedError, match="constraint_forces needs constant joint origins"):
        derive(scene).program("constraint_forces")


def test_a_scene_without_moving_bodies() -> None:
    scene = load("examples/pendulum.scene.yaml")
    fixed = tuple(Joint(joint.name, "fixed", joint.parent, joint.child, joint.origin) for joint in scene.joints)
    still = derive(replace(scene, joints=fixed))
    assert still.base_parameters.names == ()
    assert still.program("regressor").outputs[0].shape == (0, 0)
