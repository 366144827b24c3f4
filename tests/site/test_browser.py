"""The pages in a real browser: no errors, nothing loaded, nothing that does not fit, motion that plays, paper."""

from __future__ import annotations

import os
import shutil
import unicodedata
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from symgen.errors import ToolError
from symgen.site.build import Settings, build_site
from symgen.site.measures import MEASURES
from symgen.site.pdf import find_browser, pdf_name, print_pages
from tests.report import pages
from tests.site import reading
from tests.site.conftest import example

pytestmark = pytest.mark.slow
PHONE = {"width": 360, "height": 740}
DESK = {"width": 1280, "height": 900}
EMPTY_FIGURES = """() => [...document.querySelectorAll("main svg")].filter(svg => {
  if (svg.closest("details:not([open]), [hidden], [aria-hidden=true]")) return false;
  const box = svg.getBoundingClientRect();
  return box.width < 5 || box.height < 5;
}).map(svg => svg.getAttribute("aria-label") || svg.outerHTML.slice(0, 80))"""
TOO_WIDE = """() => [document.documentElement.scrollWidth, ...[...document.querySelectorAll("main *")]
  .filter(e => e.getBoundingClientRect().right > innerWidth + 1 && !e.closest(".scroll, pre, svg, math, .sheet-box"))
  .map(e => e.outerHTML.slice(0, 100))]"""


