"""The steps of sweeps over links: what one link does with what arrives, over the scalars of its class.

The mathematics is that of `symgen.plans`; a step returns {output port: scalars}. States that go from link to link:

motion (18): ω, ω̇, U row by row, acceleration of the origin less gravity (see `symgen.plans.recursive`);
wrench (6): force, moment about the link's origin;
inertia (10): mass, first and second moment;
articulated (27): J and M (six each), B row by row, and the wrench of what is beyond;
acceleration (6): ω̇, acceleration of the origin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

from symgen.algebra.linear import IDENTITY, ZERO, Vec, cross, matvec, mul, scale, sub, symmetric, vadd
from symgen.loops.one_link import OneLink
from symgen.plans import factor, free, recursive
from symgen.plans.composite import project
from symgen.plans.inertia import Inertia, moment_of_inertia
from symgen.plans.links import BALL, FREE

Scalar = Any
Results = Mapping[str, Sequence[Scalar]]
Step = Callable[[OneLink], Results]
MOTION, WRENCH, INERTIA, ARTICULATED, ACCELERATION, FREED = 18, 6, 10, 27, 6, 8


def place(one: OneLink) -> Results:
    """The whole rotation of a link."""
    return {"frame": one.placement()}


def motion(with_v: bool, with_a: bool) -> Step:
    """Outward: the motion of a link from its parent's, and its wrench."""

    def step(one: OneLink) -> Results:
        rates = one.port("v", one.nv) if with_v else (0,) * one.nv
        rates2 = one.port("a", one.nv) if with_a else (0,) * one.nv
        carried = one.state("up", MOTION)
        u = (carried[6:9], carried[9:12], carried[12:15])
        parent = recursive.Motion(carried[:3], carried[3:6], u, ZERO, carried[15:])

        def outward(heading: str, root: Any, follow: Callable[[Any, Any], Any]) -> list[Any]:
            return [follow(one.moving, root if one.key.grounded else parent)]

        links: Any = SimpleNamespace(values=one.values, outward=outward, name=lambda label, vector: None)
        (found,) = recursive.link_motions(links, rates, rates2, one.gravity)
        force, moment = recursive.wrench(one.inertia, found)
        state = (*found.w, *found.w_rate, *(x for row in found.u for x in row), *found.a)
        return {"own": state, "wrench": (*force, *moment)}

    return step


def force(with_v: bool, with_a: bool) -> Step:
    """Inward: the wrench that a joint transmits, from the link's own and those of the links beyond it."""

    def step(one: OneLink) -> Results:
        total = vadd(one.state("wrench", WRENCH), one.state("arrived", WRENCH))
        asked = project(one.moving, total[:3], total[3:], one.convention)
        if with_a and not _nothing(one.armature):
            asked = vadd(asked, scale(one.armature, one.port("a", one.nv)))
        if with_v and not _nothing(one.damping):
            asked = vadd(asked, scale(one.damping, one.port("v", one.nv)))
        found: dict[str, Sequence[Scalar]] = {"result": asked}
        if not one.key.grounded:
            sent_force, sent_moment = one.moving.wrench_to_parent(total[:3], total[3:])
            found["sent"] = (*sent_force, *sent_moment)
        return found

    return step


def _nothing(x: Scalar) -> bool:
    return type(x) is int and x == 0


def _inertia(state: Vec) -> Inertia:
    return Inertia(state[0], state[1:4], state[4:])


def composite(one: OneLink) -> Results:
    """Inward: the inertia of a link with everything beyond it, and the wrenches that its joint's velocities take."""
    whole = one.inertia.plus(_inertia(one.state("arrived", INERTIA)))
    wrenches: list[Scalar] = []
    for w, v in _motions(one):
        found = vadd(scale(whole.mass, v), cross(w, whole.first))
        wrenches += [*found, *vadd(matvec(moment_of_inertia(whole), w), cross(whole.first, v))]
    result: dict[str, Sequence[Scalar]] = {"wrenches": wrenches}
    if not one.key.grounded:
        moved = one.moving.inertia_to_parent(whole)
        result["sent"] = (moved.mass, *moved.first, *moved.second)
    return result


