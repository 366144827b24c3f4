"""Benchmark problems with published or closed-form answers: scenes, runs, and what comes out beside what should.

Simple pendulum and stiff flyball governor: the multibody benchmark library of IFToMM (problems A01, A05), as restated
by RehabEngGroup/MBSbenchmarksInOpenSim. Axisymmetric free body: Kane & Levinson, Dynamics, § 3. Heavy top: the test
of Exudyn's own suite.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from symgen.scene.builder import SceneBuilder
from symgen.scene.model import Scene
from symgen.simulate import exact
from symgen.simulate.answers import FINE, GRAVITY, Answer, answer, largest
from symgen.simulate.model import Array, Model
from symgen.simulate.run import simulate

# --- pendulum --------------------------------------------------------------------------------------------------------


def pendulum_scene() -> Scene:
    """A point mass of 1 kg on a massless bar of 1 m; q is the angle from the vertical below."""
    scene = SceneBuilder("simple_pendulum").body("mass", mass=1, com=(0, 0, -1))
    return scene.joint("hinge", "revolute", "ground", "mass", axis=(0, 1, 0)).build()


def pendulum() -> Iterator[Answer]:
    """A01: released at rest when horizontal; 10 s of the library, and 2,000 s."""
    model = Model(pendulum_scene(), ("rk4", "implicit_midpoint", "variational"))
    name, start, against = "A01 simple pendulum", np.pi / 2, "elliptic functions"
    published = "OpenSim 3.2 takes 0.637 s (i5-4570)"
    for end, bar in ((10.0, 1e-11), (2000.0, 5e-8)):
        angle, rate = exact.pendulum(end, GRAVITY, 1.0, start)
        motion = simulate(model, [start], [0.0], end, **FINE)
        error = largest(motion.q[-1, 0] - angle, motion.v[-1, 0] - rate)
        beside = published if end == 10.0 else ""
        yield answer(motion, name, f"θ, θ̇ at {end:g} s", error, bar, against, beside)
        motion = simulate(model, [start], [0.0], end, method="rk4", dt=5e-4, samples=1001)
        error = largest(motion.q[-1, 0] - angle, motion.v[-1, 0] - rate)
        yield answer(motion, name, f"θ, θ̇ at {end:g} s, dt 0.5 ms", error, 1e-11 * end, against, beside)
    for method in ("implicit_midpoint", "variational"):
        motion = simulate(model, [start], [0.0], 2000.0, method=method, dt=1e-2, samples=20001)
        yield answer(motion, name, "energy over 2000 s, dt 10 ms", motion.monitors.energy_drift, 2e-4, "bounded")


ROD = -3.13401855180855
"""Angle after 1 s, as Exudyn's suite stores it."""


def rod_pendulum() -> Iterator[Answer]:
    """Exudyn's test of its kinematic tree: a brick on a hinge, released when horizontal."""
    across = Fraction(10, 12) * (1 + Fraction(1, 100))
    moments = (Fraction(1, 60), across, across, 0, 0, 0)
    scene = SceneBuilder("rod_pendulum").body("rod", mass=10, com=(Fraction(1, 2), 0, 0), inertia=moments)
    model = Model(scene.joint("hinge", "revolute", "ground", "rod", axis=(0, -1, 0)).build(), ("rk4",))
    for settings, bar in (({"method": "DOP853", **FINE}, 1e-12), ({"method": "rk4", "dt": 5e-4}, 1e-11)):
        motion = simulate(model, [0.0], [0.0], 1.0, **settings)
        error = abs(motion.q[-1, 0] - ROD)
        yield answer(motion, "rod pendulum", "angle at 1 s", error, bar, "Exudyn's stored result")


# --- tops and free bodies --------------------------------------------------------------------------------------------


def free_body_scene(moments: tuple[float, float, float]) -> Scene:
    scene = SceneBuilder("free_body", gravity=(0, 0, 0)).body("body", mass=1, inertia=(*moments, 0, 0, 0))
    return scene.joint("free", "floating", "ground", "body").options(base_velocity="body").build()


DZHANIBEKOV = 55.061681107466372
"""Period of ω, s, for I = (1, 2, 3) and ω₀ = (1e-3, 1, 1e-3)."""


def free_body() -> Iterator[Answer]:
    """Euler's top: ω(t) in elliptic functions, and the flips of a body spun about its middle axis."""
    moments = (1.0, 2.0, 3.0)
    model = Model(free_body_scene(moments), ("lie", "variational"))
    rest = [0.0, 0.0, 0.0]
    identity = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    start = (0.6, 0.1, 1.0)
    motion = simulate(model, identity, [*rest, *start], 20.0, **FINE)
    errors = [x - y for t, v in zip(motion.t, motion.v, strict=True) for x, y in _both(v, t, moments, start)]
    yield answer(motion, "free rigid body", "ω over 20 s", largest(*errors), 1e-11, "Jacobi's elliptic functions")
    flip = (1e-3, 1.0, 1e-3)
    period = exact.free_body_period(moments, flip)
    for settings in ({"method": "DOP853", **FINE}, {"method": "lie", "dt": period / 100_000, "samples": 2}):
        motion = simulate(model, identity, [*rest, *flip], period, **settings)
        error = largest(*(motion.v[-1, 3:] - np.array(flip)), (period - DZHANIBEKOV) / DZHANIBEKOV)
        yield answer(motion, "Dzhanibekov's flips", "ω after one period", error, 1e-8, "4 K/λ")
    motion = simulate(model, identity, [*rest, *flip], 10_000.0, method="variational", dt=1e-2, samples=10_001)
    drift = motion.monitors.energy_drift
    yield answer(motion, "Dzhanibekov's flips", "energy over 10⁶ steps of 10 ms", drift, 2e-5, "bounded")


