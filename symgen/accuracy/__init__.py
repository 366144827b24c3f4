"""How accurate the compiled code is: errors against ball arithmetic, states sought for, and proven bounds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from symgen.scene.model import Scene


def rounding_data(
    scene: Scene, say: Callable[[str], None] = lambda what: None, *, states: int = 1000, search: int = 100,
    boxes: int = 512,
) -> dict[str, Any]:  # fmt: skip
    """What the section "Rounding error" of a report shows: `symgen.accuracy.data.rounding_data`, whose tools are
    imported only here."""
    from symgen.accuracy import data

    return data.rounding_data(scene, say, states=states, search=search, boxes=boxes)


__all__ = ["rounding_data"]
