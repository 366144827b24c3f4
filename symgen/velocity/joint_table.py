"""The joint table: a joint type is its motion subspace and its position map, nothing else (theory, §3; paper, Table 1).

To add a joint type: one row in `symgen.scene.joints.JOINT_TYPES` and one in `JOINT_TABLE` here, what its
neighbours share in `symgen.natural`, and how it is lowered to elementary joints in `symgen.plans.links`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import IDENTITY, ZERO, Mat, Vec, half, matmul, matvec, scale, transpose, vadd
from symgen.algebra.numbers import Numbers
from symgen.scene.model import Joint
from symgen.velocity.rotation import (
    axis_rotation,
    quaternion_exponential,
    quaternion_product,
    quaternion_rotation,
    renormalise,
)
from symgen.velocity.values import Values

Scalar = Any

PARENT, CHILD, STILL = "parent", "child", "ground"


@dataclass(frozen=True)
class Column:
    """One column of a motion subspace in ground axes: angular part w, linear part v (velocity of the child's
    point at the joint's reference), and what carries them: the body whose rotation turns w and v."""

    w: Vec
    v: Vec
    carrier: str


@dataclass(frozen=True)
class Placement:
    """What the columns of a joint are made of, in ground axes."""

    joint_axes: Mat
    """A_J: joint frame (parent's side) to ground axes."""
    child_axes: Mat
    """A: child frame to ground axes."""
    base_velocity: str


@dataclass(frozen=True)
class JointRow:
    """``pose(joint, q, values)`` → (rotation, translation) of the child in the joint frame;
    ``columns(joint, placement, values)`` → motion subspace; ``reference``: which body the point r_j is fixed in
    (its position is the joint origin for the parent, the child's origin for the child);
    ``integrate(joint, q, v·dt, placement-free data)`` → q after the motion; ``rate(joint, q, v, …)`` → dq/dt."""

    pose: Callable[[Joint, Vec, Values], tuple[Mat, Vec]]
    columns: Callable[[Joint, Placement, Values], tuple[Column, ...]]
    reference: str
    integrate: Callable[[Joint, Vec, Vec, Values], Vec]
    rate: Callable[[Joint, Vec, Vec, Values], Vec]


def _turn(axis: Vec, angle: Scalar, numbers: Numbers) -> Mat:
    return axis_rotation(axis, numbers.cos(angle), numbers.sin(angle))


def _axis(joint: Joint, values: Values) -> Vec:
    assert joint.axis is not None
    return values.vector(joint.axis)


def _axis2(joint: Joint, values: Values) -> Vec:
    assert joint.axis2 is not None
    return values.vector(joint.axis2)


def _pitch(joint: Joint, values: Values) -> Scalar:
    assert joint.pitch is not None
    return values.lift(joint.pitch)


def _add(joint: Joint, q: Vec, step: Vec, values: Values) -> Vec:
    return vadd(q, step)


def _revolute_columns(joint: Joint, at: Placement, values: Values) -> tuple[Column, ...]:
    return (Column(matvec(at.joint_axes, _axis(joint, values)), ZERO, PARENT),)


def _prismatic_columns(joint: Joint, at: Placement, values: Values) -> tuple[Column, ...]:
    return (Column(ZERO, matvec(at.joint_axes, _axis(joint, values)), PARENT),)


def _helical_columns(joint: Joint, at: Placement, values: Values) -> tuple[Column, ...]:
    u = matvec(at.joint_axes, _axis(joint, values))
    return (Column(u, scale(_pitch(joint, values), u), PARENT),)


def _cylindrical_columns(joint: Joint, at: Placement, values: Values) -> tuple[Column, ...]:
    u = matvec(at.joint_axes, _axis(joint, values))
    return (Column(u, ZERO, PARENT), Column(ZERO, u, PARENT))


def _universal_columns(joint: Joint, at: Placement, values: Values) -> tuple[Column, ...]:
    return (
        Column(matvec(at.joint_axes, _axis(joint, values)), ZERO, PARENT),
        Column(matvec(at.child_axes, _axis2(joint, values)), ZERO, CHILD),
    )


def _planar_columns(joint: Joint, at: Placement, values: Values) -> tuple[Column, ...]:
    e1, e2, n = transpose(at.joint_axes)
    return (Column(ZERO, e1, PARENT), Column(ZERO, e2, PARENT), Column(n, ZERO, PARENT))


def _spherical_columns(joint: Joint, at: Placement, values: Values) -> tuple[Column, ...]:
    return tuple(Column(axis, ZERO, CHILD) for axis in transpose(at.child_axes))


def _floating_columns(joint: Joint, at: Placement, values: Values) -> tuple[Column, ...]:
    body_axes, ground_axes = (at.child_axes, CHILD), (IDENTITY, STILL)
    linear, linear_carrier = body_axes if at.base_velocity == "body" else ground_axes
    angular, angular_carrier = ground_axes if at.base_velocity == "world" else body_axes
    return (
        *(Column(ZERO, axis, linear_carrier) for axis in transpose(linear)),
        *(Column(axis, ZERO, angular_carrier) for axis in transpose(angular)),
    )


def _helical_pose(joint: Joint, q: Vec, values: Values) -> tuple[Mat, Vec]:
    axis = _axis(joint, values)
    return _turn(axis, q[0], values.numbers), scale(_pitch(joint, values) * q[0], axis)


def _universal_pose(joint: Joint, q: Vec, values: Values) -> tuple[Mat, Vec]:
    first = _turn(_axis(joint, values), q[0], values.numbers)
    return matmul(first, _turn(_axis2(joint, values), q[1], values.numbers)), ZERO


def _spherical_integrate(joint: Joint, q: Vec, step: Vec, values: Values) -> Vec:
    return renormalise(quaternion_product(q, quaternion_exponential(step, values.numbers)))


def _floating_integrate(joint: Joint, q: Vec, step: Vec, values: Values) -> Vec:
    """world, mixed: translation and rotation apart; body: the exponential of the rigid motion, as Pinocchio does."""
    position, quaternion, convention = q[:3], q[3:], values.scene.options.base_velocity
    to_joint = transpose(values.matrix(joint.origin.rotation))
    if convention == "world":
        turned = quaternion_product(quaternion_exponential(matvec(to_joint, step[3:]), values.numbers), quaternion)
        return (*vadd(position, matvec(to_joint, step[:3])), *renormalise(turned))
    turned = quaternion_product(quaternion, quaternion_exponential(step[3:], values.numbers))
    if convention == "mixed":
        return (*vadd(position, matvec(to_joint, step[:3])), *renormalise(turned))
    travel = matvec(quaternion_rotation(quaternion), _screw_travel(step[:3], step[3:], values.numbers))
    return (*vadd(position, travel), *renormalise(turned))


def _same(joint: Joint, q: Vec, v: Vec, values: Values) -> Vec:
    return v


def _quaternion_rate(left: Vec, right: Vec) -> Vec:
    """½ left ⊗ right, one of them a quaternion and the other an angular velocity with a zero scalar part."""
    return tuple(half(x) for x in quaternion_product(left, right))


def _spherical_rate(joint: Joint, q: Vec, v: Vec, values: Values) -> Vec:
    return _quaternion_rate(q, (*v, 0))


def _floating_rate(joint: Joint, q: Vec, v: Vec, values: Values) -> Vec:
    quaternion, convention = q[3:], values.scene.options.base_velocity
    to_joint = transpose(values.matrix(joint.origin.rotation))
    if convention == "body":
        travel = matvec(quaternion_rotation(quaternion), v[:3])
        return (*travel, *_quaternion_rate(quaternion, (*v[3:], 0)))
    travel = matvec(to_joint, v[:3])
    if convention == "mixed":
        return (*travel, *_quaternion_rate(quaternion, (*v[3:], 0)))
    return (*travel, *_quaternion_rate((*matvec(to_joint, v[3:]), 0), quaternion))


def _screw_travel(v: Vec, w: Vec, numbers: Numbers) -> Vec:
    """V v with V = 1 + (1 − cos φ)/φ² w̃ + (φ − sin φ)/φ³ w̃², φ = |w| (the translation of exp6)."""
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    half = numbers.sinc_sqrt(square / 4)
    b, c = half * half / 2, numbers.sinc3_sqrt(square)
    wv = (w[1] * v[2] - w[2] * v[1], w[2] * v[0] - w[0] * v[2], w[0] * v[1] - w[1] * v[0])
    wwv = (w[1] * wv[2] - w[2] * wv[1], w[2] * wv[0] - w[0] * wv[2], w[0] * wv[1] - w[1] * wv[0])
    return tuple(x + b * y + c * z for x, y, z in zip(v, wv, wwv, strict=True))


_REVOLUTE = JointRow(
    lambda joint, q, values: (_turn(_axis(joint, values), q[0], values.numbers), ZERO),
    _revolute_columns,
    PARENT,
    _add,
    _same,
)

JOINT_TABLE: dict[str, JointRow] = {
    "revolute": _REVOLUTE,
    "continuous": _REVOLUTE,
    "prismatic": JointRow(
        lambda joint, q, values: (IDENTITY, scale(q[0], _axis(joint, values))), _prismatic_columns, PARENT, _add, _same
    ),
    "helical": JointRow(_helical_pose, _helical_columns, PARENT, _add, _same),
    "cylindrical": JointRow(
        lambda joint, q, values: (
            _turn(_axis(joint, values), q[0], values.numbers),
            scale(q[1], _axis(joint, values)),
        ),
        _cylindrical_columns,
        PARENT,
        _add,
        _same,
    ),
    "universal": JointRow(_universal_pose, _universal_columns, PARENT, _add, _same),
    "planar": JointRow(
        lambda joint, q, values: (_turn((0, 0, 1), q[2], values.numbers), (q[0], q[1], 0)),
        _planar_columns,
        CHILD,
        _add,
        _same,
    ),
    "spherical": JointRow(
        lambda joint, q, values: (quaternion_rotation(q), ZERO),
        _spherical_columns,
        PARENT,
        _spherical_integrate,
        _spherical_rate,
    ),
    "floating": JointRow(
        lambda joint, q, values: (quaternion_rotation(q[3:]), tuple(q[:3])),
        _floating_columns,
        CHILD,
        _floating_integrate,
        _floating_rate,
    ),
}
