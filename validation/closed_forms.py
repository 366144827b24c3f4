"""Textbook solutions, applied to any scene that is one of them by structure (not by name).

Sources: Landau & Lifshitz, Mechanics, §§ 32–37 (pendulum, symmetric top, free asymmetric top); Seherr-Thoss et al.,
Universal Joints and Driveshafts (Cardan's velocity ratio). Each check puts a scene into a state whose future is known,
lets our forward_dynamics carry it, and compares.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from symgen.validation.compare import norm, sample_states
from symgen.validation.differences import derivative
from symgen.validation.functions import Bound
from symgen.validation.invariants import is_conservative
from symgen.validation.mechanism import (
    IDENTITY,
    Array,
    Link,
    Mechanism,
    link_poses,
    lump,
    quaternion_of,
    rotation_about,
    rotation_of,
    vector,
)
from symgen.validation.reference import import_scipy_integrate, integrate_motion
from symgen.validation.result import Row

GROUP = "closed form"
MOTION = 1e-9
"""Criterion of solutions followed in time, relative."""
POINT = 1e-12
"""Criterion of closed-form accelerations, relative."""


def special() -> Any:
    import_scipy_integrate()
    return importlib.import_module("scipy.special")


@dataclass(frozen=True)
class Single:
    """A scene with one moving body: what the formulas need, in the body's axes and about its joint's origin."""

    link: Link
    mass: float
    com: Array
    inertia: Array
    """About the joint's origin."""
    gravity: Array
    """In the joint frame's axes."""


def single(mechanism: Mechanism, *kinds: str) -> Single | None:
    """The scene as one body on a joint of these kinds and nothing else that acts on it."""
    if len(mechanism.links) != 1 or mechanism.links[0].joint.type not in kinds:
        return None
    link = mechanism.links[0]
    if mechanism.scene.forces or not is_conservative(mechanism):
        return None
    if link.joint.armature and link.joint.type not in ("revolute", "continuous", "helical"):
        return None
    mass, com, inertia = lump(link, IDENTITY)
    about = inertia + mass * ((com @ com) * np.eye(3) - np.outer(com, com))
    return Single(link, mass, com, about, link.origin.rotation.T @ vector(mechanism.scene.gravity))


def pendulum_rows(mechanism: Mechanism, functions: Bound, _seed: int) -> Iterator[Row]:
    """Period 4 K(sin A/2)/ω₀ of a swing of amplitude A, and its greatest speed 2 ω₀ sin A/2."""
    body = single(mechanism, "revolute", "continuous")
    if body is None:
        return
    u = body.link.axis
    across = body.com - u * (u @ body.com)
    pull = body.gravity - u * (u @ body.gravity)
    lever = body.mass * norm_2(across) * norm_2(pull)
    if lever == 0.0:
        return
    # The angle at which the centre of mass hangs along gravity's part across the axis.
    hanging = float(np.arctan2(u @ np.cross(across, pull), across @ pull))
    amplitude = 2.0
    rate = float(np.sqrt(lever / (u @ body.inertia @ u + float(body.link.joint.armature))))
    period = float(4.0 * special().ellipk(np.sin(amplitude / 2.0) ** 2) / rate)
    motion = integrate_motion(mechanism, functions, np.array([hanging + amplitude]), np.zeros(1), period, 4)
    quarter, full = motion.marks[0], motion.marks[3]
    fastest = 2.0 * rate * np.sin(amplitude / 2.0)
    errors = (
        abs(motion.q[full, 0] - hanging - amplitude) / amplitude,
        abs(motion.v[full, 0]) / fastest,
        abs(motion.q[quarter, 0] - hanging) / amplitude,
        abs(abs(motion.v[quarter, 0]) - fastest) / fastest,
    )
    note = f"amplitude {amplitude:g} rad, period {period:.12g} s"
    yield Row(GROUP, "pendulum after one period and a quarter", float(max(errors)), MOTION, note, "elliptic integral K")


