"""Validation as stored data, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from symgen.scene.model import Scene
from symgen.site.measures import Say
from symgen.site.tools import ABSENT, installed
from symgen.validation.result import NOT_INSTALLED, Refinement, Row, Skip, Trajectory, ValidationResult

SIMULATORS = {"pinocchio": "pin", "exudyn": "exudyn"}
"""Name → its package."""


def validation_data(scene: Scene, say: Say, *, states: int = 1000) -> dict[str, Any]:
    """`symgen.validation.validate` with the simulators that are installed."""
    from symgen.validation import validate

    versions = installed(tuple(SIMULATORS.values()))
    against = [name for name, package in SIMULATORS.items() if versions[package] != ABSENT]
    data = validate(scene, against, states, progress=lambda done, total, what: say(what)).to_json()
    for name in SIMULATORS:
        if name not in against:
            data["skipped"] = [*_list(data["skipped"]), {"check": name, "reason": NOT_INSTALLED}]
    return data


def _list(value: object) -> list[Any]:
    assert isinstance(value, list)
    return value


def read_validation(data: Mapping[str, Any]) -> ValidationResult:
    """The result that was stored."""
    rows = tuple(
        Row(r["check"], r["quantity"], float(r["value"]), float(r["criterion"]), r["note"], r["source"])
        for r in data["rows"]
    )
    skips = tuple(Skip(s["check"], s["reason"]) for s in data["skipped"])
    trajectory = _trajectory(data["trajectory"]) if data["trajectory"] else None
    return ValidationResult(
        data["scene"], data["scene_sha256"], tuple(data["against"]), data["states"], data["seed"], rows, skips,
        trajectory, dict(data["versions"]),
    )  # fmt: skip


def _trajectory(data: Mapping[str, Any]) -> Trajectory:
    refinements = tuple(
        Refinement(
            r["formulation"], r["solver"], _floats(r["steps"]), _floats(r["errors"]), float(r["order"]),
            float(r["extrapolated"]), r["expected_order"],
        )
        for r in data["refinements"]
    )  # fmt: skip
    return Trajectory(
        _floats(data["initial_q"]), _floats(data["initial_v"]), _floats(data["times"]),
        tuple(_floats(row) for row in data["q"]), _floats(data["energy"]), tuple(data["coordinates"]), refinements,
    )  # fmt: skip


def _floats(values: Any) -> tuple[float, ...]:
    """Numbers, those that JSON lacks from their names."""
    return tuple(float(value) for value in values)
