"""Reports: well formed, complete, self-contained, the same bytes every time, safe with any name."""

from __future__ import annotations

import itertools
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import pytest

from symgen.errors import SceneError
from symgen.report import write_index, write_report
from symgen.report.page import OF_FUNCTIONS, SECTIONS
from symgen.report.tables import bound, scientific
from symgen.report.topology_graph import topology_graph
from symgen.report.words import introduction, thousands
from symgen.scene.load import load
from symgen.system import derive
from tests.report import pages

ROOT = Path(__file__).resolve().parents[2]


SMALL = ["pendulum", "cart_pole", "spherical_pendulum", "free_body", "screw_drive", "slope_body", "four_bar"]


def example(name: str) -> Path:
    return ROOT / f"examples/{name}.scene.yaml"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Pages of small scenes; the pendulum's with a validation."""
    folder = tmp_path_factory.mktemp("reports")
    found = {}
    for name in SMALL:
        scene = load(example(name))
        write_report(folder / f"{name}.html", scene, pages.result_for(scene) if name == "pendulum" else None)
        found[name] = (folder / f"{name}.html").read_text(encoding="utf-8")
    return found


@pytest.mark.parametrize("name", SMALL)
def test_well_formed(made: dict[str, str], name: str) -> None:
    seen = pages.read_html(made[name])
    assert seen.wrong == [] and seen.open == []
    assert len(seen.ids) == len(set(seen.ids))
    root = pages.read_xml(made[name])
    assert root.get("lang") == "en"
    assert len(list(root.iter("h1"))) == 1 and len(list(root.iter("main"))) == 1


@pytest.mark.parametrize("name", SMALL)
def test_every_section_is_there_and_linked(made: dict[str, str], name: str) -> None:
    root = pages.read_xml(made[name])
    sections = {section.get("id"): section for section in root.iter("section")}
    links = {a.get("href") for a in root.iter("a")}
    assert name != "four_bar" or not set(OF_FUNCTIONS) & set(sections)
    for id, title in [row for row in SECTIONS if name != "four_bar" or row[0] not in OF_FUNCTIONS]:
        heading = sections[id].find("h2")
        assert heading is not None and heading.text == title
        assert len("".join(sections[id].itertext()).split()) > 3, f"{id} is empty"
        assert f"#{id}" in links


@pytest.mark.parametrize("name", SMALL)
def test_nothing_comes_from_outside(made: dict[str, str], name: str) -> None:
    seen = pages.read_html(made[name])
    for tag, attribute, value in seen.attributes:
        if attribute in ("src", "srcset", "data", "action", "background", "poster") or (tag, attribute) == (
            "link",
            "href",
        ):
            raise AssertionError(f"<{tag} {attribute}={value}>")
        if attribute == "href":
            assert value.startswith("#")
        assert not attribute.startswith("on"), f"<{tag} {attribute}>"
    without_namespaces = re.sub(r'xmlns="[^"]*"', "", made[name])
    without_namespaces = re.sub(r'const NS = "[^"]*"', "", without_namespaces)
    assert not re.search(r"https?://|@import|url\(", without_namespaces)
    assert "Content-Security-Policy" in made[name]


@pytest.mark.parametrize("name", SMALL)
def test_accessible(made: dict[str, str], name: str) -> None:
    """Pictures have names, tables have captions and scopes, what scrolls can be focused."""
    root = pages.read_xml(made[name])
    drawings = [svg for svg in root.iter("{http://www.w3.org/2000/svg}svg") if svg.get("aria-hidden") != "true"]
    assert drawings
    for svg in drawings:
        assert svg.get("role") == "img" and svg.get("aria-label")
    for table in root.iter("table"):
        assert table.find("caption") is not None
        assert all(th.get("scope") for th in table.iter("th"))
    for box in root.iter("div"):
        if "scroll" in (box.get("class") or "").split():
            assert box.get("tabindex") == "0" and box.get("aria-label")


