"""Catalogue rows beyond plain dynamics as Pinocchio computes them, in symgen's coordinates.

Sources: Carpentier & Mansard 2018 (analytical derivatives of RNEA and ABA), Orin & Goswami 2008 (centroidal momentum),
as implemented in Pinocchio. With v_pin = S v the tangent-space derivatives follow by the product rule: S depends on
the rotation of a floating base and on nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from symgen.validation.differences import derivative
from symgen.validation.mechanism import Array, link_poses, position_rate, skew
from symgen.validation.passive import passive_derivatives, point_forces, wrench_on
from symgen.validation.pinocchio_model import Pinocchio


class State(NamedTuple):
    q: Array
    v: Array
    a: Array
    tau: Array


class MapChange(NamedTuple):
    """How S and Ṡv change along the unit directions of the tangent space and with v."""

    S: Array
    """(nv, Pinocchio's nv, nv): ∂S in direction j first."""
    rate_by_q: Array
    """(Pinocchio's nv, nv)."""
    rate_by_v: Array


def map_change(peer: Pinocchio, q: Array, v: Array) -> MapChange:
    """Only a floating base in `world` or `mixed` contributes; with Aᵀ changing by −ω_j × Aᵀ in direction j."""
    n, full = peer.mechanism.nv, int(peer.model.nv)
    dS, by_q, by_v = np.zeros((n, full, n)), np.zeros((full, n)), np.zeros((full, n))
    kind = peer.mechanism.scene.options.base_velocity
    for link, (_, place) in zip(peer.mechanism.links, peer.places, strict=True):
        if link.joint.type != "floating" or kind == "body":
            continue
        turn = peer.base_rotation(link, q)
        lin, ang = slice(link.v.start, link.v.start + 3), slice(link.v.start + 3, link.v.stop)
        row, spin = slice(place.start, place.start + 3), slice(place.start + 3, place.stop)
        to_body = turn.T if kind == "world" else np.eye(3)
        u, omega = turn.T @ v[lin], to_body @ v[ang]
        for k in range(3):
            j, turned = ang.start + k, to_body[:, k]
            dS[j, row, lin] = -skew(turned) @ turn.T
            change = np.zeros(3)
            if kind == "world":
                dS[j, spin, ang] = -skew(turned) @ turn.T
                change = -np.cross(turned, omega)
            by_q[row, j] = -np.cross(change, u) + np.cross(omega, np.cross(turned, u))
        by_v[row, lin] = -skew(omega) @ turn.T
        by_v[row, ang] = skew(u) @ to_body
    return MapChange(dS, by_q, by_v)


def mass_matrix_inverse(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    if not peer.square or np.any(peer.loose_armature):
        return (np.asarray(np.linalg.inv(peer.mass_matrix(s.q))),)
    S = peer.velocity_map(s.q, s.v).S
    upper = np.triu(np.array(peer.pin.computeMinverse(peer.model, peer.data, peer.expand(s.q))))
    return (S.T @ (upper + np.triu(upper, 1).T) @ S,)


def inverse_dynamics_derivatives(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    return inverse_dynamics_gradient(peer, s)[:2]


def inverse_dynamics_gradient(peer: Pinocchio, s: State) -> tuple[Array, Array, Array]:
    """∂tau/∂q, ∂tau/∂v, ∂tau/∂a by Pinocchio's analytical derivatives of RNEA."""
    to_pin, change = peer.velocity_map(s.q, s.v), map_change(peer, s.q, s.v)
    S, dS = to_pin.S, change.S
    motion = peer.expand(s.q), S @ s.v, S @ s.a + to_pin.S_rate_v
    peer.pin.computeRNEADerivatives(peer.model, peer.data, *motion)
    by_q, by_v, M = (np.array(x) for x in (peer.data.dtau_dq, peer.data.dtau_dv, peer.data.M))
    M = np.triu(M) + np.triu(M, 1).T
    load = np.array(peer.data.tau)
    dtau_dq = S.T @ (by_q @ S + by_v @ (dS @ s.v).T + M @ ((dS @ s.a).T + change.rate_by_q))
    dtau_dq += np.einsum("jki,k->ij", dS, load)
    dtau_dv = S.T @ (by_v @ S + M @ change.rate_by_v)
    passive_q, passive_v = passive_derivatives(peer.mechanism, s.q, s.v)
    return dtau_dq + passive_q, dtau_dv + passive_v, S.T @ M @ S + np.diag(peer.loose_armature)


def forward_dynamics_derivatives(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    """By the derivatives of ABA; where joints are coupled or a floating base has armature, from those of RNEA."""
    if not peer.square or np.any(peer.loose_armature):
        a = peer.forward_dynamics(s.q, s.v, s.tau)
        by_q, by_v, M = inverse_dynamics_gradient(peer, s._replace(a=a))
        inverse = np.asarray(np.linalg.inv(M))
        return -inverse @ by_q, -inverse @ by_v, inverse
    to_pin, change = peer.velocity_map(s.q, s.v), map_change(peer, s.q, s.v)
    S, dS = to_pin.S, change.S
    passive = peer.passive_force(s.q, s.v)
    passive_q, passive_v = passive_derivatives(peer.mechanism, s.q, s.v)
    motion = peer.expand(s.q), S @ s.v, S @ (s.tau - passive)
    by_q, by_v, upper = (np.array(x) for x in peer.pin.computeABADerivatives(peer.model, peer.data, *motion))
    inverse = np.triu(upper) + np.triu(upper, 1).T
    a = S.T @ (np.array(peer.data.ddq) - to_pin.S_rate_v)
    # S a + Ṡ v = aba(q, S v, S (tau − passive)), differentiated; S is orthogonal.
    da_dq = by_q @ S + by_v @ (dS @ s.v).T + inverse @ ((dS @ (s.tau - passive)).T - S @ passive_q)
    da_dq -= (dS @ a).T + change.rate_by_q
    da_dv = by_v @ S - inverse @ S @ passive_v - change.rate_by_v
    return S.T @ da_dq, S.T @ da_dv, S.T @ inverse @ S


def move(peer: Pinocchio, q: Array, direction: Array, t: float) -> Array:
    """A smooth curve through q that leaves it with velocity ``direction``."""
    moved = q + t * position_rate(peer.mechanism, q, direction)
    for link in peer.mechanism.links:
        if link.joint.type in ("spherical", "floating"):
            turn = slice(link.q.stop - 4, link.q.stop)
            moved[turn] /= np.linalg.norm(moved[turn])
    return moved


def inverse_dynamics_second_derivatives(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    """Pinocchio's first derivatives: differenced in q (extrapolated) and in v (quadratic: exact), and as they are for
    unit accelerations, in which they are linear."""
    n = peer.mechanism.nv
    dqdq, dqdv, dvdv, dadq = (np.zeros((n, n, n)) for _ in range(4))
    rest, _, _ = inverse_dynamics_gradient(peer, s._replace(v=np.zeros(n), a=np.zeros(n)))
    for k, unit in enumerate(np.eye(n)):

        def along(t: float, unit: Array = unit) -> Array:
            return inverse_dynamics_gradient(peer, s._replace(q=move(peer, s.q, unit, t)))[0]

        dqdq[:, :, k] = derivative(along)
        more, less = (inverse_dynamics_gradient(peer, s._replace(v=s.v + t * unit)) for t in (1.0, -1.0))
        dqdv[:, :, k], dvdv[:, :, k] = ((more[i] - less[i]) / 2.0 for i in (0, 1))
        dadq[:, k, :] = inverse_dynamics_gradient(peer, s._replace(v=np.zeros(n), a=unit))[0] - rest
    return dqdq, dqdv, dvdv, dadq


def center_of_mass(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    return (np.array(peer.pin.centerOfMass(peer.model, peer.data, peer.expand(s.q))),)


def momentum_matrix(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    A = np.array(peer.pin.computeCentroidalMap(peer.model, peer.data, peer.expand(s.q)))
    return (A @ peer.velocity_map(s.q, s.v).S,)


def momentum(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    v = peer.velocity_map(s.q, s.v).S @ s.v
    return (np.array(peer.pin.computeCentroidalMomentum(peer.model, peer.data, peer.expand(s.q), v).vector),)


def frame_jacobian(peer: Pinocchio, s: State, frame: str) -> tuple[Array, ...]:
    number = peer.model.getFrameId(f"frame/{frame}")
    axes = peer.pin.LOCAL_WORLD_ALIGNED
    J = peer.pin.computeFrameJacobian(peer.model, peer.data, peer.expand(s.q), number, axes)
    return (np.array(J).reshape(6, peer.model.nv) @ peer.velocity_map(s.q, s.v).S,)


def frame_velocity(peer: Pinocchio, s: State, frame: str) -> tuple[Array, ...]:
    number = peer.model.getFrameId(f"frame/{frame}")
    v = peer.velocity_map(s.q, s.v).S @ s.v
    peer.pin.forwardKinematics(peer.model, peer.data, peer.expand(s.q), v)
    return (np.array(peer.pin.getFrameVelocity(peer.model, peer.data, number, peer.pin.LOCAL_WORLD_ALIGNED).vector),)


def frame_bias_acceleration(peer: Pinocchio, s: State, frame: str) -> tuple[Array, ...]:
    """The classical acceleration of the frame's origin, and the angular one, when a = 0."""
    number = peer.model.getFrameId(f"frame/{frame}")
    to_pin = peer.velocity_map(s.q, s.v)
    peer.pin.forwardKinematics(peer.model, peer.data, peer.expand(s.q), to_pin.S @ s.v, to_pin.S_rate_v)
    axes = peer.pin.LOCAL_WORLD_ALIGNED
    return (np.array(peer.pin.getFrameClassicalAcceleration(peer.model, peer.data, number, axes).vector),)


def regressor(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    to_pin = peer.velocity_map(s.q, s.v)
    motion = peer.expand(s.q), to_pin.S @ s.v, to_pin.S @ s.a + to_pin.S_rate_v
    Y = np.array(peer.pin.computeJointTorqueRegressor(peer.model, peer.data, *motion))
    columns = np.concatenate([np.arange(10) + 10 * (joint - 1) for joint in peer.joints])
    return (to_pin.S.T @ Y[:, columns],)


def inertial_parameters(peer: Pinocchio) -> Array:
    """π, ten per moving body, in the order of the regressor."""
    return np.concatenate([np.array(peer.model.inertias[joint].toDynamicParameters()) for joint in peer.joints])


def inertial_force(peer: Pinocchio, s: State) -> Array:
    """Inverse dynamics without springs, dampers and armature: Y π."""
    return np.asarray(regressor(peer, s)[0] @ inertial_parameters(peer))


def joint_wrenches(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    """data.f of RNEA, with the springs between points as outer forces."""
    to_pin = peer.velocity_map(s.q, s.v)
    poses = link_poses(peer.mechanism, s.q)
    outer = [np.zeros(6) for _ in range(peer.model.njoints)]
    for link, force, place in point_forces(peer.mechanism, s.q, s.v):
        if link >= 0:
            outer[peer.joints[link]] += wrench_on(poses[link], force, place)
    loads = peer.pin.StdVec_Force()
    loads.extend(peer.pin.Force(x[:3], x[3:]) for x in outer)
    motion = peer.expand(s.q), to_pin.S @ s.v, to_pin.S @ s.a + to_pin.S_rate_v
    peer.pin.rnea(peer.model, peer.data, *motion, loads)
    return (np.array([peer.data.f[joint].vector for joint in peer.joints]),)


def single(name: str) -> Callable[[Pinocchio, State, str], tuple[Array, ...]]:
    """A method of the adapter as a row."""
    inputs = {
        "mass_matrix": ("q",), "gravity_force": ("q",), "passive_force": ("q", "v"), "bias_force": ("q", "v"),
        "inverse_dynamics": ("q", "v", "a"), "forward_dynamics": ("q", "v", "tau"),
    }[name]  # fmt: skip
    return lambda peer, s, _frame: (getattr(peer, name)(*(getattr(s, x) for x in inputs)),)


def frame_pose(peer: Pinocchio, s: State, frame: str) -> tuple[Array, ...]:
    pose, H = peer.body_pose(s.q, frame), np.eye(4)
    H[:3, :3], H[:3, 3] = pose.rotation, pose.position
    return (H,)


def kinetic_energy(peer: Pinocchio, s: State, frame: str = "") -> tuple[Array, ...]:
    return (np.array(0.5 * s.v @ peer.mass_matrix(s.q) @ s.v),)


PLAIN = ("mass_matrix", "gravity_force", "passive_force", "bias_force", "inverse_dynamics", "forward_dynamics")
"""Rows that are methods of the adapter."""

NEW = (
    mass_matrix_inverse, inverse_dynamics_derivatives, forward_dynamics_derivatives,
    inverse_dynamics_second_derivatives, center_of_mass, momentum, momentum_matrix, frame_jacobian, frame_velocity,
    frame_bias_acceleration, regressor, joint_wrenches,
)  # fmt: skip

PEER_ROWS: dict[str, Callable[[Pinocchio, State, str], tuple[Array, ...]]] = {
    **{name: single(name) for name in PLAIN},
    "frame_pose": frame_pose,
    "kinetic_energy": kinetic_energy,
    **{row.__name__: row for row in NEW},
}
"""Row of the catalogue → its outputs by Pinocchio."""
