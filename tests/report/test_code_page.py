"""The page of the code: every function whole and as it is in the file, every link there and back, nothing unescaped."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from symgen.generate import generate
from symgen.report.c_source import Source, code, definition
from symgen.report.code_page import code_page, linker, option_words
from symgen.report.highlight import highlighted
from symgen.report.page import write_report
from symgen.report.phases import PHASES, split_heading
from symgen.report.shell import ALONE
from symgen.scene.load import load
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request
from symgen.system import derive
from tests.report import pages

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module", params=["gripper", pytest.param("double_pendulum", marks=pytest.mark.slow)])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A scene's code, the page of it, and the page of the scene."""
    folder = tmp_path_factory.mktemp("code")
    system = derive(load(ROOT / f"examples/{request.param}.scene.yaml"))
    artifact = generate(system.scene, folder / "artifact", system=system)
    page = code_page(system, artifact.directory, artifact.manifest, ALONE, "index.html")
    write_report(folder / "index.html", system.scene, artifact=artifact, code_href="code.html")
    book = (folder / "index.html").read_text(encoding="utf-8")
    return {"page": page, "book": book, "manifest": artifact.manifest, "directory": artifact.directory}


def listings(page: str) -> list[tuple[int, str]]:
    """(number of the first line, text) of every listing."""
    found = []
    for first, text in re.findall(r'<pre class="listing"[^>]*--from:(\d+)"><code>(.*?)</code></pre>', page, re.S):
        plain = re.sub(r"<[^>]*>", "", text)
        for escaped, sign in (("&lt;", "<"), ("&gt;", ">"), ("&#34;", '"'), ("&#39;", "'"), ("&amp;", "&")):
            plain = plain.replace(escaped, sign)
        found.append((int(first) + 1, plain))
    return found


def test_well_formed(made: dict[str, Any]) -> None:
    seen = pages.read_html(made["page"])
    assert seen.wrong == [] and seen.open == [] and len(seen.ids) == len(set(seen.ids))
    pages.read_xml(made["page"])


def test_every_line_of_every_file_is_there(made: dict[str, Any]) -> None:
    """Listings are cut from the files as they are, and together they are the files, but for blank lines."""
    files = [*made["manifest"]["headers"], *made["manifest"]["sources"]]
    wanted = {name: (made["directory"] / name).read_text(encoding="utf-8").split("\n") for name in files}
    missing = {(name, k) for name, lines in wanted.items() for k, line in enumerate(lines) if line.strip()}
    for first, text in listings(made["page"]):
        lines = text.split("\n")
        name = next(n for n, own in wanted.items() if own[first - 1 : first - 1 + len(lines)] == lines)
        missing -= {(name, first - 1 + k) for k in range(len(lines))}
    assert not missing


def test_links_go_there_and_back(made: dict[str, Any]) -> None:
    page, book = pages.read_html(made["page"]), pages.read_html(made["book"])
    names = {row["name"] for row in made["manifest"]["functions"]}
    assert {f"f-{name}" for name in names} <= set(page.ids) and {f"def-{name}" for name in names} <= set(book.ids)
    links = {value for tag, attribute, value in page.attributes if (tag, attribute) == ("a", "href")}
    there = {value for tag, attribute, value in book.attributes if (tag, attribute) == ("a", "href")}
    for link in links:
        file, _, place = link.partition("#")
        assert file in ("", "index.html") and place in set(book.ids if file else page.ids), link
    assert {f"index.html#def-{name}" for name in names} <= links
    for link in there:
        file, _, place = link.partition("#")
        assert file in ("", "code.html") and (not place or place in set(page.ids if file else book.ids)), link
    assert {f"code.html#f-{name}" for name in names} <= there
    assert 'class="listing"' not in made["book"], "the code stands on its own page"


def test_what_is_proven_is_said(made: dict[str, Any]) -> None:
    text = " ".join("".join(pages.read_html(made["page"]).text).split())
    for row in made["manifest"]["functions"]:
        assert row["certificate"]["checked_against"] in text and row["plan"] in text
    assert made["manifest"]["scene_sha256"] in text and made["manifest"]["symgen"] in text
    assert "cc -std=c99 -O3" in text and "0BSD" in text


def test_same_page_again(made: dict[str, Any]) -> None:
    system = derive(load(ROOT / f"examples/{made['manifest']['name']}.scene.yaml"))
    assert code_page(system, made["directory"], made["manifest"], ALONE, "index.html") == made["page"]


