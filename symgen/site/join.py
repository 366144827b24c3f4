"""Joining pages to a site: the index, pages that are about symgen as a whole, the way from page to page."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from symgen.report.index import Whole, in_order, write_index
from symgen.report.page import write_text
from symgen.report.shell import Link, Place, relink
from symgen.site.glance import glance_table
from symgen.site.measures import MEASURES
from symgen.site.pages import Card, read_cards
from symgen.site.store import Record, read_record, record_path, site_key, verdicts

INDEX = "Scenes"
_Page = Callable[[Any, Place], str]


def site_records(out: Path) -> dict[str, Record]:
    """What is stored about symgen as it is now."""
    found = {id: read_record(record_path(out, "", id)) for id, row in MEASURES.items() if not row.of_scenes}
    return {id: record for id, record in found.items() if record is not None and record.key == site_key()}


def join(out: Path) -> None:
    """Write the index and the pages about symgen as a whole, and lead from every page to its neighbours. Without any
    page there is no index."""
    cards = read_cards(out)
    wholes = _wholes(out, cards)
    titles = [title for title, _, _, _ in wholes]
    for title, file, page, data in wholes:
        write_text(out / file, page(data, _place(wholes, title)))
    for file in {file for _, file, _, _ in _kinds()} - {file for _, file, _, _ in wholes}:
        (out / file).unlink(missing_ok=True)
    if not titles and not cards:
        return
    place = _place(wholes, INDEX)
    _write_index(out, cards, place, _summaries(wholes))
    ordered = [card for card in _ordered(out, cards) if card.pages]
    for at, card in enumerate(ordered):
        _relink(out, card, _scene_place(wholes, ordered, at))


def _kinds() -> list[tuple[str, str, str, str]]:
    """Title, file, module and function of the pages that are about symgen as a whole."""
    return [
        ("Hard cases", "hard.html", "symgen.report.hard", "hard_page"),
        ("Benchmarks", "benchmarks.html", "symgen.report.benchmarks", "benchmarks_page"),
        ("Peers", "peers.html", "symgen.report.peers", "peers_page"),
    ]


_Whole = tuple[str, str, _Page, Any]


def _wholes(out: Path, cards: list[Card]) -> list[_Whole]:
    """Those that there is data for: title, file, function and data."""
    data: Mapping[str, Any] = {
        **{id: record.data for id, record in site_records(out).items() if record.measured},
        "peers": [speed for card in cards if (speed := _speed(out, card)) is not None],
    }
    found: list[_Whole] = []
    for title, file, module, name in _kinds():
        given = data.get(file.removesuffix(".html"))
        if not given:
            continue
        try:
            function = getattr(importlib.import_module(module), name)
        except (ImportError, AttributeError):
            continue
        found.append((title, file, function, given))
    return found


def _speed(out: Path, card: Card) -> Any:
    """What a scene's page shows of speed."""
    record = read_record(record_path(out, card.folder, "speed"))
    return record.data if record is not None and record.measured and "speed" in card.measured else None


def _place(wholes: list[_Whole], here: str, up: str = "") -> Place:
    links: list[Link] = [(INDEX, f"{up}index.html"), *((title, f"{up}{file}") for title, file, _, _ in wholes)]
    return Place(tuple(links), here)


def _ordered(out: Path, cards: list[Card]) -> list[Card]:
    by_name = {card.name: card for card in cards}
    return [by_name[entry.name] for entry in in_order([card.entry(out) for card in cards])]


def _scene_place(wholes: list[_Whole], ordered: list[Card], at: int) -> Place:
    def link(k: int) -> Link | None:
        if not 0 <= k < len(ordered):
            return None
        return (ordered[k].name, f"../{ordered[k].folder}/{ordered[k].pages[0][1]}")

    around = _place(wholes, "", "../")
    return Place(around.links, "", ordered[at].pages, "", link(at - 1), link(at + 1))


def _relink(out: Path, card: Card, place: Place) -> None:
    for title, file in card.pages:
        path = out / card.folder / file
        try:
            text = path.read_text(encoding="utf-8")
        except OSError:
            continue
        own = Place(place.links, "", place.pages, title, place.before, place.after)
        new = relink(text, own)
        if new != text:
            write_text(path, new)


def _summaries(wholes: list[_Whole]) -> list[Whole]:
    """What the index says of the pages that are about symgen as a whole."""
    found = []
    for title, file, _, data in wholes:
        checks, failed = verdicts(data)
        if not checks:
            found.append(Whole(title, file, f"{len(data)} scenes" if len(data) > 1 else "one scene", None))
        elif failed:
            found.append(Whole(title, file, f"✗ {failed} of {checks} checks failed", False))
        else:
            found.append(Whole(title, file, f"✓ {checks} checks passed", True))
    return found


def _write_index(out: Path, cards: list[Card], place: Place, wholes: list[Whole]) -> None:
    entries = [card.entry(out) for card in cards]
    rows = []
    for card in _ordered(out, cards):
        address = f"{card.folder}/{card.pages[0][1]}" if card.pages else ""
        rows.append((card.name, address, card.verdict, card.glance or {}))
    facts = {card.name: card.facts for card in cards}
    write_index(out, entries, facts, glance_table(rows) if rows else None, place, wholes)
