"""Where a mass matrix is singular to working precision.

A pivot of an exactly singular mass matrix comes out as a rounding error, of either sign: a guard that only asks for
pivot > 0 lets accelerations of 1e16 through. So a pivot must exceed what rounding makes of it:

    pivot_k − ε_k C_k > 0,      C_k ≥ M_kk a bound from masses and lengths,      ε_k = 8 u · max |δ pivot_k| / C_k,

u half a unit in the last place, δ what a rounding of every operation makes of the pivot (`symgen.program.rounding`) at
the trial states. What is left out as ε_k C_k is what the matrix cannot be told from a singular one by.

Most pivots need no such margin. The pivot of a velocity is the least energy, twice, of motions with that velocity 1 and
those before it 0, so it is at least what the joint's own link has alone; where that is far above the rounding of C_k,
pivot_k > 0 is enough.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.algebra.linear import add, dot, known_value, mul
from symgen.algebra.numbers import FloatNumbers
from symgen.plans.accuracy import trial_states
from symgen.plans.inertia import Inertia, moment_of_inertia
from symgen.plans.walk import BALL, FREE, SCREW, SLIDE, Links, Lowered, Moving
from symgen.program.graph import Graph, Node, extract
from symgen.program.instructions import Port
from symgen.program.rounding import UNITS, is_rounded, movements
from symgen.velocity.values import Values

Scalar = Any

SAFETY = 8.0
"""A pivot must exceed what rounding makes of it by so much."""
PROVEN = 2.0**13
"""An own inertia of so many roundings of the bound needs no margin: every operation may lose a few of them."""
REACH = 1000.0
"""Displacements up to so many metres are covered where no margin is needed."""
SPAN = 100.0
"""So are run-time parameters up to so many times their defaults, and down to so small a part of them."""


@dataclass(frozen=True)
class Margins:
    """Which pivots need a margin, by coordinate, and by link how the bound C divides sums (see `_second_moments`)."""

    needed: tuple[bool, ...]
    shares: tuple[float, ...]


def margins(lowered: Lowered) -> Margins:
    """From the scene's own numbers: what each link has alone beside the bound of what it carries. Found once."""
    known = lowered.tree.kept.get("margins")
    if isinstance(known, dict) and lowered.scene.options.precision in known:
        found: Margins = known[lowered.scene.options.precision]
        return found
    near, far, small = (_placed(lowered, *place) for place in ((1.0, 1.0), (REACH, SPAN), (1.0, 1 / SPAN)))
    shares = tuple(_shares(near))
    least = PROVEN * UNITS[lowered.scene.options.precision]
    pairs = zip(_own(lowered, small), _bounds(lowered, far, shares), strict=True)
    made = Margins(tuple(not own > least * bound for own, bound in pairs), shares)
    lowered.tree.kept.setdefault("margins", {})[lowered.scene.options.precision] = made
    return made


def guards(
    lowered: Lowered, graph: Graph, values: Values, q: Sequence[Scalar], pivots: Sequence[tuple[int, Node]],
    inputs: tuple[Port, ...],
) -> list[Node]:  # fmt: skip
    """What must be positive, of the (coordinate, pivot) that need a margin."""
    links = lowered.at(values, q, regrouped=False)
    bounds = _bounds(lowered, links, margins(lowered).shares)
    wanted = [(pivot, bounds[k]) for k, pivot in pivots]
    ratios = _rounding_of(lowered, graph, wanted, inputs)
    unit = UNITS[lowered.scene.options.precision]
    margins_of = [_margin(SAFETY * unit * ratio, c) for (_, c), ratio in zip(wanted, ratios, strict=True)]
    return [_less(graph, pivot, margin) for (pivot, _), margin in zip(wanted, margins_of, strict=True)]