def screw_rows(mechanism: Mechanism, functions: Bound, seed: int) -> Iterator[Row]:
    """(I + m h²) a = τ + m g·(h u + u × c)."""
    body = single(mechanism, "helical")
    if body is None:
        return
    u, h, worst = body.link.axis, body.link.pitch, 0.0
    q, v, _a, tau = sample_states(mechanism, 50, seed)
    effective = u @ body.inertia @ u + body.mass * h * h + float(body.link.joint.armature)
    for angle, speed, load in zip(q, v, tau, strict=True):
        lever = h * u + np.cross(u, rotation_about(u, angle[0]) @ body.com)
        expected = (load[0] + body.mass * float(body.gravity @ lever)) / effective
        ours = functions("forward_dynamics", angle, speed, load)[0]
        worst = max(worst, abs(ours - expected) / max(abs(expected), 1e-300))
    yield Row(GROUP, "screw: a = (τ + m g·(h u + u×c))/(I + m h²)", worst, POINT, "50 random states", "closed form")


def slope_rows(mechanism: Mechanism, functions: Bound, seed: int) -> Iterator[Row]:
    """A body on a plane: its centre of mass falls with gravity's part in the plane (g sin α), its turning is steady."""
    body = single(mechanism, "planar")
    if body is None:
        return
    worst = 0.0
    q, v, _a, _tau = sample_states(mechanism, 50, seed)
    for place, speed in zip(q, v, strict=True):
        turn = rotation_about(np.array([0.0, 0.0, 1.0]), place[2])
        expected = np.append(body.gravity[:2] + speed[2] ** 2 * (turn @ body.com)[:2], 0.0)
        ours = functions("forward_dynamics", place, speed, np.zeros(3))
        worst = max(worst, norm(ours - expected) / max(norm(expected), 1e-3))
    slope = float(np.degrees(np.arctan2(norm_2(body.gravity[:2]), abs(body.gravity[2]))))
    yield Row(
        GROUP, "body on a slope: a = g sin α", worst, POINT, f"slope {slope:.4g}°, 50 random states", "closed form"
    )


def norm_2(x: Array) -> float:
    return float(np.linalg.norm(x))


def free_body_rows(mechanism: Mechanism, functions: Bound, _seed: int) -> Iterator[Row]:
    """The free asymmetric top: ω(t) in Jacobi's elliptic functions, and the period of the unstable middle axis."""
    body = single(mechanism, "floating")
    if body is None:
        return
    about = body.inertia - body.mass * ((body.com @ body.com) * np.eye(3) - np.outer(body.com, body.com))
    moments, axes = np.linalg.eigh(about)
    if np.min(np.diff(moments)) <= 1e-6 * moments[2] or moments[0] <= 0.0:
        return
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    solution = EulerTop(moments, np.array([0.6, 0.0, 1.0]))
    start, worst = solution.omega(0.0), 0.0
    for t, omega in spin(mechanism, functions, body, axes, start, 1.5 * solution.period):
        worst = max(worst, norm(omega - solution.omega(t)) / norm(start))
    yield Row(GROUP, "free body: ω(t) = (a cn, b sn, c dn)", worst, MOTION, "1.5 periods", "Jacobi elliptic functions")
    yield from flip_rows(mechanism, functions, body, moments, axes)


def flip_rows(mechanism: Mechanism, functions: Bound, body: Single, moments: Array, axes: Array) -> Iterator[Row]:
    """Dzhanibekov: spun about the middle axis, the body flips; after one period ω is back."""
    start = np.array([1e-3, 1.0, 1e-3])
    period = EulerTop(moments, start).period
    *_, (_t, omega) = spin(mechanism, functions, body, axes, start, period)
    note = f"middle axis, ω₀ = (1e-3, 1, 1e-3), period {period:.15g} s"
    yield Row(GROUP, "free body: ω is back after one period of flips", norm(omega - start), MOTION * 100, note, "4 K/λ")


