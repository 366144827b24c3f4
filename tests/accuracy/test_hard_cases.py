"""The command of the hard cases: a few of them, its table, its JSON and its exit status."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

pytest.importorskip("flint")

from symgen.errors import SceneError
from symgen.validation import hard_cases
from symgen.validation.hard.case import Bench, Case, Finding

QUICK = ("top of a pendulum", "closed loops", "fast spin")


@pytest.mark.parametrize("name", QUICK)
def test_quick_cases_pass(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert hard_cases.main([name]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"{name}: ") and " ok " in said and "FAILED" not in said


@pytest.mark.slow
@pytest.mark.parametrize("name", [case.name for case in hard_cases.all_cases() if case.name not in QUICK])
def test_all_other_cases_pass(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert hard_cases.main([name]) == 0, capsys.readouterr().out


def wrong(bench: Bench) -> Iterator[Finding]:
    yield bench.finding("one", "double", 1.0, 2.0)
    yield bench.finding("two", "double", 3.0, 2.0)
    yield bench.finding("shown", "double", 9.0, None)


def refused(bench: Bench) -> Iterator[Finding]:
    raise SceneError("no such thing")
    yield


def test_a_case_that_fails_is_said_and_ends_with_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cases = (Case("bad", "to count", "less than two", wrong), Case("broken", "to be", "a number", refused))
    monkeypatch.setattr(hard_cases, "all_cases", lambda: cases)
    assert hard_cases.main(["--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["passed"] is False
    assert [row["passed"] for row in found["cases"][0]["findings"]] == [True, False, True]
    assert found["cases"][1]["findings"][0]["note"] == "no such thing"
    assert hard_cases.main(["bad"]) == 1
    assert "FAILED two" in capsys.readouterr().out


def test_unknown_names_are_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert hard_cases.main(["no such case"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
