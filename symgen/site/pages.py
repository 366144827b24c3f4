"""A scene's pages from what is stored, and the card that the index has of it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from markupsafe import Markup

from symgen.artifact import Artifact
from symgen.report import measured as sections
from symgen.report.code_page import code_page
from symgen.report.page import IndexEntry, write_report, write_text
from symgen.report.shell import ALONE
from symgen.scene.model import Scene
from symgen.site.folders import BOOK, CODE, CODE_PAGE, DATA
from symgen.site.glance import Glance, glances
from symgen.site.measures import MEASURES
from symgen.site.store import Record, code_digest, read_json, read_record, record_path, scene_key
from symgen.site.validation import read_validation
from symgen.system import derive

FORMAT = 1


@dataclass(frozen=True)
class Card:
    """What the index has of a scene."""

    name: str
    folder: str
    summary: str
    verdict: str
    passed: bool | None
    drawing: str
    pages: tuple[tuple[str, str], ...]
    """Title and file name of its pages; none where they could not be made."""
    facts: tuple[tuple[str, str], ...] = ()
    glance: Mapping[str, Glance] | None = None
    """By column of the table over all scenes."""
    measured: tuple[str, ...] = ()
    """What its page shows of."""

    def entry(self, out: Path) -> IndexEntry:
        report = out / self.folder / self.pages[0][1] if self.pages else None
        return IndexEntry(self.name, report, self.summary, self.verdict, self.passed, Markup(self.drawing))


def _stored(out: Path, folder: str, scene: Scene) -> Iterator[tuple[str, Record]]:
    """What is stored about a scene as it is now, with the C that is generated for it now."""
    key = scene_key(scene.sha256, code_digest(out / folder / CODE))
    for id, row in MEASURES.items():
        record = read_record(record_path(out, folder, id)) if row.of_scenes else None
        if record is not None and record.key == key:
            yield id, record


def can_be_shown(record: Record) -> bool:
    """Whether this symgen can lay out what is stored: another one may have written it in another form."""
    try:
        if record.measured and record.id == "validation":
            read_validation(record.data)
        elif record.measured and record.id in sections.VALUES:
            sections.VALUES[record.id](record.data)
    except (LookupError, TypeError, ValueError, AttributeError):
        return False
    return True


def unreadable(record: Record) -> Record:
    return replace(record, data=None, failed="what is stored cannot be read; --fresh measures again")


def make_pages(scene: Scene, out: Path, folder: str) -> Card:
    """Write the pages of a scene, and its card. Its code lies in the site already (not that of closed loops)."""
    system = derive(scene)
    artifact = None if system.tree.cut_joints else Artifact(out / folder / CODE)
    stored = {id: record if can_be_shown(record) else unreadable(record) for id, record in _stored(out, folder, scene)}
    data = {id: record.data for id, record in stored.items() if record.measured}
    validation = read_validation(data["validation"]) if "validation" in data else None
    shown = {id: value for id, value in data.items() if id in sections.TITLES}
    if artifact is not None:
        shown["record"] = {"rows": [_row(record, folder) for record in stored.values()]}
    code = CODE_PAGE if artifact is not None else ""
    entry = write_report(out / folder / BOOK, scene, validation, artifact, shown, code_href=code, system=system)
    pages = [("Equations", BOOK)]
    if artifact is not None:
        text = code_page(system, artifact.directory, artifact.manifest, ALONE, BOOK)
        write_text(out / folder / CODE_PAGE, text)
        pages.append(("Code", CODE_PAGE))
    failed = [f"{MEASURES[id].title.lower()}: {record.failed}" for id, record in stored.items() if record.failed]
    passed, verdict = entry.passed, entry.verdict
    if failed:
        passed, verdict = False, f"✗ {'; '.join(failed)}"
    columns = glances(system, artifact.manifest if artifact else None, validation, data)
    return Card(
        scene.name, folder, entry.summary, verdict, passed, str(entry.drawing), tuple(pages),
        glance=columns, facts=tuple((g.short, g.text) for g in columns.values() if g.short),
        measured=tuple(data),
    )  # fmt: skip


def _row(record: Record, folder: str) -> dict[str, Any]:
    return {
        "title": MEASURES[record.id].title,
        "effort": record.effort,
        "settings": dict(record.settings),
        "outcome": record.refused or record.failed,
        "failed": bool(record.failed),
        "cpu_seconds": record.cpu_seconds,
        "file": f"../{DATA}/{folder}/{record.id}.json",
    }


def card_path(out: Path, folder: str) -> Path:
    return out / DATA / folder / "card.json"


def write_card(out: Path, card: Card) -> None:
    data = {
        "format": FORMAT, "name": card.name, "summary": card.summary, "verdict": card.verdict, "passed": card.passed,
        "drawing": card.drawing, "pages": card.pages, "facts": card.facts, "measured": card.measured,
        "glance": {key: value.to_json() for key, value in (card.glance or {}).items()},
    }  # fmt: skip
    write_text(card_path(out, card.folder), json.dumps(data, ensure_ascii=False, allow_nan=False, indent=1) + "\n")


def read_cards(out: Path) -> list[Card]:
    """The cards of a site, by name; those that cannot be read are left out."""
    cards = [_read_card(path.parent.name, read_json(path)) for path in (out / DATA).glob("*/card.json")]
    return sorted((card for card in cards if card), key=lambda card: (card.name.lower(), card.name))


def _read_card(folder: str, data: dict[str, Any] | None) -> Card | None:
    try:
        if data is None or data["format"] != FORMAT:
            return None
        pages = tuple((str(title), str(file)) for title, file in data["pages"])
        facts = tuple((str(name), str(value)) for name, value in data["facts"])
        glance = {key: Glance(**value) for key, value in data["glance"].items()}
        return Card(
            data["name"], folder, data["summary"], data["verdict"], data["passed"], data["drawing"], pages, facts,
            glance, tuple(data["measured"]),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError):
        return None
