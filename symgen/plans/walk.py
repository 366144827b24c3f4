"""Body-axes kinematics of elementary links: the transforms and joint motions every recursive plan shares.

Plans supply per-link steps; the two walks over the tree are here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeVar

from symgen.algebra.linear import (
    Mat,
    Vec,
    add,
    cross,
    matmul,
    matvec,
    mul,
    scale,
    sub,
    transpose,
    vadd,
    vecmat,
)
from symgen.plans.inertia import (
    Inertia,
    Six,
    link_inertias,
    regroup,
    rotate_second,
    shift,
    turn_second,
)
from symgen.plans.links import BALL, FREE, SCREW, SLIDE, TURN, Link, lower
from symgen.scene.model import Scene
from symgen.topology.tree import Tree
from symgen.velocity.rotation import quaternion_rotation
from symgen.velocity.values import Values

Scalar = Any
T = TypeVar("T")


@dataclass(frozen=True)
class Moving:
    """One link at one state: its rotation and offset relative to the parent, and its motion subspace."""

    link: Link
    turn: Mat
    """K, constant part of the rotation, as scalars."""
    sparse: bool
    """K is sparse: apply it after the turn about z instead of forming the whole matrix."""
    c: Scalar
    s: Scalar
    whole: Mat | None
    """The whole rotation, where it is not K times a turn about z."""
    offset: Vec
    """Origin in the parent's axes, joint motion included."""
    angular: Scalar
    linear: Scalar
    """Motion subspace of a one-dof link along z: angular part (0 or 1) and linear part (0, 1 or the pitch)."""

    def to_link(self, x: Vec) -> Vec:
        """A vector of the parent's axes in link axes."""
        if self.whole is not None:
            return vecmat(x, self.whole)
        y = vecmat(x, self.turn)
        if self.link.kind == SLIDE:
            return y
        c, s = self.c, self.s
        return (add(mul(c, y[0]), mul(s, y[1])), sub(mul(c, y[1]), mul(s, y[0])), y[2])

    def to_parent(self, x: Vec) -> Vec:
        """A vector of link axes in the parent's axes."""
        if self.whole is not None:
            return matvec(self.whole, x)
        if self.link.kind != SLIDE:
            c, s = self.c, self.s
            x = (sub(mul(c, x[0]), mul(s, x[1])), add(mul(s, x[0]), mul(c, x[1])), x[2])
        return matvec(self.turn, x)

    def second_to_parent(self, second: Six) -> Six:
        """A symmetric matrix of link axes in the parent's axes."""
        if self.link.kind in (BALL, FREE):
            assert self.whole is not None
            return rotate_second(self.whole, second)
        if self.link.kind != SLIDE:
            second = turn_second(self.c, self.s, second)
        return rotate_second(self.turn, second)

    def matrix_to_parent(self, m: Mat) -> Mat:
        """E m Eᵀ of a general matrix."""
        rows = transpose(tuple(self.to_parent(column) for column in transpose(m)))
        return tuple(self.to_parent(row) for row in rows)

    def inertia_to_parent(self, inertia: Inertia) -> Inertia:
        polar = inertia.about_z if self.link.planar else None
        turned = Inertia(inertia.mass, self.to_parent(inertia.first), self.second_to_parent(inertia.second), polar)
        return shift(turned, self.offset)

    def wrench_to_parent(self, force: Vec, moment: Vec) -> tuple[Vec, Vec]:
        """Force and moment about the link's origin → the same about the parent's origin, parent's axes."""
        turned = self.to_parent(force)
        return turned, vadd(self.to_parent(moment), cross(self.offset, turned))


