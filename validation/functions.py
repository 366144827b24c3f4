"""The functions under test, whoever made them, and run-time parameters bound to values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Protocol

import numpy as np

from symgen.scene.model import Scene
from symgen.validation.mechanism import Array

Function = Callable[..., Any]


class Functions(Protocol):
    """An object with one attribute per function of the catalogue, as ``artifact.load()`` returns.

    ``f.mass_matrix(q)`` takes (nq,) or (N, nq) and returns (nv, nv) or (N, nv, nv); the rest alike.
    """

    def __getattr__(self, name: str) -> Any: ...


@dataclass(frozen=True)
class Bound:
    """Functions with the scene's parameters at fixed values; ``has`` tells which exist."""

    functions: Any
    p: Array
    """Empty for a scene without parameters."""

    def has(self, *names: str) -> bool:
        return all(callable(getattr(self.functions, name, None)) for name in names)

    def __call__(self, name: str, *arguments: Any) -> Array:
        """One function's single output, float64."""
        return np.asarray(self.all(name, *arguments), dtype=float)

    def all(self, name: str, *arguments: Any) -> Any:
        """One function's outputs as it returns them: an array, or a tuple of them."""
        function: Function = getattr(self.functions, name)
        takes_p = self.p.size > 0 and "p" in getattr(function, "inputs", ("p",))
        return function(*arguments, p=self.p) if takes_p else function(*arguments)

    def inputs(self, name: str) -> tuple[str, ...]:
        """Names of a function's inputs, p excluded, where the function tells them."""
        known = getattr(getattr(self.functions, name), "inputs", ())
        return tuple(x for x in known if x != "p")


def bind(functions: Any, scene: Scene) -> Bound:
    """At the parameters' defaults."""
    return Bound(functions, np.array([float(x) for parameter in scene.parameters for x in parameter.default]))


def vary_parameters(scene: Scene, rng: np.random.Generator) -> tuple[Scene, Array]:
    """The scene with every parameter scaled by its own factor in 0.75…1.25, and the values of ``p`` that say so."""
    values: list[float] = []
    changed = scene
    for parameter in scene.parameters:
        factor = Fraction(float(rng.uniform(0.75, 1.25)))
        new = tuple(Fraction(float(x * factor)) for x in parameter.default)
        values.extend(float(x) for x in new)
        changed = with_parameter(changed, parameter.name, new)
    return changed, np.array(values)


def with_parameter(scene: Scene, name: str, values: tuple[Fraction, ...]) -> Scene:
    """The scene with one parameter's value replaced (``link1.mass``, ``gravity``, ``j1.damping``, …)."""
    if name == "gravity":
        x, y, z = values
        return replace(scene, gravity=(x, y, z))
    owner, _, field = name.rpartition(".")
    value: Any = values if field in ("com", "inertia") else values[0]

    def swap(items: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(replace(x, **{field: value}) if x.name == owner and hasattr(x, field) else x for x in items)

    return replace(scene, bodies=swap(scene.bodies), joints=swap(scene.joints), forces=swap(scene.forces))
