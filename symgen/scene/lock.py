"""Joints held at a position: a fixed joint with the exact transform."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf
from typing import Any

from symgen.errors import SceneError
from symgen.scene.document import Places, clean
from symgen.scene.exact import matmul, rotation_about, rotation_from_quaternion
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.mimics import root_of_mimics
from symgen.scene.model import IDENTITY3, ZERO3, Joint, Transform, Vector
from symgen.scene.mounts import Mounts, compose, compose_floats
from symgen.scene.schema import did_you_mean

_Z: Vector = (Fraction(0), Fraction(0), Fraction(1))


def lock_joints(joints: Sequence[Joint], lock: Mapping[str, Any], mounts: Mounts, places: Places) -> tuple[Joint, ...]:
    """``joints`` with those in ``lock`` made fixed at the position given (a number, or a list of nq numbers).

    Joints that mimic a locked one are fixed where it takes them. Raises SceneError for a joint that is not there, does
    not move, or mimics another, and for the wrong number of numbers.
    """
    known = {joint.name: joint for joint in joints}
    positions: dict[str, tuple[Fraction, ...]] = {}
    for name, position in lock.items():
        place = places.place(("lock", name))
        if name not in known:
            raise SceneError(f"there is no joint {clean(name)!r}{did_you_mean(name, _moving(known))}", place)
        joint = known[name]
        q = tuple(position) if isinstance(position, list) else (position,)
        size = JOINT_TYPES[joint.type].nq
        if size == 0:
            raise SceneError(f"joint {clean(name)!r} is fixed already", place)
        if joint.mimic is not None and joint.mimic.joint in known:
            raise SceneError(
                f"joint {clean(name)!r} mimics {clean(joint.mimic.joint)!r}; lock that one, and this one goes with it",
                place,
            )
        if len(q) != size:
            raise SceneError(f"joint {clean(name)!r} is {joint.type}: {size} numbers are wanted, {len(q)} given", place)
        positions[name] = q
    return tuple(_locked(joint, positions, known, mounts, places) for joint in joints)


def _moving(joints: Mapping[str, Joint]) -> list[str]:
    return [name for name, joint in joints.items() if joint.type != "fixed"]


def _locked(
    joint: Joint,
    positions: Mapping[str, tuple[Fraction, ...]],
    known: Mapping[str, Joint],
    mounts: Mounts,
    places: Places,
) -> Joint:
    """``joint``, fixed if it or the joint that it mimics is locked."""
    master, multiplier, offset = root_of_mimics(joint, known)
    q = positions.get(joint.name) or positions.get(master)
    if q is None:
        return joint
    if joint.mimic is not None and joint.name not in positions:
        if len(q) > 1:
            return joint  # which is refused later
        q = (multiplier * q[0] + offset,)
    bounds = dict(joint.limits)
    lower, upper = bounds.get("lower", -inf), bounds.get("upper", inf)
    if len(q) == 1 and not lower <= float(q[0]) <= upper:
        mounts.beyond.append(f"{clean(joint.name)} ({float(q[0]):.6g}, not in [{lower:.6g}, {upper:.6g}])")
    try:
        step = joint_transform(joint, q, mounts.snap)
    except ValueError as error:
        raise SceneError(f"joint {clean(joint.name)!r}: {error}", places.place(("lock", master))) from None
    if joint.name in mounts.raw:
        mounts.raw[joint.name] = compose_floats(mounts.raw[joint.name], step.rotation)
    return Joint(joint.name, "fixed", joint.parent, joint.child, compose(joint.origin, step))


def joint_transform(joint: Joint, q: Sequence[Fraction], snap: Fraction) -> Transform:
    """Pose of the child in the joint frame at position ``q``, exactly orthogonal (theory.md §3 and §7)."""
    axis, axis2 = joint.axis or _Z, joint.axis2 or _Z
    match joint.type:
        case "revolute" | "continuous":
            return Transform(rotation_about(axis, q[0], snap), ZERO3)
        case "prismatic":
            return Transform(IDENTITY3, _along(axis, q[0]))
        case "helical":
            return Transform(rotation_about(axis, q[0], snap), _along(axis, q[0] * (joint.pitch or 0)))
        case "cylindrical":
            return Transform(rotation_about(axis, q[0], snap), _along(axis, q[1]))
        case "universal":
            return Transform(matmul(rotation_about(axis, q[0], snap), rotation_about(axis2, q[1], snap)), ZERO3)
        case "planar":
            return Transform(rotation_about(_Z, q[2], snap), (q[0], q[1], Fraction(0)))
        case "spherical":
            return Transform(rotation_from_quaternion(q[3], q[0], q[1], q[2]), ZERO3)
    return Transform(rotation_from_quaternion(q[6], q[3], q[4], q[5]), (q[0], q[1], q[2]))


def _along(axis: Vector, distance: Fraction) -> Vector:
    return (axis[0] * distance, axis[1] * distance, axis[2] * distance)
