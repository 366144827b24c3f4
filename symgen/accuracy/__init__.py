"""How accurate the compiled code is: errors against ball arithmetic, states sought for, and proven bounds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from symgen.scene.model import Scene


def rounding_data(
    scene: Scene, say: Callable[[str], None] = lambda what: None, *, states: int = 1000, search: int = 100,
    boxes: int = 512,
) -> dict[str, Any]:  # fmt: skip
    """What the section "Rounding error" of a report shows: errors of every function, variant and plan at ``states``
    sampled states and the worst that ``search`` evaluations find, and bounds proven by at most ``boxes`` boxes where
    functions are short (see `symgen.accuracy.data`).

    Raises NotSupportedError where nothing can be measured, ToolError without a C compiler, SciPy or python-flint.
    """
    from symgen.accuracy.data import measured

    return measured(scene, say, states, search, boxes)


__all__ = ["rounding_data"]