@dataclass(frozen=True)
class Links:
    """All links of a tree at one state, with their inertias, and the number type they live in."""

    tree: Tree
    values: Values
    moving: tuple[Moving, ...]
    inertias: tuple[Inertia, ...]
    ground: Inertia
    """What regrouping moved to ground."""

    @property
    def nv(self) -> int:
        """Velocities of all joints, coupled ones included: what plans work with."""
        return sum(at.link.nv for at in self.moving)

    def phase(self, heading: str) -> AbstractContextManager[None]:
        """A heading for what is computed inside, in number types that keep headings."""
        keep: Callable[[str], AbstractContextManager[None]] | None = getattr(self.values.numbers, "phase", None)
        return keep(heading) if keep else nullcontext()

    def name(self, label: str, vector: Sequence[Scalar]) -> None:
        """A name for a vector, in number types that keep names."""
        keep: Callable[[str, Sequence[Scalar]], None] | None = getattr(self.values.numbers, "name", None)
        if keep:
            keep(label, vector)

    def outward(self, heading: str, root: T, step: Callable[[Moving, T], T]) -> list[T]:
        """``step(link, parent's result)`` from the root to the leaves."""
        found: list[T] = []
        for at in self.moving:
            with self.phase(f"{heading}: {at.link.name}"):
                found.append(step(at, found[at.link.parent] if at.link.parent >= 0 else root))
        return found

    def inward(
        self, heading: str, start: Sequence[T], step: Callable[[Moving, T], T], join: Callable[[T, T], T]
    ) -> None:
        """From the leaves to the root: ``step(link, what has arrived)`` gives what the parent joins to its own."""
        arrived = list(start)
        for at in reversed(self.moving):
            with self.phase(f"{heading}: {at.link.name}"):
                result = step(at, arrived[at.link.index])
                if at.link.parent >= 0:
                    arrived[at.link.parent] = join(arrived[at.link.parent], result)

    def ancestors(self, at: Moving) -> tuple[Moving, ...]:
        """The links on the way to the root, nearest first, without the link itself."""
        found = []
        index = at.link.parent
        while index >= 0:
            found.append(self.moving[index])
            index = self.moving[index].link.parent
        return tuple(found)


def _place(link: Link, values: Values, q: Sequence[Scalar]) -> Moving:
    numbers, turn, offset = values.numbers, values.matrix(link.turn), values.vector(link.offset)
    if link.kind == BALL:
        whole = matmul(turn, quaternion_rotation(tuple(q[link.q : link.q + 4])))
        return Moving(link, turn, False, 1, 0, whole, offset, 0, 0)
    if link.kind == FREE:
        whole = matmul(turn, quaternion_rotation(tuple(q[link.q + 3 : link.q + 7])))
        place = vadd(offset, matvec(turn, tuple(q[link.q : link.q + 3])))
        return Moving(link, turn, False, 1, 0, whole, place, 0, 0)
    position, along = q[link.q], tuple(row[2] for row in turn)
    if link.kind == SLIDE:
        return Moving(link, turn, True, 1, 0, None, vadd(offset, scale(position, along)), 0, 1)
    c, s = numbers.cos(position), numbers.sin(position)
    linear: Scalar = 0
    if link.kind == SCREW:
        assert link.joint.pitch is not None
        linear = values.lift(link.joint.pitch)
        offset = vadd(offset, scale(mul(linear, position), along))
    sparse = sum(1 for row in link.turn for x in row if x != 0) <= 5
    whole_matrix = None
    if not sparse:
        rz: Mat = ((c, sub(0, s), 0), (s, c, 0), (0, 0, 1))
        whole_matrix = matmul(turn, rz)
    return Moving(link, turn, sparse, c, s, whole_matrix, offset, 1, linear)