@dataclass(frozen=True)
class EulerTop:
    """Solution of Euler's equations for I₁ < I₂ < I₃ through a state ``start`` (Landau & Lifshitz § 37)."""

    moments: Array
    start: Array

    @property
    def excess(self) -> float:
        """L² − 2 E I₂, summed without cancellation: its sign says about which axis ω circles."""
        (i1, i2, i3), (x, _y, z) = self.moments, self.start
        return float(i1 * (i1 - i2) * x * x + i3 * (i3 - i2) * z * z)

    @property
    def parts(self) -> tuple[Array, float, float, float]:
        """Amplitudes (of ω₁, ω₂, ω₃ in the order cn, sn, dn or dn, sn, cn), λ, k², 1 − k²."""
        moments, w = [float(x) for x in self.moments], self.start
        flip = self.excess < 0.0
        order = (2, 1, 0) if flip else (0, 1, 2)
        i1, i2, i3 = (moments[k] for k in order)
        # 2 E I₃ − L² and L² − 2 E I₁, term by term (both change sign when the roles of 1 and 3 are exchanged)
        upper = sum(moments[k] * (i3 - moments[k]) * float(w[k]) ** 2 for k in range(3))
        lower = sum(moments[k] * (moments[k] - i1) * float(w[k]) ** 2 for k in range(3))
        amplitude = np.sqrt([upper / (i1 * (i3 - i1)), upper / (i2 * (i3 - i2)), lower / (i3 * (i3 - i1))])
        rate = float(np.sqrt((i3 - i2) * lower / (i1 * i2 * i3)))
        complement = (i3 - i1) * self.excess / ((i3 - i2) * lower)
        return amplitude, rate, 1.0 - complement, complement

    @property
    def period(self) -> float:
        _amplitude, rate, _m, complement = self.parts
        return float(4.0 * special().ellipkm1(complement) / rate)

    def omega(self, t: float) -> Array:
        """ω in principal axes, from the moment at which ω₂ = 0 rises."""
        amplitude, rate, m, _complement = self.parts
        sn, cn, dn, _phase = special().ellipj(rate * t, m)
        w = amplitude * np.array([cn, sn, dn])
        return np.asarray(w[::-1] if self.excess < 0.0 else w)


def spin(
    mechanism: Mechanism, functions: Bound, body: Single, axes: Array, start: Array, end: float
) -> Iterator[tuple[float, Array]]:
    """(t, ω in principal axes) of a floating body that starts with ω = ``start`` there and its centre at rest."""
    kind = mechanism.scene.options.base_velocity
    outer = body.link.origin.rotation
    q, omega = np.zeros(7), axes @ start
    q[3:] = quaternion_of(rotation_about(np.array([0.6, 0.0, 0.8]), 0.7))
    child = outer @ rotation_of(q[3:])
    v = np.concatenate([-np.cross(omega, body.com), omega])
    v = v if kind == "body" else np.concatenate([child @ v[:3], child @ omega if kind == "world" else omega])
    motion = integrate_motion(mechanism, functions, q, v, end, 4)
    for t, place, speed in zip(motion.t, motion.q, motion.v, strict=True):
        now = outer @ rotation_of(place[3:])
        yield float(t), axes.T @ (now.T @ speed[3:] if kind == "world" else speed[3:])


def top_rows(mechanism: Mechanism, functions: Bound, _seed: int) -> Iterator[Row]:
    """Lagrange's top: steady precession Ω, (I₃ n − I₁ Ω cos θ) Ω = m g l, and its spin n about the axis is constant."""
    body = single(mechanism, "spherical")
    if body is None or norm_2(body.com) == 0.0 or norm_2(body.gravity) == 0.0:
        return
    length = norm_2(body.com)
    axis, up = body.com / length, -body.gravity / norm_2(body.gravity)
    i3 = float(axis @ body.inertia @ axis)
    i1 = 0.5 * (float(np.trace(body.inertia)) - i3)
    symmetric = i1 * np.eye(3) + (i3 - i1) * np.outer(axis, axis)
    if norm(body.inertia - symmetric) > 1e-12 * i1 or i3 <= 0.0:
        return
    weight, tilt = body.mass * norm_2(body.gravity) * length, 0.5
    precession = float(np.sqrt(weight / i1))
    if i3 < 0.1 * i1:  # a pendulum rather than a top: let it circle as a cone, without spin
        tilt = np.pi - 0.5
        precession = float(np.sqrt(-weight / (i1 * np.cos(tilt))))
    n = float(weight / precession + i1 * precession * np.cos(tilt)) / i3
    # Turn the body so that its axis leans by the tilt from the upward vertical.
    turn = align(axis, lean(up, tilt))
    direction = turn @ axis
    omega = precession * up + (n - precession * np.cos(tilt)) * direction
    end = 2.0 * np.pi / precession
    start = quaternion_of(turn), turn.T @ omega
    motion = integrate_motion(mechanism, functions, *start, end, 4)
    worst, spun = 0.0, 0.0
    for t, q, v in zip(motion.t, motion.q, motion.v, strict=True):
        worst = max(worst, norm(rotation_of(q) @ axis - rotation_about(up, precession * t) @ direction))
        spun = max(spun, abs(float(v @ axis) - n) / max(abs(n), precession))
    name = "top" if tilt < 1.0 else "conical pendulum"
    note = f"Ω = {precession:.6g} rad/s, spin {n:.6g} rad/s, tilt {tilt:g} rad, one turn"
    yield Row(GROUP, f"{name}: the axis in steady precession", worst, MOTION, note, "Lagrange's top")
    yield Row(GROUP, f"{name}: momentum about its own axis", spun, MOTION, "same motion, relative", "Lagrange's top")


