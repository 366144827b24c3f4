"""The spanning tree in depth-first order, rigid groups lumped: the mechanism everything downstream works on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

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

    @property
    def nq(self) -> int:
        return sum(body.nq for body in self.bodies)

    @property
    def nv(self) -> int:
        return sum(body.nv for body in self.bodies)

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
    frames: dict[str, tuple[int, Transform]]


def build_tree(scene: Scene) -> Tree:
    """Order the spanning tree depth first, children in the scene's order, fixed joints lumped into their parents."""
    joints, cut = spanning_tree(scene)
    outgoing: dict[str, list[Joint]] = {}
    for joint in joints:
        outgoing.setdefault(joint.parent, []).append(joint)
    body_by_name = {body.name: body for body in scene.bodies}
    walk = _Walk([], [], {GROUND: (-1, Transform())})
    q = v = 0
    stack = [(joint, -1, Transform()) for joint in reversed(outgoing.get(GROUND, []))]
    while stack:
        joint, parent, pose = stack.pop()
        body = body_by_name[joint.child]
        origin = compose(pose, joint.origin)
        if joint.type == "fixed":
            home, here = parent, origin
            if home >= 0:
                walk.parts[home].append((body, here))
        else:
            home, here = len(walk.bodies), Transform()
            moved = replace(joint, origin=origin)
            walk.bodies.append(TreeBody(body.name, home, parent, moved, (), q, v))
            walk.parts.append([(body, here)])
            q, v = q + JOINT_TYPES[joint.type].nq, v + JOINT_TYPES[joint.type].nv
        walk.frames[body.name] = (home, here)
        stack.extend((child, home, here) for child in reversed(outgoing.get(body.name, [])))
    for frame in scene.frames:
        home, pose = walk.frames[frame.body]
        walk.frames[frame.name] = (home, compose(pose, frame.origin))
    bodies = tuple(
        TreeBody(body.name, body.index, body.parent, body.joint, tuple(parts), body.q, body.v)
        for body, parts in zip(walk.bodies, walk.parts, strict=True)
    )
    return Tree(bodies, cut, walk.frames)
