"""Composite plan: the mass matrix from inertias accumulated from the leaves, in body axes (theory, §5).

R factors along paths, so RᵀMR[i, j] is the force that moving joint j alone asks of joint i, carried by the
composite inertia of everything beyond j.
"""

from __future__ import annotations

from typing import Any

from symgen.algebra.linear import IDENTITY, ZERO, Vec, add, mul
from symgen.plans import free
from symgen.plans.fields import Wrench, carried_wrench, field_wrench
from symgen.plans.inertia import Inertia
from symgen.plans.walk import BALL, FREE, Links, Moving

Scalar = Any


def composite_inertias(links: Links) -> list[Inertia]:
    """Inertia of each link with everything beyond it, about the link's origin, link axes."""
    found = list(links.inertias)

    def step(at: Moving, composite: Inertia) -> Inertia:
        found[at.link.index] = composite
        links.name(f"hc_{at.link.name}", composite.first)
        return at.inertia_to_parent(composite) if at.link.parent >= 0 else composite

    links.inward("composite inertia", links.inertias, step, lambda mine, theirs: mine.plus(theirs))
    return found


def motions(at: Moving, convention: str) -> list[tuple[Vec, Vec]]:
    """(w, v) of every velocity of a link's joint: the motion of its origin, link axes."""
    if at.link.kind == FREE:
        return free.motions(at, convention)
    if at.link.kind == BALL:
        return [(axis, ZERO) for axis in IDENTITY]
    return [((0, 0, at.angular), (0, 0, at.linear))]


def project(at: Moving, force: Vec, moment: Vec, convention: str) -> Vec:
    """What a wrench about the link's origin, in link axes, asks of the link's own joint."""
    if at.link.kind == FREE:
        return free.generalised_force(at, force, moment, convention)
    if at.link.kind == BALL:
        return moment
    return (add(mul(at.angular, moment[2]), mul(at.linear, force[2])),)


def mass_matrix(links: Links) -> list[list[Scalar]]:
    """RᵀMR without armature, dense rows; entries between branches are structural zeros."""
    nv, convention = links.nv, links.values.scene.options.base_velocity
    m: list[list[Scalar]] = [[0] * nv for _ in range(nv)]
    composites = composite_inertias(links)
    for at in links.moving:
        with links.phase(f"mass matrix: columns of {at.link.name}"):
            composite, start = composites[at.link.index], at.link.v
            if at.link.kind == FREE:
                for i, row in enumerate(free.block(at, composite, convention)):
                    m[start + i][start : start + 6] = row
                continue
            for k, motion in enumerate(motions(at, convention)):
                _column(links, m, at, k, field_wrench(composite, *motion))
    return m


def _column(links: Links, m: list[list[Scalar]], at: Moving, k: int, wrench: Wrench) -> None:
    """Column k of a link's joint: project the wrench on its own joint, then on every joint towards the root."""
    convention = links.values.scene.options.base_velocity
    j = at.link.v + k
    for i, value in enumerate(project(at, *wrench, convention)[: k + 1]):
        m[at.link.v + i][j] = m[j][at.link.v + i] = value
    for above, felt in carried_wrench(links, at, wrench):
        for i, value in enumerate(project(above, *felt, convention)):
            m[above.link.v + i][j] = m[j][above.link.v + i] = value
