"""Plans are chosen by accuracy as well as by count."""

from __future__ import annotations

from fractions import Fraction as F
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("flint")

from symgen.accuracy.balls import relative
from symgen.accuracy.measure import Problem, Settings
from symgen.accuracy.variants import Variant, compile_variant, plans_of
from symgen.plans import choose as choosing
from symgen.plans.accuracy import longest_path, rivals, spread
from symgen.plans.families import Family
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.system import System, derive
from symgen.validation.hard.scenes import X, Y, chain

ROW = "forward_dynamics"


def plan(scene: Scene, row: str = ROW) -> str:
    return derive(scene).program(row).plan


def near_straight(problem: Problem, count: int = 60) -> dict[str, np.ndarray]:
    states = problem.box.sample(count, 4)
    return {**states, "q": 1e-3 * states["q"]}


def measured(system: System, folder: Path) -> dict[str, float]:
    """The largest error of every plan near the straight configuration and anywhere, compiled."""
    problem = Problem(system, system.output(ROW), Settings(states=60))
    worst: dict[str, float] = {}
    for number, family in enumerate(plans_of(system, problem.output)):
        (compiled,) = compile_variant(system, (problem.output,), Variant(family=family), folder / str(number))
        for states in (near_straight(problem), problem.box.sample(60, 5)):
            error = float(np.max(relative(compiled.call(states), *problem.reference.over(states))))
            worst[compiled.plan] = max(worst.get(compiled.plan, 0.0), error)
    return worst


@pytest.mark.parametrize(("links", "axes"), [(4, (Y,)), (7, (X, Y))])
def test_no_plan_is_picked_with_ten_times_the_error(links: int, axes: tuple, tmp_path: Path) -> None:
    system = derive(chain(links, axes))
    errors = measured(system, tmp_path)
    assert errors[system.program(ROW).plan] <= 10 * max(min(errors.values()), 2**-53)
    cheapest = min((c for c in system.plans(ROW) if c.counts), key=lambda c: choosing.cost(c.counts))  # type: ignore[arg-type]
    assert not cheapest.chosen and "times the error" in cheapest.why  # count alone would have taken another


def test_factoring_a_long_chain_loses_what_the_rule_says(tmp_path: Path) -> None:
    """The reason for the rule, and that the measurement can see it."""
    system = derive(chain(10))
    problem = Problem(system, system.output(ROW), Settings(states=1))
    states = near_straight(problem, 20)
    exact = problem.reference.over(states)
    found = []
    for number, family in enumerate((Family(), Family(articulated=True))):
        (compiled,) = compile_variant(system, (problem.output,), Variant(family=family), tmp_path / str(number))
        found.append(float(np.max(relative(compiled.call(states), *exact))))
    assert found[0] > 20 * found[1]


def test_heavy_loads_on_light_links_are_not_regrouped(tmp_path: Path) -> None:
    system = derive(chain(4, (X, Y), mass=lambda k: F(1000) ** (k - 2)))
    assert system.program(ROW).plan == "articulated, inertia as given"
    assert plan(chain(4, (X, Y))) in ("articulated", "factored")
    errors = measured(system, tmp_path)
    assert errors["articulated"] > 4 * errors["articulated, inertia as given"]


def test_nothing_is_estimated_where_plans_are_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(choosing, "relative_errors", never)
    monkeypatch.setattr(choosing, "estimate", never)
    assert plan(chain(2)) == "factored"
    assert plan(load("examples/free_body.scene.yaml")) == "articulated"
    assert derive(load("examples/panda.scene.yaml")).program("mass_matrix").plan == "composite"


def test_counting_every_plan_changes_no_choice() -> None:
    for scene in (chain(4), chain(3, (X, Y), mass=lambda k: F(1000) ** (k - 2))):
        (shown,) = [choice for choice in derive(scene).plans(ROW, every=True) if choice.chosen]
        assert shown.plan == plan(scene)


def test_examples_keep_their_plans() -> None:
    """Their errors are within ten times the best: docs/accuracy.md has them."""
    assert plan(load("examples/panda.scene.yaml")) == plan(load("examples/fig2.scene.yaml")) == "factored"


def test_what_makes_a_plan_suspect() -> None:
    system = derive(chain(5, mass=lambda k: 1000 if k == 4 else 1))
    assert longest_path(system.tree) == 5 and spread(system.tree) == 1003
    output = system.output(ROW)
    assert rivals(system.lowered, output, Family()) == (True, True)
    assert rivals(system.lowered, output, Family(articulated=True)) == (False, True)
    assert rivals(system.lowered, output, Family(articulated=True, regrouped=False)) == (False, False)
    assert rivals(system.lowered, system.output("mass_matrix"), Family()) == (False, False)
