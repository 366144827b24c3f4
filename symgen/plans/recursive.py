"""Recursive plan: inverse dynamics, bias and gravity forces by one outward and one inward pass in body axes.

τ = mass_matrix·a + C·v + gravity_force, without forming any of them (Newton–Euler on what the literal form says;
theory, §5). Forces and moments of a link both follow from U = ω̇̃ + ω̃ω̃, shared with the motion of its children.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import ZERO, Mat, Vec, add, cross, is_zero, matvec, mul, neg, scale, sub, total, vadd
from symgen.plans import free
from symgen.plans.fields import Wrench, joined
from symgen.plans.inertia import Inertia
from symgen.plans.walk import BALL, FREE, TURN, Links, Moving

Scalar = Any


@dataclass(frozen=True)
class Motion:
    """A link's motion in its own axes: ω, ω̇, U = ω̇̃ + ω̃ω̃, and the origin's acceleration less gravity."""

    w: Vec
    w_rate: Vec
    u: Mat
    squares: Vec
    """ω_x², ω_y², ω_z²."""
    a: Vec


def spin_matrix(w: Vec, w_rate: Vec) -> tuple[Mat, Vec]:
    """U = ω̇̃ + ω̃ω̃ and the squares of ω."""
    x, y, z = w
    xx, yy, zz = mul(x, x), mul(y, y), mul(z, z)
    xy, xz, yz = mul(x, y), mul(x, z), mul(y, z)
    ax, ay, az = w_rate
    u = (
        (sub(0, add(yy, zz)), sub(xy, az), add(xz, ay)),
        (add(xy, az), sub(0, add(xx, zz)), sub(yz, ax)),
        (sub(xz, ay), add(yz, ax), sub(0, add(xx, yy))),
    )
    return u, (xx, yy, zz)


def wrench(inertia: Inertia, motion: Motion) -> Wrench:
    """Force m a + U h, and moment about the origin: the axial part of UΣ − ΣUᵀ, plus h × a."""
    u, (sx, sy, sz), a = motion.u, motion.squares, motion.a
    xx, yy, zz, xy, xz, yz = inertia.second
    force = vadd(scale(inertia.mass, a), matvec(u, inertia.first))
    moment = (
        total((mul(yy, u[2][1]), neg(mul(zz, u[1][2])), mul(xy, u[2][0]), neg(mul(xz, u[1][0])), mul(yz, sub(sz, sy)))),
        total((mul(zz, u[0][2]), neg(mul(xx, u[2][0])), mul(yz, u[0][1]), neg(mul(xy, u[2][1])), mul(xz, sub(sx, sz)))),
        total((mul(xx, u[1][0]), neg(mul(yy, u[0][1])), mul(xz, u[1][2]), neg(mul(yz, u[0][2])), mul(xy, sub(sy, sx)))),
    )
    return force, vadd(moment, cross(inertia.first, a))


def link_motions(links: Links, v: Sequence[Scalar], a: Sequence[Scalar], gravity: Vec) -> list[Motion]:
    """Outward pass. ``gravity`` is subtracted from the acceleration of the ground, so that weight needs no pass of
    its own."""
    convention = links.values.scene.options.base_velocity
    root = Motion(ZERO, ZERO, (ZERO, ZERO, ZERO), ZERO, tuple(sub(0, g) for g in gravity))

    def step(at: Moving, parent: Motion) -> Motion:
        link, along = at.link, None
        rate, rate2 = tuple(v[link.v : link.v + link.nv]), tuple(a[link.v : link.v + link.nv])
        if link.kind == FREE:
            linear, w = free.velocity(at, rate, convention)
            acceleration, w_rate = free.acceleration(at, linear, w, rate2, convention)
            acceleration = vadd(acceleration, at.to_link(root.a))
        else:
            carried, carried_rate = at.to_link(parent.w), at.to_link(parent.w_rate)
            own, own_rate = (rate, rate2) if link.kind == BALL else _along_z(at.angular, rate[0], rate2[0])
            w = vadd(carried, own)
            along = _axis_column(at, parent)
            if along is None:
                w_rate = vadd(vadd(carried_rate, own_rate), cross(carried, own))
            else:
                w_rate = _rate_from_column(w, along, add(carried_rate[2], own_rate[2]))
            acceleration = at.to_link(vadd(parent.a, matvec(parent.u, at.offset)))
            if at.linear != 0:
                slide, slide_rate = _along_z(at.linear, rate[0], rate2[0])
                acceleration = vadd(vadd(acceleration, slide_rate), cross(carried, scale(2, slide)))
        links.name(f"w_{link.name}", w)
        links.name(f"dw_{link.name}", w_rate)
        links.name(f"a_{link.name}", acceleration)
        u, squares = spin_matrix(w, w_rate)
        if along is not None:
            u = tuple((*row[:2], entry) for row, entry in zip(u, along, strict=True))
        return Motion(w, w_rate, u, squares, acceleration)

    return links.outward("motion", root, step)


def _axis_column(at: Moving, parent: Motion) -> Vec | None:
    """U e of the joint's axis e, which the link shares with its parent (e is fixed in both, and U e is its second
    derivative): a column of the parent's U where the axis is along one, then two operations give what rotating
    ω̇ and its product with the joint's rate would. None where that saves nothing."""
    axis = tuple(row[2] for row in at.turn)
    if at.link.kind != TURN or sum(1 for x in axis if not is_zero(x)) != 1:
        return None
    return at.to_link(matvec(parent.u, axis))


