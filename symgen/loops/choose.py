"""Straight-line code or loops: which a function is emitted as, and why."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symgen.catalogue import split_row
from symgen.loops.build import build_loops, why_not
from symgen.natural.layout import NaturalCoordinates
from symgen.plans.walk import Lowered
from symgen.program.instructions import Program
from symgen.scene.model import Output
from symgen.topology.tree import Tree

PER_LINK = {"inverse_dynamics": 125, "bias_force": 120, "gravity_force": 30, "forward_dynamics": 265, "mass_matrix": 60}
"""About the operations per velocity that a row takes straight-line."""
PER_ENTRY = 14
"""About those that an entry of the mass matrix takes: one for each velocity on the way to the root."""
STRAIGHT_UP_TO = 11000
"""Operations from which on loops are written: about there straight-line code no longer stays in the caches of
instructions. Chains gain from loops earlier (at half of it, by up to a third), robots with branches and links that all
differ later: at this size either choice stays within 1.5 of the better one. Measured (see docs/large.md)."""
ALSO_STRAIGHT_UP_TO = 40000
"""Operations up to which the targets that have straight-line code only get it beside the loops in C."""


@dataclass(frozen=True)
class Code:
    """What a function is emitted as."""

    program: Program
    """For C: straight-line, or a `LoopProgram`."""
    straight: Program | None
    """For targets that know straight-line code only; None where it would be too long."""
    why: str
    note: str = ""
    """What a user must be told: what was left out or not done as asked."""


def code_of(lowered: Lowered, natural: NaturalCoordinates, output: Output, straight: Callable[[], Program]) -> Code:
    """The code of a function; ``straight`` derives its straight-line program."""
    asked, reason = lowered.scene.options.code or "auto", why_not(lowered, output)
    if asked == "straight" or reason:
        note = f"{output.name} is straight-line code, not loops: {reason}" if asked == "loops" else ""
        return Code(program := straight(), program, reason or "asked for", note)
    size = about(lowered.tree, output)
    if asked == "auto" and not too_long(size):
        return Code(program := straight(), program, f"about {size} operations: straight-line is faster")
    loops = build_loops(lowered, natural, output)
    why = "asked for" if asked == "loops" else f"about {size} operations straight-line: loops are faster"
    if size <= ALSO_STRAIGHT_UP_TO and set(lowered.scene.options.targets) - {"c"}:
        return Code(loops, straight(), why)
    others = [name for name in lowered.scene.options.targets if name != "c"]
    left_out = f"{output.name} is left out of {' and '.join(others)}: about {size} operations without loops"
    return Code(loops, None, why, left_out if others else "")


def too_long(operations: int) -> bool:
    """Whether straight-line code of so many operations had better be loops."""
    return operations > STRAIGHT_UP_TO


def about(tree: Tree, output: Output) -> int:
    """About the operations of a function's straight-line form, from the tree alone."""
    rows = {split_row(row)[0] for row in output.of}
    if {"bias_force", "forward_dynamics"} <= rows:
        rows.remove("bias_force")  # forward dynamics computes it
    total = sum(PER_LINK[row] for row in rows) * tree.nv
    if "mass_matrix" in rows:
        above: dict[int, int] = {-1: 0}
        for body in tree.bodies:
            above[body.index] = above[body.parent] + body.nv
        total += PER_ENTRY * sum(body.nv * above[body.index] for body in tree.bodies)
    return total
