"""Hard cases that take time: flips, tops at the limit of stability, long spins, and where pendulums part."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction as F
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from symgen.scene.builder import SceneBuilder
from symgen.scene.model import Scene
from symgen.validation.hard.case import Array, Bench, Case, Finding
from symgen.validation.hard.scenes import free_body
from symgen.validation.mechanism import build_mechanism, position_rate

DZHANIBEKOV_PERIOD = 55.061681107466372
"""Of the motion of the body I = (1, 2, 3) from ω = (1e-3, 1, 1e-3), by elliptic functions."""


def motion(scene: Scene, f: Any, q: Array, v: Array, times: Array, tolerance: float = 1e-13) -> Array:
    """States (q, v) at times, by DOP853 on the compiled accelerations."""
    mechanism = build_mechanism(scene)
    zero = np.zeros(mechanism.nv)
    atol = 1e-15 if tolerance < 1e-8 else tolerance  # what the noise of a float allows

    def rate(_: float, y: Array) -> Array:
        q, v = y[: mechanism.nq], y[mechanism.nq :]
        return np.concatenate([position_rate(mechanism, q, v), f.forward_dynamics(q, v, zero)])

    found = solve_ivp(rate, (times[0], times[-1]), np.concatenate([q, v]), "DOP853", times, rtol=tolerance, atol=atol)
    return np.asarray(found.y.T)


BARS = {"double": (1e-13, 1e-9), "float": (1e-6, 1e-2)}
"""Precision → tolerance of the integration, and largest difference allowed of what it amplifies."""


def flips(bench: Bench) -> Iterator[Finding]:
    scene = free_body()
    start = np.array([0.0, 0, 0, 0, 0, 0, 1]), np.array([0.0, 0, 0, 1e-3, 1, 1e-3])
    for precision, (tolerance, bar) in BARS.items():
        f = bench.loaded(scene, "forward_dynamics", precision=precision)
        times = np.array([0.0, DZHANIBEKOV_PERIOD / 2, DZHANIBEKOV_PERIOD])
        _, half, after = motion(scene, f, *start, times, tolerance)[:, 7 + 3 :]
        error = float(np.max(np.abs(after - start[1][3:])))
        yield bench.finding("ω after one period", precision, error, bar, "largest difference to the start", "rad/s")
        apart = float(abs(half[1] + 1))
        yield bench.finding(
            "ω₂ after half a period, turned over", precision, apart, bar, "difference to −1 rad/s", "rad/s"
        )


def sleeping_top(bench: Bench) -> Iterator[Finding]:
    """A top with its tip on the ground sleeps when (C ω)² > 4 A m g l."""
    A, C, weight = 0.5, 0.1, 9.81
    made = SceneBuilder("top").body("top", 1, (0, 0, F(1, 2)), (F(1, 4), F(1, 4), F(1, 10), 0, 0, 0))
    scene = made.joint("tip", "spherical", "ground", "top").build()
    limit = float(np.sqrt(4 * A * weight * 0.5) / C)
    tilt = 1e-6
    q = np.array([np.sin(tilt / 2), 0, 0, np.cos(tilt / 2)])
    cases = [
        (1.02, "stays up", "double"),
        (0.98, "falls", "double"),
        (1.02, "stays up", "float"),
        (0.98, "falls", "float"),
    ]
    for factor, right, precision in cases:
        f = bench.loaded(scene, "forward_dynamics", precision=precision)
        found = motion(
            scene,
            f,
            q,
            np.array([0, 0, factor * limit]),
            np.linspace(0, 20, 401),
            1e-11 if precision == "double" else 1e-7,
        )
        lean = float(np.max(2 * np.hypot(found[:, 0], found[:, 1])))
        good = lean < 1e-4 if right == "stays up" else lean > 1e-2
        yield bench.finding(
            f"{factor} of the limit of {limit:.2f} rad/s: {right}", precision, float(not good), 0.0,
            f"tilt of {tilt:.0e} rad grows to {lean:.0e}",
        )  # fmt: skip


def long_spin(bench: Bench) -> Iterator[Finding]:
    scene = free_body((1, 1, 1))
    v, dt, steps = np.array([0.0, 0, 0, 300.0, 400.0, 0.0]), 2.0**-10, 100000
    angle = 500.0 * dt * steps
    right = np.array([0.6 * np.sin(angle / 2), 0.8 * np.sin(angle / 2), 0, np.cos(angle / 2)])
    for precision, length, apart in (("double", 1e-11, 1e-9), ("float", 1e-6, 1e-2)):
        f = bench.loaded(scene, "integrate", precision=precision)
        q = np.array([0.0, 0, 0, 0, 0, 0, 1])
        for _ in range(steps):
            q = f.integrate(q, v, dt)
        end = np.asarray(q, dtype=float)[3:]
        off = float(abs(np.linalg.norm(end) - 1))
        turned = float(min(np.max(np.abs(end - right)), np.max(np.abs(end + right))))
        note = f"after {steps:,} steps, {angle:,.0f} rad"
        yield bench.finding("length of the quaternion", precision, off, length, note, "difference to 1")
        yield bench.finding("rotation", precision, turned, apart, note, "largest difference")


def energy_of_spin(bench: Bench) -> Iterator[Finding]:
    scene = free_body()
    start = np.array([0.0, 0, 0, 0, 0, 0, 1]), np.array([0.1, 0, 0, 100.0, 80.0, 60.0])
    exact = bench.loaded(scene, "kinetic_energy", "momentum")
    quantities: tuple[tuple[str, Callable[[Array, Array], Any]], ...] = (
        ("energy", exact.kinetic_energy), ("momentum", exact.momentum),
    )  # fmt: skip
    for precision, tolerance, bar in (("double", 1e-13, 1e-10), ("float", 1e-7, 1e-3)):
        f = bench.loaded(scene, "forward_dynamics", precision=precision)
        found = motion(scene, f, *start, np.linspace(0, 3, 4), tolerance)
        for what, quantity in quantities:
            rows = np.array([np.ravel(quantity(y[:7], y[7:])) for y in found])
            drift = float(np.max(np.abs(rows - rows[0])) / np.max(np.abs(rows[0])))
            yield bench.finding(f"{what} over 3 s at 140 rad/s", precision, drift, bar, "", "relative drift")


CASES = (
    Case(
        "Dzhanibekov's flip",
        "Rotation about the middle axis is unstable: what the code gets wrong grows a thousandfold until the "
        "body turns over.",
        f"the period {DZHANIBEKOV_PERIOD} s of elliptic functions",
        flips,
    ),
    Case(
        "sleeping top",
        "Two per cent of speed decide whether it stands; energy that is lost or won by errors would too.",
        "upright above the limit (C ω)² = 4 A m g l, falling below it",
        sleeping_top,
    ),
    Case(
        "long spin",
        "What a step loses adds up: a hundred thousand steps at 500 rad/s.",
        "a quaternion of unit length and the angle ω t; energy and momentum that stay",
        long_spin,
    ),
    Case(
        "first integrals at speed",
        "At 140 rad/s small relative errors of the accelerations are large energies.",
        "energy and momentum that stay",
        energy_of_spin,
    ),
)
