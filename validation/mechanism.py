"""The scene as the validators see it: a depth-first list of links in plain floats, and its kinematics.

Written from the scene format alone. It shares no code with the derivation, so that an error there
cannot hide here; agreement of the coordinate order is checked by name (`order_matches`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import GROUND, Body, Joint, Scene, Transform

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """x_outer = rotation · x_inner + position."""

    rotation: Array
    position: Array

    def __matmul__(self, inner: Pose) -> Pose:
        return Pose(self.rotation @ inner.rotation, self.position + self.rotation @ inner.position)

    def apply(self, point: Array) -> Array:
        return np.asarray(self.position + self.rotation @ point)

    def inverse(self) -> Pose:
        return Pose(self.rotation.T, -self.rotation.T @ self.position)


IDENTITY = Pose(np.eye(3), np.zeros(3))


@dataclass(frozen=True)
class Link:
    """A moving body, the joint that carries it, and everything that is fixed to it."""

    name: str
    joint: Joint
    parent: int
    """Index of the parent link, −1 for ground."""
    origin: Pose
    """The joint frame in the parent *link's* frame (fixed joints between are folded in)."""
    parts: tuple[tuple[Body, Pose], ...]
    q: slice
    v: slice
    coupling: tuple[float, float] | None = None
    """(multiplier, offset) of a mimic joint: ``q`` and ``v`` are then its master's places."""

    @property
    def factor(self) -> float:
        """∂(the joint's own velocity)/∂v[self.v]."""
        return self.coupling[0] if self.coupling else 1.0

    def position(self, q: Array) -> Array:
        """The joint's own coordinates."""
        return q[self.q] if self.coupling is None else self.coupling[0] * q[self.q] + self.coupling[1]

    def rate(self, v: Array) -> Array:
        """The joint's own velocities (and accelerations, alike)."""
        return v[self.v] if self.coupling is None else self.coupling[0] * v[self.v]

    @property
    def axis(self) -> Array:
        return vector(self.joint.axis or (Fraction(0),) * 3)

    @property
    def axis2(self) -> Array:
        return vector(self.joint.axis2 or (Fraction(0),) * 3)

    @property
    def pitch(self) -> float:
        return float(self.joint.pitch or 0)


@dataclass(frozen=True)
class Mechanism:
    scene: Scene
    links: tuple[Link, ...]
    frames: dict[str, tuple[int, Pose]]
    """Every body and named frame: (index of the link it belongs to, its pose in that link); −1 is ground."""
    nq: int
    nv: int

    def place(self, body: str, poses: Sequence[Pose]) -> Pose:
        """Pose of any body of the scene in ground axes, from the poses of the links."""
        index, local = self.frames[body]
        return local if index < 0 else poses[index] @ local


@dataclass(frozen=True)
class Motion:
    """Velocity of a link: of its frame's origin and angular, both in ground axes."""

    linear: Array
    angular: Array

    def at(self, arm: Array) -> Array:
        """Velocity of the point that lies at ``arm`` (ground axes) from the origin."""
        return np.asarray(self.linear + np.cross(self.angular, arm))


def vector(values: Sequence[Fraction]) -> Array:
    return np.array([float(x) for x in values])


def pose(transform: Transform) -> Pose:
    return Pose(np.array([[float(x) for x in row] for row in transform.rotation]), vector(transform.translation))


def build_mechanism(scene: Scene, raw: dict[str, Array] | None = None) -> Mechanism:
    """Links in depth-first order, children in the scene's order.

    ``raw`` replaces mounting rotations by joint name (the file's own, before snapping).
    Raises `NotSupportedError` when the scene has a closed loop.
    """
    children: dict[str, list[Joint]] = {}
    entered: set[str] = set()
    for joint in scene.joints:
        if joint.child in entered or joint.child == GROUND:
            raise NotSupportedError(f"{scene.name}: joint {joint.name} closes a loop; loops are not validated yet")
        entered.add(joint.child)
        children.setdefault(joint.parent, []).append(joint)

    links: list[Link] = []
    frames: dict[str, tuple[int, Pose]] = {GROUND: (-1, IDENTITY)}
    parts: dict[int, list[tuple[Body, Pose]]] = {}
    sizes = [0, 0]

    def mount(joint: Joint) -> Pose:
        origin = pose(joint.origin)
        rotation = (raw or {}).get(joint.name)
        return origin if rotation is None else Pose(np.asarray(rotation, dtype=float), origin.position)

    def visit(body: str) -> None:
        index, local = frames[body]
        for joint in children.get(body, []):
            origin = local @ mount(joint)
            if joint.type == "fixed":
                frames[joint.child] = (index, origin)
                parts.setdefault(index, []).append((scene.body(joint.child), origin))
            else:
                kind = JOINT_TYPES[joint.type]
                own = joint.mimic is None
                q = slice(sizes[0], sizes[0] + kind.nq * own)
                v = slice(sizes[1], sizes[1] + kind.nv * own)
                sizes[0], sizes[1] = q.stop, v.stop
                frames[joint.child] = (len(links), IDENTITY)
                parts[len(links)] = [(scene.body(joint.child), IDENTITY)]
                links.append(Link(joint.child, joint, index, origin, (), q, v))
            visit(joint.child)

    visit(GROUND)
    missing = [body.name for body in scene.bodies if body.name not in frames]
    if missing:
        raise SceneError(f"bodies not connected to ground: {', '.join(missing)}", scene.source or scene.name)
    for frame in scene.frames:
        index, local = frames[frame.body]
        frames[frame.name] = (index, local @ pose(frame.origin))
    masters = {link.joint.name: link for link in links}
    done = tuple(couple(scene, replace(link, parts=tuple(parts[i])), masters) for i, link in enumerate(links))
    return Mechanism(scene, done, frames, sizes[0], sizes[1])


