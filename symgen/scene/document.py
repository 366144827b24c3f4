"""YAML text → plain data with exact numbers, and the line of every key.

Only the plain part of YAML is read: mappings, lists, scalars. Anchors, aliases, tags, merge
keys, duplicate keys and further documents are refused, so a file is as large as it looks.
Numbers are decimals (also ``1e-3``, which YAML 1.1 calls a string), ``true`` and ``false`` are the
booleans, everything else is text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

import yaml

from symgen.errors import SceneError
from symgen.scene.exact import decimal

MAX_BYTES = 5_000_000
MAX_DEPTH = 20
MAX_VALUES = 100_000
"""What some thousands of bodies need; more takes longer than anybody waits for an error message."""

Key = str | int
Route = tuple[Key, ...]
"""Where a value sits in the data: ("bodies", 2, "mass")."""

_LIKE_NUMBER = re.compile(r"[-+]?(\d|\.\d)[\d.]*([eE][-+]?\d+)?", re.ASCII)
_LEADING_ZERO = re.compile(r"[-+]?0\d", re.ASCII)
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff\u2028\u2029]")


@dataclass(frozen=True)
class Document:
    """What a description says, and where it says it."""

    data: Any
    file: str
    """Base name, for messages."""
    lines: dict[Route, int] = field(default_factory=dict)

    def place(self, route: Route = ()) -> str:
        """``file.scene.yaml:12: bodies[2].mass``, the line being that of the nearest key known."""
        known = route
        while known and known not in self.lines:
            known = known[:-1]
        line = self.lines.get(known)
        place = self.file if line is None else f"{self.file}:{line}"
        return f"{place}: {dotted(route)}" if route else place


class Places(Protocol):
    """Says where in the user's input a part of the scene is."""

    def place(self, route: Route = ()) -> str: ...


@dataclass(frozen=True)
class Description:
    """What a Scene was made from, so that it can be made again with something changed."""

    document: Document
    folder: Path | None


def dotted(route: Route) -> str:
    """``bodies[2].mass``."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{clean(key)}" for key in route)
    return text.removeprefix(".")


def clean(text: str, limit: int = 60) -> str:
    """Foreign text made fit for a one-line message."""
    text = "".join(c if c.isprintable() else "?" for c in text)
    return text if len(text) <= limit else text[: limit - 1] + "…"


def read_bytes(path: Path) -> bytes:
    """The bytes of a scene or model file; SceneError when it cannot be read or is too large."""
    name = clean(path.name or str(path), 120)
    try:
        if path.is_dir():
            raise SceneError("is a folder; give the scene file in it", name)
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise SceneError(f"no such file (looked in {clean(str(path.parent), 200)})", name) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise SceneError(f"cannot be read: {clean(reason)}", name) from None
    if len(data) > MAX_BYTES:
        raise SceneError(f"is larger than {MAX_BYTES // 1_000_000} MB; a scene is a small text", name)
    return data


def decode(data: bytes, name: str) -> str:
    """UTF-8 text without control characters; SceneError with the line otherwise."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SceneError("is not UTF-8 text", f"{name}:{line}") from None
    match = _CONTROL.search(text)
    if match:
        line = text.count("\n", 0, match.start()) + 1
        raise SceneError(f"contains the control character U+{ord(match[0]):04X}", f"{name}:{line}")
    return text


def parse_yaml(text: str, file: str) -> Document:
    """The one YAML document in ``text``. Raises SceneError naming file and line."""
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    document = Document(None, file)
    try:
        events = yaml.parse(text, Loader=loader)
        data = _Composer(events, document).document()
    except yaml.YAMLError as error:
        raise SceneError(_yaml_problem(error, text), f"{file}:{_yaml_line(error)}") from None
    return Document(data, file, document.lines)


def _yaml_line(error: yaml.YAMLError) -> int:
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    return int(mark.line) + 1 if mark else 1


