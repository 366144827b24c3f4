"""Joint wrenches by the recursive plan: what arrives at a joint on the inward pass is what it transmits.

Inertia stays as given here: regrouping moves mass between bodies, which no joint torque feels, but its wrench does.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from symgen.algebra.linear import Vec, cross, matvec, vadd, vsub
from symgen.literal.reactions import End
from symgen.plans.fields import Wrench, joined
from symgen.plans.frames import to_link_frame
from symgen.plans.recursive import link_motions, wrench
from symgen.plans.walk import Links, Moving

Scalar = Any


def joint_wrenches(
    links: Links, v: Sequence[Scalar], a: Sequence[Scalar], gravity: Vec, springs: Iterable[End]
) -> list[Vec]:
    """W (moving bodies, 6): force, then moment about the child's frame origin, child axes. ``links`` with inertia as
    given; ``springs``: the ends of springs between points, forces in ground axes."""
    motions = link_motions(links, v, a, gravity)
    start = [wrench(inertia, motion) for inertia, motion in zip(links.inertias, motions, strict=True)]
    for end in springs:
        _pull(links, end, start)
    found: list[Vec] = [()] * len(links.tree.bodies)

    def step(at: Moving, here: Wrench) -> Wrench:
        if at.link.carries:
            axes, shift = links.values.matrix(at.link.axes), links.values.vector(at.link.shift)
            force = matvec(axes, here[0])
            found[at.link.body] = (*force, *vadd(matvec(axes, here[1]), cross(shift, force)))
        return at.wrench_to_parent(*here) if at.link.parent >= 0 else here

    links.inward("force", start, step, joined)
    return found


def _pull(links: Links, end: End, wrenches: list[Wrench]) -> None:
    """Take a spring's force off what the joints must transmit."""
    at = next(at for at in links.moving if at.link.body == end.body and at.link.carries)
    with links.phase(f"springs: {at.link.name}"):
        force = end.force
        for above in (*reversed(links.ancestors(at)), at):
            force = above.to_link(force)
        own, moment = wrenches[at.link.index]
        arm = to_link_frame(links, at, end.local)
        wrenches[at.link.index] = vsub(own, force), vsub(moment, cross(arm, force))
