"""Work and precision: data, orders that a wrong method fails, the section, the command."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symgen.integrators import methods
from symgen.report.measured import precision
from symgen.report.tables import Table
from symgen.scene.load import load
from symgen.scene.outputs import STEPS
from symgen.simulate import Model
from symgen.validation.work_precision import QUICK, precision_data
from symgen.validation.work_precision import orders as measured
from symgen.validation.work_precision.__main__ import main
from symgen.validation.work_precision.energies import long_run, verdict
from symgen.validation.work_precision.programs import BODIES, PINOCCHIO, TREE, programs
from symgen.validation.work_precision.setting import methods as methods_of
from symgen.validation.work_precision.setting import prepare

pytest.importorskip("scipy")
TINY = replace(QUICK, steps=(16, 64, 256), tolerances=(1e-3, 1e-6), longest=0.2, energy_steps=4000)


@pytest.fixture(scope="module")
def data() -> dict[str, Any]:
    return precision_data(load("examples/double_pendulum.scene.yaml"), lambda what: None, effort=TINY)


def test_every_step_states_an_order() -> None:
    assert set(measured.STATED) == set(STEPS) == set(precision.STEP_STYLES)


def test_the_data_are_plain_and_whole(data: dict[str, Any]) -> None:
    assert json.loads(json.dumps(data, allow_nan=False)) == json.loads(json.dumps(data))
    assert data["reference"]["uncertainty"] < 1e-12 and len(data["reference"]["checks"]) >= 1
    assert [row["method"] for row in data["orders"]] == [name for name in STEPS if name != "lie"]
    assert all(row["holds"] and abs(row["observed"] - row["stated"]) < 0.3 for row in data["orders"])
    finest = [p for p in data["points"] if p["integrator"] == "step:rk4"][-1]
    assert finest["error"] < 1e-8 and finest["energy"] < 1e-8 and finest["cpu_seconds"] > 0.0
    kept = {line["method"]: line for line in data["energy"]["lines"]}
    assert kept["variational"]["bounded"] and kept["implicit_midpoint"]["bounded"]


@pytest.mark.parametrize(
    ("method", "change"),
    [
        ("rk4", {"symgen.integrators.methods.WEIGHTS": tuple(Fraction(n, 60) for n in (10, 20, 20, 12))}),
        ("rk4", {"symgen.integrators.methods.STAGES": ((1, Fraction(1, 2)), (2, Fraction(2, 5)), (3, Fraction(1)))}),
        ("variational", {"symgen.integrators.variational.HALF": Fraction(51, 100)}),
    ],
)
def test_a_wrong_coefficient_shows_in_the_order(
    method: str, change: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A method is its own definition, so its certificate cannot know: the order does."""
    for name, value in change.items():
        monkeypatch.setattr(name, value)
    made = methods._rk4() if method == "rk4" else methods.variational(methods._factor)
    monkeypatch.setitem(methods.METHODS, method, made)
    model = Model(load("examples/double_pendulum.scene.yaml"), (method,))
    found = measured.order(model, method, np.array([0.9, -0.4]), np.array([0.5, 1.0]), 0.125)
    assert not found.holds, found


def test_orders_from_errors() -> None:
    assert measured.observed_order([1.6e-3, 1e-4, 6.25e-6]) == pytest.approx(4.0)
    assert measured.observed_order([1e-6, 1e-10, 1e-15]) == pytest.approx(np.log2(1e4))
    assert measured.observed_order([1e-13, 1e-14]) is None
    exact = measured.Order("rk4", 4, ((0.1, 1e-15), (0.05, 1e-16)), None)
    lost = measured.Order("rk4", 4, ((0.1, 1e-3), (0.05, 1e-3)), 0.0)
    assert exact.holds and not lost.holds


def test_what_cannot_hold_a_scene_is_listed() -> None:
    at = prepare(load("examples/gripper.scene.yaml"), 0.1)
    every, lost = programs(at)
    reasons = dict(lost)
    assert {TREE, BODIES} <= set(reasons) and "coupled" in reasons[TREE]
    assert PINOCCHIO in reasons or any(program.name == PINOCCHIO for program in every)
    assert "lie" not in methods_of(at.mechanism) and not at.energy.kept


def test_energy_that_leaks_is_told_from_energy_that_stays() -> None:
    model = Model(load("examples/double_pendulum.scene.yaml"), ("rk4", "variational"))
    start = model.start([0.9, 0.4], None)
    leaking, bounded = (long_run(model, name, start, 0.02, 20_000) for name in ("rk4", "variational"))
    assert bounded.bounded and not leaking.bounded
    assert leaking.largest[-1] > 50 * leaking.largest[len(leaking.largest) // 2]
    assert leaking.verdict == "grows"
    gone = long_run(model, "rk4", model.start([0.9, 0.4], [1e200, 0.0]), 0.02, 1000)
    assert gone.failed and not gone.bounded


def test_the_section(data: dict[str, Any]) -> None:
    values = precision.values(data)
    text = str(values["diagram"])
    assert text.startswith("<svg") and text.count("<title>") == sum(not p["failed"] for p in data["points"])
    assert "step:rk4: 256 steps" in text and str(values["order_diagram"]).startswith("<svg")
    spoiled = {**data, "energy": {"reason": "Dampers take energy here."}, "energy_kept": False}
    spoiled["points"] = [{**p, "failed": "gave up", "error": None} for p in data["points"]]
    shown = precision.values(spoiled)
    assert shown["diagram"] == "" and shown["failed"] is not None and shown["energy_reason"]


def test_the_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("symgen.validation.work_precision.__main__.QUICK", TINY)
    assert main(["pendulum", "--time", "0.5", "-o", str(tmp_path / "out")]) == 0
    assert "order of variational: stated 2" in capsys.readouterr().out
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "pendulum.csv", "pendulum.html", "pendulum.json"
    ]  # fmt: skip
    assert json.loads((tmp_path / "out" / "pendulum.json").read_text(encoding="utf-8"))["seconds"] == 0.5
    page = (tmp_path / "out" / "pendulum.html").read_text(encoding="utf-8")
    assert "<svg" in page and "http://" not in page.replace("http://www.w3.org", "")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing_here"], "nothing_here"),
        (["four_bar"], "loop"),
        (["pendulum", "--time", "0"], "--time: the time must"),
    ],
)
def test_bad_input_ends_in_one_line(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    text = capsys.readouterr().err
    assert message in text and text.count("\n") == 1 and text.startswith("symgen: ")


@pytest.mark.parametrize(
    ("run", "said"),
    [
        ((1e-6, 1.1e-6, 1.0), "bounded"),
        ((0.8, 0.96, 1.2), "too large"),
        ((0.15, 0.15, 1.0), "too large"),
        ((4.1, 1.5, 0.5), "too large"),
        ((5e-2, 0.45, 8.1), "grows"),
        ((1e-5, 1e-3, 1.0), "grows"),
        ((1e-16, 1e-14, 50.0), "bounded"),
        ((np.inf, np.inf, np.inf), "grows"),
        ((0.1, float("nan"), 1.0), "grows"),
    ],
)
def test_one_rule_says_how_energy_fares(run: tuple[float, float, float], said: str) -> None:
    assert verdict(*run) == said


def test_the_page_goes_by_the_same_rule(data: dict[str, Any]) -> None:
    wild = json.loads(json.dumps(data))
    wild["energy"]["lines"][0].update(first=0.8, last=0.96, growth=1.2, failed="", bounded=True)
    table = precision.values(wild)["long_table"]
    assert isinstance(table, Table) and "too large" in table.rows[0][4] and "fail" in table.rows[0][4]
