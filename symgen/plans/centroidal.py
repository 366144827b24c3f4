"""Centre of mass and momentum by one pass inward in body axes; the momentum matrix from composite inertias.

Regrouped inertia serves: what moves to a parent has the same mass, the same centre and the same momentum there.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import ZERO, Vec, cross, is_zero, scale, vadd, vsub
from symgen.plans.composite import composite_inertias, motions
from symgen.plans.coriolis import first_moments, link_velocities
from symgen.plans.fields import Wrench, field_wrench, joined
from symgen.plans.frames import in_ground, rotations
from symgen.plans.inertia import Inertia
from symgen.plans.walk import Links, Moving

Scalar = Any


def _roots(links: Links) -> list[Moving]:
    return [at for at in links.moving if at.link.parent < 0]


def _one_root(links: Links) -> Moving | None:
    """The only link that ground carries, where all mass is beyond it: then the centre is best seen from that link."""
    roots = _roots(links)
    grounded = not all(is_zero(x) for x in (links.ground.mass, *links.ground.first))
    return roots[0] if len(roots) == 1 and not grounded else None


def _per(mass: Scalar, first: Vec) -> Vec:
    """A first moment over a mass."""
    return scale(Fraction(1) / mass if isinstance(mass, int) else 1 / mass, first)


def _in_ground(links: Links, moments: Sequence[tuple[Scalar, Vec]]) -> Vec:
    """First moment of everything about the ground's origin, from mass and moment of each root with all beyond it."""
    first = links.ground.first
    for at in _roots(links):
        own, h = moments[at.link.index]
        first = vadd(first, vadd(at.to_parent(h), scale(own, at.offset)))
    return first


def center_of_mass(links: Links, mass: Scalar) -> Vec:
    """Centre of mass of all moving bodies (3), ground axes; ``mass`` of all of them."""
    return _per(mass, _in_ground(links, first_moments(links)))


def momentum(links: Links, v: Sequence[Scalar], mass: Scalar) -> Vec:
    """Linear momentum, then angular momentum about the centre of mass (6), ground axes."""
    arrived = _momenta(links, v)
    moments = first_moments(links)
    root = _one_root(links)
    if root is not None:
        (_, h), (p, spin) = moments[root.link.index], arrived[root.link.index]
        centre = _per(mass, h)
        return (*root.to_parent(p), *root.to_parent(vsub(spin, cross(centre, p))))
    linear, angular = ZERO, ZERO
    for at in _roots(links):
        p, spin = at.wrench_to_parent(*arrived[at.link.index])
        linear, angular = vadd(linear, p), vadd(angular, spin)
    return (*linear, *vsub(angular, cross(_per(mass, _in_ground(links, moments)), linear)))


def _momenta(links: Links, v: Sequence[Scalar]) -> list[Wrench]:
    """(momentum, moment of momentum about the link's origin) of each link with everything beyond it, link axes."""
    start = [
        field_wrench(inertia, at.w, at.v) for inertia, at in zip(links.inertias, link_velocities(links, v), strict=True)
    ]
    found = list(start)

    def step(at: Moving, here: Wrench) -> Wrench:
        found[at.link.index] = here
        return at.wrench_to_parent(*here) if at.link.parent >= 0 else here

    links.inward("momentum", start, step, joined)
    return found


def momentum_matrix(links: Links, mass: Scalar) -> list[list[Scalar]]:
    """A (6, joint velocities): the momentum of everything beyond a joint that moves alone."""
    rows: list[list[Scalar]] = [[0] * links.nv for _ in range(6)]
    convention = links.values.scene.options.base_velocity
    composites = composite_inertias(links)
    axes, centres = rotations(links, links.moving), _centres(links, composites, mass)
    root = _one_root(links)
    for at in links.moving:
        with links.phase(f"momentum matrix: columns of {at.link.name}"):
            composite, centre = composites[at.link.index], centres[at.link.index]
            for k, (w, v) in enumerate(motions(at, convention)):
                p, spin = field_wrench(composite, w, v)
                about = ZERO if at is root and w == ZERO else vsub(spin, cross(centre, p))
                column = (*in_ground(axes[at.link.index], p), *in_ground(axes[at.link.index], about))
                for i, value in enumerate(column):
                    rows[i][at.link.v + k] = value
    return rows


def _centres(links: Links, composites: Sequence[Inertia], mass: Scalar) -> list[Vec]:
    """The centre of mass of everything, seen from each link."""
    root = _one_root(links)
    if root is not None:
        seen = _per(mass, composites[root.link.index].first)

        def start(at: Moving) -> Vec:
            return seen

    else:
        centre = _per(mass, _in_ground(links, [(composite.mass, composite.first) for composite in composites]))

        def start(at: Moving) -> Vec:
            return at.to_link(vsub(centre, at.offset))

    def step(at: Moving, parent: Vec) -> Vec:
        return start(at) if at.link.parent < 0 else at.to_link(vsub(parent, at.offset))

    return links.outward("centre of mass in link axes", ZERO, step)
