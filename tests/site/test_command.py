"""`symgen report`: wrong input is one line and leaves nothing; names and folders are safe."""

from __future__ import annotations

import importlib
import inspect
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen import cli
from symgen.scene.names import identifier
from symgen.site.folders import folder_name
from symgen.site.measures import MEASURES, chosen
from tests.report import pages
from tests.site.fakes import Put

Small = Callable[[str], Path]


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The one line of a run that ends with status 2."""
    assert cli.run(["report", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and captured.err.count("\n") == 1
    return captured.err.removeprefix("symgen: ").strip()


def test_one_bad_scene_stops_all(small: Small, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = tmp_path / "bad.scene.yaml"
    bad.write_text("name: bad\nbodies: 3\njoints: []\n", encoding="utf-8")
    out = tmp_path / "out"
    assert refused([str(small("one")), str(bad), "-o", str(out)], capsys).startswith("bad.scene.yaml:2")
    wrong = tmp_path / "wrong.scene.yaml"
    text = small("wrong").read_text(encoding="utf-8")
    wrong.write_text(text.replace("mass_matrix,", "parameter_jacobian:mass_matrix,"), encoding="utf-8")
    assert "no run-time parameters" in refused([str(wrong), "-o", str(out)], capsys)
    assert not out.exists()


def test_two_scenes_of_one_name(small: Small, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = tmp_path / "other.scene.yaml"
    other.write_bytes(small("one").read_bytes())
    line = refused([str(small("one")), str(other), "-o", str(tmp_path / "out")], capsys)
    assert line == f"{other}: 'one' is the name of {small('one')} too" and not (tmp_path / "out").exists()
    line = refused([str(small("one")), str(small("one")), "-o", str(tmp_path / "out")], capsys)
    assert line == f"{small('one')}: is given twice"


@pytest.mark.parametrize("what", ["file", "folder", "link"])
def test_other_things_are_left_alone(
    what: str, small: Small, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    if what == "file":
        out.write_text("mine", encoding="utf-8")
    elif what == "link":
        (tmp_path / "elsewhere").mkdir()
        out.symlink_to(tmp_path / "elsewhere")
    else:
        out.mkdir()
        (out / "index.html").write_text("mine", encoding="utf-8")
    before = sorted(path.name for path in tmp_path.rglob("*"))
    line = refused([str(small("one")), "-o", str(out)], capsys)
    assert {"file": "is a file", "link": "symbolic link", "folder": "holds other files"}[what] in line
    assert sorted(path.name for path in tmp_path.rglob("*")) == before


def test_wrong_usage(
    small: Small, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, out = str(small("one")), str(tmp_path / "out")
    assert "SCENE" in refused(["-o", out], capsys)
    assert "-o" in refused([scene], capsys)
    assert "nothing measures 'weather'" in refused([scene, "-o", out, "--with", "weather"], capsys)
    assert "none" in refused([scene, "-o", out, "--with", "none,motion"], capsys)
    assert "--jobs" in refused([scene, "-o", out, "--jobs", "0"], capsys)
    monkeypatch.setenv("CHROME", "no-such-browser")
    assert "no-such-browser" in refused([scene, "-o", out, "--pdf"], capsys)
    monkeypatch.delenv("CHROME")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "printing needs Chromium" in refused([scene, "-o", out, "--pdf"], capsys)
    assert not (tmp_path / "out").exists()


def test_status_and_summary(put: Put, small: Small, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    put("validation", "validation")
    put("motion", "without_tool")
    arguments = ["report", str(small("one")), "-o", str(tmp_path / "out")]
    assert cli.run(arguments) == 0
    printed = capsys.readouterr()
    assert printed.err == ""  # silent in a pipe
    assert "✓ two checks passed" in printed.out and "not measured: one, motion: no C compiler" in printed.out
    put("validation", "breaking")
    assert cli.run([*arguments, "--fresh", "--json"]) == 0  # what was measured still counts
    answer = json.loads(capsys.readouterr().out)
    assert [line["state"] for line in answer["measurements"]] == ["failed", "refused"]
    (tmp_path / "out/data/one/validation.json").unlink()
    assert cli.run(arguments) == 1
    assert "FAILED: one, validation: unexpected ZeroDivisionError: a bug" in capsys.readouterr().out


def test_choice_of_measurements() -> None:
    assert chosen(("all",)) == tuple(MEASURES)
    assert chosen(("none",)) == ()
    assert chosen(("motion", "validation", "motion")) == ("validation", "motion")


@pytest.mark.parametrize("id", list(MEASURES))
def test_measurements_take_their_settings(id: str) -> None:
    """What a page says of settings is what was asked of the function."""
    row = MEASURES[id]
    function = getattr(importlib.import_module(row.module), row.function)
    given = [None] * (1 + row.of_scenes)
    for effort in ("quick", "full"):
        inspect.signature(function).bind(*given, **row.settings(effort))


def test_help_imports_nothing_slow() -> None:
    code = "import sys; from symgen import cli; cli.run(['report', '--help']); "
    code += "sys.exit(bool({'sympy', 'casadi'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=False).returncode == 0


@settings(max_examples=50)
@given(st.text(max_size=80))
def test_folders_are_safe(name: str) -> None:
    folder = folder_name(name)
    assert folder == identifier(folder) or "-" in folder
    assert folder.isascii() and 0 < len(folder) <= 60
    assert not set(folder) & set('/\\:*?"<>|. \0') and not folder.startswith("-")
    assert folder.lower() not in ("data", "pdf", "index", "hard", "benchmarks", "peers")


@settings(max_examples=50)
@given(st.text(max_size=20), st.text(max_size=20))
def test_folders_differ_where_names_do(first: str, second: str) -> None:
    if first != second:
        assert folder_name(first) != folder_name(second)


@pytest.mark.parametrize("name", ["fig1", "double_pendulum", "Arm2"])
def test_plain_names_are_their_folders(name: str) -> None:
    assert folder_name(name) == name


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    from dataclasses import replace

    from symgen.site.build import Settings, build_site
    from tests.site import reading

    scene = replace(pages.hostile_scene(), name=f"../{pages.HOSTILE}")
    build_site([scene], tmp_path / "out", Settings(()))
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert reading.broken_links(tmp_path / "out") == []
    for text in reading.html_files(tmp_path / "out").values():
        seen = pages.read_html(text)
        assert seen.wrong == [] and seen.open == []
        assert "img" not in {tag for tag, _, _ in seen.attributes}
        assert not any(name.startswith("on") for _, name, _ in seen.attributes)
