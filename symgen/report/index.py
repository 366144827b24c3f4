"""The index: a card per scene, and the scenes side by side."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from symgen.report.page import IndexEntry, write_text
from symgen.report.shell import ALONE, Place, page
from symgen.report.tables import Table

Facts = Sequence[tuple[str, str]]
"""(name, value) of a card."""


@dataclass(frozen=True)
class Whole:
    """A page that is about no one scene."""

    title: str
    address: str
    verdict: str
    passed: bool | None


def in_order(entries: Sequence[IndexEntry]) -> list[IndexEntry]:
    """What failed first, then by name."""
    return sorted(entries, key=lambda entry: (entry.passed is not False, entry.name.lower(), entry.name))


def write_index(
    path: str | Path,
    entries: Sequence[IndexEntry],
    facts: Mapping[str, Facts] = MappingProxyType({}),
    glance: Table | None = None,
    place: Place = ALONE,
    wholes: Sequence[Whole] = (),
) -> Path:
    """Write the index page to ``path`` (a file, or a folder that gets an index.html) and return where it is.

    ``facts``: scene → what its card says beside the verdict; ``glance``: a table over all scenes; ``wholes``: pages
    about no one scene. Links are relative, so the folder may move. Raises SceneError when the page cannot be written.
    """
    path = Path(path)
    path = path if path.suffix == ".html" else path / "index.html"
    cards = []
    ordered = in_order(entries)
    for entry in ordered:
        link = Path(os.path.relpath(entry.report, path.parent)).as_posix() if entry.report is not None else ""
        style = {True: "pass", False: "fail", None: "quiet"}[entry.passed]
        cards.append({"entry": entry, "link": link, "style": style, "facts": facts.get(entry.name, ())})
    failed = [
        (str(card["link"]), entry.name) for card, entry in zip(cards, ordered, strict=True) if entry.passed is False
    ]
    failed += [(whole.address, whole.title) for whole in wholes if whole.passed is False]
    sections = [("scenes", "Scenes"), ("glance", "At a glance")] if glance is not None else []
    text = page(
        "report/index.html.j2", "symgen: reports", sections, place, cards=cards, failed=failed, glance=glance,
        wholes=wholes, headings=dict(sections) or {"scenes": "Scenes"},
    )  # fmt: skip
    write_text(path, text)
    return path
