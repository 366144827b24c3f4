"""Every example gets its page."""

from __future__ import annotations

from pathlib import Path

import pytest

from symgen.report import write_report
from symgen.scene.load import load
from tests.report import pages

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.mark.parametrize("name", ["payload", "gripper"])
def test_run_time_places_and_coupled_joints_are_written(name: str, tmp_path: Path) -> None:
    write_report(tmp_path / "page.html", load(EXAMPLES / f"{name}.scene.yaml"))
    seen = pages.read_html((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert seen.wrong == [] and seen.open == []


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.scene.yaml")), ids=lambda path: path.name.split(".")[0])
def test_every_example(path: Path, tmp_path: Path) -> None:
    write_report(tmp_path / "page.html", load(path))
    assert "<math" in (tmp_path / "page.html").read_text(encoding="utf-8") or "four_bar" in path.name
