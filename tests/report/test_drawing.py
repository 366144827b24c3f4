"""The drawing: every joint type has a symbol, bodies stand where the kinematics puts them, the script agrees."""

from __future__ import annotations

import html
import json
import math
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from defusedxml.ElementTree import fromstring

from symgen.report import camera
from symgen.report.drawing import Frame
from symgen.report.joint_symbols import SYMBOLS
from symgen.report.live import drawing_json
from symgen.report.mechanism import draw
from symgen.report.page import write_report
from symgen.report.picture import write_drawing
from symgen.report.rank import constraint_rank, rank
from symgen.report.topology_graph import topology_graph
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.load import load
from symgen.system import System, derive

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted(path.name.removesuffix(".scene.yaml") for path in ROOT.glob("examples/*.scene.yaml"))


def system(name: str) -> System:
    return derive(load(ROOT / f"examples/{name}.scene.yaml"))


def _turn(axis: tuple[float, ...], angle: float) -> np.ndarray:
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * skew + (1 - math.cos(angle)) * skew @ skew


def _pose(frames: tuple[Frame, ...], frame: Frame, values: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """What the script computes: a frame's pose from its sliders."""
    parent = (np.eye(3), np.zeros(3)) if frame.parent < 0 else _pose(frames, frames[frame.parent], values)
    rotation = parent[0] @ np.array(frame.origin_rotation)
    position = parent[1] + parent[0] @ np.array(frame.origin)
    if not frame.motions:
        return np.array(frame.rotation), np.array(frame.position)
    for motion in frame.motions:
        value = values[motion.slider] * motion.factor + motion.offset
        if motion.kind == "turn":
            rotation = rotation @ _turn(motion.axis, value)
        else:
            position = position + rotation @ (np.array(motion.axis) * value)
    return rotation, position


def test_every_joint_type_has_a_symbol() -> None:
    assert set(SYMBOLS) == set(JOINT_TYPES)


@pytest.mark.parametrize("name", EXAMPLES)
def test_sliders_start_where_the_kinematics_puts_the_bodies(name: str) -> None:
    drawing = draw(system(name))
    values = [slider.value for slider in drawing.sliders]
    for frame in drawing.frames:
        rotation, position = _pose(drawing.frames, frame, values)
        assert np.allclose(rotation, frame.rotation, atol=1e-5)
        assert np.allclose(position, frame.position, atol=1e-5 * max(1.0, drawing.radius))


@pytest.mark.parametrize("name", EXAMPLES)
def test_everything_is_in_the_picture(name: str) -> None:
    drawing = draw(system(name))
    picture = str(camera.render(drawing))
    assert len(picture) < 100_000
    numbers = [float(x) for d in re.findall(r' d="([^"]*)"', picture) for x in re.findall(r"-?\d+\.?\d*", d)]
    assert numbers and min(numbers) > -20 and max(numbers) < camera.WIDTH + 20
    labels = {label.text for label in drawing.labels}
    points = {e.label for e in system(name).natural.entities if e.kind != "angle"}
    assert points <= labels
    json.loads(str(drawing_json(drawing)))


def test_a_drawing_of_its_own(tmp_path: Path) -> None:
    picture = write_drawing(tmp_path / "a" / "fig1.svg", load(ROOT / "examples/fig1.scene.yaml")).read_text(
        encoding="utf-8"
    )
    root = fromstring(picture)
    assert root.tag == "{http://www.w3.org/2000/svg}svg" and root.get("aria-label")
    assert "prefers-color-scheme:dark" in picture and len(picture) < 60_000


SPRUNG = """
name: sprung
bodies:
  - {name: bob, mass: 0.5, com: [0, 0, -0.5], inertia: [0.01, 0.01, 0.001, 0, 0, 0]}
joints:
  - {name: swing, type: revolute, parent: ground, child: bob, axis: [0, 1, 0]}
forces:
  - {type: spring, name: s1, between: [bob, ground], points: [[0, 0, -0.5], [1, 0, 0]], stiffness: 10, length: 0.5}
parameters: [bob.mass, s1.stiffness]
outputs: [mass_matrix]
"""


def test_springs_join_their_points(tmp_path: Path) -> None:
    (tmp_path / "sprung.scene.yaml").write_text(SPRUNG, encoding="utf-8")
    scene = load(tmp_path / "sprung.scene.yaml")
    drawing = draw(derive(scene))
    (spring,) = (shape for shape in drawing.shapes if shape.kind == "spring")
    ends = camera.shape_points(drawing, spring)
    angle = drawing.sliders[0].value
    assert np.allclose(ends, [[-0.5 * math.sin(angle), 0, -0.5 * math.cos(angle)], [1, 0, 0]], atol=1e-5)
    write_report(tmp_path / "page.html", scene)
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert (
        "line spring" in page and "bob.mass" in page and "joins (0, 0, −0.5) m of bob".replace(", ", ",\u00a0") in page
    )


def test_cut_joints_are_dashed_and_red() -> None:
    picture = str(topology_graph(system("four_bar")))
    assert picture.count('class="edge cut"') == 1 and "c (R), cut" in picture
    assert any(shape.colour == "#c63d3d" for shape in draw(system("four_bar")).shapes)


@pytest.mark.parametrize("name", ["fig1", "fig2", "screw_drive", "slope_body", "universal_shaft"])
def test_nullity_is_the_number_of_degrees_of_freedom(name: str) -> None:
    derived = system(name)
    assert derived.natural.nn - constraint_rank(derived) == derived.tree.nv


def test_rank() -> None:
    assert rank([[1, 2, 3], [2, 4, 6], [0, 1, 1]], 2**61 - 1) == 2
    assert rank([[0, 0], [0, 0]], 2**61 - 1) == 0
    assert rank([], 2**61 - 1) == 0


def _chromium() -> str:
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome") or ""


PROBE = """
const run = async () => {
  const inner = document.querySelector("iframe").contentDocument, svg = inner.querySelector("#mechanism-drawing svg");
  const paths = () => [...svg.querySelectorAll(".solids>path")].map(e => e.getAttribute("d"));
  const changed = async old => {
    for (let k = 0; k < 200 && paths().join() === old.join(); k++) await new Promise(done => setTimeout(done, 50));
    return paths();
  };
  const found = {before: paths()};
  found.wide = inner.documentElement.scrollWidth - inner.documentElement.clientWidth;
  found.sliders = inner.querySelectorAll("#mechanism-controls input").length;
  svg.dispatchEvent(new KeyboardEvent("keydown", {key: "ArrowLeft"}));
  found.turned = await changed(found.before);
  inner.querySelector("#mechanism-controls button").click();
  found.back = await changed(found.turned);
  document.title = JSON.stringify(found);
};
document.querySelector("iframe").addEventListener("load", run);
"""


def _outline(path: str) -> list[float]:
    return [float(x) for x in re.findall(r"-?\d+\.?\d*", path)]


def _distance(path: str, others: list[list[float]]) -> float:
    """How far the corners of the most similar path are, in pixels."""
    mine = _outline(path)
    same = [other for other in others if len(other) == len(mine)]
    return min((max(abs(x - y) for x, y in zip(mine, other, strict=True)) for other in same), default=math.inf)


@pytest.mark.skipif(not _chromium(), reason="no Chromium")
@pytest.mark.parametrize(
    "name",
    [
        "universal_shaft",
        pytest.param("pendulum", marks=pytest.mark.slow),
        pytest.param("four_bar", marks=pytest.mark.slow),
    ],
)
def test_in_a_browser(name: str, tmp_path: Path) -> None:
    """In 400 pixels nothing sticks out sideways, the drawing turns, and coming back it is the picture of the file."""
    write_report(tmp_path / "page.html", load(ROOT / f"examples/{name}.scene.yaml"))
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    wrapper = tmp_path / "wrapper.html"
    frame = f'<iframe width="400" height="900" srcdoc="{html.escape(page)}"></iframe>'
    wrapper.write_text(f"<!doctype html><meta charset=utf-8><body>{frame}<script>{PROBE}</script>", encoding="utf-8")
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--dump-dom"]
    flags += ["--disable-background-networking", "--disable-component-update", "--disable-sync"]
    command = [_chromium(), *flags, "--virtual-time-budget=20000", f"--user-data-dir={tmp_path / 'profile'}"]
    shown = subprocess.run([*command, wrapper.as_uri()], check=True, capture_output=True, text=True, timeout=120)
    title = re.search(r"<title>(.*?)</title>", shown.stdout)
    assert title is not None, "the probe did not finish"
    found = json.loads(html.unescape(title[1]))
    assert found["wide"] <= 0, "the page scrolls sideways"
    assert found["sliders"] == len(draw(system(name)).sliders)
    back, turned = ([_outline(path) for path in found[key]] for key in ("back", "turned"))
    assert len(back) == len(found["before"])
    assert max(_distance(path, back) for path in found["before"]) < 0.35
    assert max(_distance(path, turned) for path in found["before"]) > 2
