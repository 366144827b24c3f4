"""A Pinocchio model of a scene, and the maps between symgen's coordinates and Pinocchio's.

Positions are the same numbers in both (the joints are chosen so); a mimic joint has a coordinate of its own there,
which `Pinocchio.expand` computes. Velocities differ on a floating base, where Pinocchio's are in base axes, and by
the mimic joints: v_pin = S v with S and Ṡ of `Pinocchio.velocity_map`. A joint with several freedoms that Pinocchio
has not is a chain of elementary ones: its derivatives are wrong for composite joints whose axes move.
Source: Featherstone 2008 for the algorithms Pinocchio runs (CRBA, RNEA, ABA).
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from symgen.errors import NotSupportedError, ToolError
from symgen.scene.model import JointSpring, Scene, Spring
from symgen.validation.mechanism import Array, Link, Mechanism, Pose, body_inertia, build_mechanism, vector


def import_pinocchio() -> ModuleType:
    try:
        return importlib.import_module("pinocchio")
    except ImportError as error:
        raise ToolError("Pinocchio is not installed: pip install 'symgen[validation]'") from error


@dataclass(frozen=True)
class VelocityMap:
    """v_pin = S v and v̇_pin = S a + Ṡ v; S is (Pinocchio's nv, nv)."""

    S: Array
    S_rate_v: Array


@dataclass(frozen=True)
class Pinocchio:
    """Dynamics of a scene by Pinocchio, in symgen's coordinates and units."""

    mechanism: Mechanism
    pin: Any
    model: Any
    data: Any
    loose_armature: Array
    """Armature that Pinocchio cannot carry in its own coordinates (floating bases), on symgen's diagonal."""
    joints: tuple[int, ...]
    """Pinocchio's joint that moves each link (the last of a chain)."""
    places: tuple[tuple[slice, slice], ...]
    """Where each link's coordinates are in Pinocchio's q and v."""

    @property
    def square(self) -> bool:
        """No joint is coupled to another: S is orthogonal then."""
        return int(self.model.nv) == self.mechanism.nv

    def expand(self, q: Array) -> Array:
        """Pinocchio's q, in which coupled joints have coordinates too."""
        full = np.zeros(self.model.nq)
        for link, (place, _) in zip(self.mechanism.links, self.places, strict=True):
            full[place] = link.position(q)
        return full

    def velocity_map(self, q: Array, v: Array) -> VelocityMap:
        """S and Ṡ v at a state."""
        S, rate = np.zeros((self.model.nv, self.mechanism.nv)), np.zeros(self.model.nv)
        kind = self.mechanism.scene.options.base_velocity
        for link, (_, place) in zip(self.mechanism.links, self.places, strict=True):
            S[place, link.v] = link.factor * np.eye(place.stop - place.start)
            if link.joint.type != "floating" or kind == "body":
                continue
            turn = self.base_rotation(link, q)
            lin, ang = slice(link.v.start, link.v.start + 3), slice(link.v.start + 3, link.v.stop)
            full = slice(place.start, place.start + 3)
            S[full, lin] = turn.T
            omega = v[ang]
            if kind == "world":
                S[place.start + 3 : place.stop, ang] = turn.T
                omega = turn.T @ omega
            # d(Aᵀ)/dt = −ω̃ Aᵀ with ω in base axes; the angular part gives −ω × ω = 0.
            rate[full] = -np.cross(omega, turn.T @ v[lin])
        return VelocityMap(S, rate)

    def base_rotation(self, link: Link, q: Array) -> Array:
        """Rotation of a floating link's axes to ground axes."""
        return np.asarray(link.origin.rotation @ self.pin.Quaternion(*np.roll(q[link.q][3:], 1)).normalized().matrix())

    def mass_matrix(self, q: Array) -> Array:
        """M (nv, nv) by CRBA."""
        S = self.velocity_map(q, np.zeros(self.mechanism.nv)).S
        M = np.array(self.pin.crba(self.model, self.data, self.expand(q)))
        return np.asarray(S.T @ M @ S + np.diag(self.loose_armature))

    def mass_matrix_by_columns(self, q: Array) -> Array:
        """M from RNEA with unit accelerations: independent of CRBA's joint-order trap."""
        n = self.mechanism.nv
        S, zero, full = self.velocity_map(q, np.zeros(n)).S, np.zeros(self.model.nv), self.expand(q)
        rest = np.array(self.pin.rnea(self.model, self.data, full, zero, zero))
        columns = [np.array(self.pin.rnea(self.model, self.data, full, zero, S[:, k])) - rest for k in range(n)]
        return np.asarray(S.T @ np.array(columns).T + np.diag(self.loose_armature))

    def gravity_force(self, q: Array) -> Array:
        S = self.velocity_map(q, np.zeros(self.mechanism.nv)).S
        return np.asarray(S.T @ np.array(self.pin.computeGeneralizedGravity(self.model, self.data, self.expand(q))))

    def passive_force(self, q: Array, v: Array) -> Array:
        """Springs and dampers on the left-hand side, from Pinocchio's own Jacobians."""
        passive, to_pin = np.zeros(self.mechanism.nv), self.velocity_map(q, v)
        for link in self.mechanism.links:
            passive[link.v] += link.factor * float(link.joint.damping) * link.rate(v)
        springs = [force for force in self.mechanism.scene.forces if isinstance(force, Spring)]
        if springs:
            self.pin.computeJointJacobians(self.model, self.data, self.expand(q))
            self.pin.forwardKinematics(self.model, self.data, self.expand(q), to_pin.S @ v)
        for spring in springs:
            passive -= to_pin.S.T @ self._spring_force(spring, to_pin.S @ v)
        for force in self.mechanism.scene.forces:
            if isinstance(force, JointSpring):
                link = next(x for x in self.mechanism.links if x.joint.name == force.joint)
                load = float(force.stiffness) * (link.position(q) - float(force.rest))
                passive[link.v] += link.factor * (load + float(force.damping) * link.rate(v))
        return passive

    def _spring_force(self, spring: Spring, v: Array) -> Array:
        """Jᵀ f of a spring between two points, Pinocchio's generalised coordinates."""
        ends = [self._point(body, vector(point)) for body, point in zip(spring.between, spring.points, strict=True)]
        (r1, J1), (r2, J2) = ends
        distance = float(np.linalg.norm(r2 - r1))
        direction = (r2 - r1) / distance
        rate = float(direction @ ((J2 - J1) @ v))
        tension = float(spring.stiffness) * (distance - float(spring.length)) + float(spring.damping) * rate
        return np.asarray(tension * (J1 - J2).T @ direction)

    def _point(self, body: str, local: Array) -> tuple[Array, Array]:
        """Position of a body's point and its Jacobian (3, nv), ground axes."""
        index, inner = self.mechanism.frames[body]
        if index < 0:
            return inner.apply(local), np.zeros((3, self.model.nv))
        joint = self.joints[index]
        placement = self.data.oMi[joint]
        J = np.array(self.pin.getJointJacobian(self.model, self.data, joint, self.pin.LOCAL_WORLD_ALIGNED))
        J = J.reshape(6, self.model.nv)  # of one joint alone it comes as six numbers
        arm = placement.rotation @ inner.apply(local)
        return placement.translation + arm, J[:3] - np.asarray(self.pin.skew(arm)) @ J[3:]

    def bias_force(self, q: Array, v: Array) -> Array:
        """C v + gravity + passive forces (nv)."""
        return self.inverse_dynamics(q, v, np.zeros(self.mechanism.nv))

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """tau (nv) by RNEA."""
        to_pin = self.velocity_map(q, v)
        motion = self.expand(q), to_pin.S @ v, to_pin.S @ a + to_pin.S_rate_v
        tau = np.array(self.pin.rnea(self.model, self.data, *motion))
        return np.asarray(to_pin.S.T @ tau + self.loose_armature * a + self.passive_force(q, v))

    def forward_dynamics(self, q: Array, v: Array, tau: Array) -> Array:
        """a (nv) by ABA; by CRBA and RNEA where joints are coupled or a floating base has armature."""
        if np.any(self.loose_armature) or not self.square:
            return np.asarray(np.linalg.solve(self.mass_matrix(q), tau - self.bias_force(q, v)))
        to_pin = self.velocity_map(q, v)
        # S is orthogonal on every joint, so S⁻ᵀ = S and S⁻¹ = Sᵀ.
        load = to_pin.S @ (tau - self.passive_force(q, v))
        acceleration = np.array(self.pin.aba(self.model, self.data, self.expand(q), to_pin.S @ v, load))
        return np.asarray(to_pin.S.T @ (acceleration - to_pin.S_rate_v))

    def body_pose(self, q: Array, body: str) -> Pose:
        index, inner = self.mechanism.frames[body]
        if index < 0:
            return inner
        self.pin.forwardKinematics(self.model, self.data, self.expand(q))
        placement = self.data.oMi[self.joints[index]]
        return Pose(np.array(placement.rotation), np.array(placement.translation)) @ inner


def joint_models(pin: Any, link: Link) -> list[Any]:
    """The chain of Pinocchio joints whose coordinates are symgen's."""
    match link.joint.type:
        case "revolute" | "continuous":
            return [pin.JointModelRevoluteUnaligned(link.axis)]
        case "prismatic":
            return [pin.JointModelPrismaticUnaligned(link.axis)]
        case "helical":
            return [pin.JointModelHelicalUnaligned(link.axis, link.pitch)]
        case "cylindrical":
            return [pin.JointModelRevoluteUnaligned(link.axis), pin.JointModelPrismaticUnaligned(link.axis)]
        case "universal":
            return [pin.JointModelRevoluteUnaligned(link.axis), pin.JointModelRevoluteUnaligned(link.axis2)]
        case "planar":
            return [pin.JointModelPX(), pin.JointModelPY(), pin.JointModelRZ()]
        case "spherical":
            return [pin.JointModelSpherical()]
        case "floating":
            return [pin.JointModelFreeFlyer()]
    raise NotSupportedError(f"joint type {link.joint.type} has no Pinocchio model")


def build_pinocchio(scene: Scene, raw: dict[str, Array] | None = None) -> Pinocchio:
    """The scene as a Pinocchio model, joints added depth first (CRBA is silently wrong otherwise).

    ``raw`` replaces mounting rotations by joint name, to measure what snapping changed.
    Raises `ToolError` when Pinocchio is missing, `NotSupportedError` on closed loops.
    """
    pin = import_pinocchio()
    mechanism = build_mechanism(scene, raw)
    model = pin.Model()
    model.name = scene.name
    loose = np.zeros(mechanism.nv)
    armature: list[float] = []
    joints: list[int] = []
    places: list[tuple[slice, slice]] = []
    for link in mechanism.links:
        start = slice(model.nq, None), slice(model.nv, None)
        joint = joints[link.parent] if link.parent >= 0 else 0
        placement = pin.SE3(link.origin.rotation, link.origin.position)
        for k, part in enumerate(joint_models(pin, link)):
            number = model.njoints
            joint = model.addJoint(joint, part, placement, f"{link.joint.name}/{k}")
            placement = pin.SE3.Identity()
            if joint != number:
                raise ToolError(f"Pinocchio renumbered joint {link.joint.name}")
        joints.append(joint)
        places.append((slice(start[0].start, model.nq), slice(start[1].start, model.nv)))
        for body, local in link.parts:
            inertia = pin.Inertia.Zero()  # the constructor refuses what no body can have, which URDF files do hold
            inertia.mass, inertia.lever, inertia.inertia = float(body.mass), vector(body.com), body_inertia(body)
            model.appendBodyToJoint(joint, inertia, pin.SE3(local.rotation, local.position))
        floating = link.joint.type == "floating"
        armature += [0.0 if floating else float(link.joint.armature)] * (model.nv - start[1].start)
        if floating:
            loose[link.v] = float(link.joint.armature)
    add_frames(pin, model, mechanism, joints)
    model.armature = np.array(armature)
    model.gravity.linear = vector(scene.gravity)
    return Pinocchio(mechanism, pin, model, model.createData(), loose, tuple(joints), tuple(places))


def add_frames(pin: Any, model: Any, mechanism: Mechanism, joints: list[int]) -> None:
    """Every body and frame of the scene as a frame of Pinocchio's, by its name."""
    for name, (index, local) in mechanism.frames.items():
        joint = joints[index] if index >= 0 else 0
        place = pin.SE3(local.rotation, local.position)
        model.addFrame(pin.Frame(f"frame/{name}", joint, 0, place, pin.FrameType.OP_FRAME), False)
