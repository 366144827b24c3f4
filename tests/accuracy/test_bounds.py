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
from symgen.algebra.numbers import FloatNumbers
from symgen.artifact import Artifact
from symgen.errors import SceneError
from symgen.program.evaluate import evaluate
from symgen.program.instructions import Instruction, Port, Program, count
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


@pytest.mark.parametrize("row", ["bias_force", "integrate", "forward_dynamics"])
def test_quaternions_of_unit_length_have_bounds(row: str, tmp_path: Path) -> None:
    system = derive(load("examples/spinning_top.scene.yaml"))
    problem = Problem(system, system.output(row), Settings(states=400))
    states, high, low = problem.known("double")
    (compiled,) = compile_variant(system, (problem.output,), Variant(), tmp_path / "f")
    measured = float(np.max(errors(compiled.call(states), high, low)))
    proven = bound(problem.program, problem.box.intervals(), 128, spheres=problem.box.spheres())
    assert measured <= proven.error <= 100 * measured
    assert np.max(np.abs(high)) <= proven.largest < 3 * np.max(np.abs(high)) + 1


def test_entire_functions_are_enclosed() -> None:
    """Their derivatives too: a bound over a small box is close to that of its middle, and not below it."""
    x = Instruction("input", value=("q", 0))
    for op in ("cos_sqrt", "sinc_sqrt", "sinc3_sqrt"):
        made = Program(
            "f", (Port("q", (1,)),), (Port("y", (1,)),), (x, Instruction("mul", (0, 0)), Instruction(op, (1,))), ((2,),)
        )
        for at in (0.0, 1e-9, 0.3, 2.0, 7.0):
            point, small = bound(made, [(at, at)], 1), bound(made, [(at - 1e-4, at + 1e-4)], 1)
            assert 0 < point.error <= small.error <= 1.1 * point.error + 1e-19
            moved = moved_by_rounding(made, at)
            assert moved <= point.error <= moved + 8 * 2**-53


def moved_by_rounding(made: Program, at: float) -> float:
    """|∂y/∂(x²)| x² u by differences: what the rounding of the square alone does."""
    step = 1e-6 * at * at
    if not step:
        return 0.0
    high, low = (evaluate(made, FloatNumbers(), {"q": [np.sqrt(at * at + d)]})["y"][0] for d in (step, -step))
    return float(abs(high - low) / (2 * step) * at * at * 2**-53 * (1 - 1e-3))


def test_boxes_without_unit_quaternions_are_left_out() -> None:
    program = derive(load("examples/spinning_top.scene.yaml")).program("bias_force")
    sides = [(0.9, 1.0)] * 4 + [(-1.0, 1.0)] * 3
    with pytest.raises(SceneError, match="unit length"):
        bound(program, sides, 8, spheres=[0])
