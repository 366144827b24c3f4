"""The index: a card per scene, and the scenes side by side."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from symgen.report.page import IndexEntry, write_text
from symgen.report.shell import ALONE, Place, page
from symgen.report.tables import Table

Facts = Sequence[tuple[str, str]]
"""(name, value) of a card."""


def in_order(entries: Sequence[IndexEntry]) -> list[IndexEntry]:
    """What failed first, then by name."""
    return sorted(entries, key=lambda entry: (entry.passed is not False, entry.name.lower(), entry.name))


def write_index(
    path: str | Path,
    entries: Sequence[IndexEntry],
    facts: Mapping[str, Facts] = MappingProxyType({}),
    glance: Table | None = None,
    place: Place = ALONE,
) -> Path:
    """Write the index page to ``path`` (a file, or a folder that gets an index.html) and return where it is.

    ``facts``: scene → what its card says beside the verdict; ``glance``: a table over all scenes. Links are relative,
    so the folder may move. Raises SceneError when the page cannot be written.
    """
    path = Path(path)
    path = path if path.suffix == ".html" else path / "index.html"
    cards = []
    for entry in in_order(entries):
        link = Path(os.path.relpath(entry.report, path.parent)).as_posix() if entry.report is not None else ""
        style = {True: "pass", False: "fail", None: "quiet"}[entry.passed]
        cards.append({"entry": entry, "link": link, "style": style, "facts": facts.get(entry.name, ())})
    failed = [card for card in cards if card["style"] == "fail"]
    sections = [("scenes", "Scenes"), ("glance", "At a glance")] if glance is not None else []
    text = page(
        "report/index.html.j2", "symgen: reports", sections, place, cards=cards, failed=failed, glance=glance,
        headings=dict(sections) or {"scenes": "Scenes"},
    )  # fmt: skip
    write_text(path, text)
    return path
