"""The index: a card per scene."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from symgen.report.page import IndexEntry, write_text
from symgen.report.shell import page


def write_index(path: str | Path, entries: Sequence[IndexEntry]) -> Path:
    """Write the index page to ``path`` (a file, or a folder that gets an index.html) and return where it is.

    Links are relative, so the folder may move. Raises SceneError when the page cannot be written.
    """
    path = Path(path)
    path = path if path.suffix == ".html" else path / "index.html"
    cards = []
    for entry in sorted(entries, key=lambda e: e.name):
        link = Path(os.path.relpath(entry.report, path.parent)).as_posix() if entry.report is not None else ""
        style = {True: "pass", False: "fail", None: "quiet"}[entry.passed]
        cards.append({"entry": entry, "link": link, "style": style})
    failed = [entry.name for entry in entries if entry.passed is False]
    write_text(path, page("report/index.html.j2", "symgen: reports", cards=cards, failed=failed))
    return path