def lean(up: Array, tilt: float) -> Array:
    side = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    return np.asarray(np.cos(tilt) * up + np.sin(tilt) * side / norm_2(side))


def align(start: Array, end: Array) -> Array:
    """A rotation that takes one unit vector into another."""
    cross = np.cross(start, end)
    if norm_2(cross) < 1e-12:
        helper = np.cross(start, np.eye(3)[int(np.argmin(np.abs(start)))])
        return np.eye(3) if start @ end > 0 else rotation_about(helper / norm_2(helper), np.pi)
    return rotation_about(cross / norm_2(cross), float(np.arctan2(norm_2(cross), start @ end)))


def angular_jacobian(functions: Bound, frame: str, local: Array, q: Array) -> Array:
    """ω = J v of the body that carries a frame, from frame_pose differentiated along integrate."""
    columns = []
    for e in np.eye(len(q)):

        def turned(t: float, e: Array = e) -> Array:
            return functions(f"frame_pose_{frame}", functions("integrate", q, e, t))[:3, :3] @ local.T

        w = derivative(turned) @ turned(0.0).T
        columns.append([w[2, 1], w[0, 2], w[1, 0]])
    return np.array(columns).T


def cardan_rows(mechanism: Mechanism, functions: Bound, seed: int) -> Iterator[Row]:
    """ω₂/ω₁ = cos β/(1 − sin²β cos²γ) of two shafts whose directions stand still, from frame_pose and integrate."""
    if len(mechanism.links) != 2 or not functions.has("integrate"):
        return
    drive, cross = mechanism.links
    turning = drive.joint.type in ("revolute", "continuous") and cross.joint.type == "universal" and cross.parent == 0
    frame = next((n for n, (k, _) in mechanism.frames.items() if k == 1 and functions.has(f"frame_pose_{n}")), None)
    if not turning or frame is None:
        return
    outer = cross.origin.rotation
    shaft = outer.T @ drive.axis  # the driven shaft's direction, in the second body at zero position
    if max(abs(shaft @ cross.axis), abs(shaft @ cross.axis2), abs(cross.axis @ cross.axis2)) > 1e-14:
        return
    local, worst = mechanism.frames[frame][1].rotation, 0.0
    for q in sample_states(mechanism, 10, seed)[0]:
        poses = link_poses(mechanism, q)
        first, second = poses[0].rotation @ drive.axis, poses[1].rotation @ shaft
        arm = poses[0].rotation @ outer @ cross.axis
        if abs(first @ second) < 0.2:
            continue  # nearly at right angles a Cardan joint locks
        J = angular_jacobian(functions, frame, local, q)
        # The cross moves so that the second shaft turns about its own direction only.
        keep = np.eye(3) - np.outer(second, second)
        relative = np.linalg.lstsq(keep @ J[:, 1:], -keep @ J[:, 0], rcond=None)[0]
        ratio = float(second @ (J @ np.array([1.0, *relative])))
        expected = float(first @ second / (1.0 - (arm @ second) ** 2))
        worst = max(worst, abs(ratio - expected) / abs(expected))
    note = "10 random bends; frame_pose differentiated along integrate"
    yield Row(GROUP, "Cardan joint: ω₂/ω₁ = cos β/(1 − sin²β cos²γ)", worst, MOTION, note, "universal joint")


FORMS = (pendulum_rows, screw_rows, slope_rows, free_body_rows, top_rows, cardan_rows)


def closed_form_rows(mechanism: Mechanism, functions: Bound, seed: int) -> list[Row]:
    """Every closed form that the scene's structure admits; none is fine."""
    return [row for form in FORMS for row in form(mechanism, functions, seed)]
