"""The spanning tree in depth-first order, rigid groups lumped: the mechanism everything downstream works on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.algebra import linear
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import GROUND, Body, Joint, Scene, Transform
from symgen.topology.graph import spanning_tree


def compose(outer: Transform, inner: Transform) -> Transform:
    """The pose of inner's frame seen from outer's parent."""
    return Transform(
        linear.matmul(outer.rotation, inner.rotation),  # type: ignore[arg-type]
        linear.vadd(linear.matvec(outer.rotation, inner.translation), outer.translation),
    )


@dataclass(frozen=True)
class Coupling:
    """Position of a joint = multiplier · (coordinate of its master) + offset."""

    multiplier: Fraction
    offset: Fraction


@dataclass(frozen=True)
class TreeBody:
    """A moving rigid group and the tree joint that enters it."""

    name: str
    index: int
    parent: int
    """Index of the parent; −1 is ground."""
    joint: Joint
    """``joint.origin`` is re-expressed in the parent's frame (or ground axes)."""
    parts: tuple[tuple[Body, Transform], ...]
    """The bodies welded together, each with its pose in this body's frame; the first is the body itself."""
    q: int
    v: int
    """Where the joint's coordinates start in q and v; a coupled joint's are its master's."""
    coupling: Coupling | None = None
    mount: tuple[Joint, ...] = ()
    """The joints whose origins make up ``joint.origin``: the fixed ones since the parent, and the joint itself."""
    welds: tuple[tuple[Joint, ...], ...] = ()
    """Per part, the fixed joints that lead to it from this body."""

    @property
    def nq(self) -> int:
        return JOINT_TYPES[self.joint.type].nq

    @property
    def nv(self) -> int:
        return JOINT_TYPES[self.joint.type].nv


@dataclass(frozen=True)
class Tree:
    """Moving bodies depth first: a parent precedes its children, a subtree is contiguous."""

    bodies: tuple[TreeBody, ...]
    cut_joints: tuple[Joint, ...]
    frames: Mapping[str, tuple[int, Transform]]
    """Every body and every named frame: (index of the tree body it is fixed in, −1 for ground; its pose there)."""
    welds: Mapping[str, tuple[Joint, ...]]
    """Every body and named frame: the fixed joints on the way there from the tree body it is fixed in."""
    kept: dict[str, Any] = field(default_factory=dict, init=False, compare=False, repr=False)
    """What was once derived of this tree and took long, by name."""

    @cached_property
    def nq(self) -> int:
        """Independent coordinates: coupled joints have none."""
        return sum(body.nq for body in self.bodies if body.coupling is None)

    @cached_property
    def nv(self) -> int:
        return sum(body.nv for body in self.bodies if body.coupling is None)

    @cached_property
    def coupled(self) -> bool:
        return any(body.coupling is not None for body in self.bodies)

    def path(self, index: int) -> tuple[int, ...]:
        """Bodies from the root to ``index``, both ends included."""
        found: list[int] = []
        while index >= 0:
            found.append(index)
            index = self.bodies[index].parent
        return tuple(reversed(found))

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        found: list[list[int]] = [[] for _ in self.bodies]
        for body in self.bodies:
            if body.parent >= 0:
                found[body.parent].append(body.index)
        return tuple(tuple(row) for row in found)

    @cached_property
    def path_matrix(self) -> NDArray[np.int64]:
        """π (bodies × edges): +1 edge leaves the node, −1 edge enters it (paper §2)."""
        matrix = np.zeros((len(self.bodies), len(self.bodies)), dtype=np.int64)
        for body in self.bodies:
            matrix[body.index, body.index] = -1
            if body.parent >= 0:
                matrix[body.parent, body.index] = 1
        return matrix

    @cached_property
    def secondary_path_matrix(self) -> NDArray[np.int64]:
        """π* (bodies × edges): minus the number of edges from edge j to body i, both ends counted (paper §2)."""
        matrix = np.zeros((len(self.bodies), len(self.bodies)), dtype=np.int64)
        for body in self.bodies:
            if body.parent >= 0:
                parent = matrix[body.parent]
                matrix[body.index] = np.where(parent < 0, parent - 1, 0)
            matrix[body.index, body.index] = -1
        return matrix


