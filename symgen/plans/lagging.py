"""Axes that stay behind: links whose axes need not turn with them, so that motion and forces turn less often."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symgen.algebra.linear import is_zero, sub
from symgen.plans.inertia import Inertia
from symgen.plans.links import TURN, Link

Scalar = Any


def lagging(links: Sequence[Link]) -> frozenset[int]:
    """Turning links followed by one about a parallel axis. Their axes may stay behind with the parent's: then nothing
    has to be turned from one to the next, only what is constant in the body (its inertia, its children's places), by
    the sum of the angles so far."""
    return frozenset(
        link.parent
        for link in links
        if parallel(link) and links[link.parent].kind == TURN and sparse(links[link.parent])
    )


def lagging_leaves(links: Sequence[Link], inertias: Sequence[Inertia]) -> frozenset[int]:
    """Turning links without children whose axes had better stay behind: turning the inertia takes fewer operations
    than turning motion and forces there and back."""
    parents = {link.parent for link in links}
    return frozenset(
        link.index
        for link in links
        if link.kind == TURN and link.index not in parents and not link.planar and sparse(link)
        if _operations_behind(inertias[link.index]) < _operations_along(inertias[link.index])
    )


def _operations_along(inertia: Inertia) -> int:
    """Operations of a leaf's dynamics in axes that turn with it: ω, one column of U, the moment there and back, and,
    where it has a first moment, acceleration and force as well; and its wrench."""
    (hx, hy, _), (xx, yy, _, xy, xz, yz) = inertia.first, inertia.second
    first, second = _present(hx, hy), tuple(0 if is_zero(x) else 1 for x in (xx, yy, xy, xz, yz))
    # A slender body along x or y needs one component of the column, of the acceleration and of the moment less.
    slender = not (_present(hy, yy, xy, xz, yz) and _present(hx, xx, xy, xz, yz))
    return 18 + (12 if first else 0) - (10 if slender else 0) + _operations_of_wrench(first, second)


def _operations_behind(inertia: Inertia) -> int:
    """Operations of a leaf's dynamics in axes that stay behind: h and Σ are turned instead, and denser afterwards."""
    (hx, hy, _), (xx, yy, _, xy, xz, yz) = inertia.first, inertia.second
    first, mixed, skewed = _present(hx, hy), _present(xz, yz), _present(xy) + _present(sub(xx, yy))
    turning = sum((0, 2, 6)[found] for found in (first, mixed)) + (0, 6, 8)[skewed]
    alike = 0 if is_zero(xx) and is_zero(yy) else 1
    second = (1, 1, 1) if skewed else (alike, alike, 0)
    return turning + _operations_of_wrench(2 if first else 0, (*second, *((1, 1) if mixed else (0, 0))))


def _present(*values: Scalar) -> int:
    return sum(1 for x in values if not is_zero(x))


def _operations_of_wrench(first: int, second: Sequence[int]) -> int:
    """Multiplications and additions of U h, h × a and the moment of UΣ (see `symgen.plans.recursive.wrench`)."""
    moments = sum(cost * present for cost, present in zip((4, 4, 7, 7, 7), second, strict=True))
    return (10 * first - 3 if first else 0) + moments


def parallel(link: Link) -> bool:
    """A turn about an axis parallel to its parent's (the same way or the other)."""
    return link.kind == TURN and link.parent >= 0 and not link.loose and abs(link.turn[2][2]) == 1 and sparse(link)


def sparse(link: Link) -> bool:
    """The constant part of the rotation has few entries, all known."""
    return not link.loose and sum(1 for row in link.turn for x in row if x != 0) <= 5