def _rate_from_column(w: Vec, column: Vec, z: Scalar) -> Vec:
    """ω̇ from the last column of U, (ω_x ω_z + ω̇_y, ω_y ω_z − ω̇_x, …), and ω̇_z."""
    return sub(mul(w[1], w[2]), column[1]), sub(column[0], mul(w[0], w[2])), z


def _along_z(part: Scalar, rate: Scalar, rate2: Scalar) -> tuple[Vec, Vec]:
    return (0, 0, mul(part, rate)), (0, 0, mul(part, rate2))


def inverse_dynamics(links: Links, v: Sequence[Scalar], a: Sequence[Scalar], gravity: Vec) -> list[Scalar]:
    """τ without armature, springs and damping. Zero sequences of ``v`` or ``a`` (int 0) cost nothing."""
    convention = links.values.scene.options.base_velocity
    tau: list[Scalar] = [0] * links.nv
    wrenches = transmitted_wrenches(links, link_motions(links, v, a, gravity))
    for at, (force, moment) in zip(links.moving, wrenches, strict=True):
        link = at.link
        if link.kind == FREE:
            with links.phase(f"force: {link.name}"):
                tau[link.v : link.v + 6] = free.generalised_force(at, force, moment, convention)
        elif link.kind == BALL:
            tau[link.v : link.v + 3] = moment
        else:
            tau[link.v] = add(mul(at.angular, moment[2]), mul(at.linear, force[2]))
    return tau


def own_wrench(links: Links, motions: Sequence[Motion], at: Moving) -> Wrench:
    """(force, moment about the link's origin) that the link's own motion takes, link axes."""
    with links.phase(f"force: {at.link.name}"):
        return wrench(links.inertias[at.link.index], motions[at.link.index])


def tip_force(links: Links, motions: Sequence[Motion], at: Moving) -> Vec:
    """Force that the point mass takes which the link's parent has at the link's origin, parent's axes."""
    if at.link.index not in links.tips:
        return ZERO
    carrier = motions[at.link.parent]
    return scale(links.tips[at.link.index], vadd(carrier.a, matvec(carrier.u, at.offset)))


def transmitted_wrenches(links: Links, motions: Sequence[Motion]) -> list[Wrench]:
    """(force, moment about the link's origin) that each link's joint transmits to it, link axes: inward pass."""
    found: list[Wrench] = [(ZERO, ZERO)] * len(links.moving)

    def step(at: Moving, outer: Wrench) -> Wrench:
        link = at.link
        force, moment = found[link.index] = joined(own_wrench(links, motions, at), outer)
        links.name(f"f_{link.name}", force)
        links.name(f"n_{link.name}", moment)
        if link.parent < 0:
            return ZERO, ZERO
        return at.wrench_to_parent(force, moment, tip_force(links, motions, at))

    links.inward("force", found, step, joined)
    return found
