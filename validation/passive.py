"""Springs and dampers by the validators' own kinematics; their derivatives by the complex step, exact to rounding."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from symgen.scene.model import JointSpring, Spring
from symgen.validation.mechanism import (
    IDENTITY,
    Array,
    Mechanism,
    Motion,
    Pose,
    link_motions,
    link_poses,
    position_rate,
    vector,
)

STILL = Motion(np.zeros(3), np.zeros(3))
STEP = 1e-40


def point_forces(mechanism: Mechanism, q: Any, v: Any) -> list[tuple[int, Any, Any]]:
    """What every spring between points does: (link, force on it, point it acts at), ground axes; link −1 is ground."""
    springs = [force for force in mechanism.scene.forces if isinstance(force, Spring)]
    if not springs:
        return []
    poses = link_poses(mechanism, q)
    motions = link_motions(mechanism, q, v, poses)
    found: list[tuple[int, Any, Any]] = []
    for spring in springs:
        ends = []
        for body, point in zip(spring.between, spring.points, strict=True):
            index, local = mechanism.frames[body]
            here, motion = (IDENTITY, STILL) if index < 0 else (poses[index], motions[index])
            place = (here @ local).apply(vector(point))
            ends.append((index, place, motion.at(place - here.position)))
        (one, r1, v1), (two, r2, v2) = ends
        distance = np.sqrt((r2 - r1) @ (r2 - r1))
        direction = (r2 - r1) / distance
        tension = float(spring.stiffness) * (distance - float(spring.length))
        tension = tension + float(spring.damping) * (direction @ (v2 - v1))
        found += [(one, tension * direction, r1), (two, -tension * direction, r2)]
    return found


def passive_force(mechanism: Mechanism, q: Any, v: Any) -> Any:
    """passive_force (nv), left-hand side; ``q`` and ``v`` may be complex."""
    found = np.zeros(mechanism.nv, dtype=complex)
    links = {link.joint.name: link for link in mechanism.links}
    for link in mechanism.links:
        found[link.v] += link.factor * float(link.joint.damping) * link.rate(v)
    for force in mechanism.scene.forces:
        if isinstance(force, JointSpring):
            link = links[force.joint]
            load = float(force.stiffness) * (link.position(q) - float(force.rest))
            found[link.v] += link.factor * (load + float(force.damping) * link.rate(v))
    forces = [(link, force, place) for link, force, place in point_forces(mechanism, q, v) if link >= 0]
    if forces:
        poses = link_poses(mechanism, q)
        for k, unit in enumerate(np.eye(mechanism.nv)):
            motions = link_motions(mechanism, q, unit, poses)
            for index, force, place in forces:
                found[k] -= force @ motions[index].at(place - poses[index].position)
    return found


def passive_derivatives(mechanism: Mechanism, q: Array, v: Array) -> tuple[Array, Array]:
    """∂/∂q in the tangent space and ∂/∂v of `passive_force`, each (nv, nv)."""

    if not mechanism.scene.forces:
        damping = np.zeros(mechanism.nv)
        for link in mechanism.links:
            damping[link.v] += link.factor**2 * float(link.joint.damping)
        return np.zeros((mechanism.nv, mechanism.nv)), np.diag(damping)

    def columns(along: Callable[[Array], Any]) -> Array:
        return np.array([along(unit).imag / STEP for unit in np.eye(mechanism.nv)]).T

    by_q = columns(lambda unit: passive_force(mechanism, q + 1j * STEP * position_rate(mechanism, q, unit), v))
    return by_q, columns(lambda unit: passive_force(mechanism, q, v + 1j * STEP * unit))


def wrench_on(pose: Pose, force: Array, place: Array) -> Array:
    """A force at a point as (force, moment about the pose's origin), the pose's axes."""
    moment = np.cross(place - pose.position, force)
    return np.concatenate([pose.rotation.T @ force, pose.rotation.T @ moment])
