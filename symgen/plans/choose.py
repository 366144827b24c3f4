"""Choosing the plan of a function: count every family that could win, take the cheapest, say why."""

from __future__ import annotations

from dataclasses import dataclass

from symgen.catalogue import split_row
from symgen.natural.layout import NaturalCoordinates
from symgen.plans.build import FAMILIES, Family, build, families_of
from symgen.plans.walk import Lowered
from symgen.program.instructions import Counts, Program, count
from symgen.scene.model import Output
from symgen.topology.tree import Tree

DIVISION_COST = 8
"""Additions that a division or a root is worth: about what it occupies a floating-point unit for."""
LITERAL_LIMIT = 3
"""Up to so many velocities the literal form may win, and is always counted."""
LITERAL_SHOWN = 12
"""Up to so many it is counted when asked for."""
SMALL = 12
"""Up to so many velocities every way to group constant inertias is counted."""


@dataclass(frozen=True)
class PlanChoice:
    """One line of `symgen show`: a plan, its operations (None where not counted), whether it was taken, and why."""

    plan: str
    counts: Counts | None
    chosen: bool
    why: str


def cost(counts: Counts) -> int:
    """Operations weighted by what they take."""
    return counts.add + counts.mul + DIVISION_COST * (counts.div + counts.sqrt)


def factor_lower_bound(tree: Tree) -> int:
    """Operations of LᵀDL and its solves from the sparsity alone: what forward dynamics by factoring costs at least."""
    total, depth = 0, {-1: 0}
    for body in tree.bodies:
        before = depth[body.parent]
        for k in range(body.nv):
            above = before + k
            total += above * (above + 1) + 5 * above
        depth[body.index] = before + body.nv
    return total


def choose(
    lowered: Lowered, natural: NaturalCoordinates, output: Output, every: bool = False
) -> tuple[Program, tuple[PlanChoice, ...]]:
    """The program of a function by its cheapest family, and what was weighed.

    ``every`` counts also those families that cannot win, where that is affordable.
    """
    tree = lowered.tree
    programs: dict[Family, Program] = {}
    passed: dict[Family, str] = {}
    families = families_of(output)
    only = len(families) == 1
    solves = any(split_row(row)[0] == "forward_dynamics" for row in output.of)
    bound = factor_lower_bound(tree)
    order = sorted(families, key=lambda family: not family.articulated)
    for family in order:
        reason = "" if only else _reason_to_skip(family, lowered, solves, bound, programs, every)
        if reason:
            passed[family] = reason
        else:
            programs[family] = build(lowered, natural, output, family)
    best = min(families, key=lambda family: _rank(family, programs))
    return programs[best], tuple(_choice(output, family, best, programs, passed) for family in families)


def _rank(family: Family, programs: dict[Family, Program]) -> tuple[bool, int, int]:
    counted = family in programs
    return (not counted, cost(count(programs[family])) if counted else 0, FAMILIES.index(family))


def _reason_to_skip(
    family: Family, lowered: Lowered, solves: bool, bound: int, programs: dict[Family, Program], every: bool
) -> str:
    tree = lowered.tree
    if family.literal and tree.nv > (LITERAL_SHOWN if every else LITERAL_LIMIT):
        return "not counted: multiplies out matrices that the other plans never form"
    if not (family.regrouped or family.literal or every or lowered.parametric or tree.nv <= SMALL):
        return "not counted: constant inertia, and more than 12 velocities"
    articulated = programs.get(Family(articulated=True))
    if solves and not family.articulated and articulated is not None:
        known = cost(count(articulated))
        if bound > known:
            return f"not counted: LᵀDL alone takes at least {bound} operations"
    return ""


def _choice(
    output: Output, family: Family, best: Family, programs: dict[Family, Program], passed: dict[Family, str]
) -> PlanChoice:
    name, explanation = family.plan(output), family.explanation(output)
    if family not in programs:
        return PlanChoice(name, None, False, passed[family])
    counts = count(programs[family])
    if family == best:
        alone = len(programs) + len(passed) == 1
        return PlanChoice(name, counts, True, "the only plan" if alone else f"fewest operations: {explanation}")
    more = cost(counts) / max(cost(count(programs[best])), 1)
    return PlanChoice(name, counts, False, f"{more:.2f} times the cost: {explanation}")
