"""A bounded part of what tools/fuzz.py does, with hypothesis beside it; and that the judge sees what it should."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from symgen.cli import run
from symgen.errors import SceneError, SymgenError
from symgen.scene.load import load
from tools import fuzz
from tools.hostile import hostile_documents
from tools.mutations import NUMBERS, mutate
from tools.seeds import SEEDS

LIMIT = 5.0
KINDS = {name: text.encode() for name, text in SEEDS.items() if not name.endswith(".xml")}


@pytest.fixture(autouse=True)
def model(tmp_path: Path) -> None:
    """What the seed over a model names."""
    (tmp_path / "robot.urdf").write_text(SEEDS["good.urdf"], encoding="utf-8")


def problem(path: Path) -> str:
    return fuzz.check(path, LIMIT).finding


def test_the_seeds_are_good(tmp_path: Path) -> None:
    for name, text in KINDS.items():
        (tmp_path / name).write_bytes(text)
        assert load(tmp_path / name).bodies


@settings(max_examples=150, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
@given(st.sampled_from(sorted(KINDS)), st.integers(0, 2**32 - 1))
def test_damaged_files(tmp_path: Path, name: str, seed: int) -> None:
    path = tmp_path / name
    path.write_bytes(mutate(KINDS[name], random.Random(seed)))
    assert problem(path) == ""


@settings(max_examples=150, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
@given(st.sampled_from(["a.yaml", "a.urdf"]), st.binary(max_size=60) | st.text(max_size=60).map(str.encode))
def test_arbitrary_bytes(tmp_path: Path, name: str, data: bytes) -> None:
    path = tmp_path / name
    path.write_bytes(data)
    assert problem(path) == ""


@pytest.mark.parametrize("name", ["good.scene.yaml", "good.urdf"])
def test_every_odd_number_in_one_place(name: str, tmp_path: Path) -> None:
    """The mass, of which a scene that is read must have the value that was written."""
    before, after = {"good.urdf": ('mass value="', '"'), "good.scene.yaml": ("name: link2\n    mass: ", "\n")}[name]
    text = KINDS[name].decode()
    start = text.index(before) + len(before)
    end = text.index(after, start)
    for number in NUMBERS:
        path = tmp_path / name
        path.write_text(text[:start] + number + text[end:], encoding="utf-8")
        assert problem(path) == "", number
        if (scene := fuzz.check(path, LIMIT).scene) is not None:
            assert float(scene.bodies[1].mass) == float(number)


@pytest.mark.parametrize("name", sorted(name for name in hostile_documents(10) if not name.endswith(".xml")))
def test_hostile_documents(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(hostile_documents(60_000)[name])
    assert problem(path) == ""


@pytest.mark.slow
def test_hostile_documents_as_long_as_they_may_be() -> None:
    tally = fuzz.fuzz(0, 0, LIMIT, 1, [], None, 4_900_000)
    assert not tally.findings, tally.text()


@pytest.mark.slow
def test_many_damaged_files() -> None:
    tally = fuzz.fuzz(2000, 1, LIMIT, 100, kinds=(".yaml", ".urdf"))
    assert not tally.findings, tally.text()


@pytest.mark.slow
def test_damaged_mujoco_files() -> None:
    pytest.importorskip("mujoco")
    tally = fuzz.fuzz(60, 1, LIMIT, 20, kinds=(".xml",))
    assert not tally.findings, tally.text()


# -- the judge -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "seen"),
    [
        (KeyError("mass"), "KeyError: 'mass'"),
        (RecursionError("deep"), "RecursionError"),
        (SceneError("two\nlines", "good.urdf"), "not one printable line"),
        (SceneError("\x1b[31m", "good.urdf"), "not one printable line"),
        (SceneError("what?", "elsewhere"), "does not begin with the file's name"),
        (SceneError("x" * 1000, "good.urdf"), "characters"),
        (SymgenError("good.urdf: fine"), ""),
    ],
)
def test_what_the_judge_sees(error: Exception, seen: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(path: Path) -> None:
        raise error

    monkeypatch.setattr(fuzz, "load", failing)
    found = fuzz.check(tmp_path / "good.urdf", LIMIT).finding
    assert seen in found and bool(seen) == bool(found)


def test_the_judge_sees_slowness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def spinning(path: Path) -> None:
        while True:
            pass

    monkeypatch.setattr(fuzz, "load", spinning)
    assert fuzz.check(tmp_path / "good.urdf", 0.005).finding == "stopped after 0.1 s"


def test_the_judge_sees_debris(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "good.scene.yaml"
    path.write_text(SEEDS["good.scene.yaml"].replace("name: good", "nam: good"))

    def debris(arguments: list[str]) -> int:
        (tmp_path / "out").mkdir()
        (tmp_path / "out" / "good.c").touch()
        return run(arguments)

    assert fuzz.check_command(path, False, LIMIT).verdict == "generate 2"
    monkeypatch.setattr(fuzz, "run", debris)
    assert fuzz.check_command(path, False, LIMIT).finding == "a folder without success"
    assert {left.name for left in tmp_path.iterdir()} == {path.name, "robot.urdf"}


def test_the_same_seed_gives_the_same_input() -> None:
    first, second = (mutate(KINDS["good.urdf"], random.Random("1 .urdf 7")) for _ in range(2))
    assert first == second != KINDS["good.urdf"]
