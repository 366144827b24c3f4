"""Compiled functions of a scene, one set for every way to have them: precision, trigonometry, batch, and plan."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.catalogue import function_name
from symgen.generate import generate
from symgen.plans.build import build
from symgen.plans.choose import Choice
from symgen.plans.families import Family, families_of, output_merges
from symgen.plans.lagging import lagging
from symgen.program.instructions import count
from symgen.program.rounding import UNITS
from symgen.scene.canonical import with_hash
from symgen.scene.model import Output, Scene
from symgen.system import System

Array = NDArray[np.float64]
LONGEST_LITERAL = 6
"""Velocities up to which the literal form is among the plans that are compared."""


@dataclass(frozen=True)
class Variant:
    """A way to have a function."""

    precision: str = "double"
    trigonometry: str = "polynomial"
    batch: bool = False
    family: Family | None = None
    """None: the plan that is chosen."""
    loops: bool = False

    @property
    def name(self) -> str:
        words = [self.precision, self.trigonometry if self.trigonometry != "polynomial" else ""]
        words += ["batch" if self.batch else "", "loops" if self.loops else ""]
        return " ".join(word for word in words if word)

    @property
    def unit(self) -> float:
        return UNITS[self.precision]


STANDARD = (
    Variant(),
    Variant(trigonometry="libm"),
    Variant(batch=True),
    Variant("float"),
    Variant("float", "libm"),
    Variant("float", batch=True),
)


@dataclass(frozen=True)
class Compiled:
    """One compiled function, over arrays of states."""

    variant: Variant
    function: str
    plan: str
    operations: int
    """Additions, multiplications, divisions and roots of the program."""
    call: Callable[[Mapping[str, Array]], Array]
    """Inputs (states, size) → outputs one behind the other, (states, size), as doubles."""


def compile_variant(system: System, outputs: tuple[Output, ...], variant: Variant, folder: Path) -> list[Compiled]:
    """Generate (certified, as always) and compile functions. Raises SymgenError where that cannot be done."""
    scene = with_options(system.scene, outputs, variant)
    fresh = System(scene, system.tree, system.natural, chosen(system, outputs, variant.family))
    loaded = generate(scene, folder, system=fresh).load()
    names = {output: function_name(output.name) for output in outputs}
    return [
        Compiled(
            variant, output.name, fresh.code(output.name).program.plan, count(fresh.program(output.name)).flops,
            _call(getattr(loaded, name)),
        )
        for output, name in names.items()
        if name in loaded
    ]  # fmt: skip


def with_options(scene: Scene, outputs: tuple[Output, ...], variant: Variant) -> Scene:
    code = "loops" if variant.loops else "straight" if variant.family else scene.options.code
    options = replace(
        scene.options, precision=variant.precision, trigonometry=variant.trigonometry, batch=variant.batch,
        targets=("c",), code=code,
    )  # fmt: skip
    return with_hash(replace(scene, outputs=outputs, options=options))


def chosen(system: System, outputs: tuple[Output, ...], family: Family | None) -> dict[tuple[Output, bool], Choice]:
    """What `System` keeps, with a plan already chosen."""
    if family is None:
        return {}
    programs = {output: build(system.lowered, system.natural, output, family) for output in outputs}
    return {(output, every): Choice(program, ()) for output, program in programs.items() for every in (False, True)}


def plans_of(system: System, output: Output) -> list[Family]:
    """Every family that a function can have, whether it would be weighed or not."""
    found = []
    for family in families_of(output, system.tree):
        if family.literal and system.tree.nv > LONGEST_LITERAL:
            continue
        found.append(family)
        if not family.literal and output_merges(output) and lagging(system.lowered.links):
            found.append(replace(family, merged=True))
    return found


def _call(function: Any) -> Callable[[Mapping[str, Array]], Array]:
    """Without a batch form among the files the scalar function runs state after state."""

    def call(states: Mapping[str, Array]) -> Array:
        given = {name: states[name] for name in function.inputs}
        if "dt" in given:
            given["dt"] = given["dt"][:, 0]
        count = len(next(iter(given.values())))
        found = function(**given)
        rows = found if isinstance(found, tuple) else (found,)
        return np.hstack([np.asarray(row, dtype=np.float64).reshape(count, -1) for row in rows])

    return call