def couple(scene: Scene, link: Link, links: dict[str, Link]) -> Link:
    """A mimic joint's link at its master's places (mimics of mimics composed); any other as it is."""
    mimic, multiplier, offset = link.joint.mimic, Fraction(1), Fraction(0)
    if mimic is None:
        return link
    while mimic is not None:
        offset += multiplier * mimic.offset
        multiplier *= mimic.multiplier
        master = mimic.joint
        mimic = scene.joint(master).mimic
    coupling = (float(multiplier), float(offset))
    return replace(link, q=links[master].q, v=links[master].v, coupling=coupling)


def order_matches(mechanism: Mechanism, names: Sequence[str], starts: Sequence[tuple[int, int]]) -> bool:
    """Does another's depth-first list (body names; where their q and v start) agree with ours?"""
    ours = [(link.name, link.q.start, link.v.start) for link in mechanism.links]
    if len(names) != len(ours):
        return False
    return ours == [(name, q, v) for name, (q, v) in zip(names, starts, strict=True)]


def skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def rotation_about(axis: Array, angle: float) -> Array:
    """Rodrigues' formula."""
    k = skew(axis)
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k))


def rotation_of(quaternion: Array) -> Array:
    """Rotation of the quaternion [x y z w], divided by its squared norm."""
    s, w = quaternion[:3], quaternion[3]
    k = skew(s)
    return np.asarray(np.eye(3) + 2.0 * (w * k + k @ k) / (quaternion @ quaternion))


def quaternion_of(rotation: Array) -> Array:
    """Unit quaternion [x y z w] of a rotation matrix, by its largest component (Shepperd 1978)."""
    R = rotation
    products = np.array(
        [
            [1 + R[0, 0] - R[1, 1] - R[2, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[2, 1] - R[1, 2]],
            [R[0, 1] + R[1, 0], 1 - R[0, 0] + R[1, 1] - R[2, 2], R[1, 2] + R[2, 1], R[0, 2] - R[2, 0]],
            [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], 1 - R[0, 0] - R[1, 1] + R[2, 2], R[1, 0] - R[0, 1]],
            [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 1 + R[0, 0] + R[1, 1] + R[2, 2]],
        ]
    )
    row = products[int(np.argmax(np.diag(products)))]
    return np.asarray(row / np.linalg.norm(row))


def joint_pose(link: Link, q: Array) -> Pose:
    """The child's frame in the joint frame."""
    zero, axis = np.zeros(3), link.axis
    match link.joint.type:
        case "revolute" | "continuous":
            return Pose(rotation_about(axis, q[0]), zero)
        case "prismatic":
            return Pose(np.eye(3), axis * q[0])
        case "helical":
            return Pose(rotation_about(axis, q[0]), axis * (link.pitch * q[0]))
        case "cylindrical":
            return Pose(rotation_about(axis, q[0]), axis * q[1])
        case "universal":
            return Pose(rotation_about(axis, q[0]) @ rotation_about(link.axis2, q[1]), zero)
        case "planar":
            return Pose(rotation_about(np.array([0.0, 0.0, 1.0]), q[2]), np.array([q[0], q[1], 0.0]))
        case "spherical":
            return Pose(rotation_of(q), zero)
        case "floating":
            return Pose(rotation_of(q[3:]), np.array(q[:3]))
    raise NotSupportedError(f"joint type {link.joint.type} is not validated")


def joint_motion(link: Link, q: Array, v: Array, outer: Array, child: Array, base_velocity: str) -> Motion:
    """The child's velocity relative to its parent, ground axes, at the child's origin.

    ``outer`` is the joint frame's rotation to ground axes, ``child`` the child's.
    """
    zero, u = np.zeros(3), outer @ link.axis
    match link.joint.type:
        case "revolute" | "continuous":
            return Motion(zero, u * v[0])
        case "prismatic":
            return Motion(u * v[0], zero)
        case "helical":
            return Motion(u * (link.pitch * v[0]), u * v[0])
        case "cylindrical":
            return Motion(u * v[1], u * v[0])
        case "universal":
            return Motion(zero, u * v[0] + child @ link.axis2 * v[1])
        case "planar":
            return Motion(outer[:, 0] * v[0] + outer[:, 1] * v[1], outer[:, 2] * v[2])
        case "spherical":
            return Motion(zero, child @ v)
        case "floating":
            linear = child @ v[:3] if base_velocity == "body" else np.array(v[:3])
            return Motion(linear, np.array(v[3:]) if base_velocity == "world" else child @ v[3:])
    raise NotSupportedError(f"joint type {link.joint.type} is not validated")


