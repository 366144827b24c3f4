"""The constants of links, and how they look: zero, one, minus one or any number.

Links that look alike are one class and share their code.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from symgen.algebra.linear import ZERO, matvec
from symgen.plans.inertia import NO_MOMENT, Inertia, link_inertias, rotate_second, shift
from symgen.plans.links import BALL, FREE, SCREW, SLIDE, TURN, Link
from symgen.plans.walk import Lowered, Rationals
from symgen.velocity.values import Values

Scalar = Any
TURN_AT, OFFSET_AT, MASS_AT, FIRST_AT, SECOND_AT = 0, 9, 12, 13, 16
ARMATURE_AT, DAMPING_AT, PITCH_AT, SLOTS = 22, 23, 24, 25
PLACED = (*range(TURN_AT, MASS_AT), PITCH_AT)
"""Slots that say how a link stands on its parent."""
INERTIAL = tuple(range(MASS_AT, ARMATURE_AT))
SPARSE, WHOLE = "sparse", "whole"
"""A link's rotation is applied as a constant one and a turn about z, or kept as one matrix."""
ANY = "x"
REGROUPED_IN_A_ROW = 12
"""Regrouping multiplies denominators from link to link; every so many links towards the root it starts anew, in trees
where constants would become long."""


@dataclass(frozen=True)
class Slots:
    """A link with its constants, and what they look like."""

    link: Link
    values: tuple[Fraction, ...]

    @cached_property
    def looks(self) -> tuple[str, ...]:
        return tuple(_look(k, value) for k, value in enumerate(self.values))

    @cached_property
    def form(self) -> str:
        if self.link.kind in (BALL, FREE):
            return WHOLE
        if self.link.kind == SLIDE:
            return SPARSE
        return SPARSE if sum(1 for x in self.values[:OFFSET_AT] if x != 0) <= 5 else WHOLE


def _look(slot: int, value: Fraction) -> str:
    if value == 0:
        return "0"
    return str(value) if slot < OFFSET_AT and abs(value) == 1 else ANY


def link_slots(lowered: Lowered) -> list[Slots]:
    """The constants of all links of a scene without run-time parameters."""
    values = Values(lowered.scene, Rationals())
    inertias = grouped_inertias(lowered, values)
    found = []
    for link, inertia in zip(lowered.links, inertias, strict=True):
        joint = link.joint
        numbers = [x for row in link.turn for x in row]
        numbers += [*link.offset, inertia.mass, *inertia.first, *inertia.second]
        numbers += [joint.armature, joint.damping, (joint.pitch or 0) if link.kind == SCREW else 0]
        found.append(Slots(link, tuple(Fraction(x) for x in numbers)))
    return found


def grouped_inertias(lowered: Lowered, values: Values) -> list[Inertia]:
    """Inertias of links, with what joints cannot feel moved towards the root (see `symgen.plans.inertia.regroup`)."""
    given = link_inertias(lowered.tree, lowered.links, values)
    depth: list[int] = []
    for link in lowered.links:
        depth.append(0 if link.parent < 0 else depth[link.parent] + 1)
    long = any(x.denominator > 1 << 20 for link in lowered.links for row in link.turn for x in map(Fraction, row))
    kept = list(given)
    for link in reversed(lowered.links):
        if link.parent < 0 or (long and depth[link.index] % REGROUPED_IN_A_ROW == 0):
            if link.parent < 0:
                kept[link.index] = _split(link, kept[link.index])[0]
            continue
        kept[link.index], moved = _split(link, kept[link.index])
        turn, offset = values.matrix(link.turn), values.vector(link.offset)
        turned = Inertia(moved.mass, matvec(turn, moved.first), rotate_second(turn, moved.second))
        kept[link.parent] = kept[link.parent].plus(shift(turned, offset))
    return kept


def _split(link: Link, own: Inertia) -> tuple[Inertia, Inertia]:
    """(what the link's joint feels, what it does not)."""
    if link.kind == TURN:
        felt = Inertia(0, (*own.first[:2], 0), (*own.second[:2], 0, *own.second[3:]))
        return felt, Inertia(own.mass, (0, 0, own.first[2]), (0, 0, own.second[2], 0, 0, 0))
    if link.kind == SLIDE:
        return Inertia(own.mass, own.first), Inertia(0, ZERO, own.second)
    if link.kind == BALL:
        return Inertia(0, own.first, own.second), Inertia(own.mass)
    return own, Inertia(0, ZERO, NO_MOMENT)


def covers(wider: Sequence[str], narrower: Sequence[str]) -> bool:
    """Whether what looks like ``narrower`` may be computed as if it looked like ``wider``."""
    return all(a in (ANY, b) for a, b in zip(wider, narrower, strict=True))


def widened(looks: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """The narrowest look that covers all."""
    return tuple(row[0] if len(set(row)) == 1 else ANY for row in zip(*looks, strict=True))
