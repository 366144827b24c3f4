"""What was measured, kept as JSON: a file per scene and measurement, with the key that says what it was measured of."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from symgen.report.page import write_text
from symgen.site.folders import DATA
from symgen.version import VERSION

FORMAT = 1
_NOT_MEASURED = frozenset({"report", "site", "__pycache__", "show.py", "cli.py", "console.py"})
"""Parts of the package that change pages and no measurement."""


@dataclass(frozen=True)
class Key:
    """What a measurement is of. It counts only where all of this is as it was."""

    symgen: str
    scene: str
    """SHA-256 of the scene's meaning; empty for what is about symgen as a whole."""
    code: str
    """SHA-256 of the C that was generated for the scene, or of symgen's own source."""


@dataclass(frozen=True)
class Record:
    """One measurement, or why there is none."""

    id: str
    key: Key
    effort: str
    settings: Mapping[str, Any]
    data: Any = None
    refused: str = ""
    """Something that it needs is missing, or the scene has no such thing."""
    failed: str = ""
    """It broke, or a certificate failed."""
    cpu_seconds: float = field(default=0.0, compare=False)
    """What it took, with the compilers and programs that it started."""
    tools: Mapping[str, str] = field(default_factory=dict)
    """Package → the version that was installed, or ``absent``, of those that it uses where they are there."""

    @property
    def measured(self) -> bool:
        return not self.refused and not self.failed

    def serves(self, asked: Record) -> bool:
        """Whether nothing need be measured anew for what is asked. What took full effort serves where a quick one is
        asked for. What other simulators were installed for is shown as what it is, and serves no more."""
        settings, effort = asked.settings, asked.effort
        same = dict(self.settings) == dict(settings) or (self.effort == "full" and effort == "quick")
        return self.measured and self.key == asked.key and same and dict(self.tools) == dict(asked.tools)


def scene_key(sha256: str, code: str) -> Key:
    return Key(VERSION, sha256, code)


def site_key() -> Key:
    """Of measurements that are about symgen itself."""
    return Key(VERSION, "", _own_source())


@cache
def _own_source() -> str:
    digest = hashlib.sha256()

    def walk(folder: Traversable, path: str) -> None:
        for entry in sorted(folder.iterdir(), key=lambda e: e.name):
            if entry.name in _NOT_MEASURED:
                continue
            if entry.is_dir():
                walk(entry, f"{path}/{entry.name}")
            elif entry.name.endswith((".py", ".j2")):
                digest.update(f"{path}/{entry.name}\0".encode() + entry.read_bytes() + b"\0")

    walk(resources.files("symgen"), "")
    return digest.hexdigest()


def verdicts(data: Any) -> tuple[int, int]:
    """How many checks there are in data, as objects with a key ``passed`` (the innermost ones), and how many failed.
    What has nothing ``allowed`` is there for comparison, and is no check."""
    parts = list(data.values()) if isinstance(data, dict) else data if isinstance(data, list) else []
    inner = [verdicts(part) for part in parts]
    checks, failed = sum(c for c, _ in inner), sum(f for _, f in inner)
    if not checks and isinstance(data, dict) and isinstance(data.get("passed"), bool):
        return (0, 0) if data.get("allowed", True) is None else (1, int(not data["passed"]))
    return checks, failed


def code_digest(folder: Path) -> str:
    """SHA-256 of the generated C in a folder (names and bytes)."""
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.[ch]")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def record_path(out: Path, folder: str, id: str) -> Path:
    """``folder``: the scene's; empty for what is about symgen as a whole."""
    return out / DATA / folder / f"{id}.json" if folder else out / DATA / f"{id}.json"


def write_record(path: Path, record: Record) -> None:
    """Raises SceneError where it cannot be written, ValueError for numbers that JSON lacks."""
    text = json.dumps({"format": FORMAT, **asdict(record)}, ensure_ascii=False, allow_nan=False, indent=1)
    write_text(path, text + "\n")


def read_record(path: Path) -> Record | None:
    """None where there is none that can be read."""
    found = read_json(path)
    try:
        if found is None or found.pop("format") != FORMAT:
            return None
        return Record(**{**found, "key": Key(**found["key"])})
    except (KeyError, TypeError):
        return None


def read_json(path: Path) -> dict[str, Any] | None:
    """A JSON object, None where there is none that can be read."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None