def _placed(lowered: Lowered, slide: float, factor: float) -> Links:
    """The links as floats: slides at ``slide`` metres, parameters at ``factor`` times their defaults."""
    p = [factor * float(x) for parameter in lowered.scene.parameters for x in parameter.default]
    q = [0.0] * sum(body.nq for body in lowered.tree.bodies if body.coupling is None)
    for link in lowered.links:
        body = lowered.tree.bodies[link.body]
        if link.kind in (BALL, FREE):
            q[body.q + body.nq - 1] = 1.0
    values = Values(lowered.scene, FloatNumbers(), p)
    links = lowered.at(values, q, regrouped=False)
    if any(link.kind in (SLIDE, SCREW) for link in lowered.links):
        moving = tuple(_slid(at, slide) for at in links.moving)
        return replace(links, moving=moving)
    return links


def _slid(at: Moving, slide: float) -> Moving:
    if at.link.kind not in (SLIDE, SCREW):
        return at
    along = tuple(float(row[2]) for row in at.turn)
    return replace(at, offset=tuple(float(x) + slide * a for x, a in zip(at.offset, along, strict=True)))


def _trace(inertia: Inertia) -> Scalar:
    """Σ m|x|² about the link's origin."""
    return add(add(inertia.second[0], inertia.second[1]), inertia.second[2])


def _shares(links: Links) -> list[float]:
    """By link: the t of `_second_moments` for which the bound is least at this place, a power of two."""
    masses = [float(inertia.mass) for inertia in links.inertias]
    seconds = [float(_trace(inertia)) for inertia in links.inertias]
    found = [1.0] * len(masses)
    for at in reversed(links.moving):
        k, parent, length = at.link.index, at.link.parent, math.sqrt(float(dot(at.offset, at.offset)))
        if parent < 0:
            continue
        if length > 0 and masses[k] > 0 and seconds[k] > 0:
            found[k] = 2.0 ** round(math.log2(length * math.sqrt(masses[k] / seconds[k])))
        masses[parent] += masses[k]
        seconds[parent] += (math.sqrt(max(seconds[k], 0)) + length * math.sqrt(max(masses[k], 0))) ** 2
    return found


def _second_moments(links: Links, shares: Sequence[float]) -> tuple[list[Scalar], list[Scalar]]:
    """Mass of every link and all beyond it, and a bound of their Σ m|x|² about its origin in every configuration: at a
    distance L it is at most Σ m(|x| + L)² ≤ (1 + t) Σ m|x|² + (1 + 1/t) m L², for every t > 0."""
    masses = [inertia.mass for inertia in links.inertias]
    seconds = [_trace(inertia) for inertia in links.inertias]
    for at in reversed(links.moving):
        k, parent, t = at.link.index, at.link.parent, Fraction(shares[at.link.index])
        if parent < 0:
            continue
        length = dot(at.offset, at.offset)
        further = mul(mul(_as(length, 1 + 1 / t), length), masses[k])
        same = known_value(length) == 0
        masses[parent] = add(masses[parent], masses[k])
        seconds[parent] = add(seconds[parent], seconds[k] if same else mul(_as(seconds[k], 1 + t), seconds[k]))
        seconds[parent] = _short(add(seconds[parent], 0 if same else further))
    return masses, seconds


def _as(like: Scalar, value: Fraction) -> Scalar:
    return float(value) if isinstance(like, float) else value


def _short(x: Scalar) -> Scalar:
    """A rational as one of few digits that is not smaller."""
    value = None if isinstance(x, float) else known_value(x)
    if value is None or value <= 0:
        return x
    short = Fraction(float(value) * (1 + 2.0**-20)).limit_denominator(10**30)
    return x.graph.const(short) if isinstance(x, Node) else short


def _bounds(lowered: Lowered, links: Links, shares: Sequence[float]) -> list[Scalar]:
    """C of every coordinate. Coupled joints: (Σ g √C)² ≤ n Σ g² C."""
    masses, seconds = _second_moments(links, shares)
    joints: list[Scalar] = []
    for at in links.moving:
        m, s = masses[at.link.index], seconds[at.link.index]
        turning = add(s, mul(mul(at.linear, at.linear), m)) if at.link.kind == SCREW else s
        joints += {FREE: [m, m, m, s, s, s], BALL: [s, s, s], SLIDE: [m]}.get(at.link.kind, [turning])
    found: list[Scalar] = [0] * lowered.tree.nv
    rates = [(body, body.v + k) for body in lowered.tree.bodies for k in range(body.nv)]
    sharing = Counter(k for _, k in rates)
    for (body, k), c in zip(rates, joints, strict=True):
        g = body.coupling.multiplier if body.coupling is not None else 1
        bound = add(c, links.values.armature(body.joint))
        weight = Fraction(g) ** 2 * sharing[k]
        found[k] = add(found[k], bound if weight == 1 else mul(_as(bound, weight), bound))
    return found


