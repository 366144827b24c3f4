"""The canonical form of a scene's meaning, and its hash."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from typing import Any

from symgen.scene.model import Scene

_NOT_MEANING = frozenset({"notes", "source", "sha256", "raw", "description"})
_WHERE_GIVEN = frozenset({"mimic", "code"})
"""Fields that are named only where they have a value: scenes without them keep the hash they always had."""


def canonical(scene: Scene) -> str:
    """JSON of everything that changes what is derived: key order and number spelling do not."""
    data = {f.name: _plain(getattr(scene, f.name)) for f in fields(scene) if f.name not in _NOT_MEANING}
    return json.dumps(data, sort_keys=True, ensure_ascii=True, separators=(",", ":"))


def with_hash(scene: Scene) -> Scene:
    """``scene`` with ``sha256`` of its canonical form."""
    return replace(scene, sha256=hashlib.sha256(canonical(scene).encode("ascii")).hexdigest())


def _plain(value: Any) -> Any:
    if isinstance(value, Fraction):
        return str(value)
    if is_dataclass(value) and not isinstance(value, type):
        named = {f.name: getattr(value, f.name) for f in fields(value)}
        given = {key: item for key, item in named.items() if key not in _WHERE_GIVEN or item is not None}
        return {"kind": type(value).__name__, **{key: _plain(item) for key, item in given.items()}}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    return value
