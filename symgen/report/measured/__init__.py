"""Sections of a scene's page that show what was measured, each from plain data (as it stands in a JSON file).

A module per section: ``values(data)`` gives what its template (report/sections/ID.html.j2) lays out, as ``it``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from symgen.report.measured import motion, precision, record, rounding, speed

Values = Callable[[Mapping[str, Any]], dict[str, object]]
TITLES: dict[str, str] = {
    "motion": "Motion",
    "rounding": "Rounding error",
    "precision": "Work and precision",
    "speed": "Speed against error",
    "record": "How it was measured",
}
"""Section → its title, in reading order."""
VALUES: dict[str, Values] = {
    "motion": motion.values,
    "rounding": rounding.values,
    "precision": precision.values,
    "speed": speed.values,
    "record": record.values,
}
"""Section → what its template lays out."""


def present(data: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(id, title) of the sections there is data for."""
    return [(name, title) for name, title in TITLES.items() if name in data]


def values(data: Mapping[str, Any]) -> dict[str, dict[str, object]]:
    """What the templates of these sections lay out."""
    return {name: VALUES[name](data[name]) for name, _ in present(data)}