def _motions(one: OneLink) -> list[tuple[Vec, Vec]]:
    """(w, v) of every velocity of a joint, link axes."""
    at = one.moving
    if at.link.kind == FREE:
        units = [tuple(1 if i == k else 0 for i in range(6)) for k in range(6)]
        pairs = [free.velocity(at, unit, one.convention) for unit in units]
        return [(w, v) for v, w in pairs]
    if at.link.kind == BALL:
        return [(axis, ZERO) for axis in IDENTITY]
    return [((0, 0, at.angular), (0, 0, at.linear))]


def column(one: OneLink) -> Results:
    """One column of a link's rows of the mass matrix: the wrench that a velocity beyond it takes, felt by its joint
    and carried to the parent."""
    wrench = tuple(one.graph.input(f"w{k}", 0) for k in range(WRENCH))
    result: dict[str, Sequence[Scalar]] = {"m": project(one.moving, wrench[:3], wrench[3:], one.convention)}
    if not one.key.grounded:
        sent_force, sent_moment = one.moving.wrench_to_parent(wrench[:3], wrench[3:])
        result["x"] = (*sent_force, *sent_moment)
    return result


def articulated(with_v: bool) -> Step:
    """Inward: the articulated inertia of a link with everything beyond it, its joint's velocities eliminated."""

    def step(one: OneLink) -> Results:
        at, body = one.moving, factor.Articulated(one.inertia)
        wrench = one.state("wrench", WRENCH)
        body.force, body.moment = wrench[:3], wrench[3:]
        body.join(_articulated(one.state("arrived", ARTICULATED)))
        rest = list(one.port("tau", one.nv))
        if with_v and not _nothing(one.damping):
            rest = [sub(x, mul(one.damping, y)) for x, y in zip(rest, one.port("v", one.nv), strict=True)]
        if at.link.kind == FREE:
            linear, angular = free.wrench(at, tuple(rest), one.convention)
            rest = [*linear, *angular]
        joint = SimpleNamespace(v=0, nv=one.nv, joint=one.member.joint)
        links: Any = SimpleNamespace(tree=SimpleNamespace(bodies=[joint]), values=one.values)
        freed = factor.eliminated(links, at, body, (one.armature,) * one.nv, rest)
        kept = [x for row in freed for x in (*row.moment, *row.force, row.inverse, row.rest)]
        result: dict[str, Sequence[Scalar]] = {"kept": kept, "pivot": [row.pivot for row in freed]}
        if not one.key.grounded:
            moved = body.to_parent(at)
            result["sent"] = (
                *_six(moved.j), *_six(moved.m), *(x for row in moved.b for x in row), *moved.moment, *moved.force,
            )  # fmt: skip
        return result

    return step


def _six(m: Any) -> Vec:
    return m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2]


def _articulated(state: Vec) -> factor.Articulated:
    found = factor.Articulated(Inertia())
    found.j, found.m = symmetric(state[:6]), symmetric(state[6:12])
    found.b = (state[12:15], state[15:18], state[18:21])
    found.moment, found.force = state[21:24], state[24:]
    return found


def acceleration(one: OneLink) -> Results:
    """Outward: the accelerations of a joint from what `articulated` kept, and the link's own."""
    carried = one.state("up", ACCELERATION)
    kept = one.state("kept", FREED * one.nv)
    freed = []
    for k in range(one.nv):
        row = kept[FREED * k : FREED * (k + 1)]
        freed.append(factor.Freed(row[:3], row[3:6], 0, row[6], row[7]))
    x, w_rate, a = factor.accelerated(one.moving, (carried[:3], carried[3:]), freed)
    if one.link.kind == FREE:
        x = list(free.generalised_force(one.moving, a, w_rate, one.convention))
    return {"result": x, "own": (*w_rate, *a)}
