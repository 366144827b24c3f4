"""Rounding errors on a scene's page, and the page of the hard cases."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("flint")

from symgen.accuracy import rounding_data
from symgen.accuracy.choices import changed, random_chain
from symgen.errors import NotSupportedError
from symgen.report.hard import hard_page, powers
from symgen.report.measured import rounding
from symgen.report.page import write_report
from symgen.scene.load import load
from symgen.system import derive
from symgen.validation.hard import figures
from symgen.validation.hard.case import Bench, Case, Finding, ran
from symgen.validation.hard.scenes import chain
from symgen.validation.hard_cases import as_data


@pytest.fixture(scope="module")
def data() -> dict[str, Any]:
    said: list[str] = []
    found = rounding_data(load("examples/spinning_top.scene.yaml"), said.append, states=30, search=60, boxes=64)
    assert said[-1] == "proven bounds" and "1 of" in said[0]
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    return found


def test_errors_are_plain_data(data: dict[str, Any]) -> None:
    assert {row["function"] for row in data["rows"]} >= {"mass_matrix", "forward_dynamics", "integrate"}
    assert data["box"] == "quaternions of unit length, velocities within ±2, accelerations and forces within ±5"
    for row in data["rows"]:
        assert row["tenth"] <= row["median"] <= row["ninetieth"] <= row["percentile"] <= row["largest"] < 1e-3
        assert row["operations"] >= 0 and row["absolute"] >= 0
    proven = {(row["function"], row["precision"]): row for row in data["bounds"]}
    assert ("integrate", "float") in proven and ("forward_dynamics", "double") in proven
    for row in proven.values():
        assert 0 <= row["measured"] <= row["proven"]


def test_the_section_shows_them(data: dict[str, Any], tmp_path: Path) -> None:
    scene = load("examples/spinning_top.scene.yaml")
    write_report(tmp_path / "one.html", scene, measured={"rounding": data})
    write_report(tmp_path / "two.html", scene, measured={"rounding": data})
    text = (tmp_path / "one.html").read_text(encoding="utf-8")
    assert text == (tmp_path / "two.html").read_text(encoding="utf-8")
    assert 'id="rounding"' in text and "Errors of every variant" in text and "Bounds of" in text
    assert text.count("double batch") >= len({row["function"] for row in data["rows"]})
    assert "wrong" not in text[text.index('id="rounding"') : text.index("What the plans lose")]


def test_wrong_answers_are_shown(data: dict[str, Any]) -> None:
    spoilt = copy.deepcopy(data)
    spoilt["rows"][0]["wrong"] = 3
    found = rounding.values(spoilt)
    assert "three states had a wrong kind of answer" in str(found["lead"]).lower()
    assert found["rows"].header[-1] == "wrong"  # type: ignore[attr-defined]


def test_plans_are_compared_with_the_best_one(data: dict[str, Any]) -> None:
    found = rounding.values(data)["plans"]
    assert any("(chosen)" in row[0] for row in found.rows)  # type: ignore[attr-defined]
    assert min(float(row[-1]) for row in found.rows) == 1.0  # type: ignore[attr-defined]


def test_closed_loops_have_no_errors() -> None:
    with pytest.raises(NotSupportedError, match="closed loops"):
        rounding_data(load("examples/four_bar.scene.yaml"))


def case(bench: Bench) -> Iterator[Finding]:
    yield from bench.accurate(chain(2), "forward_dynamics", figures.near_straight(2), "two <links>", plans=True)
    yield bench.finding("locked", "float", 0.0, 0.0, "NaN")
    yield bench.finding("a wrong one", "double", 3.0, 2.0, "at 1e-3", "rad")


def test_the_page_of_the_hard_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    hard = Case("huge angles", "what is hard", "what is right", case)
    found = as_data([(hard, ran(hard))])
    monkeypatch.setattr(figures, "LINKS", (2, 3))
    monkeypatch.setattr(figures, "MORE_LINKS", ())
    monkeypatch.setattr(figures, "PLACES", (1.0, 1e6))
    monkeypatch.setattr(figures, "DECADES", (0, 9, 38))
    curves = figures.figures(lambda what: None)
    assert {len(curve["points"]) for curve in curves["angles"]} == {2, 3}
    (ours, world) = (dict(curve["points"]) for curve in curves["places"])
    assert ours[1e6] < 1e-15 and world[1e6] > 1e3 * world[1.0]
    found["figures"] = json.loads(json.dumps(curves, allow_nan=False))
    text = hard_page(found)
    assert text == hard_page(found)
    assert "1 failed" in text and "✗ wrong" in text and "two &lt;links&gt;" in text and "at 10⁻³" in text
    assert 'id="huge-angles"' in text and text.count("<svg") >= 1 and "For comparison" in text


def test_powers_of_ten_are_written_as_such() -> None:
    assert powers("1e6 times, 2.5e-3 m, at 1.0") == "10⁶ times, 2.5\u00a0×\u00a010⁻³ m, at 1.0"


def test_choices_that_accuracy_made_are_listed() -> None:
    (row,) = [row for row in changed(derive(chain(4))) if row.function == "forward_dynamics"]
    assert row.cheapest.startswith("factored") and row.chosen.startswith("articulated")
    assert row.error > 4 and row.dearer >= 1
    assert not list(changed(derive(chain(2))))
    assert random_chain(3).sha256 == random_chain(3).sha256 != random_chain(4).sha256
