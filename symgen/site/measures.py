"""Everything that can be measured for a site, by id: which function does it, how hard it tries, what it is called."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from symgen.errors import NotSupportedError, ToolError
from symgen.scene.model import Scene

Say = Callable[[str], None]
"""``say(what)``: what is being done now."""


@dataclass(frozen=True)
class Measure:
    """A measurement. The function takes (scene, say), or (say) where it is about symgen as a whole, and settings by
    keyword; what it gives is plain JSON data."""

    id: str
    title: str
    module: str
    function: str
    quick: Mapping[str, Any] = field(default_factory=dict)
    full: Mapping[str, Any] = field(default_factory=dict)
    alone: bool = False
    """It takes times, so nothing else runs meanwhile."""
    of_scenes: bool = True
    tools: tuple[str, ...] = ()
    """Packages that are used where they are installed, so that other versions of them are measured with anew."""

    def settings(self, effort: str) -> Mapping[str, Any]:
        return self.full if effort == "full" else self.quick


# fmt: off
MEASURES = {
    measure.id: measure
    for measure in (
        Measure(
            "validation", "Validation", "symgen.site.validation", "validation_data", {"states": 1000}, {"states": 1000},
            tools=("pin", "exudyn"),
        ),
        Measure("motion", "Motion", "symgen.simulate", "motion_data"),
        Measure(
            "rounding", "Rounding error", "symgen.accuracy", "rounding_data",
            {"states": 1000, "search": 100}, {"states": 10_000, "search": 400},
            tools=("python-flint",),
        ),
        Measure(
            "precision", "Work and precision", "symgen.site.adapters", "precision_data",
            {"effort": "quick"}, {"effort": "full"}, alone=True, tools=("scipy", "pin", "exudyn"),
        ),
        Measure(
            "speed", "Speed against error", "symgen.bench", "speed_data",
            {"variants": "none", "rounds": 31}, {"variants": "standard", "rounds": 101}, alone=True,
            tools=("casadi", "pin", "cmeel-cppadcodegen", "mujoco", "adam-robotics", "sympy", "python-flint"),
        ),
        Measure(
            "hard", "Hard cases", "symgen.validation.hard_cases", "hard_data", of_scenes=False, tools=("python-flint",)
        ),
        Measure(
            "benchmarks", "Benchmarks", "symgen.validation.benchmarks", "benchmark_data", alone=True, of_scenes=False
        ),
    )
}
# fmt: on
DEFAULT = ("validation", "motion")


def chosen(names: Sequence[str]) -> tuple[str, ...]:
    """Ids in the table's order; ``all`` and ``none`` stand for themselves. Raises ToolError for others."""
    for name in names:
        if name not in MEASURES and name not in ("all", "none"):
            raise ToolError(f"nothing measures '{name}': choose from {', '.join(MEASURES)}, all, none")
    if "none" in names:
        if len(set(names)) > 1:
            raise ToolError("none and others do not go together")
        return ()
    return tuple(id for id in MEASURES if "all" in names or id in names)


def measure(id: str, scene: Scene | None, effort: str, say: Say) -> Any:
    """Run a measurement. Raises NotSupportedError or ToolError where it cannot be made here."""
    row = MEASURES[id]
    try:
        function = getattr(importlib.import_module(row.module), row.function)
    except (ImportError, AttributeError) as error:
        raise NotSupportedError(missing(error) or f"{row.title.lower()} cannot be measured by this symgen") from None
    try:
        return function(*([scene] if row.of_scenes else []), say, **row.settings(effort))
    except ImportError as error:
        raise ToolError(missing(error) or str(error)) from None


def missing(error: Exception) -> str:
    """Which package is not there, in words; empty when it is not about that."""
    name = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
    return f"the package {name} is not installed" if name and not name.startswith("symgen") else ""
