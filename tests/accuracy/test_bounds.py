"""Proven bounds: never below what is measured, and not far above."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("flint")

from symgen.accuracy.balls import errors
from symgen.accuracy.bounds import bound
from symgen.accuracy.measure import Problem, Settings
from symgen.accuracy.variants import Variant, compile_variant
from symgen.artifact import Artifact
from symgen.errors import NotSupportedError
from symgen.program.instructions import count
from symgen.scene.load import load
from symgen.system import derive

RANGES = {"q": np.pi, "v": 2.0, "a": 5.0, "tau": 5.0}


def box_of(problem: Problem) -> list[tuple[float, float]]:
    return [(-RANGES[port.name], RANGES[port.name]) for port in problem.program.inputs for _ in range(port.size)]


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("row", ["bias_force", "forward_dynamics"])
def test_bounds_hold_and_are_of_use(row: str, precision: str, tmp_path: Path) -> None:
    system = derive(load("examples/double_pendulum.scene.yaml"))
    problem = Problem(system, system.output(row), Settings(states=400))
    states, high, low = problem.known(precision)
    (compiled,) = compile_variant(system, (problem.output,), Variant(precision), tmp_path / "f")
    measured = float(np.max(errors(compiled.call(states), high, low)))
    proven = bound(problem.program, box_of(problem), 256, precision)
    assert measured <= proven.error <= 100 * measured
    assert np.max(np.abs(high)) <= proven.largest
    manifest = Artifact(tmp_path / "f").manifest["functions"][0]["operations"]
    counted = count(problem.program)
    assert (counted.mul, counted.div) == (manifest["mul"], manifest["div"])  # the C is the program, step by step


def test_more_boxes_never_hurt() -> None:
    system = derive(load("examples/double_pendulum.scene.yaml"))
    problem = Problem(system, system.output("forward_dynamics"), Settings(states=1))
    one, many = bound(problem.program, box_of(problem), 1), bound(problem.program, box_of(problem), 512)
    assert one.error == np.inf and many.error < 1e-11 and many.boxes == 512


def test_a_point_has_nearly_the_error_itself() -> None:
    system = derive(load("examples/pendulum.scene.yaml"))
    problem = Problem(system, system.output("bias_force"), Settings(states=1))
    sides = [(0.7, 0.7)] * len(box_of(problem))
    found = bound(problem.program, sides, 1)
    assert 0 < found.error < 16 * 2**-53 * found.largest


def test_what_has_no_bound_is_said() -> None:
    system = derive(load("examples/free_body.scene.yaml"))
    program = system.program("integrate")
    with pytest.raises(NotSupportedError, match="no bound is stated"):
        bound(program, [(0.1, 0.2)] * sum(port.size for port in program.inputs), 1)