@pytest.mark.slow
def test_every_phase_is_explained(tmp_path: Path) -> None:
    """Of all rows of the catalogue, for a tree that floats, with springs."""
    rows = "coriolis_matrix,gravity_force,forward_dynamics,mass_matrix_inverse,inverse_dynamics_derivatives,"
    rows += "forward_dynamics_derivatives,center_of_mass,momentum,momentum_matrix,regressor,joint_wrenches,"
    rows += "constraint_forces,frame_pose:foot,frame_jacobian:foot,frame_velocity:foot,jvp:mass_matrix,vjp:bias_force"
    scene = request(load(ROOT / "examples/fig2.scene.yaml"), parse_outputs(rows), None, ("c",))
    artifact = generate(scene, tmp_path / "artifact")
    headings = set()
    for source in code(artifact.directory, artifact.manifest).functions.values():
        headings |= {heading.text for heading in source.headings() if not heading.text.endswith(".")}
    unknown = {heading for heading in headings if split_heading(heading)[0] not in PHASES}
    assert not unknown and len(headings) > 40


def test_headings_are_taken_apart() -> None:
    assert split_heading("composite inertia: lower") == ("composite inertia", "lower")
    assert split_heading("mass matrix: columns of a of b") == ("mass matrix: columns", "a of b")
    assert split_heading("derivatives by velocity: columns and rows of x: y")[1] == "x: y"
    assert split_heading("factor: LᵀDL") == ("factor: LᵀDL", "")
    assert split_heading("something new: x")[0] not in PHASES


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    system = derive(pages.hostile_scene())
    artifact = generate(system.scene, tmp_path / "artifact", system=system)
    page = code_page(system, artifact.directory, artifact.manifest, ALONE, "index.html")
    seen = pages.read_html(page)
    assert seen.wrong == [] and seen.open == [] and f"file{pages.HOSTILE}.yaml" in "".join(seen.text)
    assert "img" not in {tag for tag, _, _ in seen.attributes}
    assert not any(name.startswith("on") for _, name, _ in seen.attributes)


@pytest.mark.parametrize("target", ["casadi", "cuda"])
def test_other_targets_have_a_page(target: str, tmp_path: Path) -> None:
    scene = load(ROOT / "examples/pendulum.scene.yaml")
    system = derive(request(scene, parse_outputs("mass_matrix,step:rk4"), None, (target,)))
    artifact = generate(system.scene, tmp_path / "artifact", system=system)
    page = code_page(system, artifact.directory, artifact.manifest, ALONE, "index.html")
    text = " ".join("".join(pages.read_html(page).text).split())
    assert "No C was asked for" in text and "mass_matrix" in text


HOSTILE = """/* </pre><script>alert(1)</script> & "x" */
#include "a<b>.h" /* <i> */
static const char *s = "<b>\\"&"; /* two
   lines <u> */
double f(double cos_q0, const double q[2]) { return q[0] < 1.5e-3 && cos_q0 > 0x1Fu ? 1 : .5; }"""


def test_code_stays_text() -> None:
    source = Source("x.c", 11, tuple(HOSTILE.split("\n")))
    joints = [{"name": "a<b>", "q": [0, 1], "v": [0, 1]}, {"name": "c", "q": [1, 1], "v": [1, 1]}]
    listing = highlighted(source, linker({"joints": joints, "functions": []}, "book.html"))
    ((first, text),) = listings(str(listing))
    assert first == 11 and text == HOSTILE
    seen = pages.read_html(str(listing))
    assert seen.wrong == [] and seen.open == []
    assert {tag for tag, _, _ in seen.attributes} == {"pre", "span", "a", "b"}
    links = [(tag, value) for tag, attribute, value in seen.attributes if attribute in ("href", "title")]
    assert ("a", "book.html#joint-1") in links and ("a", "cosine of a<b>") in links
    assert all(line.count("<b ") == line.count("</b>") for line in str(listing).split("\n"))


def test_what_switches_for_a_function_stands_with_it(made: dict[str, Any]) -> None:
    """A macro before and one after a function: no bare line of them is a piece between the functions."""
    for _, text in listings(made["page"]):
        assert text.strip() not in ("SYMGEN_PAIRED", "SYMGEN_UNPAIRED")


def test_a_macro_behind_a_function_is_its_own() -> None:
    lines = ("/* What it is. */", "SWITCHED_OFF", "void f(void)", "{", "}", "SWITCHED_ON", "", "void g(void)", "{", "}")
    found = definition(Source("x.c", 1, lines), "f")
    assert found is not None and found.lines == lines[:6]
    found = definition(Source("x.c", 1, lines), "g")
    assert found is not None and found.lines == lines[7:]


def test_options_are_words() -> None:
    for name, value in (("code", None), ("batch", False), ("status", True), ("snap", "1e-06"), ("targets", ["c"])):
        text = option_words(name, value)
        assert text not in ("None", "False", "True") and "e-" not in text
