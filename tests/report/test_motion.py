"""The motion in a page: the data are a motion of the mechanism, and the page plays them."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symgen.errors import NotSupportedError, SceneError
from symgen.report.measured import motion as section
from symgen.report.mechanism import draw
from symgen.report.page import write_report
from symgen.report.player import STILLS, player
from symgen.scene.load import load
from symgen.simulate import motion_data
from symgen.system import derive
from tests.report import pages

ROOT = Path(__file__).resolve().parents[2]


@cache
def data(name: str) -> dict[str, Any]:
    return motion_data(load(ROOT / f"examples/{name}.scene.yaml"), lambda _: None, seconds=4.0, frames=60)


def rotation(x: float, y: float, z: float, w: float) -> np.ndarray:
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_bodies_are_where_the_angles_put_them() -> None:
    found = data("double_pendulum")
    assert len(found["times"]) == len(found["poses"]) == len(found["q"]) == 60 and found["times"][-1] == 4.0
    for (first, second), row in zip(found["q"], found["poses"], strict=True):
        upper, lower = np.array(row[:7]), np.array(row[7:])
        assert np.allclose(upper[:3], 0)
        assert np.allclose(rotation(*upper[3:]) @ [0, 0, -1], [-math.sin(first), 0, -math.cos(first)], atol=1e-4)
        elbow = rotation(*upper[3:]) @ [0, 0, -1]
        assert np.allclose(lower[:3], elbow, atol=1e-4)
        assert np.allclose(
            rotation(*lower[3:]) @ [0, 0, -1], [-math.sin(first + second), 0, -math.cos(first + second)], atol=1e-4
        )


def test_energy_stays_and_something_happens() -> None:
    found = data("double_pendulum")
    total = np.array(found["kinetic"]) + np.array(found["potential"])
    assert found["conservative"] and np.ptp(total) < 1e-3 * max(found["kinetic"])
    assert found["monitors"]["energy_drift"] < 1e-6
    assert np.ptp(np.array(found["q"]), axis=0).min() > 0.5


@pytest.mark.parametrize("name", ["spinning_top", "slope_body"])
def test_quaternions_are_of_unit_length_and_do_not_jump(name: str) -> None:
    poses = np.array(data(name)["poses"]).reshape(len(data(name)["times"]), -1, 7)
    turns = poses[:, :, 3:]
    assert np.allclose(np.linalg.norm(turns, axis=2), 1, atol=1e-4)
    assert np.all(np.sum(turns[1:] * turns[:-1], axis=2) > 0.4), "two frames are more than 2.4 rad apart"


def test_a_top_precesses_and_does_not_fall() -> None:
    found = data("spinning_top")
    axes = np.array([rotation(*row[3:7])[:, 2] for row in found["poses"]])
    tilt, azimuth = np.arccos(axes[:, 2]), np.unwrap(np.arctan2(axes[:, 1], axes[:, 0]))
    assert tilt.max() < 0.8 and abs(azimuth[-1] - azimuth[0]) > 1.0


def test_what_slides_is_thrown_and_comes_back() -> None:
    found = data("slope_body")
    x = [row[0] for row in found["q"]]
    assert x[0] == 0 and abs(x[-1]) < 1e-3 and min(x) < -0.02, "with constant acceleration it is back at the end"


def test_the_data_are_small_and_always_the_same() -> None:
    scene = load(ROOT / "examples/pendulum.scene.yaml")
    first, second = (motion_data(scene, lambda _: None, seconds=1.0) for _ in range(2))
    assert json.dumps(first) == json.dumps(second)
    assert len(json.dumps(first)) < 40_000


def test_refusals() -> None:
    with pytest.raises(NotSupportedError):
        motion_data(load(ROOT / "examples/four_bar.scene.yaml"), lambda _: None)
    with pytest.raises(SceneError):
        motion_data(load(ROOT / "examples/pendulum.scene.yaml"), lambda _: None, seconds=0.0)


def test_the_page_has_player_stills_and_curves(tmp_path: Path) -> None:
    scene = load(ROOT / "examples/double_pendulum.scene.yaml")
    write_report(tmp_path / "page.html", scene, measured={"motion": data("double_pendulum")})
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    seen = pages.read_html(page)
    assert seen.wrong == [] and seen.open == [] and len(seen.ids) == len(set(seen.ids))
    pages.read_xml(page)
    told = json.loads(re.findall(r'id="motion-data">(.*?)</script>', page, re.S)[0])
    assert len(told["frames"]) == 60 and len(told["corners"]) == 2
    assert page.count('class="still"') == STILLS and page.count('class="cursor"') == 2
    assert "autoplay" not in page and "the frame tip" in page
    write_report(tmp_path / "without.html", scene)
    assert "motion-data" not in (tmp_path / "without.html").read_text(encoding="utf-8")


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    scene = pages.hostile_scene()
    found = motion_data(scene, lambda _: None, seconds=1.0, frames=10)
    write_report(tmp_path / "page.html", scene, measured={"motion": found})
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    seen = pages.read_html(page)
    assert seen.wrong == [] and seen.open == []
    assert "img" not in {tag for tag, _, _ in seen.attributes}
    assert f"arm{pages.HOSTILE}" in "".join(seen.text)


def test_stills_show_different_places() -> None:
    scene = derive(load(ROOT / "examples/pendulum.scene.yaml"))
    made = player(draw(scene), data("pendulum"), 1.0)
    assert len(made.stills) == STILLS and len({str(still.picture) for still in made.stills}) == STILLS
    assert made.points
    numbers = [float(x) for x in re.findall(r"[ML ](-?\d+\.?\d*) ", str(made.stills[0].picture))]
    assert numbers and min(numbers) >= 0 and max(numbers) <= 220


def test_many_coordinates_are_not_all_drawn() -> None:
    one = data("pendulum")
    many = {
        **one,
        "joints": [{"name": f"j{k}", "type": "revolute", "q": [k, 1], "v": [k, 1]} for k in range(30)],
        "q": [[row[0]] * 30 for row in one["q"]],
    }
    values = section.values(many)
    assert len(values["panels"]) == 7 and "six coordinates more" in str(values["hidden"])  # type: ignore[arg-type]


CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome") or ""


@pytest.mark.slow
@pytest.mark.skipif(not CHROMIUM, reason="no Chromium")
def test_it_plays(tmp_path: Path) -> None:
    """Nothing moves by itself; play, pause, keys and the time slider do what they say; the curves' cursor follows."""
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    scene = load(ROOT / "examples/double_pendulum.scene.yaml")
    write_report(tmp_path / "page.html", scene, measured={"motion": data("double_pendulum")})
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"] if os.geteuid() == 0 else [])
        page = browser.new_page(viewport={"width": 400, "height": 900})
        said: list[str] = []
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto((tmp_path / "page.html").as_uri())
        drawn = (
            "() => [...document.querySelectorAll('#motion-drawing .solids path')].map(e => e.getAttribute('d')).join()"
        )
        moves = f"before => ({drawn})() !== before"
        page.wait_for_function(f"({drawn})() !== ''")
        before = page.evaluate(drawn)
        page.wait_for_timeout(300)
        assert page.evaluate(drawn) == before, "it moves by itself"
        page.click("#motion-play")
        page.wait_for_function(moves, arg=before, timeout=20_000)
        assert page.text_content("#motion-play") == "Pause"
        page.focus("#motion-drawing svg")
        page.keyboard.press("Space")
        assert page.text_content("#motion-play") == "Play"
        page.fill("#motion-time", "2")
        assert str(page.text_content("#motion-readout")).startswith("2.00")
        assert page.get_attribute("#motion .cursor >> nth=0", "transform") != "translate(0.0 0)"
        at_two = page.evaluate(drawn)
        page.focus("#motion-drawing svg")
        page.keyboard.press("ArrowLeft")
        page.wait_for_function(moves, arg=at_two, timeout=20_000)
        page.click(".still button >> nth=0")
        assert str(page.text_content("#motion-readout")).startswith("0.00")
        assert said == [] and page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        browser.close()


def test_what_is_said_of_the_start_is_true() -> None:
    """Where a limit holds a joint, it does not hang at rest."""
    found = data("payload")
    assert "lift is at a limit there" in found["start"] and "hang at rest" not in found["start"]
    assert "hang at rest" in data("double_pendulum")["start"]
    said = str(section.values(found)["energy"])
    assert said.startswith("Dampers take energy away") and " J to " in said
    assert "of their size" in str(section.values(data("double_pendulum"))["energy"])


def test_points_whose_path_is_drawn_have_different_names() -> None:
    points = player(draw(derive(load(ROOT / "examples/payload.scene.yaml"))), data("payload"), 1.0).points
    assert len(points) == len(set(points)) > 3
    assert "the frame tool" in points and "the joint elbow" in points
