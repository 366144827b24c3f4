"""A Pinocchio model of a scene, and the maps between symgen's coordinates and Pinocchio's.

Positions are the same numbers in both (the joints are chosen so). Velocities differ on a floating
base only: Pinocchio's are in base axes, v_pin = S v with S and Ṡ of `Pinocchio.velocity_map`.
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
    """v_pin = S v and v̇_pin = S a + Ṡ v."""

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

    def neutral(self) -> Array:
        return np.asarray(self.pin.neutral(self.model))

    def velocity_map(self, q: Array, v: Array) -> VelocityMap:
        """S and Ṡ v at a state."""
        S, rate = np.eye(self.mechanism.nv), np.zeros(self.mechanism.nv)
        kind = self.mechanism.scene.options.base_velocity
        for link in self.mechanism.links:
            if link.joint.type != "floating" or kind == "body":
                continue
            turn = link.origin.rotation @ self.pin.Quaternion(*np.roll(q[link.q][3:], 1)).normalized().matrix()
            lin, ang = slice(link.v.start, link.v.start + 3), slice(link.v.start + 3, link.v.stop)
            S[lin, lin] = turn.T
            omega = v[ang]
            if kind == "world":
                S[ang, ang] = turn.T
                omega = turn.T @ omega
            # d(Aᵀ)/dt = −ω̃ Aᵀ with ω in base axes; the angular part gives −ω × ω = 0.
            rate[lin] = -np.cross(omega, turn.T @ v[lin])
        return VelocityMap(S, rate)

    def mass_matrix(self, q: Array) -> Array:
        """M (nv, nv) by CRBA."""
        S = self.velocity_map(q, np.zeros(self.mechanism.nv)).S
        M = np.array(self.pin.crba(self.model, self.data, q))
        return np.asarray(S.T @ M @ S + np.diag(self.loose_armature))

    def mass_matrix_by_columns(self, q: Array) -> Array:
        """M from RNEA with unit accelerations: independent of CRBA's joint-order trap."""
        n = self.mechanism.nv
        S, zero = self.velocity_map(q, np.zeros(n)).S, np.zeros(n)
        rest = np.array(self.pin.rnea(self.model, self.data, q, zero, zero))
        columns = [np.array(self.pin.rnea(self.model, self.data, q, zero, S[:, k])) - rest for k in range(n)]
        return np.asarray(S.T @ np.array(columns).T + np.diag(self.loose_armature))

    def gravity_force(self, q: Array) -> Array:
        S = self.velocity_map(q, np.zeros(self.mechanism.nv)).S
        return np.asarray(S.T @ np.array(self.pin.computeGeneralizedGravity(self.model, self.data, q)))

    def passive_force(self, q: Array, v: Array) -> Array:
        """Springs and dampers on the left-hand side, from Pinocchio's own Jacobians."""
        passive, to_pin = np.zeros(self.mechanism.nv), self.velocity_map(q, v)
        for link in self.mechanism.links:
            passive[link.v] += float(link.joint.damping) * v[link.v]
        springs = [force for force in self.mechanism.scene.forces if isinstance(force, Spring)]
        if springs:
            self.pin.computeJointJacobians(self.model, self.data, q)
            self.pin.forwardKinematics(self.model, self.data, q, to_pin.S @ v)
        for spring in springs:
            passive -= to_pin.S.T @ self._spring_force(spring, to_pin.S @ v)
        for force in self.mechanism.scene.forces:
            if isinstance(force, JointSpring):
                link = next(x for x in self.mechanism.links if x.joint.name == force.joint)
                passive[link.v] += float(force.stiffness) * (q[link.q] - float(force.rest))
                passive[link.v] += float(force.damping) * v[link.v]
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
            return inner.apply(local), np.zeros((3, self.mechanism.nv))
        placement = self.data.oMi[index + 1]
        J = np.array(self.pin.getJointJacobian(self.model, self.data, index + 1, self.pin.LOCAL_WORLD_ALIGNED))
        J = J.reshape(6, self.mechanism.nv)  # of one joint alone it comes as six numbers
        arm = placement.rotation @ inner.apply(local)
        return placement.translation + arm, J[:3] - np.asarray(self.pin.skew(arm)) @ J[3:]

    def bias_force(self, q: Array, v: Array) -> Array:
        """C v + gravity + passive forces (nv)."""
        return self.inverse_dynamics(q, v, np.zeros(self.mechanism.nv))

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """tau (nv) by RNEA."""
        to_pin = self.velocity_map(q, v)
        tau = np.array(self.pin.rnea(self.model, self.data, q, to_pin.S @ v, to_pin.S @ a + to_pin.S_rate_v))
        return np.asarray(to_pin.S.T @ tau + self.loose_armature * a + self.passive_force(q, v))

    def forward_dynamics(self, q: Array, v: Array, tau: Array) -> Array:
        """a (nv) by ABA."""
        if np.any(self.loose_armature):
            return np.asarray(np.linalg.solve(self.mass_matrix(q), tau - self.bias_force(q, v)))
        to_pin = self.velocity_map(q, v)
        # S is orthogonal on every joint, so S⁻ᵀ = S and S⁻¹ = Sᵀ.
        load = to_pin.S @ (tau - self.passive_force(q, v))
        acceleration = np.array(self.pin.aba(self.model, self.data, q, to_pin.S @ v, load))
        return np.asarray(to_pin.S.T @ (acceleration - to_pin.S_rate_v))

    def body_pose(self, q: Array, body: str) -> Pose:
        index, inner = self.mechanism.frames[body]
        if index < 0:
            return inner
        self.pin.forwardKinematics(self.model, self.data, q)
        placement = self.data.oMi[index + 1]
        return Pose(np.array(placement.rotation), np.array(placement.translation)) @ inner


