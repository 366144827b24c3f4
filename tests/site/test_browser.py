"""The pages in a real browser: no errors, nothing loaded, nothing that does not fit, motion that plays, paper."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from symgen.errors import ToolError
from symgen.site.build import Settings, build_site
from symgen.site.pdf import find_browser, pdf_name, print_pages
from tests.site import reading
from tests.site.conftest import example
from tests.site.fakes import Put

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


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A tree, a chain and a closed loop; the first with its real motion."""
    out = tmp_path_factory.mktemp("site")
    with pytest.MonkeyPatch.context() as patch:
        Put(patch)("validation", "validation")
        build_site([example("spinning_top"), example("four_bar")], out, Settings(jobs=2))
        build_site([example("double_pendulum")], out, Settings(("validation",)))
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


def test_paper(site: Path) -> None:
    """Every page as a PDF with pages and text; what is folded on the screen is open on paper."""
    pypdf = pytest.importorskip("pypdf", reason="needs pypdf")
    try:
        program = find_browser()
    except ToolError as error:
        pytest.skip(str(error))
    made = print_pages(program, site, lambda done, total, what: None)
    assert {path.name for path in made} == {pdf_name(file.relative_to(site)) for file in files(site)}
    for path in made:
        reader = pypdf.PdfReader(path)
        text = "\n".join(page.extract_text() for page in reader.pages)
        assert len(reader.pages) > 0 and len(text) > 500, path
        assert f"1 / {len(reader.pages)}" in text
        width, height = (float(x) for x in reader.pages[0].mediabox[2:])
        assert (round(width), round(height)) == (595, 842) or (round(width), round(height)) == (596, 842)
    text = "\n".join(page.extract_text() for page in pypdf.PdfReader(site / "pdf/double_pendulum.pdf").pages)
    assert "double_pendulum_mass_matrix" in text
    assert "Colours:" not in text and "file://" not in text
