"""Body-axes kinematics of elementary links: the transforms and joint motions every recursive plan shares.

Plans supply per-link steps; the two walks over the tree are here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeVar

from symgen.algebra.linear import (
    ZERO,
    Mat,
    Vec,
    add,
    cross,
    is_zero,
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
    Grouped,
    Inertia,
    Six,
    link_inertias,
    regroup,
    rotate_second,
    shift,
    turn_back,
    turn_matrix,
    turn_second,
    turn_vector,
)
from symgen.plans.lagging import lagging, lagging_leaves, parallel
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
    c: Scalar
    s: Scalar
    whole: Mat | None
    """The whole rotation, where it is not K times a turn about z."""
    offset: Vec
    """Origin in the parent's axes, joint motion included."""
    angular: Scalar
    linear: Scalar
    """Motion subspace of a one-dof link along z: angular part (0 or 1) and linear part (0, 1 or the pitch)."""
    outer: tuple[Scalar, Scalar] | None = None
    """Cosine and sine of a turn about the parent's z that comes before everything: the parent's axes lag behind it."""
    angle: Scalar = None
    """How far the link's body is turned about z from these axes, where they lag behind it (see `lagging`)."""

    def to_link(self, x: Vec) -> Vec:
        """A vector of the parent's axes in link axes."""
        if self.whole is not None:
            return vecmat(x, self.whole)
        if self.outer is not None:
            x = turn_back(*self.outer, x)
        return turn_back(self.c, self.s, vecmat(x, self.turn))

    def to_parent(self, x: Vec) -> Vec:
        """A vector of link axes in the parent's axes."""
        if self.whole is not None:
            return matvec(self.whole, x)
        x = matvec(self.turn, turn_vector(self.c, self.s, x))
        return x if self.outer is None else turn_vector(*self.outer, x)

    def second_to_parent(self, second: Six) -> Six:
        """A symmetric matrix of link axes in the parent's axes."""
        if self.link.kind in (BALL, FREE):
            assert self.whole is not None
            return rotate_second(self.whole, second)
        second = rotate_second(self.turn, turn_second(self.c, self.s, second))
        return second if self.outer is None else turn_second(*self.outer, second)

    def matrix_to_parent(self, m: Mat) -> Mat:
        """E m Eᵀ of a general matrix."""
        if self.whole is not None:
            return matmul(matmul(self.whole, m), transpose(self.whole))
        m = matmul(matmul(self.turn, turn_matrix(self.c, self.s, m)), transpose(self.turn))
        return m if self.outer is None else turn_matrix(*self.outer, m)

    def inertia_to_parent(self, inertia: Inertia) -> Inertia:
        polar = inertia.about_z if self.link.planar else None
        turned = Inertia(inertia.mass, self.to_parent(inertia.first), self.second_to_parent(inertia.second), polar)
        return shift(turned, self.offset)

    def wrench_to_parent(self, force: Vec, moment: Vec, further: Vec = ZERO) -> tuple[Vec, Vec]:
        """Force and moment about the link's origin → the same about the parent's origin, parent's axes. ``further``:
        another force through the link's origin, parent's axes."""
        turned = vadd(self.to_parent(force), further)
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
    tips: Mapping[int, Scalar]
    """Point masses at the origins of links, each fixed in the link's parent, that are not in ``inertias``."""

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


def _place(link: Link, values: Values, q: Sequence[Scalar], parent: Moving | None, behind: frozenset[int]) -> Moving:
    """A link at a state; the axes of the links in ``behind`` lag."""
    angle = None if parent is None else parent.angle
    numbers = values.numbers
    if angle is None and link.index not in behind:
        return _place_freely(link, values, q)
    own = q[link.q] if link.kind == TURN else None
    if angle is not None and parallel(link):
        own = add(own, angle) if link.turn[2][2] == 1 else sub(own, angle)
    outer = None if angle is None else (numbers.cos(angle), numbers.sin(angle))
    if link.index in behind:
        turn, offset = values.matrix(link.turn), values.vector(link.offset)
        before = None if parallel(link) else outer
        found = Moving(link, turn, 1, 0, None, offset, 1, 0, outer=before, angle=own)
    elif link.kind == TURN and parallel(link):
        turn, offset = values.matrix(link.turn), values.vector(link.offset)
        found = Moving(link, turn, numbers.cos(own), numbers.sin(own), None, offset, 1, 0)
    else:
        found = _place_freely(link, values, q)
        if outer is not None:
            found = _turned_before(found, outer)
    return found if outer is None else replace(found, offset=turn_vector(*outer, found.offset))


def _turned_before(found: Moving, outer: tuple[Scalar, Scalar]) -> Moving:
    """The parent's axes lag: everything is turned by ``outer`` about its z."""
    if found.whole is None:
        return replace(found, outer=outer)
    c, s = outer
    return replace(found, whole=matmul(((c, sub(0, s), 0), (s, c, 0), (0, 0, 1)), found.whole), outer=outer)