def joint_model(pin: Any, link: Link) -> Any:
    """The Pinocchio joint whose coordinates are symgen's."""
    match link.joint.type:
        case "revolute" | "continuous":
            return pin.JointModelRevoluteUnaligned(link.axis)
        case "prismatic":
            return pin.JointModelPrismaticUnaligned(link.axis)
        case "helical":
            return pin.JointModelHelicalUnaligned(link.axis, link.pitch)
        case "cylindrical":
            parts = [pin.JointModelRevoluteUnaligned(link.axis), pin.JointModelPrismaticUnaligned(link.axis)]
        case "universal":
            parts = [pin.JointModelRevoluteUnaligned(link.axis), pin.JointModelRevoluteUnaligned(link.axis2)]
        case "planar":
            parts = [pin.JointModelPX(), pin.JointModelPY(), pin.JointModelRZ()]
        case "spherical":
            return pin.JointModelSpherical()
        case "floating":
            return pin.JointModelFreeFlyer()
        case other:
            raise NotSupportedError(f"joint type {other} has no Pinocchio model")
    composite = pin.JointModelComposite()
    for part in parts:
        composite.addJoint(part)
    return composite


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
    armature = np.zeros(mechanism.nv)
    for index, link in enumerate(mechanism.links):
        placement = pin.SE3(link.origin.rotation, link.origin.position)
        joint = model.addJoint(link.parent + 1, joint_model(pin, link), placement, link.joint.name)
        if joint != index + 1:
            raise ToolError(f"Pinocchio renumbered joint {link.joint.name}")
        for body, local in link.parts:
            inertia = pin.Inertia(float(body.mass), vector(body.com), body_inertia(body))
            model.appendBodyToJoint(joint, inertia, pin.SE3(local.rotation, local.position))
        (loose if link.joint.type == "floating" else armature)[link.v] = float(link.joint.armature)
    model.armature = armature
    model.gravity.linear = vector(scene.gravity)
    return Pinocchio(mechanism, pin, model, model.createData(), loose)