def link_poses(mechanism: Mechanism, q: Array) -> list[Pose]:
    """Pose of every link in ground axes."""
    poses: list[Pose] = []
    for link in mechanism.links:
        parent = IDENTITY if link.parent < 0 else poses[link.parent]
        poses.append(parent @ link.origin @ joint_pose(link, link.position(q)))
    return poses


def link_motions(mechanism: Mechanism, q: Array, v: Array, poses: Sequence[Pose]) -> list[Motion]:
    """Velocity of every link."""
    motions: list[Motion] = []
    for link, here in zip(mechanism.links, poses, strict=True):
        base = IDENTITY if link.parent < 0 else poses[link.parent]
        carried = Motion(np.zeros(3), np.zeros(3)) if link.parent < 0 else motions[link.parent]
        own = joint_motion(
            link, link.position(q), link.rate(v), base.rotation @ link.origin.rotation, here.rotation,
            mechanism.scene.options.base_velocity,
        )  # fmt: skip
        motions.append(Motion(carried.at(here.position - base.position) + own.linear, carried.angular + own.angular))
    return motions


def link_accelerations(mechanism: Mechanism, q: Array, v: Array, a: Array) -> list[Motion]:
    """Accelerations of every link's origin and its angular one, ground axes.

    The derivative of `link_motions` along q̇ = G v, v̇ = a by the complex step, exact to rounding.
    """
    step = 1e-40j
    at_q = q + step * position_rate(mechanism, q, v)
    motions = link_motions(mechanism, at_q, v + step * a, link_poses(mechanism, at_q))
    return [Motion(x.linear.imag / step.imag, x.angular.imag / step.imag) for x in motions]


def quaternion_rate(quaternion: Array, omega: Array) -> Array:
    """½ quaternion ∘ (ω, 0) for the quaternion [x y z w] and ω in the turned axes."""
    s, w = quaternion[:3], quaternion[3]
    return 0.5 * np.append(w * omega + np.cross(s, omega), -s @ omega)


def position_rate(mechanism: Mechanism, q: Array, v: Array) -> Array:
    """q̇ = G(q) v."""
    rate = np.zeros(mechanism.nq)
    base_velocity = mechanism.scene.options.base_velocity
    for link in mechanism.links:
        if link.coupling is not None:
            continue
        qj, vj = q[link.q], v[link.v]
        if link.joint.type == "spherical":
            rate[link.q] = quaternion_rate(qj, vj)
        elif link.joint.type == "floating":
            turn = rotation_of(qj[3:])
            outer = link.origin.rotation
            linear = turn @ vj[:3] if base_velocity == "body" else outer.T @ vj[:3]
            omega = (outer @ turn).T @ vj[3:] if base_velocity == "world" else vj[3:]
            rate[link.q] = np.concatenate([linear, quaternion_rate(qj[3:], omega)])
        else:
            rate[link.q] = vj
    return rate


def random_state(mechanism: Mechanism, rng: np.random.Generator) -> tuple[Array, Array]:
    """Joint angles within ±π, displacements within ±1 m, random unit quaternions, velocities within ±2."""
    q = rng.uniform(-1.0, 1.0, mechanism.nq)
    for link in mechanism.links:
        if link.coupling is not None:
            continue
        kind = JOINT_TYPES[link.joint.type]
        scale = np.array([np.pi if unit == "rad" else 1.0 for unit in kind.q_units])
        q[link.q] *= scale
        if link.joint.type in ("spherical", "floating"):
            quaternion = rng.normal(size=4)
            q[link.q.stop - 4 : link.q.stop] = quaternion / np.linalg.norm(quaternion)
    return q, rng.uniform(-2.0, 2.0, mechanism.nv)


def body_inertia(body: Body) -> Array:
    """3×3 about the centre of mass, body axes."""
    xx, yy, zz, xy, xz, yz = (float(x) for x in body.inertia)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def lump(link: Link, local: Pose) -> tuple[float, Array, Array]:
    """Mass, centre and inertia about the centre of all bodies welded to a link, in the frame where ``local`` is it."""
    parts = [(float(body.mass), local @ here, body) for body, here in link.parts]
    mass = sum(m for m, _, _ in parts)
    centres = [here.apply(vector(body.com)) for _, here, body in parts]
    weighted = sum((m * c for (m, _, _), c in zip(parts, centres, strict=True)), np.zeros(3))
    centre = np.asarray(weighted / mass) if mass else np.zeros(3)
    inertia = np.zeros((3, 3))
    for (m, here, body), c in zip(parts, centres, strict=True):
        d = c - centre
        inertia += here.rotation @ body_inertia(body) @ here.rotation.T + m * ((d @ d) * np.eye(3) - np.outer(d, d))
    return mass, centre, inertia
