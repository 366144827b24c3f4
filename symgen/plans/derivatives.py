"""Analytic plan of the derivatives of inverse dynamics, in body axes.

Moving joint j by δφ changes the accelerations of everything beyond it by a field a + ẇ × x + w × ẏ (see
`symgen.plans.fields`): with δω, δω̇, δa the changes of the link's own motion as seen in its axes, w = 2δω and
ẇ = δω̇ + ω × δω. The 2 is put into ẏ: composites are made of twice the velocities, and w is δω here. Nothing is
differentiated twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from symgen.algebra.linear import IDENTITY, ZERO, Vec, cross, matvec, mul, scale, sub, vadd, vsub
from symgen.plans import free
from symgen.plans.composite import project
from symgen.plans.field_matrices import Bodies, Columns, Matrix, bodies, write
from symgen.plans.fields import Field, Wrench
from symgen.plans.recursive import Motion, link_motions, transmitted_wrenches
from symgen.plans.walk import BALL, FREE, Links, Moving

Scalar = Any
Z: Vec = (0, 0, 1)


@dataclass(frozen=True)
class Change:
    """∂τ by one variable of all joints, without springs and damping, is ``rest`` + mass_matrix · ``undone``, the mass
    matrix being that of the bodies alone, without armature. ``undone``: accelerations of a joint that alone undo part
    of what its own position or velocity changes."""

    rest: Matrix
    undone: Matrix


@dataclass(frozen=True)
class Derivation:
    """The derivatives of inverse dynamics at the joint velocities v. With ``relieved``, what a joint can undo is taken
    apart: who solves for accelerations need not solve for that."""

    links: Links
    v: Sequence[Scalar]
    gravity: Vec
    relieved: bool = False

    @property
    def convention(self) -> str:
        return self.links.values.scene.options.base_velocity

    @cached_property
    def spins(self) -> list[Vec]:
        """ω of every link, link axes."""
        return self.links.outward("motion", ZERO, self._spin)

    def _spin(self, at: Moving, parent: Vec) -> Vec:
        rate = tuple(self.v[at.link.v : at.link.v + at.link.nv])
        if at.link.kind == FREE:
            return free.velocity(at, rate, self.convention)[1]
        return vadd(at.to_link(parent), rate if at.link.kind == BALL else (0, 0, mul(at.angular, rate[0])))

    @cached_property
    def bodies(self) -> Bodies:
        return bodies(self.links, [scale(2, w) for w in self.spins], scale(2, tuple(self.v)))

    def by_velocity(self) -> Change:
        """∂τ/∂v, which no acceleration changes."""
        return self._changes("derivatives by velocity: columns and rows", [self._velocities()])[0]

    def by_position(self, a: Sequence[Scalar]) -> Change:
        """∂τ/∂q (tangent) at the joint accelerations a."""
        return self._changes("derivatives by position: columns and rows", [self._positions(a)])[0]

    def by_both(self, a: Sequence[Scalar]) -> tuple[Change, Change]:
        """∂τ/∂q and ∂τ/∂v."""
        by_position, by_velocity = self._changes(
            "derivatives: columns and rows", [self._positions(a), self._velocities()]
        )
        return by_position, by_velocity

    def _changes(self, heading: str, wanted: Sequence[Columns]) -> list[Change]:
        taken = [self._relieved(columns) for columns in wanted]
        found = self.bodies.matrices(heading, [columns for columns, _ in taken])
        return [Change(rest, undone) for rest, (_, undone) in zip(found, taken, strict=True)]

    def _relieved(self, columns: Columns) -> tuple[Columns, Matrix]:
        nv = self.links.nv
        undone: Matrix = [[0] * nv for _ in range(nv)]
        if not self.relieved:
            return columns, undone
        rest = []
        for at, fields in zip(self.links.moving, columns.fields, strict=True):
            taken = [_relieved(at, field, self.convention) for field in fields]
            rest.append([field for field, _ in taken])
            for k, (_, own) in enumerate(taken):
                write(undone, at.link.v, at.link.v + k, own)
        return Columns(rest, columns.transmitted), undone

    def _velocities(self) -> Columns:
        return Columns([self._velocity_fields(at) for at in self.links.moving])

    def _velocity_fields(self, at: Moving) -> list[Field]:
        """What each velocity of a link's joint changes on everything beyond it."""
        link, w = at.link, self.spins[at.link.index]
        with self.links.phase(f"derivatives: fields of {link.name}"):
            if link.kind == FREE:
                return _free_velocities(at, w, tuple(self.v[link.v : link.v + 6]), self.convention)
            if link.kind == BALL:
                carried = at.to_link(self.spins[link.parent] if link.parent >= 0 else ZERO)
                return [Field(ZERO, vadd(cross(carried, c), cross(w, c)), c) for c in IDENTITY]
            psi = scale(2, cross(w, Z))
            return [Field(scale(at.linear, psi), scale(at.angular, psi), scale(at.angular, Z))]

    def _positions(self, a: Sequence[Scalar]) -> Columns:
        motion_of = link_motions(self.links, self.v, a, self.gravity)
        wrenches = transmitted_wrenches(self.links, motion_of)

        def transmitted(at: Moving, k: int, change: Wrench) -> tuple[Vec, Wrench]:
            turned = _turned(at, k, change, wrenches[at.link.index], self.convention)
            if at.link.kind != FREE:
                return project(at, *change, self.convention), turned
            # Axes of a free link's forces that are the ground's do not turn with it.
            force = change[0] if self.convention == "body" else turned[0]
            moment = turned[1] if self.convention == "world" else change[1]
            return project(at, force, moment, self.convention), turned

        return Columns([self._position_fields(at, motion_of) for at in self.links.moving], transmitted)

    def _position_fields(self, at: Moving, motion_of: Sequence[Motion]) -> list[Field]:
        link, motion = at.link, motion_of[at.link.index]
        with self.links.phase(f"derivatives: fields of {link.name}"):
            if link.kind == FREE:
                return _free_positions(at, motion, self.gravity, self.convention)
            root = Motion(ZERO, ZERO, (ZERO, ZERO, ZERO), ZERO, tuple(sub(0, g) for g in self.gravity))
            parent = motion_of[link.parent] if link.parent >= 0 else root
            if link.kind == BALL:
                w, w_rate = at.to_link(parent.w), at.to_link(parent.w_rate)
                return [Field(cross(motion.a, c), _u_times(w, w_rate, c), cross(w, c)) for c in IDENTITY]
            s = tuple(row[2] for row in motion.u)  # z is fixed in the link and in its parent: one acceleration
            if at.angular == 0:
                return [Field(scale(at.linear, s))]
            turning = cross(motion.w, Z)
            if at.linear == 0:
                return [Field(cross(motion.a, Z), s, turning)]
            # A screw: the acceleration of the origin is carried by the parent, and by its own travel.
            base = at.to_link(vadd(parent.a, matvec(parent.u, at.offset)))
            travel = cross(scale(2, turning), (0, 0, mul(at.linear, self.v[link.v])))
            return [Field(vadd(vadd(cross(base, Z), scale(at.linear, s)), travel), s, turning)]