def _yaml_problem(error: yaml.YAMLError, text: str) -> str:
    problem = getattr(error, "problem", None) or str(error)
    mark = getattr(error, "problem_mark", None)
    if "cannot start any token" in problem and mark and text.split("\n")[mark.line][mark.column :].startswith("\t"):
        problem = "a tab is used for indentation; use spaces"
    return f"not valid YAML: {clean(problem, 100)}"


class _Composer:
    """Events → data. A hand-written walk, because depth, aliases and tags must be refused before they cost anything."""

    def __init__(self, events: Iterator[Any], document: Document) -> None:
        self.events = events
        self.document_ = document
        self.lines = document.lines

    def next(self) -> Any:
        return next(self.events)

    def fail(self, message: str, event: Any, route: Route = ()) -> SceneError:
        place = f"{self.document_.file}:{event.start_mark.line + 1}"
        return SceneError(message, f"{place}: {dotted(route)}" if route else place)

    def document(self) -> Any:
        self.next()
        event = self.next()
        if isinstance(event, yaml.StreamEndEvent):
            raise SceneError("is empty; a scene starts with 'name: …'", self.document_.file)
        data = self.value(self.next(), ())
        self.next()
        event = self.next()
        if isinstance(event, yaml.DocumentStartEvent):
            raise self.fail("a second YAML document starts here; a scene file holds one", event)
        return data

    def value(self, event: Any, route: Route) -> Any:
        """The value that starts with ``event``, and the line it is on."""
        if isinstance(event, yaml.AliasEvent):
            raise self.fail(f"the alias *{clean(str(event.anchor))} is not read; write the value out", event, route)
        if event.anchor is not None:
            raise self.fail(f"the anchor &{clean(event.anchor)} is not read; write the value out", event, route)
        if event.tag is not None and event.tag != "!":
            raise self.fail(f"the YAML tag {clean(event.tag)} is not read; remove it", event, route)
        self.lines.setdefault(route, event.start_mark.line + 1)
        if len(route) > MAX_DEPTH:
            raise self.fail(f"nested more than {MAX_DEPTH} deep", event, route[:3])
        if len(self.lines) > MAX_VALUES:
            raise self.fail(f"has more than {MAX_VALUES} values", event)
        if isinstance(event, yaml.ScalarEvent):
            return self.scalar(event, route)
        return self.sequence(route) if isinstance(event, yaml.SequenceStartEvent) else self.mapping(route)

    def sequence(self, route: Route) -> list[Any]:
        items: list[Any] = []
        while not isinstance(event := self.next(), yaml.SequenceEndEvent):
            items.append(self.value(event, (*route, len(items))))
        return items

    def mapping(self, route: Route) -> dict[str, Any]:
        items: dict[str, Any] = {}
        while not isinstance(event := self.next(), yaml.MappingEndEvent):
            if not isinstance(event, yaml.ScalarEvent) or event.anchor or event.tag not in (None, "!"):  # ? [a, b]: …
                raise self.fail("a key must be a plain word", event, route)
            key = event.value
            if key == "<<" and not event.style:
                raise self.fail("the merge key << is not read; write the values out", event, route)
            if key in items:
                raise self.fail(f"the key {clean(key)!r} is given twice", event, route)
            mark: Any = event.start_mark
            self.lines[(*route, key)] = mark.line + 1
            items[key] = self.value(self.next(), (*route, key))
        return items

    def scalar(self, event: Any, route: Route) -> Fraction | bool | str | None:
        text: str = event.value
        if event.style:  # quoted or block text: never a number
            return text
        if text in ("", "~", "null", "Null", "NULL"):
            return None
        if text.lower() in ("true", "false"):
            return text.lower() == "true"
        if _LIKE_NUMBER.fullmatch(text):
            if _LEADING_ZERO.match(text):
                raise self.fail(f"drop the leading zero of {clean(text)}; YAML may read it as octal", event, route)
            try:
                return decimal(text)
            except ValueError as error:
                raise self.fail(str(error), event, route) from None
        return text
