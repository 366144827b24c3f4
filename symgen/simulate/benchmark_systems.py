"""Benchmark problems of several bodies: oscillators, chains, two programs that drift apart, the flyball governor."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np

from symgen.generate import generate
from symgen.scene.builder import SceneBuilder
from symgen.scene.model import Output, Scene
from symgen.scene.request import request
from symgen.simulate import exact
from symgen.simulate.answers import FINE, GRAVITY, Answer, answer, largest
from symgen.simulate.model import Array, Model
from symgen.simulate.run import integrators, simulate


def oscillators() -> Iterator[Answer]:
    """A damped mass on a spring, and two masses between three springs, whose modes are known."""
    scene = SceneBuilder("oscillator", gravity=(0, 0, 0)).body("mass", mass=2)
    scene.joint("slide", "prismatic", "ground", "mass", axis=(1, 0, 0), damping="0.4")
    model = Model(scene.joint_spring("slide", stiffness=50).build(), ("implicit_midpoint",))
    motion = simulate(model, [0.3], None, 20.0, **FINE)
    error = largest(
        *(x - exact.oscillator(float(t), 5.0, 0.1, 0.3) for t, x in zip(motion.t, motion.q[:, 0], strict=True))
    )
    yield answer(motion, "damped oscillator", "x over 20 s", error, 1e-12, "exp(-d t) cos", kept=False)
    scene = SceneBuilder("two_masses", gravity=(0, 0, 0)).body("a", mass=1).body("b", mass=1)
    scene.joint("first", "prismatic", "ground", "a", axis=(1, 0, 0))
    scene.joint("second", "prismatic", "ground", "b", axis=(1, 0, 0))
    scene.joint_spring("first", stiffness=9).joint_spring("second", stiffness=9)
    scene.spring(("a", "b"), ((0, 0, 0), (0, 0, 0)), stiffness=8)
    model = Model(scene.build())
    motion = simulate(model, [0.5, 0.1], None, 50.0, **FINE)
    together, apart = 0.3 * np.cos(3.0 * motion.t), 0.2 * np.cos(5.0 * motion.t)
    error = largest(*(motion.q[:, 0] - together - apart), *(motion.q[:, 1] - together + apart))
    yield answer(motion, "two masses, three springs", "x over 50 s", error, 1e-11, "modes 3 and 5 rad/s")


def chain_scene(n: int) -> Scene:
    """n equal rods of 1 m in a vertical plane."""
    scene = SceneBuilder(f"zigzag_{n}")
    before = "ground"
    for k in range(n):
        name = f"rod{k}"
        scene.body(name, mass=1, com=(0, 0, -0.5), inertia=(Fraction(1, 12), Fraction(1, 12), 0, 0, 0, 0))
        scene.joint(f"j{k}", "revolute", before, name, axis=(0, 1, 0), xyz=(0, 0, -1 if k else 0))
        before = name
    return scene.build()


def zigzag() -> Iterator[Answer]:
    """A chain of ten rods that hangs in a zigzag and falls: its energy stays, and coarser steps come to the same."""
    n = 10
    model = Model(chain_scene(n), ("rk4", "variational"))
    q0 = [0.6 if k == 0 else 1.2 * (-1) ** k for k in range(n)]
    fine = simulate(model, q0, None, 2.0, **FINE)
    yield answer(fine, f"zigzag chain of {n}", "energy over 2 s", fine.monitors.energy_drift, 1e-11, "energy is kept")
    motion = simulate(model, q0, None, 2.0, method="rk4", dt=1e-4)
    error = largest(*(motion.q[-1] - fine.q[-1]))
    yield answer(motion, f"zigzag chain of {n}", "q at 2 s, dt 0.1 ms", error, 1e-5, "DOP853, rtol 1e-13")
    motion = simulate(model, q0, None, 20.0, method="variational", dt=5e-4, samples=20_001)
    drift = motion.monitors.energy_drift
    yield answer(motion, f"zigzag chain of {n}", "energy over 20 s, dt 0.5 ms", drift, 2e-4, "bounded")


def double_scene() -> Scene:
    """Two uniform rods."""
    return chain_scene(2)


def divergence() -> Iterator[Answer]:
    """How long two correct programs agree on a chaotic motion: ours and Pinocchio's articulated bodies, the same
    Runge–Kutta steps, until the angles differ by 1e-3. Rounding of 1e-16 grows as exp(λ t); nobody can do better."""
    try:
        from symgen.validation.pinocchio_model import build_pinocchio

        theirs = build_pinocchio(double_scene())
    except ImportError:
        return
    model, dt, end = Model(double_scene(), ("rk4",)), 1e-3, 60.0
    start = np.array([2.5, 1.0])
    ours = simulate(model, list(start), None, end, method="rk4", dt=dt)
    zero = np.zeros(2)
    began = time.process_time()
    y, horizon = np.concatenate([start, zero]), end

    def rate(state: Array) -> Array:
        return np.concatenate([state[2:], theirs.forward_dynamics(state[:2], state[2:], zero)])

    for k in range(1, round(end / dt) + 1):
        a = rate(y)
        b = rate(y + 0.5 * dt * a)
        c = rate(y + 0.5 * dt * b)
        d = rate(y + dt * c)
        y = y + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        if float(np.abs(y[:2] - ours.q[k]).max()) > 1e-3:
            horizon = k * dt
            break
    spent = time.process_time() - began
    half = int(0.25 * horizon / dt)
    note = f"they agree to 1e-3 for {horizon:.1f} s; Pinocchio from Python takes {spent:.2f} s for that"
    again = simulate(model, list(start), None, end, method="rk4", dt=dt / 2)
    apart = np.abs(again.q[::2][:half] - ours.q[:half]).max()
    yield answer(ours, "double pendulum", "10 s over the horizon of agreement", 10.0 / horizon, 1.0, "Pinocchio", note)
    note = f"step halved, first quarter of the horizon ({0.25 * horizon:.1f} s)"
    yield answer(ours, "double pendulum", "q between dt 1 ms and 0.5 ms", float(apart), 1e-5, "itself", note)


def pair_scene() -> Scene:
    """A floating body of 2 kg that carries one of 1 kg on a ball joint, both lopsided, no weight."""
    scene = SceneBuilder("tumbling_pair", gravity=(0, 0, 0))
    scene.body("hull", mass=2, com=("0.1", 0, "0.2"), inertia=("0.3", "0.2", "0.25", "0.01", 0, "0.02"))
    scene.body("arm", mass=1, com=(0, "0.3", "-0.1"), inertia=("0.05", "0.02", "0.06", 0, 0, 0))
    scene.joint("base", "floating", "ground", "hull")
    return scene.joint("wrist", "spherical", "hull", "arm", xyz=(0, "0.2", "0.1")).build()


def tumbling_pair() -> Iterator[Answer]:
    """Nothing is known of this motion but its first integrals: a million steps by the steps that should keep them."""
    scene = pair_scene()
    rows = tuple(Output(name, (name,)) for name in ("momentum", "center_of_mass"))
    model, name = Model(scene, ("implicit_midpoint", "variational")), "tumbling pair"
    with tempfile.TemporaryDirectory() as folder:
        functions = generate(request(scene, rows, targets=("c",)), Path(folder)).load()

    def momenta(q: Array, v: Array) -> Array:
        found = np.asarray(functions.momentum(q, v))
        return np.concatenate([found[:3], found[3:] + np.cross(functions.center_of_mass(q), found[:3])])

    start = [0.1, 0.2, 0.3, 1.0, -0.5, 0.7, 0.6, -0.8, 1.2]
    for method, bar in (("variational", 2e-4), ("implicit_midpoint", 0.1)):
        motion = simulate(model, None, start, 10_000.0, method=method, dt=1e-2, samples=10_001)
        drift, what = motion.monitors.energy_drift, "over 10⁶ steps of 10 ms"
        yield answer(motion, name, f"energy {what}", drift, bar, "energy is kept")
        if method == "variational":
            first, last = (momenta(motion.q[k], motion.v[k]) for k in (0, -1))
            lost = float(np.abs(last - first).max())
            yield answer(motion, name, f"momenta {what}, N s, N m s", lost, 1e-8, "momenta are kept")


THIN, ROD = Fraction(1, 200_000), Fraction(100_01, 400_000)
"""Moments of 0.3 kg of 1 × 0.01 × 0.01 m, along and across: m a²/6, m (1 + a²)/12."""
BALL = Fraction(5)
MASS = BALL + Fraction(3, 10)
CENTRE = (BALL + Fraction(15, 100)) / MASS
"""Of a rod with its ball, from the hinge."""
ACROSS = ROD + Fraction(3, 10) * (CENTRE - Fraction(1, 2)) ** 2 + BALL * (1 - CENTRE) ** 2
SLIDER = Fraction(5, 1000)
SPIN = 2 * np.pi


def governor_scene() -> Scene:
    """A05: shaft, slider and two rods with a ball of 5 kg at their ends, as a tree; springs of 0.5 m with dampers stand
    for the couplers between the rods' middles and the slider. Rods and shaft 1 × 0.01 × 0.01 m, slider a cube of
    0.1 m, 3000 kg/m³; q = (turn, s, β right, β left)."""
    scene = SceneBuilder("flyball_governor")
    scene.body("shaft", mass=Fraction(3, 10), com=(0, 0, Fraction(1, 2)), inertia=(ROD, ROD, THIN, 0, 0, 0))
    scene.body("slider", mass=3, inertia=(SLIDER, SLIDER, SLIDER, 0, 0, 0))
    scene.joint("turn", "revolute", "ground", "shaft", axis=(0, 0, 1))
    scene.joint("slide", "prismatic", "shaft", "slider", axis=(0, 0, 1))
    half, edge = Fraction(1, 2), Fraction(1, 20)
    for name, side in (("right", 1), ("left", -1)):
        scene.body(name, mass=MASS, com=(side * CENTRE, 0, 0), inertia=(THIN, ACROSS, ACROSS, 0, 0, 0))
        scene.joint(f"{name}_hinge", "revolute", "shaft", name, axis=(0, side, 0), xyz=(side * edge, 0, 1))
        ends = ((side * half, 0, 0), (side * edge, 0, 0))
        scene.spring((name, "slider"), ends, stiffness=800_000, damping=40_000, length=half)
    return scene.build()


def rigid_governor(end: float, points: int) -> tuple[Array, Array]:
    """s(t) of the governor with rigid couplers, s = 1 − sin β: one coordinate, since angular momentum is kept.

    ½ m(β) β̇² + L²/(2 J(β)) + V(β) = E, integrated as β̈ = (−U' − ½ m' β̇²)/m."""
    c, across, mass = float(CENTRE), float(ACROSS), float(MASS)

    def inertia(beta: float) -> float:
        own = across * np.cos(beta) ** 2 + float(THIN) * np.sin(beta) ** 2
        return float(float(THIN + SLIDER) + 2.0 * (own + mass * (0.05 + c * np.cos(beta)) ** 2))

    def inertia_rate(beta: float) -> float:
        own = 2.0 * (float(THIN) - across) * np.sin(beta) * np.cos(beta)
        return float(2.0 * (own - 2.0 * mass * c * np.sin(beta) * (0.05 + c * np.cos(beta))))

    start = np.pi / 6
    momentum = inertia(start) * SPIN

    def rate(_t: float, y: Array) -> Array:
        beta, speed = y
        pull = 2.0 * mass * GRAVITY * c * np.cos(beta) + 3.0 * GRAVITY * np.cos(beta)
        spin = 0.5 * momentum**2 / inertia(beta) ** 2 * inertia_rate(beta)
        effective = 2.0 * (across + mass * c * c) + 3.0 * np.cos(beta) ** 2
        slope = -6.0 * np.cos(beta) * np.sin(beta)
        return np.array([speed, (pull + spin - 0.5 * slope * speed**2) / effective])

    times = np.linspace(0.0, end, points)
    solver = integrators().solve_ivp(rate, (0.0, end), [start, 0.0], "DOP853", times, rtol=1e-11, atol=1e-12)
    return times, 1.0 - np.sin(solver.y[0])


def governor() -> Iterator[Answer]:
    """The stiff flyball governor over 10 s: by an implicit solver, by the implicit midpoint rule with steps far longer
    than the springs allow to explicit ones, and beside the governor with rigid couplers."""
    model = Model(governor_scene(), ("implicit_midpoint",))
    q0, v0, name = [0.0, 0.5, np.pi / 6, np.pi / 6], [SPIN, 0.0, 0.0, 0.0], "A05 stiff flyball governor"
    end, points = 10.0, 1001
    explicit = simulate(model, q0, v0, end, samples=points, rtol=1e-10, atol=1e-12)
    stiff = simulate(model, q0, v0, end, method="Radau", samples=points, rtol=1e-9, atol=1e-11)
    error = largest(*(stiff.q[:, 1] - explicit.q[:, 1]))
    yield answer(stiff, name, "s over 10 s, m", error, 1e-6, "DOP853", kept=False)
    steps = simulate(model, q0, v0, end, method="implicit_midpoint", dt=1e-3, samples=points)
    error = largest(*(steps.q[:, 1] - explicit.q[:, 1]))
    yield answer(steps, name, "s over 10 s, dt 1 ms, m", error, 1e-3, "DOP853", kept=False)
    _, rigid = rigid_governor(1.0, 101)
    error = largest(*(explicit.q[:101, 1] - rigid))
    yield answer(explicit, name, "s over 1 s, m", error, 5e-3, "rigid couplers, one coordinate", kept=False)


PROBLEMS = (oscillators, zigzag, tumbling_pair, divergence, governor)