def test_same_bytes(tmp_path: Path) -> None:
    """In another process with another hash seed too; nothing of this machine is in it."""
    code = "import sys; from symgen.report import write_report; from symgen.scene.load import load; "
    code += "write_report(sys.argv[2], load(sys.argv[1]))"
    pages_made = []
    for seed in ("1", "2"):
        target = tmp_path / seed / "page.html"
        environment = {"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
        command = [sys.executable, "-c", code, str(example("pendulum")), str(target)]
        subprocess.run(command, check=True, env=environment, cwd=tmp_path)
        pages_made.append(target.read_bytes())
    assert pages_made[0] == pages_made[1]
    assert str(ROOT).encode() not in pages_made[0] and str(tmp_path).encode() not in pages_made[0]


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    scene = pages.hostile_scene()
    # The generator itself makes identifiers of names; the page must not depend on that.
    entry = write_report(tmp_path / "page.html", scene, pages.result_for(scene))
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    seen = pages.read_html(page)
    tags = {tag for tag, _, _ in seen.attributes}
    assert seen.wrong == [] and seen.open == []
    assert "img" not in tags and not any(name.startswith("on") for _, name, _ in seen.attributes)
    assert pages.HOSTILE in "".join(seen.text)
    pages.read_xml(page)
    data = re.search(r'id="mechanism-data">(.*?)</script>', page, re.S)
    assert data is not None
    assert json.loads(data[1])["sliders"][0]["label"] == f"swing{pages.HOSTILE}"
    index = write_index(tmp_path / "index.html", [entry])
    assert "img" not in {tag for tag, _, _ in pages.read_html(index.read_text(encoding="utf-8")).attributes}


def test_validation_is_shown(made: dict[str, str], tmp_path: Path) -> None:
    text = "".join(pages.read_html(made["pendulum"]).text)
    for shown in ("✓ pass", "same state", "bias_force <b>", "the simulator has no such joint & says so", "order 4"):
        assert shown in text
    assert "observed order 3.98 (expected 4)" in text and "observed order not observable" in text
    assert "✗" not in text
    scene = load(example("pendulum"))
    entry = write_report(tmp_path / "failed.html", scene, pages.result_for(scene, failing=True))
    failed = "".join(pages.read_html((tmp_path / "failed.html").read_text(encoding="utf-8")).text)
    assert "✗ fail" in failed and "not a number" in failed and "✗ 1 of 3 checks failed" in failed
    assert entry.passed is False


def test_facts_are_those_of_the_scene(made: dict[str, str]) -> None:
    text = " ".join("".join(pages.read_html(made["cart_pole"]).text).split())
    assert "planar chain of rigid bodies: two moving bodies, two joints" in text
    loops = derive(load(example("four_bar")))
    assert introduction(loops)[0].endswith("four joints that move (one of them closes a loop), one fixed one.")
    payload = introduction(derive(load(example("payload"))))[0]
    assert payload.endswith("three moving bodies, three joints that move, five fixed ones.")
    assert re.search(r"nullity is \d+ − \d+ = 2, equal to the number of degrees of freedom, 2", text)
    pendulum = " ".join("".join(pages.read_html(made["pendulum"]).text).split())
    assert "2 natural coordinates x satisfy 1 constraint Ψ(x) = 0" in pendulum
    assert "<math" in made["cart_pole"] and "cart_pole_mass_matrix" in text
    assert 'id="f-mass_matrix"' in made["cart_pole"]
    loop = " ".join("".join(pages.read_html(made["four_bar"]).text).split())
    assert "closed loop" in loop and "cut at c" in loop


def test_an_artifact_is_used_as_it_is(tmp_path: Path) -> None:
    from symgen.generate import generate

    scene = load(example("pendulum"))
    artifact = generate(scene, tmp_path / "artifact")
    write_report(tmp_path / "given.html", scene, None, artifact)
    write_report(tmp_path / "made.html", scene)
    assert (tmp_path / "given.html").read_bytes() == (tmp_path / "made.html").read_bytes()


def test_a_page_that_cannot_be_written_is_one_message(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(SceneError, match="cannot write the report"):
        write_report(tmp_path / "file" / "page.html", load(example("pendulum")))


def test_a_long_chain_stays_readable(tmp_path: Path) -> None:
    """Many bodies: no page that explodes, no matrix that nobody reads."""
    lines = ["name: chain", "bodies:"]
    lines += [f"  - {{name: link{k}, mass: 1, com: [0.1, 0, 0], inertia: [0.1, 0.1, 0.1, 0, 0, 0]}}" for k in range(45)]
    lines.append("joints:")
    for k in range(45):
        ends = f"parent: {f'link{k - 1}' if k else 'ground'}, child: link{k}"
        axis = "[0, 0, 1]" if k % 2 else "[0, 1, 0]"
        lines.append(f"  - {{name: joint{k}, type: revolute, {ends}, axis: {axis}, origin: {{xyz: [0.2, 0, 0]}}}}")
    lines.append("outputs: ['frame_pose:link3']")
    (tmp_path / "chain.scene.yaml").write_text("\n".join(lines), encoding="utf-8")
    write_report(tmp_path / "page.html", load(tmp_path / "chain.scene.yaml"))
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "too large to print" in page and "too many to be drawn" in page and len(page) < 1_000_000
    assert pages.read_html(page).wrong == []


def test_index(tmp_path: Path) -> None:
    entries = []
    for name in ("four_bar", "pendulum"):
        scene = load(example(name))
        entries.append(write_report(tmp_path / name / "report.html", scene))
    index = write_index(tmp_path, entries)
    root = pages.read_xml(index.read_text(encoding="utf-8"))
    links = [a.get("href") for a in root.iter("a") if a.get("class") != "skip"]
    assert links == ["four_bar/report.html", "pendulum/report.html"]
    assert all((tmp_path / link).is_file() for link in links if link)
    assert "topology only" in "".join(root.itertext())


def test_trajectories_with_nothing_finite_do_not_break_plots() -> None:
    from symgen.report.plots import Series, line_plot, loglog_plot

    nothing = Series("x", (0.0, 1.0), (math.nan, math.inf))
    assert "svg" in line_plot([nothing], "t", "time", "x", "m")
    assert loglog_plot([nothing], "t", "x", "y") == ""
    assert loglog_plot([], "t", "x", "y") == ""


def test_numbers_have_one_style() -> None:
    """Thousands with narrow spaces from ten thousand on, powers of ten with ×, and no line breaks in either."""
    assert [thousands(x) for x in (999, 2077, 12345, 1234567)] == ["999", "2077", "12\u202f345", "1\u202f234\u202f567"]
    assert scientific(1.6e-12) == "1.6\u00a0×\u00a010⁻¹²" and bound(1e-12) == "10⁻¹²" and scientific(0.0) == "0"
    assert scientific(-5e7) == "−5.0\u00a0×\u00a010⁷"


def test_edges_of_the_graph_run_straight_into_their_bodies() -> None:
    """Beside a label no line slants: every edge is made of level and upright pieces."""
    for name in ("payload", "gripper"):
        for line in re.findall(r'class="edge(?: fixed)?" d="([^"]*)"', topology_graph(derive(load(example(name))))):
            points = [tuple(map(float, pair.split())) for pair in re.findall(r"-?[\d.]+ -?[\d.]+", line)]
            assert len(points) == 4
            assert all(a[0] == b[0] or a[1] == b[1] for a, b in itertools.pairwise(points))
