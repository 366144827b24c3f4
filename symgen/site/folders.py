"""Where a site's files lie, and whether a folder is one.

DIR/index.html, hard.html, benchmarks.html, peers.html
DIR/NAME/index.html, code.html, code/      a scene's pages and its generated files
DIR/data/site.json                         says that DIR is a site
DIR/data/NAME/ID.json, DIR/data/ID.json    what was measured
DIR/pdf/                                   pages as PDF
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator
from pathlib import Path

from symgen.artifact import check_target
from symgen.artifact.staging import locked
from symgen.artifact.write import cannot_write
from symgen.errors import SceneError
from symgen.scene.document import clean
from symgen.scene.names import identifier

DATA, PDF, CODE = "data", "pdf", "code"
BOOK, CODE_PAGE = "index.html", "code.html"
"""The pages of a scene."""
MARK = f"{DATA}/site.json"
_TAKEN = frozenset({DATA, PDF, "index", "hard", "benchmarks", "peers"})
"""Names that a site uses itself."""
_GENERATOR = '<meta name="generator" content="symgen '


def folder_name(scene_name: str) -> str:
    """The folder of a scene: its name where that is a plain word, else one made of it; always the same for a name."""
    plain = identifier(scene_name)
    if plain == scene_name and plain.lower() not in _TAKEN:
        return plain
    return f"{plain[:40]}-{hashlib.sha256(scene_name.encode('utf-8', 'replace')).hexdigest()[:8]}"


def check_site(out: Path) -> None:
    """Raise SceneError where no site can be written, or where something else lies."""
    check_target(out)
    try:
        if not out.is_dir() or (out / MARK).is_file() or not any(out.iterdir()):
            return
        index = out / "index.html"
        if index.is_file() and _GENERATOR in index.read_text(encoding="utf-8", errors="replace")[:4000]:
            return
    except OSError as error:
        raise SceneError(f"cannot be read: {clean(error.strerror or str(error))}", clean(str(out), 300)) from None
    raise SceneError("holds other files; give an empty folder, or one that `symgen report` made", clean(str(out), 300))


@contextlib.contextmanager
def opened(out: Path) -> Iterator[None]:
    """The folder exists, says that it is a site, and no other run writes there meanwhile."""
    from symgen.report.page import write_text

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(error, out) from None
    with locked(out):
        write_text(out / MARK, '{"format": 1}\n')
        yield