LITTLE: dict[str, dict[str, Any]] = {
    "validation": {"states": 10},
    "rounding": {"states": 40, "search": 0, "boxes": 8},
    "speed": {"peers": [], "variants": "none", "rounds": 3, "states": 16},
    "benchmarks": {"names": ["oscillators"]},
}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A top with its motion, a closed loop, and a pendulum with everything that can be measured, of a little each."""
    out = tmp_path_factory.mktemp("site")
    with pytest.MonkeyPatch.context() as patch:
        for id, little in LITTLE.items():
            patch.setitem(MEASURES, id, replace(MEASURES[id], quick=little))
        build_site([example("spinning_top"), example("four_bar")], out, Settings(("motion",), jobs=2))
        everything = tuple(id for id in MEASURES if id != "hard")
        result = build_site([example("double_pendulum")], out, Settings(everything, jobs=2))
    assert result.passed, result.to_text()
    return out


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    try:
        program = find_browser()
    except ToolError as error:
        pytest.skip(str(error))
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=program, args=sandbox)
        yield browser
        browser.close()


class Opened:
    """A page, and what it said and asked for."""

    def __init__(self, browser: Any, file: Path, **settings: Any) -> None:
        self.context = browser.new_context(**{"viewport": DESK, **settings})
        self.page = self.context.new_page()
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(file.as_uri())
        self.asked.remove(file.as_uri())

    def __enter__(self) -> Opened:
        return self

    def __exit__(self, *_error: object) -> None:
        self.context.close()


def files(site: Path) -> list[Path]:
    return [site / name for name in reading.html_files(site)]


def test_every_section_is_there(site: Path) -> None:
    """What is measured gets its section, what is about no scene its page."""
    ids = set(pages.read_html(reading.html_files(site)["double_pendulum/index.html"]).ids)
    assert {id for id, row in MEASURES.items() if row.of_scenes} <= ids
    assert {"benchmarks.html", "peers.html"} <= set(reading.html_files(site))


def test_pages_load_in_silence_and_fit(chromium: Any, site: Path) -> None:
    assert len(files(site)) >= 4
    for file in files(site):
        grounds = []
        for scheme, size in (("light", DESK), ("dark", PHONE)):
            with Opened(chromium, file, color_scheme=scheme, viewport=size) as it:
                assert it.said == [] and it.asked == [], file
                assert it.page.evaluate(EMPTY_FIGURES) == [], file
                width, *wide = it.page.evaluate(TOO_WIDE)
                assert width <= size["width"], (file, wide)
                grounds.append(it.page.evaluate("getComputedStyle(document.body).backgroundColor"))
        assert grounds == ["rgb(250, 249, 246)", "rgb(18, 22, 27)"], file


def test_links_lead_somewhere(site: Path) -> None:
    assert reading.broken_links(site) == []


def test_one_can_go_round_by_keyboard(chromium: Any, site: Path) -> None:
    with Opened(chromium, site / "index.html") as it:
        it.page.keyboard.press("Tab")
        assert it.page.evaluate("document.activeElement.getAttribute('href')") == "#content"
        it.page.get_by_role("link", name="double_pendulum").first.focus()
        it.page.keyboard.press("Enter")
        it.page.wait_for_url("**/double_pendulum/index.html")
        it.page.get_by_role("link", name="four_bar").focus()
        it.page.keyboard.press("Enter")
        it.page.wait_for_url("**/four_bar/index.html")
        it.page.get_by_role("navigation", name="Site").get_by_role("link", name="Scenes").click()
        it.page.wait_for_url("**/index.html")


def test_the_reader_chooses_the_colours(chromium: Any, site: Path) -> None:
    with Opened(chromium, site / "index.html", color_scheme="light") as it:
        seen = []
        for _ in range(3):
            it.page.get_by_role("button", name="Colours").click()
            seen.append(
                it.page.evaluate("[document.documentElement.dataset.theme, document.body.matches(':root *')]")[0]
            )
        assert seen == ["light", "dark", None]
        it.page.get_by_role("button", name="Colours").click()
        it.page.get_by_role("button", name="Colours").click()
        it.page.reload()
        assert it.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 22, 27)"
        it.page.emulate_media(media="print")  # paper is white, whatever was chosen
        assert it.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        assert it.said == []


def test_nothing_is_said_where_nothing_can_be_kept(chromium: Any, site: Path) -> None:
    """Some browsers keep nothing for pages from files, and say so by an error."""
    context = chromium.new_context(viewport=DESK)
    context.add_init_script("Object.defineProperty(window, 'localStorage', {get() { throw new Error('no'); }})")
    page, said = context.new_page(), list[str]()
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto((site / "index.html").as_uri())
    page.get_by_role("button", name="Colours").click()
    assert said == [] and page.evaluate("document.documentElement.dataset.theme") == "light"
    context.close()


@pytest.mark.parametrize("motion", ["no-preference", "reduce"])
def test_the_motion_plays_and_stops(chromium: Any, site: Path, motion: str) -> None:
    with Opened(chromium, site / "spinning_top/index.html", reduced_motion=motion) as it:
        drawing, button = it.page.locator("#motion-drawing svg").first, it.page.locator("#motion-play")
        time = "+document.getElementById('motion-time').value"
        still = drawing.inner_html()
        it.page.wait_for_timeout(300)
        assert drawing.inner_html() == still and it.page.evaluate(time) == 0.0  # not by itself
        button.click()
        it.page.wait_for_function(f"{time} > 0")
        assert button.get_attribute("aria-pressed") == "true"
        it.page.wait_for_function("was => document.querySelector('#motion-drawing svg').innerHTML !== was", arg=still)
        button.click()
        stopped = it.page.evaluate(time)
        it.page.wait_for_timeout(300)
        assert it.page.evaluate(time) == stopped and button.get_attribute("aria-pressed") == "false"
        it.page.locator("#motion-time").focus()
        it.page.keyboard.press(".")
        assert it.page.evaluate(time) != stopped
        assert it.said == [] and it.asked == []


def plain(text: str) -> str:
    """Without blanks and ligatures."""
    return "".join(unicodedata.normalize("NFKC", text).split())


def folded(page: str) -> list[str]:
    """The first words of what is folded on the screen and not left out on paper."""
    found = []
    for details in pages.read_xml(page).iter("details"):
        if details.get("open") is None and details.get("class") != "long":
            found.append(plain("".join("".join(e.itertext()) for e in details if e.tag != "summary"))[:25])
    return found


def test_paper(site: Path, tmp_path: Path) -> None:
    """Pages as PDFs with pages, numbers and text; what is folded on the screen is open on paper."""
    pypdf = pytest.importorskip("pypdf", reason="needs pypdf")
    try:
        program = find_browser()
    except ToolError as error:
        pytest.skip(str(error))
    shutil.copytree(site / "double_pendulum", tmp_path / "double_pendulum")
    shutil.copyfile(site / "index.html", tmp_path / "index.html")
    made = print_pages(program, tmp_path, lambda done, total, what: None)
    assert [path.name for path in made] == ["index.pdf", "double_pendulum-code.pdf", "double_pendulum.pdf"]
    texts = {}
    for path in made:
        reader = pypdf.PdfReader(path)
        texts[path.name] = text = plain("".join(page.extract_text() for page in reader.pages))
        assert len(reader.pages) > 0 and len(text) > 500, path
        assert f"1/{len(reader.pages)}" in text
        width, height = (float(x) for x in reader.pages[0].mediabox[2:])
        assert abs(width - 595) <= 1 and abs(height - 842) <= 1
        assert "Colours:" not in text and "file://" not in text
    assert "voiddouble_pendulum_mass_matrix" in texts["double_pendulum-code.pdf"]
    hidden = folded((site / "double_pendulum/index.html").read_text(encoding="utf-8"))
    assert hidden and all(words in texts["double_pendulum.pdf"] for words in hidden), hidden


def test_names_of_pdfs() -> None:
    names = {"index.html": "index.pdf", "fig1/index.html": "fig1.pdf", "fig1/code.html": "fig1-code.pdf"}
    assert {page: pdf_name(Path(page)) for page in names} == names
