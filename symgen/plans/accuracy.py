"""Choosing by accuracy as well as by count: no plan is taken whose rounding error is estimated far above another's.

Two things make the plans of one function differ in accuracy. LᵀDL loses what the condition of the mass matrix says,
about 4 n⁴ for a straight chain of n equal links, where articulated bodies lose little; and regrouped inertia adds what
is heavy and far out to what is light and near. Where neither is in sight nothing is estimated and nothing is lost.
Elsewhere `symgen.program.rounding` says what rounding does to each, at a few states, in milliseconds.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from symgen.plans.families import SOLVED, Family, innermost
from symgen.plans.walk import Lowered
from symgen.program.instructions import Program
from symgen.program.rounding import rounding
from symgen.scene.model import Output
from symgen.topology.tree import Tree

Array = NDArray[np.float64]

WORSE = 4.0
"""Estimates this many times the best one are refused. Their ratio is mostly good to a factor of 2.5; the largest
errors that were measured of chosen plans are up to 7.6 times the best plan's (docs/accuracy.md)."""
FLOOR = 4.0
"""Errors below so many roundings are as good as any."""
SAFE_PATH = 2
"""Up to so many velocities from the root LᵀDL and articulated bodies lose the same."""
SPREAD = 100
"""A body that carries so many times its own mass makes regrouped inertia suspect."""
LOST = 1000.0
"""With more roundings than this, inertia as given is tried also where it is too large to be weighed."""
STATES = 32
"""Half of them anywhere, half of them close to the configuration of zeros, where links often lie in line."""
NEAR = 1e-3
DRAWS = 4
"""Sets of random roundings at each state."""


def rivals(lowered: Lowered, output: Output, best: Family) -> tuple[bool, bool]:
    """Whether the other algorithm, and whether the other grouping of inertia, may be much more accurate than
    ``best``. From the tree and the masses alone."""
    rows = {innermost(row) for row in output.of}
    if not rows & SOLVED:
        return False, False
    factored = "forward_dynamics" in rows and not best.articulated and longest_path(lowered.tree) > SAFE_PATH
    return factored, best.regrouped and not lowered.parametric and spread(lowered.tree) > SPREAD


def longest_path(tree: Tree) -> int:
    """Velocities on the longest way from the root to a leaf."""
    depth = {-1: 0}
    for body in tree.bodies:
        depth[body.index] = depth[body.parent] + body.nv
    return max(depth.values())


def spread(tree: Tree) -> float:
    """The largest ratio of what a body carries to its own mass."""
    own = [sum((part.mass for part, _ in body.parts), Fraction(0)) for body in tree.bodies]
    beyond = [Fraction(0)] * len(own)
    largest = Fraction(0)
    for body in reversed(tree.bodies):
        if own[body.index] > 0:
            largest = max(largest, beyond[body.index] / own[body.index])
        if body.parent >= 0:
            beyond[body.parent] += own[body.index] + beyond[body.index]
    return float(largest)


def trial_states(tree: Tree, program: Program) -> dict[str, Array]:
    """Inputs of a program at a few states, the same on every run: angles within ±π, everything else within ±1."""
    made, states = random.Random(1), dict[str, Array]()
    for port in program.inputs:
        if port.name == "p":
            continue
        rows = np.array([[made.uniform(-1, 1) for _ in range(port.size)] for _ in range(STATES)])
        states[port.name] = rows
    if "q" in states:
        q = states["q"] * np.pi
        q[STATES // 2 :] *= NEAR
        for body in tree.bodies:
            if body.nq > body.nv:
                part = q[:, body.q + body.nq - 4 : body.q + body.nq]
                part[STATES // 2 :, 3] = 1
                part /= np.linalg.norm(part, axis=1, keepdims=True)
        states["q"] = q
    return states


def estimate(lowered: Lowered, program: Program) -> float:
    """About how many roundings of error this program has: the mean over the worst quarter of the trial states."""
    states = trial_states(lowered.tree, program)
    if any(port.name == "p" for port in program.inputs):
        defaults = [float(x) for parameter in lowered.scene.parameters for x in parameter.default]
        states["p"] = np.tile(defaults, (STATES, 1))
    found = np.sort(np.nan_to_num(rounding(program, states, DRAWS), nan=np.inf))
    return float(np.mean(found[-STATES // 4 :]))


def relative_errors(
    lowered: Lowered, programs: Mapping[Family, Program], candidates: Sequence[Family]
) -> dict[Family, float]:
    """Estimated errors, in units of that of the best of ``candidates``; up to `WORSE` is good enough."""
    found = {family: max(estimate(lowered, programs[family]), FLOOR) for family in candidates}
    least = min(found.values())
    return {family: value / least if np.isfinite(least) else 1.0 for family, value in found.items()}
