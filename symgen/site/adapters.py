"""Measurements that take more than plain settings."""

from __future__ import annotations

from typing import Any

from symgen.scene.model import Scene
from symgen.site.measures import Say


def precision_data(scene: Scene, say: Say, *, effort: str) -> dict[str, Any]:
    """`symgen.validation.work_precision` with one of its two efforts."""
    from symgen.validation.work_precision.data import FULL, QUICK
    from symgen.validation.work_precision.data import precision_data as measure

    return measure(scene, say, effort=FULL if effort == "full" else QUICK)
