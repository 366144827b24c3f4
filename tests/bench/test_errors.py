"""Errors of what is measured: against exact results, in the precision that each variant has."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symgen.bench.errors import FEW, Exact, Truth, errors_of, relative, rounded
from symgen.bench.measure import Settings, pose
from symgen.bench.variant import Problem
from symgen.scene.load import load
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request

NAMES = "mass_matrix,forward_dynamics,inverse_dynamics_derivatives"


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    scene = request(load("examples/double_pendulum.scene.yaml"), outputs=parse_outputs(NAMES), targets=("c",))
    return pose(scene, Settings(states=12), tmp_path_factory.mktemp("bench"))[0]


def results(exact: Exact) -> list[list[np.ndarray]]:
    return [[high[k] for high in exact.high] for k in range(exact.states)]


@pytest.mark.parametrize("function", NAMES.split(","))
def test_balls_and_fifty_digits_agree(problem: Problem, function: str) -> None:
    pytest.importorskip("flint")
    balls, digits = Truth(problem, balls=True), Truth(problem, balls=False)
    assert (balls.states, digits.states) == (12, FEW)
    one, other = balls.of(function, "double"), digits.of(function, "double")
    for x, y, below_x, below_y in zip(one.high, other.high, one.low, other.low, strict=True):
        assert np.array_equal(x[:FEW], y)
        assert np.allclose(below_x[:FEW], below_y, rtol=1e-9, atol=1e-300)
    assert one.conditions is not None
    assert other.conditions is None
    assert balls.of(function, "double") is one


def test_an_error_is_seen_in_its_output_and_in_units(problem: Problem) -> None:
    """One entry of the second output off by 1e-9 of its norm, at one state."""
    pytest.importorskip("flint")
    exact = Truth(problem).of("inverse_dynamics_derivatives", "double")
    outputs = results(exact)
    clean = errors_of(outputs, exact, "double")
    assert 0 < clean.largest < 2.0**-53
    scale = np.max(np.abs(outputs[7][1]))
    outputs[7][1] = outputs[7][1] + np.array([1e-9 * scale, 0, 0, 0])
    found = errors_of(outputs, exact, "double")
    assert found.largest == pytest.approx(1e-9, rel=1e-6)
    assert found.median < 2.0**-53
    assert exact.conditions is not None
    assert found.units == pytest.approx(1e-9 * 2.0**53 / max(1.0, exact.conditions[1][7]), rel=1e-6)


def test_what_is_not_a_number_is_infinitely_wrong(problem: Problem) -> None:
    exact = Truth(problem, balls=False).of("mass_matrix", "double")
    outputs = results(exact)
    outputs[1][0] = outputs[1][0] * np.nan
    assert errors_of(outputs, exact, "double").largest == np.inf


def test_states_without_an_answer_count_for_nothing() -> None:
    high = np.array([[1.0], [np.nan]])
    exact = Exact((high,), (np.zeros((2, 1)),), None)
    assert errors_of([[np.array([1.0])], [np.array([5.0])]], exact, "double").largest == 0
    nothing = Exact((high[1:],), (np.zeros((1, 1)),), None)
    assert errors_of([[np.array([5.0])]], nothing, "double").largest == 0


def test_results_that_are_zero_have_absolute_errors() -> None:
    assert relative(np.array([[1e-17]]), np.array([[2e-17]]), np.zeros((1, 1))) == pytest.approx(1e-17)


def test_float_has_exact_results_at_states_that_a_float_holds(problem: Problem) -> None:
    states = rounded(problem, "forward_dynamics", "float")
    assert all(np.array_equal(rows, rows.astype(np.float32)) for rows in states.values())
    assert not np.array_equal(states["q"], rounded(problem, "forward_dynamics", "double")["q"])
    truth = Truth(problem, balls=False)
    exact, other = truth.of("forward_dynamics", "float"), truth.of("forward_dynamics", "double")
    assert 1e-9 < errors_of(results(exact), other, "double").largest < 1e-4


def test_the_same_problem_twice(problem: Problem, tmp_path: Path) -> None:
    again = pose(problem.scene, Settings(states=12), tmp_path)[0]
    assert np.array_equal(again.column("q"), problem.column("q"))
