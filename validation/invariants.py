"""First integrals along the reference motion: energy, and the momenta that no joint or weight can change.

All are computed from the scene and the links' motions; generated functions enter by the motion alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symgen.scene.model import JointSpring, Spring
from symgen.validation.mechanism import (
    Array,
    Link,
    Mechanism,
    Motion,
    Pose,
    body_inertia,
    link_motions,
    link_poses,
    vector,
)
from symgen.validation.reference import Motion as States
from symgen.validation.result import Row

CRITERION = 1e-10
"""Drift relative to the size of the terms (the integrator's tolerances are 1e-12)."""


@dataclass(frozen=True)
class Momentum:
    """Of a set of bodies, ground axes; ``angular`` about the ground's origin."""

    mass: float
    centre: Array
    linear: Array
    angular: Array

    def about(self, point: Array) -> Array:
        return np.asarray(self.angular - np.cross(point, self.linear))


def momentum(links: list[Link], poses: list[Pose], motions: list[Motion]) -> Momentum:
    mass, moment, linear, angular = 0.0, np.zeros(3), np.zeros(3), np.zeros(3)
    for link, here, motion in zip(links, poses, motions, strict=True):
        for body, local in link.parts:
            m, place = float(body.mass), here @ local
            centre = place.apply(vector(body.com))
            velocity = motion.at(centre - here.position)
            inertia = place.rotation @ body_inertia(body) @ place.rotation.T
            mass += m
            moment += m * centre
            linear += m * velocity
            angular += np.cross(centre, m * velocity) + inertia @ motion.angular
    return Momentum(mass, moment / mass if mass else moment, linear, angular)


def energy(mechanism: Mechanism, q: Array, v: Array) -> tuple[float, float]:
    """Kinetic and potential energy (springs included) in J."""
    poses = link_poses(mechanism, q)
    motions = link_motions(mechanism, q, v, poses)
    gravity, kinetic, potential = vector(mechanism.scene.gravity), 0.0, 0.0
    for link, here, motion in zip(mechanism.links, poses, motions, strict=True):
        kinetic += 0.5 * float(link.joint.armature) * float(link.rate(v) @ link.rate(v))
        for body, local in link.parts:
            m, place = float(body.mass), here @ local
            centre = place.apply(vector(body.com))
            velocity = motion.at(centre - here.position)
            spin = place.rotation.T @ motion.angular
            kinetic += 0.5 * m * float(velocity @ velocity) + 0.5 * float(spin @ body_inertia(body) @ spin)
            potential -= m * float(gravity @ centre)
    return kinetic, potential + spring_energy(mechanism, q, poses)


def spring_energy(mechanism: Mechanism, q: Array, poses: list[Pose]) -> float:
    stored = 0.0
    joints = {link.joint.name: link for link in mechanism.links}
    for force in mechanism.scene.forces:
        if isinstance(force, Spring):
            ends = [
                mechanism.place(body, poses).apply(vector(point))
                for body, point in zip(force.between, force.points, strict=True)
            ]
            stretch = float(np.linalg.norm(ends[1] - ends[0])) - float(force.length)
            stored += 0.5 * float(force.stiffness) * stretch**2
        else:
            turned = joints[force.joint].position(q) - float(force.rest)
            stored += 0.5 * float(force.stiffness) * float(turned @ turned)
    return stored


def is_conservative(mechanism: Mechanism) -> bool:
    joints = any(joint.damping for joint in mechanism.scene.joints)
    return not joints and not any(force.damping for force in mechanism.scene.forces)


def energy_row(mechanism: Mechanism, motion: States) -> Row:
    """T + V along the motion; with dampers, it may only fall."""
    pairs = np.array([energy(mechanism, q, v) for q, v in zip(motion.q, motion.v, strict=True)])
    total = pairs.sum(axis=1)
    size = max(float(np.ptp(pairs[:, 1])), float(pairs[:, 0].max()), 1e-300)
    span = f"over {motion.t[-1]:g} s"
    if is_conservative(mechanism):
        drift = float(np.abs(total - total[0]).max()) / size
        return Row("first integrals", "energy T + V", drift, CRITERION, f"drift {span}, relative", "conservation")
    rise = max(0.0, float(np.max(np.diff(total), initial=0.0))) / size
    return Row(
        "first integrals", "energy T + V never rises", rise, CRITERION, f"dampers; {span}, relative", "dissipation"
    )


def subtree(mechanism: Mechanism, root: int) -> list[int]:
    found = [root]
    for k, link in enumerate(mechanism.links):
        if link.parent in found:
            found.append(k)
    return found


ONE_AXIS = ("revolute", "continuous", "prismatic", "helical")
"""Their armature adds armature·v to the one momentum they free."""


def is_isolated(mechanism: Mechanism, members: list[int]) -> bool:
    """Nothing but its root joint and its weight acts on the subtree from outside."""
    root = mechanism.links[members[0]].joint
    if root.damping or (root.armature and root.type not in ONE_AXIS):
        return False
    if any(link.coupling is not None for link in mechanism.links):
        return False  # a coupling acts on both of its joints
    for force in mechanism.scene.forces:
        if isinstance(force, JointSpring):
            if force.joint == root.name:
                return False
        elif len({mechanism.frames[body][0] in members for body in force.between}) > 1:
            return False
    return True


@dataclass(frozen=True)
class Integral:
    """A quantity linear in momentum: direction · (P or L), with the rate at which gravity changes it."""

    name: str
    direction: Array
    kind: str
    """``linear``, ``angular`` about ``point``, ``centre`` (angular about the centre of mass) or ``screw``."""
    point: Array
    pitch: float = 0.0

    def value(self, now: Momentum, t: float, gravity: Array) -> float:
        pushed = now.linear - now.mass * gravity * t
        if self.kind == "linear":
            return float(self.direction @ pushed)
        about = now.about(now.centre if self.kind == "centre" else self.point)
        return float(self.direction @ (about + self.pitch * pushed))


def integrals_of(link: Link, gravity: Array) -> Iterator[Integral]:
    """What a root joint on ground leaves alone, in the directions in which it is free (Noether)."""
    R, here = link.origin.rotation, link.origin.position
    u = R @ link.axis
    upright = float(np.linalg.norm(np.cross(u, gravity))) < 1e-14
    kind, zero = link.joint.type, np.zeros(3)
    if kind in ("prismatic", "cylindrical"):
        yield Integral("momentum along the axis, less its weight's impulse", u, "linear", zero)
    if kind in ("revolute", "continuous", "cylindrical", "universal") and upright:
        yield Integral("angular momentum about the upright axis", u, "angular", here)
    if kind == "helical" and upright:
        yield Integral("screw momentum about the upright axis, less its weight's impulse", u, "screw", here, link.pitch)
    if kind == "spherical":
        size = float(np.linalg.norm(gravity))
        directions = [gravity / size] if size else list(np.eye(3))
        for k, direction in enumerate(directions):
            name = "vertical angular momentum" if size else f"angular momentum {'xyz'[k]}"
            yield Integral(name, direction, "angular", here)
    if kind == "planar":
        for k in range(2):
            yield Integral(f"momentum in the plane, {'xy'[k]}, less its weight's impulse", R[:, k], "linear", zero)
        yield Integral("angular momentum about the normal through the centre of mass", R[:, 2], "centre", zero)
    if kind == "floating":
        for k, e in enumerate(np.eye(3)):
            yield Integral(f"momentum {'xyz'[k]}, less its weight's impulse", e, "linear", zero)
        for k, e in enumerate(np.eye(3)):
            yield Integral(f"angular momentum {'xyz'[k]} about the centre of mass", e, "centre", zero)


def momentum_rows(mechanism: Mechanism, motion: States) -> Iterator[Row]:
    gravity = vector(mechanism.scene.gravity)
    roots = [k for k, link in enumerate(mechanism.links) if link.parent < 0]
    for root in roots:
        members = subtree(mechanism, root)
        link = mechanism.links[root]
        integrals = list(integrals_of(link, gravity)) if is_isolated(mechanism, members) else []
        if not integrals:
            continue
        history = []
        for q, v in zip(motion.q, motion.v, strict=True):
            poses = link_poses(mechanism, q)
            motions = link_motions(mechanism, q, v, poses)
            history.append(
                momentum(
                    [mechanism.links[k] for k in members], [poses[k] for k in members], [motions[k] for k in members]
                )
            )
        for integral in integrals:
            values = np.array([integral.value(x, t, gravity) for x, t in zip(history, motion.t, strict=True)])
            if link.joint.armature:
                values = values + float(link.joint.armature) * motion.v[:, link.v.start]
            drift = float(np.abs(values - values[0]).max()) / max(momentum_size(history, integral), 1e-300)
            label = integral.name if len(roots) == 1 else f"{integral.name} ({link.name})"
            yield Row("first integrals", label, drift, CRITERION, f"over {motion.t[-1]:g} s, relative", "conservation")


def momentum_size(history: list[Momentum], integral: Integral) -> float:
    """The size of what cancels in an integral, at its largest."""
    size = 0.0
    for now in history:
        p = float(np.linalg.norm(now.linear))
        if integral.kind == "linear":
            size = max(size, p, 1e-3 * now.mass)
        else:
            arm = (
                float(np.linalg.norm(now.centre))
                if integral.kind == "centre"
                else float(np.linalg.norm(integral.point))
            )
            size = max(size, float(np.linalg.norm(now.angular)), p * (arm + abs(integral.pitch)))
    return size
