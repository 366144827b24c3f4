"""Reading a site: its pages, and where their links lead."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

from tests.report import pages


def html_files(site: Path) -> dict[str, str]:
    """Path from the site's folder → text, of all its pages."""
    found = [*site.glob("*.html"), *site.glob("*/*.html")]
    return {path.relative_to(site).as_posix(): path.read_text(encoding="utf-8") for path in sorted(found)}


def broken_links(site: Path) -> list[str]:
    """Links to files or anchors that are not there, and links out of the site."""
    texts = html_files(site)
    ids = {name: set(pages.read_html(text).ids) for name, text in texts.items()}
    wrong = []
    for name, text in texts.items():
        for tag, attribute, value in pages.read_html(text).attributes:
            if tag == "a" and attribute == "href" and not _leads(site, ids, name, unquote(value)):
                wrong.append(f"{name}: {value}")
    return wrong


def _leads(site: Path, ids: dict[str, set[str]], page: str, address: str) -> bool:
    if "://" in address:
        return False
    file, _, anchor = address.partition("#")
    target = (site / page).parent / file if file else site / page
    if not target.resolve().is_relative_to(site.resolve()) or not target.exists():
        return False
    name = target.resolve().relative_to(site.resolve()).as_posix()
    return not anchor or anchor in ids.get(name, set())


def text_of(page: str) -> str:
    return " ".join("".join(pages.read_html(page).text).split())