@dataclass(frozen=True)
class Lowered:
    """The elementary links of a tree with their inertias, as given and regrouped: what does not depend on the state.

    Without run-time inertial parameters the inertias are exact numbers, found once for all functions and number types.
    """

    tree: Tree
    links: tuple[Link, ...]
    scene: Scene

    @cached_property
    def parametric(self) -> bool:
        """True when inertial parameters are run-time arguments."""
        return any(parameter.name.endswith((".mass", ".com", ".inertia")) for parameter in self.scene.parameters)

    @cached_property
    def loose(self) -> bool:
        """True when origins of joints are run-time arguments: then links are lowered for every number type."""
        return any(parameter.name.endswith((".xyz", ".rpy")) for parameter in self.scene.parameters)

    @cached_property
    def _exact(self) -> dict[bool, tuple[list[Inertia], Inertia]]:
        values = Values(self.scene, Rationals())
        given = link_inertias(self.tree, self.links, values)
        return {False: (given, Inertia()), True: regroup(self.links, given, values)}

    def inertias(self, values: Values, regrouped: bool) -> tuple[list[Inertia], Inertia]:
        """Of every link, and of ground, as scalars of the number type of ``values``."""
        if not self.parametric and not self.loose:
            found, ground = self._exact[regrouped]
            return [_lift(inertia, values) for inertia in found], _lift(ground, values)
        links = self.links_at(values)
        given = link_inertias(self.tree, links, values)
        return regroup(links, given, values) if regrouped else (given, Inertia())

    def links_at(self, values: Values) -> tuple[Link, ...]:
        return lower(self.tree, values) if self.loose else self.links

    def joint_positions(self, values: Values, q: Sequence[Scalar]) -> list[Scalar]:
        """Positions of all joints, coupled ones included, from the coordinates q."""
        return [x for body in self.tree.bodies for x in values.positions(body, q)]

    def joint_rates(self, values: Values, v: Sequence[Scalar]) -> list[Scalar]:
        """Velocities (or accelerations) of all joints: G v."""
        return [x for body in self.tree.bodies for x in values.rates(body, v)]

    def reduce(self, values: Values, forces: Sequence[Scalar]) -> list[Scalar]:
        """Gᵀ f: forces on all joints to forces on the coordinates."""
        if not self.tree.coupled:
            return list(forces)
        found: list[Scalar] = [0] * self.tree.nv
        start = 0
        for body in self.tree.bodies:
            for k in range(body.nv):
                force = mul(values.multiplier(body), forces[start + k])
                found[body.v + k] = add(found[body.v + k], force)
            start += body.nv
        return found

    def reduce_columns(self, values: Values, matrix: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
        """A G: columns of all joints to columns of the coordinates."""
        return [self.reduce(values, row) for row in matrix]

    def reduce_matrix(self, values: Values, matrix: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
        """Gᵀ A G."""
        if not self.tree.coupled:
            return [list(row) for row in matrix]
        columns = zip(*self.reduce_columns(values, matrix), strict=True)
        return [list(row) for row in zip(*(self.reduce(values, column) for column in columns), strict=True)]

    def at(self, values: Values, q: Sequence[Scalar], regrouped: bool = True) -> Links:
        """The links at the coordinates q. With ``regrouped``, inertial parameters that joints cannot feel are moved to
        parents first (the numbers are the same, the operations fewer)."""
        inertias, ground = self.inertias(values, regrouped)
        positions = self.joint_positions(values, q)
        moving = tuple(_place(link, values, positions) for link in self.links_at(values))
        return Links(self.tree, values, moving, tuple(inertias), ground)


class Rationals:
    """Exact numbers for what needs no functions."""

    def const(self, value: Fraction | int) -> Fraction:
        return Fraction(value)

    def _none(self, x: Scalar) -> Scalar:
        raise NotImplementedError("rationals have no such function")

    sqrt = cos = sin = cos_sqrt = sinc_sqrt = sinc3_sqrt = _none


def _lift(inertia: Inertia, values: Values) -> Inertia:
    return Inertia(values.lift(inertia.mass), values.vector(inertia.first), values.vector(inertia.second))


def lowered(scene: Scene, tree: Tree) -> Lowered:
    return Lowered(tree, lower(tree), scene)


__all__ = ["BALL", "FREE", "SCREW", "SLIDE", "TURN", "Links", "Lowered", "Moving", "lowered"]