@dataclass
class _Walk:
    """State of the depth-first walk (an explicit stack, so that long chains do not recurse)."""

    bodies: list[TreeBody]
    parts: list[list[tuple[Body, Transform]]]
    welds: list[list[tuple[Joint, ...]]]
    frames: dict[str, tuple[int, Transform]]
    chains: dict[str, tuple[Joint, ...]]

    def enter(self, joint: Joint, parent: int, pose: Transform, chain: tuple[Joint, ...], body: Body) -> int:
        """Put a body where its joint leads; the index of the tree body it is part of."""
        origin = compose(pose, joint.origin)
        chain = (*chain, joint)
        if joint.type == "fixed":
            home, here = parent, origin
            if home >= 0:
                self.parts[home].append((body, here))
                self.welds[home].append(chain)
        else:
            home, here = len(self.bodies), Transform()
            self.bodies.append(TreeBody(body.name, home, parent, replace(joint, origin=origin), (), 0, 0, mount=chain))
            self.parts.append([(body, here)])
            chain = ()
            self.welds.append([chain])
        self.frames[body.name], self.chains[body.name] = (home, here), chain
        return home


def build_tree(scene: Scene) -> Tree:
    """Order the spanning tree depth first, children in the scene's order, fixed joints lumped into their parents."""
    joints, cut = spanning_tree(scene)
    outgoing: dict[str, list[Joint]] = {}
    for joint in joints:
        outgoing.setdefault(joint.parent, []).append(joint)
    body_by_name = {body.name: body for body in scene.bodies}
    walk = _Walk([], [], [], {GROUND: (-1, Transform())}, {GROUND: ()})
    stack = [(joint, -1) for joint in reversed(outgoing.get(GROUND, []))]
    while stack:
        joint, parent = stack.pop()
        pose = walk.frames[joint.parent][1]
        home = walk.enter(joint, parent, pose, walk.chains[joint.parent], body_by_name[joint.child])
        stack.extend((child, home) for child in reversed(outgoing.get(joint.child, [])))
    for frame in scene.frames:
        home, pose = walk.frames[frame.body]
        walk.frames[frame.name] = (home, compose(pose, frame.origin))
        walk.chains[frame.name] = walk.chains[frame.body]
    return Tree(_with_coordinates(walk), cut, walk.frames, walk.chains)


def _with_coordinates(walk: _Walk) -> tuple[TreeBody, ...]:
    """Places in q and v: own ones depth first, coupled joints at those of their masters."""
    places: dict[str, tuple[int, int]] = {}
    q = v = 0
    for body in walk.bodies:
        if body.joint.mimic is None:
            places[body.joint.name] = (q, v)
            q, v = q + body.nq, v + body.nv
    joints = {body.joint.name: body.joint for body in walk.bodies}
    found = []
    for body, parts, welds in zip(walk.bodies, walk.parts, walk.welds, strict=True):
        master, coupling = _coupling(body.joint, joints)
        q, v = places[master]
        found.append(replace(body, parts=tuple(parts), welds=tuple(welds), q=q, v=v, coupling=coupling))
    return tuple(found)


def _coupling(joint: Joint, joints: Mapping[str, Joint]) -> tuple[str, Coupling | None]:
    """The master whose coordinate moves a joint, and how: a mimic of a mimic is composed."""
    if joint.mimic is None:
        return joint.name, None
    multiplier, offset, master = Fraction(1), Fraction(0), joint
    while master.mimic is not None:
        offset += multiplier * master.mimic.offset
        multiplier *= master.mimic.multiplier
        master = joints[master.mimic.joint]
    return master.name, Coupling(multiplier, offset)
