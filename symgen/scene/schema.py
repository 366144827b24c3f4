"""The shape of a scene file: JSON Schema validation, said in one clear message.

The schema (`schemas/scene.schema.json`, Draft 2020-12) is also what editors use. The library finds
what is wrong; this module chooses the one error to show and words it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from functools import lru_cache
from importlib import resources
from itertools import islice
from typing import Any

from jsonschema import Draft202012Validator, validators
from jsonschema.exceptions import ValidationError
from jsonschema.protocols import Validator

from symgen.errors import SceneError
from symgen.scene.document import Document, Route, clean
from symgen.scene.exact import decimal

SUPERSEDED = {
    "friction": "friction is not modelled; use damping (viscous), or remove it",
    "links": "a scene calls them 'bodies'",
    "loops": "a loop is an ordinary joint between two bodies; list it under 'joints'",
}
"""Keys people try, and what to do instead."""
MAX_FINDINGS = 1000
"""Looked at to choose the one that is shown: a file that is wrong everywhere must not take minutes to refuse."""


def did_you_mean(word: str, choices: Iterable[str]) -> str:
    """`` (did you mean 'mass'?)``, or the choices when they are few, or nothing."""
    known = list(choices)
    lower = {k.lower(): k for k in reversed(known)}
    close = get_close_matches(word.lower(), lower, n=1, cutoff=0.6)
    close = close or [k for k in sorted(lower) if len(word) >= 3 and word.lower() in k]
    if close:
        return f"; did you mean {clean(lower[close[0]])!r}?"
    return f"; known: {', '.join(known)}" if 0 < len(known) <= 20 else ""


@dataclass(frozen=True)
class _Finding:
    """What the library found: ``value`` at ``route`` breaks ``rule``, which wants ``wanted``."""

    rule: str
    value: Any
    wanted: Any
    schema: Any
    route: Route
    text: str


def _finding(error: ValidationError) -> _Finding:
    route = tuple(error.absolute_path)
    return _Finding(str(error.validator), error.instance, error.validator_value, error.schema, route, error.message)


@lru_cache(maxsize=1)
def _validator() -> Validator:
    text = resources.files("symgen.scene").joinpath("schemas/scene.schema.json").read_text(encoding="utf-8")
    checker = Draft202012Validator.TYPE_CHECKER.redefine("number", lambda _, x: isinstance(x, Fraction))
    exact: Any = validators.extend(Draft202012Validator, type_checker=checker)  # type: ignore[no-untyped-call]
    validator: Validator = exact(json.loads(text))
    return validator


def check_schema(document: Document) -> None:
    """Raise SceneError for the first thing in the file that a scene cannot have."""
    data = document.data
    if not isinstance(data, dict):
        raise SceneError(f"a scene is a mapping that starts with 'name: …', not {_say(data)}", document.place())
    findings = [_finding(error) for error in islice(_validator().iter_errors(data), MAX_FINDINGS)]
    if findings:
        raise _explain(min(findings, key=lambda f: _rank(f, document)), document)


def _rank(found: _Finding, document: Document) -> tuple[bool, int, int, str]:
    """First line first; of one object, what is there before what is missing; the plainest rule first."""
    misspelt = found.rule == "required" and _is_misspelt(found)
    kind = {"additionalProperties": 0, "type": 1, "required": 3}.get(found.rule, 2)
    return (misspelt, document.lines.get(found.route, 0), kind, found.text)


def _is_misspelt(found: _Finding) -> bool:
    """The missing key is probably there under a misspelt name, which is the better message."""
    known = found.schema.get("properties", {})
    extra = [key for key in found.value if key not in known]
    return any(get_close_matches(key.lower(), _missing(found), n=1, cutoff=0.6) for key in extra)


def _missing(found: _Finding) -> list[str]:
    return [key for key in found.wanted if key not in found.value]


def _explain(found: _Finding, document: Document) -> SceneError:
    if found.rule == "additionalProperties":
        known = list(found.schema["properties"])
        key = next(key for key in found.value if key not in known)
        advice = f"; {SUPERSEDED[key]}" if key in SUPERSEDED else did_you_mean(key, known)
        return SceneError(f"unknown key {clean(key)!r}{advice}", document.place((*found.route, key)))
    return SceneError(_message(found, found.route, document.data), document.place(found.route))


def _message(found: _Finding, route: Route, data: Any) -> str:
    value, rule = found.value, found.wanted
    match found.rule:
        case "required":
            return f"{_owner(value, route)}needs {_list(_missing(found))}"
        case "type":
            return f"{_want(rule)} is wanted here, not {_say(value)}"
        case "enum":
            return f"{_say(value)} is not known{did_you_mean(value if isinstance(value, str) else '', rule)}"
        case "pattern":
            return (
                f"{clean(value)!r} is no identifier; a name is made of letters, digits and _, and starts with no digit"
            )
        case "minLength":
            return "is empty"
        case "maxLength":
            return f"is longer than {rule} characters"
        case "minItems" | "maxItems":
            return _count(found, value, route)
        case "minimum":
            return f"is {_number(value)}; " + ("it cannot be negative" if rule == 0 else f"at least {rule} is wanted")
        case "maximum":
            return f"is {_number(value)}; at most {rule} is wanted"
    return _forbidden(route, data)


def _owner(value: Any, route: Route) -> str:
    """``revolute joint 'j1' ``, so that a missing field names its owner."""
    if not route:
        return "the scene "
    if len(route) > 2 and isinstance(route[-1], str):
        return f"{route[-1]} "
    name = value.get("name") if isinstance(value, dict) else None
    kind = {"bodies": "body", "joints": "joint", "forces": "force", "frames": "frame", "outputs": "output"}.get(
        str(route[0]), str(route[0])
    )
    form = value.get("type") if isinstance(value, dict) else None
    words = [str(form)] if isinstance(form, str) and kind in ("joint", "force") else []
    return clean(" ".join([*words, kind, *([repr(name)] if isinstance(name, str) else [])])) + " "


def _count(found: _Finding, value: Sequence[Any], route: Route) -> str:
    low, high = found.schema.get("minItems"), found.schema.get("maxItems")
    if low == high:
        return f"has {len(value)} entries; {low} are wanted" + (
            " [ixx, iyy, izz, ixy, ixz, iyz]" if route[-1] == "inertia" else ""
        )
    return f"has {len(value)} entries; at most {high} are wanted" if len(value) > (high or 0) > 0 else "is empty"


def _forbidden(route: Route, data: Any) -> str:
    """Schema ``not: {}``, which nothing passes: the key is known, but not here."""
    key = str(route[-1])
    if key in SUPERSEDED:
        return SUPERSEDED[key]
    owner: Any = data
    for step in route[:-1]:
        owner = owner[step]
    if len(route) == 1:
        return "goes with 'model' only" + ("; leave the bodies out instead" if key == "remove" else "")
    kind = {"joints": "joint", "forces": "force"}.get(str(route[0]), str(route[0]))
    return f"a {clean(str(owner.get('type')))} {kind} has no {key!r}"


def _want(rule: str | list[str]) -> str:
    words = {
        "number": "a number", "string": "a text", "array": "a list", "object": "a mapping", "boolean": "true or false",
    }  # fmt: skip
    return " or ".join(words[r] for r in ([rule] if isinstance(rule, str) else rule))


def _say(value: Any) -> str:
    """A value as a person would name it."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Fraction):
        return f"the number {_number(value)}"
    if isinstance(value, str):
        plain = value.strip(" +-.").lower()
        if plain in ("nan", "inf", "infinity"):
            return f"{clean(value)!r} (numbers must be finite)"
        return f"the text {clean(value)!r}" + (_like_number(value) if plain[:1].isdigit() else "")
    if isinstance(value, dict):
        return "a mapping"
    return "a list" if isinstance(value, list) else clean(repr(value))


def _like_number(text: str) -> str:
    try:
        decimal(text)
    except ValueError:
        return " (not a decimal number)"
    return " (remove the quotes?)"


def _number(value: Any) -> str:
    return f"{float(value):.12g}"


def _list(keys: Sequence[str]) -> str:
    return " and ".join(repr(key) for key in keys)
