"""Choosing the plan of a function: count every family that could win, take the cheapest that is accurate, say why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symgen.catalogue import split_row
from symgen.natural.layout import NaturalCoordinates
from symgen.plans.accuracy import LOST, WORSE, estimate, relative_errors, rivals
from symgen.plans.build import build
from symgen.plans.families import FAMILIES, Family, families_of, output_merges
from symgen.plans.lagging import lagging
from symgen.plans.walk import Lowered
from symgen.program.instructions import Counts, Program, count
from symgen.scene.model import Output
from symgen.topology.tree import Tree

DIVISION_COST = 8
"""Additions that a division or a root is worth: about what it occupies a floating-point unit for."""
LITERAL_LIMIT = 6
"""Up to so many velocities the literal form may win, and is always counted."""
LITERAL_SUMS = frozenset({"gravity_force", "potential_energy"})
"""Rows that are one sum over bodies, where the literal form may win in larger scenes too."""
SMALL = 12
"""Up to so many velocities literal sums and every way to group constant inertias are weighed, the rest counted when
asked for."""


NEAR = 1.1
"""Families that cost up to so much more than the best one may overtake it once axes are merged."""
MERGING_PAYS = 0.97
"""Merged axes must save so much: their sums of angles and turned inertias live longer in registers than what they
save."""


@dataclass(frozen=True)
class PlanChoice:
    """One line of `symgen show`: a plan, its operations (None where not counted), whether it was taken, and why."""

    plan: str
    counts: Counts | None
    chosen: bool
    why: str


@dataclass(frozen=True)
class Choice:
    """The program of a function, what was weighed, and the programs of other derivations of the same derivatives:
    they are certified with it, each against the literal form and so against one another."""

    program: Program
    weighed: tuple[PlanChoice, ...]
    others: tuple[Program, ...] = ()


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


def choose(lowered: Lowered, natural: NaturalCoordinates, output: Output, every: bool = False) -> Choice:
    """The program of a function by its cheapest family, and what was weighed.

    ``every`` counts also those families that are not weighed, where that is affordable; it changes no choice.
    """
    programs: dict[Family, Program] = {}
    passed: dict[Family, str] = {}
    families = families_of(output, lowered.tree)
    for family in sorted(families, key=lambda family: not family.articulated):
        reason = _reason_to_skip(family, lowered, output, programs) if len(families) > 1 else ""
        if reason:
            passed[family] = reason
        if not reason or (every and lowered.tree.nv <= SMALL):
            programs[family] = build(lowered, natural, output, family)
    weighed = [family for family in families if family not in passed]
    best = min(weighed, key=lambda family: (cost(count(programs[family])), FAMILIES.index(family)))
    merged = _merged(lowered, output, best, weighed, programs)
    if merged:
        programs.update((family, build(lowered, natural, output, family)) for family in merged)
        families = (*families, *merged)
        rival = min(merged, key=lambda family: cost(count(programs[family])))
        if cost(count(programs[rival])) <= MERGING_PAYS * cost(count(programs[best])):
            best = rival
    errors = _errors(lowered, natural, output, best, programs, passed)
    if errors.get(best, 0) > WORSE:
        good = [family for family, error in errors.items() if error <= WORSE]
        best = min(good, key=lambda family: (cost(count(programs[family])), family.merged))
    others = [
        program
        for family, program in programs.items()
        if family not in passed and family.differentiated != best.differentiated and family.merged <= best.merged
    ]
    rows = tuple(_choice(output, family, best, programs, passed, errors) for family in families)
    return Choice(programs[best], rows, tuple(others[:1]))


def _errors(
    lowered: Lowered, natural: NaturalCoordinates, output: Output, best: Family, programs: dict[Family, Program],
    passed: dict[Family, str],
) -> dict[Family, float]:  # fmt: skip
    """Estimated errors of the cheapest plan and of those that may be far more accurate, relative to the least one's;
    empty where none may be."""
    algorithm, grouping = rivals(lowered, output, best)
    if not algorithm and not grouping:
        return {}
    afloat = any(body.joint.type == "floating" for body in lowered.tree.bodies)
    given = replace(best, regrouped=False, merged=False)
    if grouping and given in passed and estimate(lowered, programs[best]) > LOST:
        programs[given] = programs.get(given) or build(lowered, natural, output, given)
        del passed[given]
    candidates = [
        family
        for family in programs
        if family == best
        or (
            (algorithm or family.articulated == best.articulated)
            and (grouping or family.regrouped == best.regrouped)
            and family.differentiated == best.differentiated
            and not (family.literal and afloat)  # far from the origin ground axes lose more than any trial state shows
            and family not in passed
        )
    ]
    return relative_errors(lowered, programs, candidates) if len(candidates) > 1 else {}


def _merged(
    lowered: Lowered, output: Output, best: Family, weighed: Sequence[Family], programs: Mapping[Family, Program]
) -> list[Family]:
    """Families with parallel axes merged that are weighed beside the others: of the best one and those near it, in
    small scenes of all that regroup inertia."""
    if best.literal or not output_merges(output) or not lagging(lowered.links):
        return []
    small, limit = lowered.tree.nv <= SMALL, NEAR * cost(count(programs[best]))
    if not small and "inverse_dynamics_second_derivatives" in output.of:
        return []  # as long as everything else together, and 2 % shorter at best: not built twice
    chosen = [
        family
        for family in weighed
        if family.regrouped and not family.literal and (small or cost(count(programs[family])) <= limit)
    ]
    return [replace(family, merged=True) for family in dict.fromkeys((*chosen, best))]


def _reason_to_skip(family: Family, lowered: Lowered, output: Output, programs: dict[Family, Program]) -> str:
    """Why a family is not weighed. The same whether it is counted for show or not."""
    nv, rows = lowered.tree.nv, {split_row(row)[0] for row in output.of}
    if family.literal and nv > (SMALL if rows <= LITERAL_SUMS else LITERAL_LIMIT):
        return "not counted: multiplies out matrices that the other plans never form"
    if not (family.regrouped or family.literal or lowered.parametric or nv <= SMALL):
        return f"not counted: constant inertia, and more than {SMALL} velocities"
    if family.differentiated and nv > SMALL:
        return f"not counted: a tangent of every operation for each of more than {SMALL} velocities"
    articulated = programs.get(Family(articulated=True))
    if "forward_dynamics" in rows and not family.articulated and articulated is not None:
        bound = factor_lower_bound(lowered.tree)
        if bound > cost(count(articulated)):
            return f"not counted: LᵀDL alone takes at least {bound} operations"
    return ""


def _choice(
    output: Output, family: Family, best: Family, programs: dict[Family, Program], passed: dict[Family, str],
    errors: Mapping[Family, float],
) -> PlanChoice:  # fmt: skip
    name, explanation = family.plan(output), family.explanation(output)
    if family not in programs:
        return PlanChoice(name, None, False, passed[family])
    counts = count(programs[family])
    if family == best:
        alone = len(programs.keys() | passed.keys()) == 1
        refused = any(error > WORSE and cost(count(programs[other])) < cost(counts) for other, error in errors.items())
        fewest = "fewest operations of those as accurate" if refused else "fewest operations"
        return PlanChoice(name, counts, True, "the only plan" if alone else f"{fewest}: {explanation}")
    own, least = cost(counts), cost(count(programs[best]))
    unweighed = ", not weighed at this size" if family in passed else ""
    compared = f"{own / least:.2f} times the cost" if least else "the chosen one is free" if own else "free too"
    if errors.get(family, 0) > WORSE and own < least:
        compared = f"{own / least:.2f} times the cost, about {errors[family]:.0f} times the error"
    elif family.merged and own < least:
        compared = f"{own / least:.2f} times the cost, too little gained for values that live longer"
    return PlanChoice(name, counts, False, f"{compared}{unweighed}: {explanation}")