def _u_times(w: Vec, w_rate: Vec, c: Vec) -> Vec:
    """(ω̇̃ + ω̃ω̃) c."""
    return vadd(cross(w_rate, c), cross(w, cross(w, c)))


def _free_velocities(at: Moving, w: Vec, rate: Vec, convention: str) -> list[Field]:
    """A free link's velocities enter as their axes say."""
    if convention == "body":
        linear, _ = free.velocity(at, rate, convention)
        return [
            *(Field(cross(w, axis)) for axis in IDENTITY),
            *(Field(cross(c, linear), cross(w, c), c) for c in IDENTITY),
        ]
    axes = (at.to_link(axis) if convention == "world" else axis for axis in IDENTITY)
    return [Field(), Field(), Field(), *(Field(ZERO, cross(w, c), c) for c in axes)]


def _free_positions(at: Moving, motion: Motion, gravity: Vec, convention: str) -> list[Field]:
    """Where a free link is changes nothing, how it is turned does."""
    still = [Field(), Field(), Field()]
    if convention == "body":
        weight = at.to_link(tuple(sub(0, g) for g in gravity))
        return still + [Field(cross(weight, c)) for c in IDENTITY]
    if convention == "mixed":
        return still + [Field(cross(motion.a, c)) for c in IDENTITY]
    return still + [
        Field(cross(motion.a, c), _u_times(motion.w, motion.w_rate, c), cross(motion.w, c))
        for c in (at.to_link(axis) for axis in IDENTITY)
    ]


def _turned(at: Moving, k: int, change: Wrench, wrench: Wrench, convention: str) -> Wrench:
    """The change of a transmitted wrench in the parent's eyes, its own turn or shift with the joint included."""
    kind = at.link.kind
    if kind == FREE and k < 3:
        return change
    if kind in (BALL, FREE):
        axis = IDENTITY[k % 3]
        turn, shift = at.to_link(axis) if kind == FREE and convention == "world" else axis, ZERO
    else:
        turn, shift = scale(at.angular, Z), scale(at.linear, Z)
    force = vadd(change[0], cross(turn, wrench[0]))
    return force, vadd(vadd(change[1], cross(turn, wrench[1])), cross(shift, wrench[0]))


def _relieved(at: Moving, field: Field, convention: str) -> tuple[Field, Vec]:
    """A field less what accelerations of the link's own joint make of it, and these accelerations."""
    if at.link.kind == FREE:
        return Field(w=field.w), free.generalised_force(at, field.a, field.w_rate, convention)
    if at.link.kind == BALL:
        return Field(field.a, ZERO, field.w), field.w_rate
    own = field.w_rate[2] if at.angular != 0 else field.a[2]
    a, w_rate = (vsub(x, (0, 0, mul(part, own))) for x, part in ((field.a, at.linear), (field.w_rate, at.angular)))
    return Field(a, w_rate, field.w), (own,)