def _place_freely(link: Link, values: Values, q: Sequence[Scalar]) -> Moving:
    numbers, turn, offset = values.numbers, values.matrix(link.turn), values.vector(link.offset)
    if link.kind == BALL:
        whole = matmul(turn, quaternion_rotation(tuple(q[link.q : link.q + 4])))
        return Moving(link, turn, 1, 0, whole, offset, 0, 0)
    if link.kind == FREE:
        whole = matmul(turn, quaternion_rotation(tuple(q[link.q + 3 : link.q + 7])))
        place = vadd(offset, matvec(turn, tuple(q[link.q : link.q + 3])))
        return Moving(link, turn, 1, 0, whole, place, 0, 0)
    position, along = q[link.q], tuple(row[2] for row in turn)
    if link.kind == SLIDE:
        return Moving(link, turn, 1, 0, None, vadd(offset, scale(position, along)), 0, 1)
    c, s = numbers.cos(position), numbers.sin(position)
    linear: Scalar = 0
    if link.kind == SCREW:
        assert link.joint.pitch is not None
        linear = values.lift(link.joint.pitch)
        offset = vadd(offset, scale(mul(linear, position), along))
    whole_matrix = None
    if sum(1 for row in turn for x in row if not is_zero(x)) > 5:  # else K is applied after the turn about z
        rz: Mat = ((c, sub(0, s), 0), (s, c, 0), (0, 0, 1))
        whole_matrix = matmul(turn, rz)
    return Moving(link, turn, c, s, whole_matrix, offset, 1, linear)


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
    def _exact(self) -> tuple[Values, list[Inertia]]:
        values = Values(self.scene, Rationals())
        return values, link_inertias(self.tree, self.links, values)

    @cached_property
    def _grouped(self) -> dict[frozenset[int], Grouped]:
        return {}

    def _regrouped(self, tips: frozenset[int]) -> Grouped:
        if tips not in self._grouped:
            values, given = self._exact
            self._grouped[tips] = regroup(self.links, given, values, tips)
        return self._grouped[tips]

    def inertias(self, values: Values, regrouped: bool, tips: frozenset[int] = frozenset()) -> Grouped:
        """Of every link, and of ground, as scalars of the number type of ``values``."""
        if not self.parametric and not self.scene.runtime_origins:
            found = self._regrouped(tips) if regrouped else Grouped(self._exact[1], Inertia(), {})
            inertias = [_lift(inertia, values) for inertia in found.links]
            masses = {index: values.lift(mass) for index, mass in found.tips.items()}
            return Grouped(inertias, _lift(found.ground, values), masses)
        links = self.links_at(values)
        given = link_inertias(self.tree, links, values)
        return regroup(links, given, values) if regrouped else Grouped(given, Inertia(), {})

    def links_at(self, values: Values) -> tuple[Link, ...]:
        """The links, lowered for every number type where origins of joints are run-time arguments."""
        return lower(self.tree, values) if self.scene.runtime_origins else self.links

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

    def at(
        self,
        values: Values,
        q: Sequence[Scalar],
        regrouped: bool = True,
        merged: bool = False,
        leaves: bool = False,
        tips: frozenset[int] = frozenset(),
    ) -> Links:
        """The links at the coordinates q. With ``regrouped``, inertial parameters that joints cannot feel are moved to
        parents first (the numbers are the same, the operations fewer). With ``merged``, links along parallel axes share
        axes (see `lagging`), with ``leaves`` the last links leave theirs behind where that saves operations (see
        `lagging_leaves`): link axes are then not fixed in the bodies. Links in ``tips`` may leave point masses, where
        inertias are constant, at their children's origins (see `regroup`): for plans that know of them."""
        grouped = self.inertias(values, regrouped, tips)
        inertias = grouped.links
        positions = self.joint_positions(values, q)
        links = self.links_at(values)
        behind = (lagging(links) if merged else frozenset()) | (
            lagging_leaves(links, inertias) if leaves else frozenset()
        )
        moving: list[Moving] = []
        for link in links:
            moving.append(_place(link, values, positions, moving[link.parent] if link.parent >= 0 else None, behind))
            if link.index in behind:
                inertias[link.index] = _turned_inertia(inertias[link.index], moving[-1], values)
        return Links(self.tree, values, tuple(moving), tuple(inertias), grouped.ground, grouped.tips)


def _turned_inertia(inertia: Inertia, at: Moving, values: Values) -> Inertia:
    """A body's inertia in axes that lag behind it."""
    c, s = values.numbers.cos(at.angle), values.numbers.sin(at.angle)
    polar = inertia.about_z if at.link.planar else None
    return Inertia(inertia.mass, turn_vector(c, s, inertia.first), turn_second(c, s, inertia.second), polar)


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