def _own(lowered: Lowered, links: Links) -> list[float]:
    """By coordinate: no pivot is smaller than this, the inertia of the joint's own link with the armature."""
    bodies, found = lowered.tree.bodies, [0.0] * lowered.tree.nv
    start = {body.index: sum(other.nv for other in bodies[: body.index]) for body in bodies}
    for at in links.moving:
        body = bodies[at.link.body]
        still = all(bodies[up.link.body].v < body.v or up.link.body == body.index for up in links.ancestors(at))
        if body.coupling is None and still:
            first, armature = body.v + at.link.v - start[body.index], float(links.values.armature(body.joint))
            own = _alone(at, links.inertias[at.link.index])
            found[first : first + at.link.nv] = [x + armature for x in own]
    return found


def _alone(at: Moving, inertia: Inertia) -> list[float]:
    """Least pivots of a link that is alone."""
    turning: NDArray[np.float64] = np.array(moment_of_inertia(inertia), dtype=float)
    m, h = float(inertia.mass), np.array(inertia.first, dtype=float)
    if at.link.kind in (BALL, FREE):
        least = max(float(np.linalg.eigvalsh(turning)[0]), 0.0)
        if at.link.kind == BALL:
            return [least] * 3
        if least == 0:
            return [0.0] * 6
        cross = np.array([[0, -h[2], h[1]], [h[2], 0, -h[0]], [-h[1], h[0], 0]])
        # linear velocities are eliminated last: what is left of m when the link is free to turn
        left = m * np.eye(3) - cross.T @ np.linalg.solve(turning, cross)
        return [max(float(np.linalg.eigvalsh(left)[0]), 0.0)] * 3 + [least] * 3
    if at.link.kind == SLIDE:
        return [m]
    return [float(turning[2, 2]) + (float(at.linear) ** 2 * m if at.link.kind == SCREW else 0.0)]


def _rounding_of(
    lowered: Lowered, graph: Graph, wanted: Sequence[tuple[Node, Scalar]], inputs: tuple[Port, ...]
) -> list[float]:
    """By pivot: the largest |δ pivot|/C over the trial states, δ for a relative rounding of 1."""
    results = [[pivot for pivot, _ in wanted], [c for _, c in wanted]]
    program = extract(graph, "pivots", inputs, (Port("pivot", (len(wanted),)), Port("bound", (len(wanted),))), results)
    states = trial_states(lowered.tree, program)
    count = len(next(iter(states.values()))) if states else 1
    if any(port.name == "p" for port in inputs):
        states["p"] = np.tile([float(x) for row in lowered.scene.parameters for x in row.default], (count, 1))
    values, moves = movements(program, states, is_rounded, 1)
    n = len(wanted)
    with np.errstate(all="ignore"):
        ratios = np.nan_to_num(moves[:n] / values[n:], nan=0.0, posinf=0.0)
    return [float(x) for x in np.max(ratios, axis=1)]


def _less(graph: Graph, pivot: Node, margin: Scalar) -> Node:
    """pivot − margin of the pivot as it is computed: no constant is drawn into its sum."""
    return graph.raw("sub", pivot, margin if isinstance(margin, Node) else graph.const(margin)) if margin else pivot


def _margin(part: float, bound: Scalar) -> Scalar:
    """ε C; powers of two, for a reader."""
    known = known_value(bound)
    if part <= 0 or known == 0:
        return 0
    if known is not None:
        return Fraction(2) ** math.ceil(math.log2(part * float(known)))
    return mul(Fraction(2) ** math.ceil(math.log2(part)), bound)
