"""The site: complete, joined, grown by later runs, the same bytes, with what is stored used again."""

from __future__ import annotations

import importlib.metadata
import itertools
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from symgen import cli
from symgen.bench.peers import registry
from symgen.site import glance, tools
from symgen.site.build import Settings, build_site
from symgen.site.measures import MEASURES
from symgen.site.pages import read_cards
from symgen.site.store import verdicts
from tests.report import pages
from tests.site import reading
from tests.site.conftest import example
from tests.site.fakes import Put

VALIDATION = Settings(("validation",), jobs=2)
NOTHING = Settings(())


Small = Callable[[str], Path]


def build(out: Path, *scenes: Path, settings: Settings = VALIDATION) -> dict[str, list[str]]:
    """State → what was measured so, as scene/measurement."""
    result = build_site(scenes, out, settings)
    found: dict[str, list[str]] = {}
    for line in result.lines:
        found.setdefault(line.state, []).append(f"{line.scene}/{line.what}")
    return found


def html(out: Path) -> dict[str, str]:
    return reading.html_files(out)


def test_pages_are_joined(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    build(tmp_path, small("pendulum"), small("cart_pole"), example("four_bar"))
    texts = html(tmp_path)
    assert {"index.html", "pendulum/index.html", "cart_pole/index.html", "four_bar/index.html"} <= set(texts)
    assert reading.broken_links(tmp_path) == []
    for name, text in texts.items():
        seen = pages.read_html(text)
        assert seen.wrong == [] and seen.open == [] and len(seen.ids) == len(set(seen.ids)), name
        root = pages.read_xml(text)
        assert len(list(root.iter("h1"))) == 1 and len(list(root.iter("main"))) == 1
        assert next(nav.get("aria-label") for nav in root.iter("nav")) == "Site"
    middle = {(a.get("rel"), a.get("href")) for a in pages.read_xml(texts["four_bar/index.html"]).iter("a")}
    assert {("prev", "../cart_pole/index.html"), ("next", "../pendulum/index.html")} <= middle
    index = reading.text_of(texts["index.html"])
    assert "four_bar3 (open tree)" in index
    assert "3 scenes" in index and "✓ two checks passed" in index and "topology only" in index
    assert (tmp_path / "pendulum/code/manifest.json").is_file()


def test_headings_go_down_one_by_one(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    build(tmp_path, small("pendulum"))
    for name, text in html(tmp_path).items():
        levels = [int(level) for level in re.findall(r"<h([1-6])[ >]", text)]
        assert levels[0] == 1, name
        assert all(b <= a + 1 for a, b in itertools.pairwise(levels)), (name, levels)


def test_what_is_stored_is_used_again(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation", quick={"states": 10}, full={"states": 20})
    here, scene = ["pendulum/Validation"], small("pendulum")
    assert build(tmp_path, scene) == {"measured": here}
    before = html(tmp_path)
    assert build(tmp_path, scene) == {"stored": here}
    assert html(tmp_path) == before
    assert build(tmp_path, scene, settings=NOTHING) == {}
    assert html(tmp_path) == before  # what is stored is shown, whatever is asked for
    assert build(tmp_path, scene, settings=Settings(("validation",), "full")) == {"measured": here}
    assert build(tmp_path, scene) == {"stored": here}  # full effort serves where quick is asked for
    assert "random states20" in reading.text_of(html(tmp_path)["pendulum/index.html"])
    assert build(tmp_path, scene, settings=Settings(("validation",), fresh=True)) == {"measured": here}


def test_a_changed_scene_is_measured_again(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    scene, site = tmp_path / "arm.scene.yaml", tmp_path / "site"
    text = small("arm").read_text(encoding="utf-8")
    scene.write_text(text, encoding="utf-8")
    build_site([scene], site, VALIDATION)
    scene.write_text(re.sub(r"mass: [0-9.]+", "mass: 7.5", text, count=1), encoding="utf-8")
    changed = build_site([scene], site, NOTHING)
    assert changed.scenes[0][2] is None  # what was measured of another mass is not shown
    assert "not shown, as what was measured has changed since: arm, validation" in changed.to_text()
    assert "not validated" in html(site)["arm/index.html"]
    assert [line.state for line in build_site([scene], site, VALIDATION).lines] == ["measured"]


def test_a_site_grows(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    build(tmp_path, small("cart_pole"))
    assert 'rel="next"' not in html(tmp_path)["cart_pole/index.html"]
    build(tmp_path, small("pendulum"))
    texts = html(tmp_path)
    assert 'rel="next"' in texts["cart_pole/index.html"] and reading.broken_links(tmp_path) == []
    assert "2 scenes" in reading.text_of(texts["index.html"])


def test_the_same_bytes(put: Put, small: Small, tmp_path: Path) -> None:
    """Whatever the order and the number of processes; nothing of this machine is in it."""
    put("validation", "validation")
    build(tmp_path / "a", small("pendulum"), small("cart_pole"))
    build(tmp_path / "b", small("cart_pole"), small("pendulum"), settings=Settings(("validation",), jobs=1))
    for path in (tmp_path / "a/data").glob("*/validation.json"):  # the time that it took is part of the data
        other = tmp_path / "b/data" / path.relative_to(tmp_path / "a/data")
        took = json.loads(path.read_text(encoding="utf-8"))["cpu_seconds"]
        data = {**json.loads(other.read_text(encoding="utf-8")), "cpu_seconds": took}
        other.write_text(json.dumps(data), encoding="utf-8")
    build(tmp_path / "b", small("cart_pole"), small("pendulum"))
    assert html(tmp_path / "a") == html(tmp_path / "b")
    assert not any(str(tmp_path) in text for text in html(tmp_path / "a").values())


def test_what_failed_comes_first(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "failing")
    result = build_site([small("pendulum"), small("cart_pole"), small("furuta")], tmp_path, VALIDATION)
    assert not result.passed and {name: ok for name, _, ok in result.scenes}["cart_pole"] is False
    root = pages.read_xml(html(tmp_path)["index.html"])
    assert [h.findtext("a") for h in root.iter("h3")] == ["cart_pole", "furuta", "pendulum"]
    assert "Checks failed in cart_pole" in reading.text_of(html(tmp_path)["index.html"])


@pytest.mark.parametrize(
    ("function", "state", "reason"),
    [
        ("refusing", "refused", "no simulator has such a joint"),
        ("without_tool", "refused", "no C compiler"),
        ("without_package", "refused", "the package no_such_package_anywhere is not installed"),
        ("not_written_yet", "refused", "cannot be measured by this symgen"),
        ("breaking", "failed", "unexpected ZeroDivisionError: a bug"),
        ("uncertified", "failed", "a function is not the function"),
        ("dying", "failed", "its process ended with status 7"),
        ("without_number", "failed", "ValueError"),
    ],
)
def test_what_cannot_be_measured_is_a_line(
    put: Put, small: Small, tmp_path: Path, function: str, state: str, reason: str
) -> None:
    put("validation", function)
    result = build_site([small("pendulum")], tmp_path, VALIDATION)
    assert [(line.state, line.scene) for line in result.lines] == [(state, "pendulum")]
    assert reason in result.lines[0].reason and reason in result.to_text()
    assert result.passed is (state == "refused")
    page = reading.text_of(html(tmp_path)["pendulum/index.html"])
    assert reason in page
    assert json.loads(json.dumps(result.to_json()))["measurements"][0]["state"] == state
    put("validation", "validation")  # and it is tried again
    assert [line.state for line in build_site([small("pendulum")], tmp_path, VALIDATION).lines] == ["measured"]


def test_a_refusal_leaves_what_was_measured(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    build(tmp_path, small("pendulum"))
    before = html(tmp_path)
    put("validation", "without_tool")
    assert build(tmp_path, small("pendulum"), settings=Settings(("validation",), fresh=True)) == {
        "refused": ["pendulum/Validation"]
    }
    assert html(tmp_path) == before


def test_an_interrupt_leaves_pages_of_what_there_is(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    put("motion", "sleeping")

    def progress(_done: int, _total: int, what: str) -> None:
        if what == "pendulum: motion":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build_site([small("pendulum")], tmp_path, Settings(("validation", "motion")), progress)
    assert "✓ two checks passed" in html(tmp_path)["index.html"]


def test_an_interrupt_says_where_the_pages_are(
    put: Put, small: Small, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And makes no index where there is none."""

    def interrupted(*_given: object) -> None:
        raise KeyboardInterrupt

    put("validation", "validation")
    arguments = ["report", str(small("pendulum")), "-o", str(tmp_path), "--with", "validation"]
    with monkeypatch.context() as patch:
        patch.setattr("symgen.site.tasks.run", interrupted)
        assert cli.run(arguments) == 130
        assert capsys.readouterr().err.strip() == "symgen: interrupted"
        assert html(tmp_path) == {}
    assert cli.run(arguments) == 0
    capsys.readouterr()
    monkeypatch.setattr("symgen.site.tasks.run", interrupted)
    assert cli.run(arguments) == 130
    told = capsys.readouterr().err.strip()
    assert told == f"symgen: interrupted; pages of what there is: {tmp_path / 'index.html'}"
    assert reading.broken_links(tmp_path) == []
    assert [card.measured for card in read_cards(tmp_path)] == [("validation",)]


def test_damaged_data_are_measured_again(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    build(tmp_path, small("pendulum"))
    for damage in ("{", '{"format": 99}', '{"format": 1, "id": 3}'):
        (tmp_path / "data/pendulum/validation.json").write_text(damage, encoding="utf-8")
        (tmp_path / "data/pendulum/card.json").write_text(damage, encoding="utf-8")
        assert build(tmp_path, small("pendulum")) == {"measured": ["pendulum/Validation"]}


def test_data_of_another_form_do_not_stop_a_page(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    build(tmp_path, small("pendulum"))
    stored = tmp_path / "data/pendulum/validation.json"
    data = json.loads(stored.read_text(encoding="utf-8"))
    del data["data"]["rows"]
    stored.write_text(json.dumps(data), encoding="utf-8")
    assert not build_site([small("pendulum")], tmp_path, NOTHING).passed
    assert "--fresh measures again" in reading.text_of(html(tmp_path)["pendulum/index.html"])
    assert build(tmp_path, small("pendulum")) == {"measured": ["pendulum/Validation"]}
    assert "✓ two checks passed" in html(tmp_path)["index.html"]


def test_pages_about_no_one_scene(put: Put, small: Small, tmp_path: Path) -> None:
    put("validation", "validation")
    put("hard", "hard", of_scenes=False)
    wanted = Settings(("validation", "hard"), jobs=2)
    assert build(tmp_path, small("one"), settings=wanted) == {"measured": ["one/Validation", "/Hard cases"]}
    texts = html(tmp_path)
    assert "Hard cases ✓ 3 checks passed" in reading.text_of(texts["index.html"])
    for name in ("index.html", "hard.html", "one/index.html"):
        assert "hard.html" in texts[name] and reading.broken_links(tmp_path) == []
    assert build(tmp_path, small("one"), settings=wanted) == {"stored": ["one/Validation", "/Hard cases"]}
    put("hard", "harder", of_scenes=False)
    again = build_site([small("one")], tmp_path, Settings(("hard",), fresh=True))
    assert not again.passed and again.failures == ("hard cases: 1 of 2 checks failed",)
    assert "Checks failed in Hard cases" in reading.text_of(html(tmp_path)["index.html"])
    put("hard", "breaking", of_scenes=False)
    (tmp_path / "data/hard.json").unlink()
    assert not build_site([small("one")], tmp_path, Settings(("hard",))).passed
    assert "hard.html" not in html(tmp_path) and "hard.html" not in html(tmp_path)["one/index.html"]


def test_verdicts_are_counted_at_the_leaves() -> None:
    right, wrong, beside = {"passed": True, "allowed": 3.0}, {"passed": False}, {"passed": False, "allowed": None}
    assert verdicts([]) == verdicts({"a": 1, "b": "passed"}) == verdicts(beside) == (0, 0)
    assert verdicts([right, wrong, {"passed": False, "rows": [right, right]}]) == (4, 1)
    assert verdicts({"passed": True, "cases": [{"findings": [right, beside, wrong]}]}) == (2, 1)


def test_numbers_at_a_glance_are_plain() -> None:
    shown = [glance._digits(x, 2) for x in (0.79, 1.0, 1.96, 12.4, 187.0, 1870.0)]
    assert shown == ["0.79", "1.0", "2.0", "12", "187", "1870"]
    assert [glance._digits(x, 3) for x in (4.0, 17.0, 123.4)] == ["4.00", "17.0", "123"]


def test_another_simulator_is_measured_with_anew(
    put: Put, small: Small, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was measured without it stays shown, and says so."""
    put("validation", "without_pinocchio", tools=("pin",))
    monkeypatch.setattr(tools, "_version", lambda package: tools.ABSENT)
    here, scene = ["pendulum/Validation"], small("pendulum")
    assert build(tmp_path, scene) == {"measured": here}
    told = build_site([scene], tmp_path, VALIDATION)
    assert [line.state for line in told.lines] == ["stored"]
    assert "checks passed, Pinocchio not installed" in told.to_text()
    assert "checks passed, Pinocchio not installed" in reading.text_of(html(tmp_path)["index.html"])
    monkeypatch.setattr(tools, "_version", lambda package: "4.1.0")
    assert build(tmp_path, scene, settings=NOTHING) == {}
    assert "Pinocchio not installed" in html(tmp_path)["index.html"]
    put("validation", "validation", tools=("pin",))
    assert build(tmp_path, scene) == {"measured": here}
    assert "Pinocchio not installed" not in html(tmp_path)["index.html"]


def test_versions_are_of_what_is_installed() -> None:
    asked = {package for row in MEASURES.values() for package in row.tools}
    assert asked <= set(tools.MODULES)
    assert tools._version("sympy") == importlib.metadata.version("sympy")
    peers = {peer.package for peer in registry.PEERS}
    assert peers <= set(MEASURES["speed"].tools)