def _both(
    v: Array, t: float, moments: tuple[float, float, float], start: tuple[float, float, float]
) -> Iterator[tuple[float, float]]:
    yield from zip((float(x) for x in v[3:]), exact.free_body(float(t), moments, start), strict=True)


def symmetric_body() -> Iterator[Answer]:
    """An axisymmetric free body: the whole rotation in closed form."""
    across, along, omega = 2.0, 0.5, np.array([0.4, -0.3, 3.0])
    model = Model(free_body_scene((across, across, along)), ("lie",))
    start = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, *omega]
    for settings, bar in (({"method": "DOP853", **FINE}, 1e-10), ({"method": "lie", "dt": 1e-3, "samples": 101}, 1e-9)):
        motion = simulate(model, *start, 100.0, **settings)
        worst = 0.0
        for t, q in zip(motion.t, motion.q, strict=True):
            worst = max(worst, float(np.abs(turned(q[3:]) - exact.symmetric_body(t, across, along, omega)).max()))
        yield answer(motion, "axisymmetric free body", "rotation over 100 s", worst, bar, "precession and spin (Kane)")


def turned(quaternion: Array) -> Array:
    """Rotation matrix of [x y z w], of norm one."""
    x, y, z, w = quaternion
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew)


def top_scene(mass: float, height: float, across: float, along: float) -> Scene:
    """A symmetric top on its tip; moments about the tip."""
    inner = across - mass * height * height
    scene = SceneBuilder("top").body("top", mass=mass, com=(0, 0, height), inertia=(inner, inner, along, 0, 0, 0))
    return scene.joint("tip", "spherical", "ground", "top").build()


def precession() -> Iterator[Answer]:
    """A symmetric top in steady precession Ω: (L₃ − I₁ Ω cos θ) Ω = m g l."""
    mass, height, across, along, tilt, rate = 0.5, 0.1, 0.0056, 0.001, 0.5, 4.0
    moment = mass * GRAVITY * height / rate + across * rate * np.cos(tilt)
    leaning = exact.rotation(np.array([0.0, 1.0, 0.0]), tilt)
    omega = leaning.T @ np.array([0.0, 0.0, rate])
    omega[2] = moment / along
    end = 10.0 * 2.0 * np.pi / rate
    model = Model(top_scene(mass, height, across, along), ("lie",))
    start = [0.0, np.sin(tilt / 2), 0.0, np.cos(tilt / 2)], list(omega)
    for settings, bar in (({"method": "DOP853", **FINE}, 1e-10), ({"method": "lie", "dt": 2e-5, "samples": 201}, 1e-8)):
        motion = simulate(model, *start, end, **settings)
        worst = 0.0
        for t, q in zip(motion.t, motion.q, strict=True):
            axis = exact.rotation(np.array([0.0, 0.0, 1.0]), rate * t) @ leaning[:, 2]
            worst = max(worst, float(np.abs(turned(q)[:, 2] - axis).max()))
        yield answer(motion, "symmetric top", "axis over 10 turns of precession", worst, bar, "steady precession")


def sleeping_top() -> Iterator[Answer]:
    """A sleeping top is stable where L₃² > 4 I₁ m g l: above and below it, the axis follows the linear motion."""
    mass, height, across, along, small = 0.5, 0.1, 0.0056, 0.001, 1e-6
    weight = mass * GRAVITY * height
    limit = np.sqrt(4.0 * across * weight)
    model = Model(top_scene(mass, height, across, along))
    for part in (1.02, 0.98):
        moment = part * limit
        start = [0.0, np.sin(small / 2), 0.0, np.cos(small / 2)], [0.0, 0.0, moment / along]
        motion = simulate(model, *start, 2.0, rtol=1e-13, atol=1e-18)
        worst, widest = 0.0, 0.0
        for t, q in zip(motion.t, motion.q, strict=True):
            z = exact.sleeping_top(float(t), across, moment, weight, small)
            axis = turned(q)[:, 2]
            worst, widest = max(worst, abs(complex(axis[0], axis[1]) - z)), max(widest, abs(z))
        side = "above" if part > 1 else "below"
        what, note = (
            f"axis, spin {abs(part - 1):.0%} {side} the limit",
            f"{side} the limit the tilt grows {widest / small:.3g} times",
        )
        yield answer(motion, "sleeping top", f"{what}, relative", worst / widest, 1e-7, "L₃² = 4 I₁ m g l", note)


def heavy_top() -> Iterator[Answer]:
    """Exudyn's test: m = 15 kg, centre of mass 1 m along y, J = diag(0.234375, 0.46875, 0.234375) about it."""
    scene = SceneBuilder("heavy_top").body(
        "top", mass=15, com=(0, 1, 0), inertia=("0.234375", "0.46875", "0.234375", 0, 0, 0)
    )
    model = Model(scene.joint("tip", "spherical", "ground", "top").build(), ("lie",))
    published = np.array([0.43878109, 0.5457284, 0.08939975, -0.70827915])
    omega = [0.0, 150.0, -4.61538]
    for settings in ({"method": "DOP853", **FINE}, {"method": "lie", "dt": 1e-5}):
        motion = simulate(model, None, omega, 0.2, **settings)
        q = motion.q[-1]
        error = min(largest(*(q - published)), largest(*(q + published)))
        yield answer(motion, "heavy top", "Euler parameters at 0.2 s", error, 1e-7, "Exudyn's stored result")


PROBLEMS = (pendulum, rod_pendulum, free_body, symmetric_body, precession, sleeping_top, heavy_top)
