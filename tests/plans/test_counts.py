"""Operation counts that must not grow, and what `symgen show` says of the choice."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symgen.plans.choose import cost
from symgen.program.instructions import count
from symgen.scene.load import load
from symgen.scene.model import Options
from symgen.system import System, derive
from tests.plans.chains import chain

BARS = {
    "ur5": {"mass_matrix": 99, "bias_force": 177, "inverse_dynamics": 234, "forward_dynamics": 394,
            "coriolis_matrix": 325, "mass_matrix_inverse": 274, "inverse_dynamics_derivatives": 805,
            "forward_dynamics_derivatives": 1713, "inverse_dynamics_second_derivatives": 1769},
    "panda": {"mass_matrix": 356, "bias_force": 542, "inverse_dynamics": 563, "forward_dynamics": 1109,
              "coriolis_matrix": 1339, "mass_matrix_inverse": 703, "inverse_dynamics_derivatives": 2605,
              "forward_dynamics_derivatives": 4342, "inverse_dynamics_second_derivatives": 12259},
    "fig2": {"coriolis_matrix": 2008, "mass_matrix_inverse": 1840, "inverse_dynamics_derivatives": 4565,
             "forward_dynamics_derivatives": 7989},
    "double_pendulum": {"mass_matrix": 4, "bias_force": 15, "inverse_dynamics": 24, "forward_dynamics": 31},
}  # fmt: skip
"""Flops, sines and cosines not counted. (The Panda has damped joints, 14 of its operations.)"""


@pytest.fixture(scope="module", params=list(BARS))
def robot(request: pytest.FixtureRequest) -> tuple[str, System]:
    return request.param, derive(load(f"examples/{request.param}.scene.yaml"))


def test_counts_stay_at_or_below_what_was_reached(robot: tuple[str, System]) -> None:
    name, system = robot
    for function, most in BARS[name].items():
        assert count(system.program(function)).flops <= most, function


def test_the_cheapest_plan_is_chosen_and_the_choice_explained(robot: tuple[str, System]) -> None:
    _, system = robot
    for function in ("mass_matrix", "forward_dynamics", "natural_coordinates"):
        choices = system.plans(function)
        (chosen,) = [choice for choice in choices if choice.chosen]
        assert chosen.counts is not None
        for choice in choices:
            assert choice.why
            assert choice.counts is None or cost(choice.counts) >= cost(chosen.counts)


def test_nothing_is_a_multiple_of_no_cost() -> None:
    system = derive(load("examples/free_body.scene.yaml"))
    whys = {choice.plan: choice.why for choice in system.plans("gravity_force")}
    assert not any("times" in why for why in whys.values())
    assert any(why.startswith("free too: ") for why in whys.values())


def test_long_chains_go_to_articulated_bodies_without_counting_what_cannot_win() -> None:
    system = derive(replace(chain(40), options=Options(code="straight")))
    choices = {choice.plan: choice for choice in system.plans("forward_dynamics", every=False)}
    assert choices["articulated"].chosen
    assert choices["factored"].counts is None and "LᵀDL alone" in choices["factored"].why


@pytest.mark.parametrize("name", ["free_body", "fig2", "furuta", "universal_shaft"])
def test_what_is_shown_as_chosen_is_what_is_emitted(name: str) -> None:
    scene = load(f"examples/{name}.scene.yaml")
    for output in derive(scene).outputs:
        (shown,) = [choice for choice in derive(scene).plans(output.name) if choice.chosen]
        assert derive(scene).program(output.name).plan == shown.plan, output.name


def test_literal_forms_win_where_they_are_cheaper() -> None:
    system = derive(load("examples/free_body.scene.yaml"))
    assert system.program("coriolis_matrix").plan == system.program("kinetic_energy").plan == "literal"
