"""One link of a class on its own: its place, inertia and joint as scalars of a graph, for the steps of sweeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from symgen.algebra.linear import Mat, Vec, matmul, matvec, mul, scale, vadd
from symgen.loops.model import CONSTANTS
from symgen.loops.slots import (
    ARMATURE_AT,
    DAMPING_AT,
    FIRST_AT,
    MASS_AT,
    OFFSET_AT,
    PITCH_AT,
    SECOND_AT,
    WHOLE,
)
from symgen.plans.inertia import Inertia
from symgen.plans.links import BALL, FREE, SCREW, SLIDE, Link
from symgen.plans.walk import Moving
from symgen.program.graph import Graph, Node
from symgen.scene.model import Scene
from symgen.velocity.rotation import quaternion_rotation
from symgen.velocity.values import Values

Scalar = Any
Pattern = tuple[bool, ...]
"""Which entries of a state may differ from zero."""

UNIT = {"0": 0, "1": 1}


@dataclass(frozen=True)
class Key:
    """What links of one class have in common."""

    kind: str
    form: str
    grounded: bool
    looks: tuple[str, ...]
    """Of the slots that the sweep reads."""
    states: tuple[tuple[str, Pattern], ...]
    """States that arrive: port and pattern."""

    @property
    def group(self) -> tuple[Any, ...]:
        """Classes of one group may be widened to one another."""
        return self.kind, self.form, self.grounded, tuple(name for name, _ in self.states)


@dataclass
class OneLink:
    """The graph of a step and the scalars in it. ``slots``: the slots that the sweep reads, in the order of
    ``key.looks``."""

    scene: Scene
    key: Key
    slots: Sequence[int]
    member: Link
    """One of the class."""
    gravity: Vec
    graph: Graph = field(default_factory=Graph)

    @property
    def convention(self) -> str:
        return self.scene.options.base_velocity

    @cached_property
    def values(self) -> Values:
        return Values(self.scene, self.graph)

    @cached_property
    def link(self) -> Link:
        parent = -1 if self.key.grounded else 0
        joint = replace(self.member.joint, child="link")
        return replace(self.member, index=0, parent=parent, joint=joint, q=0, v=0, planar=False)

    def slot(self, slot: int) -> Scalar:
        """A constant as the class knows it; 0 for what the sweep does not read."""
        if slot not in self.slots:
            return 0
        look = self.key.looks[list(self.slots).index(slot)]
        if look in UNIT:
            return UNIT[look]
        return self.graph.const(Fraction(-1)) if look == "-1" else self.graph.input(CONSTANTS, slot)

    def row(self, first: int, size: int) -> Vec:
        return tuple(self.slot(first + k) for k in range(size))

    def port(self, name: str, size: int) -> Vec:
        """All entries of an input."""
        return self.graph.inputs(name, size)

    def state(self, name: str, size: int) -> Vec:
        """The entries of a state that arrives, zeros where it has none."""
        pattern: Mapping[str, Pattern] = dict(self.key.states)
        if name not in pattern:
            return (0,) * size
        return tuple(self.graph.input(name, k) if there else 0 for k, there in enumerate(pattern[name]))

    @property
    def nv(self) -> int:
        return self.link.nv

    @cached_property
    def turn(self) -> Mat:
        return tuple(self.row(3 * k, 3) for k in range(3))

    @cached_property
    def offset(self) -> Vec:
        return self.row(OFFSET_AT, 3)

    @cached_property
    def inertia(self) -> Inertia:
        return Inertia(self.slot(MASS_AT), self.row(FIRST_AT, 3), self.row(SECOND_AT, 6))

    @property
    def armature(self) -> Scalar:
        return self.slot(ARMATURE_AT)

    @property
    def damping(self) -> Scalar:
        return self.slot(DAMPING_AT)

    @cached_property
    def moving(self) -> Moving:
        """The link at a state: with the rotation that the sweep of placements has found, where there is one."""
        link, turn, offset = self.link, self.turn, self.offset
        along = tuple(row[2] for row in turn)
        whole: Mat | None = None
        if self.key.form == WHOLE:
            frame = self.port("frame", frame_size(link.kind))
            whole = (frame[:3], frame[3:6], frame[6:9])
            if link.kind == FREE:
                offset = frame[9:]
        if link.kind in (BALL, FREE):
            return Moving(link, turn, 1, 0, whole, offset, 0, 0)
        if link.kind == SLIDE:
            return Moving(link, turn, 1, 0, None, vadd(offset, scale(self.port("q", 1)[0], along)), 0, 1)
        c, s = self.port("c", 1)[0], self.port("s", 1)[0]
        linear: Scalar = 0
        if link.kind == SCREW:
            linear = self.slot(PITCH_AT)
            offset = vadd(offset, scale(mul(linear, self.port("q", 1)[0]), along))
        return Moving(link, turn, c, s, whole, offset, 1, linear)

    def placement(self) -> list[Scalar]:
        """The whole rotation of the link, row by row, and the place of a free one."""
        turn, kind = self.turn, self.link.kind
        if kind == BALL:
            rotation = quaternion_rotation(self.port("q", 4))
        elif kind == FREE:
            rotation = quaternion_rotation(self.port("q", 7)[3:])
        else:
            c, s = self.port("c", 1)[0], self.port("s", 1)[0]
            rotation = ((c, -s, 0), (s, c, 0), (0, 0, 1))
        whole = [entry for row in matmul(turn, rotation) for entry in row]
        if kind == FREE:
            whole += vadd(self.offset, matvec(turn, self.port("q", 7)[:3]))
        return whole


def frame_size(kind: str) -> int:
    """Scalars of the placement of a link."""
    return 12 if kind == FREE else 9


def is_nothing(x: Scalar) -> bool:
    return (type(x) is int and x == 0) or (type(x) is Node and x.op == "const" and x.value == 0)
