"""The page of benchmark problems, from data as they are stored."""

from __future__ import annotations

import json
from typing import Any

import pytest

from symgen.report.benchmarks import benchmarks_page, identifier
from symgen.simulate.answers import Answer
from symgen.simulate.statements import STATEMENTS
from symgen.validation.benchmarks import benchmark_data, row_data


def row(error: float = 1e-9, drift: float = float("nan")) -> dict[str, Any]:
    return row_data(Answer("heavy top", "angles", "lie", error, 1e-7, "Exudyn", drift, 0.002))


def test_lines_are_plain_data() -> None:
    plain = row()
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert plain["drift"] is None and plain["passed"] is True and plain["statement"]["words"]


def test_a_line_above_its_bar_is_seen() -> None:
    good, bad = benchmarks_page([row()]), benchmarks_page([row(), row(1e-3), row(float("nan"))])
    assert "all within their bars" in good and "✗" not in good
    assert "2 of 3 answers failed" in bad and "not a number" in bad
    assert good == benchmarks_page([row()])


def test_the_page_has_every_problem_once() -> None:
    rows = [row_data(Answer(name, "x", "rk4", 1e-9, 1e-7, "y", 1e-12, 0.1)) for name in STATEMENTS]
    text = benchmarks_page(rows)
    assert all(text.count(f'<section id="{identifier(name)}"') == 1 for name in STATEMENTS)
    assert len({identifier(name) for name in STATEMENTS}) == len(STATEMENTS)
    assert all(statement.answer and statement.source for statement in STATEMENTS.values())


def test_data_of_some_problems() -> None:
    pytest.importorskip("scipy")
    told: list[str] = []
    rows = benchmark_data(told.append, names=("rod_pendulum", "oscillators"))
    assert told == ["rod pendulum", "oscillators"] and all(one["passed"] for one in rows)
    assert {one["problem"] for one in rows} == {"rod pendulum", "damped oscillator", "two masses, three springs"}
