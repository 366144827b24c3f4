"""The reference in ball arithmetic, and what is measured with it."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest

pytest.importorskip("flint")

from flint import arb, ctx

from symgen.accuracy.balls import ArbNumbers, Reference, relative
from symgen.accuracy.measure import Problem, Settings, judge, measure
from symgen.accuracy.search import worst_state
from symgen.accuracy.states import picked
from symgen.accuracy.table import as_csv, as_json, as_markdown, as_text
from symgen.accuracy.variants import Compiled, Variant, compile_variant
from symgen.program.instructions import Instruction, Port, Program
from symgen.program.rounding import condition, rounding
from symgen.scene.load import load
from symgen.system import derive

I = Instruction  # noqa: E741
Q = (Port("q", (1,)),)
Y = (Port("y", (1,)),)


def program(*steps: Instruction, result: int = -1, guards: tuple[int, ...] = ()) -> Program:
    return Program("f", Q, Y, steps, ((result % len(steps),),), guards)


X = I("input", value=("q", 0))
ONE = I("const", value=Fraction(1))
ADD_AND_TAKE = program(X, ONE, I("add", (0, 1)), I("sub", (2, 1)))
"""(q + 1) − 1."""


def test_functions_of_a_squared_angle() -> None:
    numbers = ArbNumbers()
    with ctx.workprec(200), mpmath.workdps(160):
        for angle in ("1e-30", "0.1", "3", "20"):
            y = mpmath.mpf(angle)
            x = arb(angle) ** 2
            truth = (mpmath.cos(y), mpmath.sin(y) / y, (y - mpmath.sin(y)) / y**3)
            found = (numbers.cos_sqrt(x), numbers.sinc_sqrt(x), numbers.sinc3_sqrt(x))
            for exact, ball in zip(truth, found, strict=True):
                assert (
                    abs(mpmath.mpf(ball.mid().str(50, radius=False)) - exact) <= abs(exact) * mpmath.mpf("1e-15") ** 2
                )
        assert numbers.sinc3_sqrt(arb(0)).overlaps(arb(1) / 6)


def test_precision_rises_until_nothing_is_lost() -> None:
    found = Reference(ADD_AND_TAKE).at({"q": [1e-250]})
    assert found.high[0] == 1e-250 and abs(found.low[0]) < 1e-280 and found.bits > 800
    assert Reference(ADD_AND_TAKE).at({"q": [0.5]}).bits < found.bits


def test_there_is_no_answer_where_a_pivot_vanishes() -> None:
    square = program(X, I("mul", (0, 0)), ONE, I("sub", (1, 2)), I("div", (2, 3)), guards=(3,))
    assert not Reference(square).at({"q": [1.0]}).answer
    assert not Reference(square).at({"q": [0.5]}).answer
    assert Reference(square).at({"q": [2.0]}).high[0] == pytest.approx(1 / 3)


def test_errors_are_seen_to_the_last_bit() -> None:
    third = program(X, I("const", value=Fraction(1, 3)), I("mul", (0, 1)))
    exact = Reference(third).at({"q": [1.0]})
    high, low = exact.high[None], exact.low[None]
    error = relative(np.array([[1 / 3]]), high, low)[0]
    assert 0.1 * 2**-53 < error < 2**-53
    assert relative(np.array([[np.nextafter(1 / 3, 1)]]), high, low)[0] > 2**-53
    assert relative(np.array([[np.nan]]), high, low)[0] == np.inf
    assert relative(np.array([[1.0]]), high * np.nan, low)[0] == np.inf
    assert relative(np.array([[np.nan]]), high * np.nan, low)[0] == 0


def test_condition_is_of_the_problem_and_rounding_of_the_plan() -> None:
    states = {"q": np.array([[1e-6], [1.0]])}
    assert np.allclose(condition(ADD_AND_TAKE, states), 1)
    small, large = rounding(ADD_AND_TAKE, states, 8)
    assert small > 1e5 and large < 10
    difference = program(X, I("const", value=Fraction(1, 3)), I("sub", (0, 1)))
    near = condition(difference, {"q": np.array([[1 / 3 + 1e-9], [5.0]])})
    assert near[0] > 1e8 and near[1] < 2


@pytest.fixture(scope="module")
def problem() -> Problem:
    system = derive(load("examples/double_pendulum.scene.yaml"))
    return Problem(system, system.output("forward_dynamics"), Settings(states=200))


@pytest.fixture(scope="module")
def compiled(problem: Problem, tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    (made,) = compile_variant(problem.system, (problem.output,), Variant(), tmp_path_factory.mktemp("f") / "f")
    return made


def test_a_wrong_digit_is_not_excused_by_the_condition(problem: Problem, compiled: Compiled) -> None:
    states, high, low = problem.known("double")
    good = judge(compiled, problem.datum, states, high, low)
    assert good.wrong == 0 and good.units < 8
    spoilt = replace(compiled, call=lambda given: compiled.call(given) * (1 + 1e-12))
    assert judge(spoilt, problem.datum, states, high, low).units > 100
    none = replace(
        compiled, call=lambda given: compiled.call(given) * np.where(np.arange(200) == 7, np.nan, 1)[:, None]
    )
    assert judge(none, problem.datum, states, high, low).wrong == 1


def test_searches_find_more_than_samples_do(problem: Problem, compiled: Compiled) -> None:
    states, high, low = problem.known("double")
    sampled = relative(compiled.call(picked(states, slice(24))), high[:24], low[:24])
    worst = worst_state(compiled, problem.reference, problem.box, 300)
    assert worst.error > np.median(sampled) * 3 and worst.evaluations < 500
    again = worst_state(compiled, problem.reference, problem.box, 300)
    assert again.error == worst.error


def test_every_variant_and_plan_is_measured() -> None:
    rows = measure(load("examples/double_pendulum.scene.yaml"), Settings(states=50, rows=("forward_dynamics",)))
    assert {row.variant for row in rows} == {
        "double", "double libm", "double batch", "float", "float libm", "float batch",
    }  # fmt: skip
    assert {"factored", "articulated", "literal"} <= {row.plan for row in rows} and any(row.chosen for row in rows)
    for row in rows:
        assert row.wrong == 0 and row.largest < (1e-4 if row.variant.startswith("float") else 1e-12), row
        assert row.backward < 16, row
    assert min(row.largest for row in rows if row.variant.startswith("float")) > 1e-8
    assert as_text(rows).count("\n") == len(rows) and as_csv(rows).count("\n") == len(rows) + 1
    assert as_markdown(rows).count("\n") == 3 and '"backward"' in as_json(rows)


def test_what_cannot_be_derived_is_not_measured(tmp_path: Path) -> None:
    from symgen.accuracy.measure import measurable

    assert measurable(load("examples/four_bar.scene.yaml"), ("mass_matrix",)) == ()
    assert measurable(load("examples/pendulum.scene.yaml"), ("mass_matrix", "parameter_jacobian:mass_matrix")) == (
        "mass_matrix",
    )
