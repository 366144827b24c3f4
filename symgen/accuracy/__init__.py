"""How accurate the compiled code is: errors against ball arithmetic, states sought for, and proven bounds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from symgen.scene.model import Scene


def rounding_data(scene: Scene, say: Callable[[str], None] = lambda what: None, **effort: int) -> dict[str, Any]:
    """What the section "Rounding error" of a report shows, see `symgen.accuracy.data.rounding_data` (``states``,
    ``search``, ``boxes``). Raises ToolError without python-flint."""
    from symgen.accuracy.data import rounding_data as measured

    return measured(scene, say, **effort)


__all__ = ["rounding_data"]
