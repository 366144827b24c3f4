"""Poses, velocity transformation R and its rate (theory, §3), over any number type.

Everything is in ground axes: this is the literal form, the definition. R is assembled from π*: each
negative entry becomes a block of the joint table, each zero a block of zeros.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from symgen.algebra.linear import (
    ZERO,
    Mat,
    Vec,
    cross,
    matmul,
    matvec,
    scale,
    vadd,
    vsub,
)
from symgen.algebra.numbers import State
from symgen.topology.tree import Tree, TreeBody
from symgen.velocity.joint_table import CHILD, JOINT_TABLE, PARENT, Column, Placement
from symgen.velocity.values import Values

Scalar = Any
T = TypeVar("T")


def outward(tree: Tree, root: T, step: Callable[[TreeBody, T], T]) -> tuple[T, ...]:
    """The one walk from root to leaves: ``step(body, parent's result)`` for every body, depth first."""
    found: list[T] = []
    for body in tree.bodies:
        found.append(step(body, found[body.parent] if body.parent >= 0 else root))
    return tuple(found)


@dataclass(frozen=True)
class Pose:
    """Frame of a body in ground axes: x_ground = rotation x_body + origin."""

    rotation: Mat
    origin: Vec

    def point(self, local: Vec) -> Vec:
        return vadd(self.origin, matvec(self.rotation, local))

    def vector(self, local: Vec) -> Vec:
        return matvec(self.rotation, local)


GROUND_POSE = Pose(((1, 0, 0), (0, 1, 0), (0, 0, 1)), ZERO)


@dataclass(frozen=True)
class JointMotion:
    """The columns of one joint with their reference point r_j, ground axes."""

    columns: tuple[Column, ...]
    reference: Vec
    reference_body: int


@dataclass(frozen=True)
class Kinematics:
    """Poses and joint motions of every body at one state."""

    tree: Tree
    poses: tuple[Pose, ...]
    motions: tuple[JointMotion, ...]

    def pose(self, index: int) -> Pose:
        return self.poses[index] if index >= 0 else GROUND_POSE


def kinematics(tree: Tree, values: Values, q: Sequence[Scalar]) -> Kinematics:
    """Poses of all bodies and the columns of all joints at q."""
    poses: list[Pose] = []
    motions: list[JointMotion] = []
    for body in tree.bodies:
        parent = poses[body.parent] if body.parent >= 0 else GROUND_POSE
        rotation, translation = values.placed(body.mount, body.joint.origin)
        joint_axes, joint_origin = matmul(parent.rotation, rotation), parent.point(translation)
        row = JOINT_TABLE[body.joint.type]
        turn, slide = row.pose(body.joint, values.positions(body, q), values)
        pose = Pose(matmul(joint_axes, turn), vadd(joint_origin, matvec(joint_axes, slide)))
        placement = Placement(joint_axes, pose.rotation, values.scene.options.base_velocity)
        on_child = row.reference == CHILD
        poses.append(pose)
        motions.append(
            JointMotion(
                _coupled(row.columns(body.joint, placement, values), values.multiplier(body)),
                pose.origin if on_child else joint_origin,
                body.index if on_child else body.parent,
            )
        )
    return Kinematics(tree, tuple(poses), tuple(motions))


def _coupled(columns: tuple[Column, ...], multiplier: Scalar) -> tuple[Column, ...]:
    """Columns for the velocity of the joint's master."""
    if type(multiplier) is int and multiplier == 1:
        return columns
    return tuple(Column(scale(multiplier, c.w), scale(multiplier, c.v), c.carrier) for c in columns)


def _gather(found: dict[int, Vec], index: int, column: Vec) -> None:
    """Joints that share a velocity (coupled ones) add their columns."""
    found[index] = vadd(found[index], column) if index in found else column


@dataclass(frozen=True)
class Twist:
    """Motion of a body in ground axes: angular velocity and velocity of its origin (or their rates)."""

    angular: Vec
    linear: Vec


AT_REST = Twist(ZERO, ZERO)


def twists(at: Kinematics, v: Sequence[Scalar]) -> tuple[Twist, ...]:
    """ω and ṙ of every body, R θ̇ at the bodies' origins (paper (4.1), (4.3))."""

    def step(body: TreeBody, parent: Twist) -> Twist:
        origin, motion = at.poses[body.index].origin, at.motions[body.index]
        arm = vsub(origin, at.pose(body.parent).origin)
        angular, linear = parent.angular, vadd(parent.linear, cross(parent.angular, arm))
        reach = vsub(origin, motion.reference)
        for column, rate in zip(motion.columns, v[body.v : body.v + body.nv], strict=True):
            angular = vadd(angular, scale(rate, column.w))
            linear = vadd(linear, scale(rate, vadd(column.v, cross(column.w, reach))))
        return Twist(angular, linear)

    return outward(at.tree, AT_REST, step)


def column_rates(at: Kinematics, moving: Sequence[Twist]) -> tuple[tuple[tuple[Vec, Vec], ...], ...]:
    """(ẇ, v̇) of every column: carried by the parent, by the child, or constant (Ȧ = ω̃ A)."""

    def rate(body: TreeBody, column: Column) -> tuple[Vec, Vec]:
        if column.carrier == PARENT:
            spin = moving[body.parent].angular if body.parent >= 0 else ZERO
        else:
            spin = moving[body.index].angular if column.carrier == CHILD else ZERO
        return cross(spin, column.w), cross(spin, column.v)

    return tuple(tuple(rate(body, column) for column in at.motions[body.index].columns) for body in at.tree.bodies)


def point_velocity(at: Kinematics, moving: Sequence[Twist], body: int, point: Vec) -> Vec:
    """Velocity of a point fixed in a body, ground axes."""
    if body < 0:
        return ZERO
    twist = moving[body]
    return vadd(twist.linear, cross(twist.angular, vsub(point, at.poses[body].origin)))


def point_columns(at: Kinematics, body: int, point: Vec) -> dict[int, Vec]:
    """The non-zero columns of R for a point fixed in a body: {velocity index: v + w × d}, d = r_k − r_j."""
    found: dict[int, Vec] = {}
    for j in at.tree.path(body):
        motion = at.motions[j]
        d = vsub(point, motion.reference)
        for k, column in enumerate(motion.columns):
            _gather(found, at.tree.bodies[j].v + k, vadd(column.v, cross(column.w, d)))
    return found


def vector_columns(at: Kinematics, body: int, vector: Vec) -> dict[int, Vec]:
    """The non-zero columns of R for a vector fixed in a body: {velocity index: w × u}."""
    found: dict[int, Vec] = {}
    for j in at.tree.path(body):
        for k, column in enumerate(at.motions[j].columns):
            _gather(found, at.tree.bodies[j].v + k, cross(column.w, vector))
    return found


Rates = Sequence[Sequence[tuple[Vec, Vec]]]


def point_column_rates(at: Kinematics, moving: Sequence[Twist], rates: Rates, body: int, point: Vec) -> dict[int, Vec]:
    """The columns of Ṙ for a point: v̇ + ẇ × d + w × ḋ. ``rates`` from `column_rates`."""
    velocity = point_velocity(at, moving, body, point)
    found: dict[int, Vec] = {}
    for j in at.tree.path(body):
        motion = at.motions[j]
        d = vsub(point, motion.reference)
        d_rate = vsub(velocity, point_velocity(at, moving, motion.reference_body, motion.reference))
        for k, (column, (w_rate, v_rate)) in enumerate(zip(motion.columns, rates[j], strict=True)):
            rate = vadd(v_rate, vadd(cross(w_rate, d), cross(column.w, d_rate)))
            _gather(found, at.tree.bodies[j].v + k, rate)
    return found


def vector_column_rates(
    at: Kinematics, moving: Sequence[Twist], rates: Rates, body: int, vector: Vec
) -> dict[int, Vec]:
    """The columns of Ṙ for a vector: ẇ × u + w × u̇. ``rates`` from `column_rates`."""
    vector_rate = cross(moving[body].angular, vector) if body >= 0 else ZERO
    found: dict[int, Vec] = {}
    for j in at.tree.path(body):
        for k, (column, (w_rate, _)) in enumerate(zip(at.motions[j].columns, rates[j], strict=True)):
            rate = vadd(cross(w_rate, vector), cross(column.w, vector_rate))
            _gather(found, at.tree.bodies[j].v + k, rate)
    return found


def bias_accelerations(at: Kinematics, moving: Sequence[Twist], v: Sequence[Scalar]) -> tuple[Twist, ...]:
    """Angular acceleration and acceleration of the origin of every body when θ̈ = 0, by one outward pass
    (Ṙ θ̇ at the bodies' origins, without Ṙ)."""
    rates = column_rates(at, moving)

    def step(body: TreeBody, parent: Twist) -> Twist:
        here, before = moving[body.index], moving[body.parent] if body.parent >= 0 else AT_REST
        motion, origin = at.motions[body.index], at.poses[body.index].origin
        arm = vsub(origin, at.pose(body.parent).origin)
        angular = parent.angular
        linear = vadd(parent.linear, cross(parent.angular, arm))
        linear = vadd(linear, cross(before.angular, vsub(here.linear, before.linear)))
        reach = vsub(origin, motion.reference)
        reach_rate = vsub(here.linear, point_velocity(at, moving, motion.reference_body, motion.reference))
        for column, (w_rate, v_rate), rate in zip(
            motion.columns, rates[body.index], v[body.v : body.v + body.nv], strict=True
        ):
            angular = vadd(angular, scale(rate, w_rate))
            moved = vadd(v_rate, vadd(cross(w_rate, reach), cross(column.w, reach_rate)))
            linear = vadd(linear, scale(rate, moved))
        return Twist(angular, linear)

    return outward(at.tree, AT_REST, step)


def point_bias(at: Kinematics, moving: Sequence[Twist], bias: Sequence[Twist], body: int, point: Vec) -> Vec:
    """Acceleration of a body's point when θ̈ = 0."""
    arm = vsub(point, at.poses[body].origin)
    spin = moving[body].angular
    return vadd(bias[body].linear, vadd(cross(bias[body].angular, arm), cross(spin, cross(spin, arm))))


def vector_bias(moving: Sequence[Twist], bias: Sequence[Twist], body: int, vector: Vec) -> Vec:
    """Second derivative of a body's vector when θ̈ = 0."""
    spin = moving[body].angular
    return vadd(cross(bias[body].angular, vector), cross(spin, cross(spin, vector)))


def configuration_rate(tree: Tree, values: Values, q: Sequence[Scalar], v: Sequence[Scalar]) -> Vec:
    """dq/dt = G(q) v: the tangent of `integrate`, for quaternions of any norm."""
    found: list[Scalar] = []
    for body in tree.bodies:
        if body.coupling is None:
            own = tuple(q[body.q : body.q + body.nq]), tuple(v[body.v : body.v + body.nv])
            found.extend(JOINT_TABLE[body.joint.type].rate(body.joint, *own, values))
    return tuple(found)


def integrate(tree: Tree, values: Values, state: State) -> Vec:
    """q after moving with velocity v for the time dt, on the manifold."""
    found: list[Scalar] = []
    for body in tree.bodies:
        if body.coupling is not None:
            continue
        step = tuple(state.dt * x for x in state.v[body.v : body.v + body.nv])
        row = JOINT_TABLE[body.joint.type]
        found.extend(row.integrate(body.joint, tuple(state.q[body.q : body.q + body.nq]), step, values))
    return tuple(found)
