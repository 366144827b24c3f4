"""What is run: our steps and right-hand sides, Pinocchio's in the same solvers, Exudyn's own solvers."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from symgen.errors import NotSupportedError, SymgenError
from symgen.simulate.run import integrators, simulate
from symgen.validation import exudyn_bodies, exudyn_tree
from symgen.validation.exudyn_model import import_exudyn, settings
from symgen.validation.mechanism import Array, Mechanism, position_rate
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio, import_pinocchio
from symgen.validation.trajectories import flat
from symgen.validation.work_precision.setting import BALLS, Setting

PLAIN = ("revolute", "prismatic", *BALLS)
OURS_C, OURS_SCIPY = "symgen (C)", "symgen (SciPy)"
PINOCCHIO = "Pinocchio ABA (SciPy)"
TREE, BODIES = "Exudyn KinematicTree", "Exudyn redundant"
PROGRAMS = (OURS_C, OURS_SCIPY, PINOCCHIO, TREE, BODIES)
SOLVERS = ("DOP853", "RK45", "LSODA", "Radau")


@dataclass(frozen=True)
class Outcome:
    """Poses at the end, CPU seconds, and the relative change of the energy where it is known."""

    poses: Array
    cpu_seconds: float
    energy: float | None = None


Run = Callable[[float], Outcome]
"""Steps or tolerance → what comes out."""


@dataclass(frozen=True)
class Program:
    """One line of a diagram. ``knob``: "steps" or "rtol"."""

    name: str
    integrator: str
    knob: str
    run: Run


def programs(at: Setting) -> tuple[list[Program], list[tuple[str, str]]]:
    """Everything that can carry the scene, and (program, why not) of the rest."""
    found = [Program(OURS_C, f"step:{name}", "steps", _ours(at, name)) for name in at.model.steps]
    found += [Program(OURS_SCIPY, name, "rtol", _ours(at, name)) for name in SOLVERS]
    lost = []
    for name, make in ((PINOCCHIO, _pinocchios), (TREE, _trees), (BODIES, _redundant)):
        try:
            found.extend(make(at))
        except SymgenError as error:
            lost.append((name, str(error)))
    return found, lost


# --- ours ------------------------------------------------------------------------------------------------------------


def _ours(at: Setting, method: str) -> Run:
    def run(knob: float) -> Outcome:
        stepped = method in at.model.steps
        how: dict[str, Any] = {"dt": at.end / knob} if stepped else {"rtol": knob, "atol": knob * 1e-2}
        motion = simulate(at.model, list(at.q), list(at.v), at.end, method=method, samples=2, **how)
        q, v = motion.q[-1], motion.v[-1]
        return Outcome(at.poses(q), motion.cpu_seconds, at.energy_error(q, v))

    return run


# --- Pinocchio -------------------------------------------------------------------------------------------------------


def _pinocchios(at: Setting) -> Iterator[Program]:
    rate = pinocchio_rate(at, build_pinocchio(at.scene))
    for method in ("DOP853", "RK45"):
        yield Program(PINOCCHIO, method, "rtol", _solved(at, rate, method))


def pinocchio_end(at: Setting, rtol: float) -> Array:
    """Poses at the end by Pinocchio in SciPy's DOP853. Raises SymgenError where it cannot hold the scene."""
    return _solved(at, pinocchio_rate(at, build_pinocchio(at.scene)), "DOP853")(rtol).poses


def _solved(at: Setting, rate: Callable[[float, Array], Array], method: str) -> Run:
    nq = at.mechanism.nq

    def run(knob: float) -> Outcome:
        began = time.process_time()
        y = np.concatenate([at.q, at.v])
        solver = getattr(integrators(), method)(rate, 0.0, y, at.end, rtol=knob, atol=knob * 1e-2)
        while solver.status == "running":
            solver.step()
            solver.dense_output()
        spent = time.process_time() - began
        q = normalised(at.mechanism, np.array(solver.y[:nq]))
        return Outcome(at.poses(q), spent, at.energy_error(q, np.array(solver.y[nq:])))

    return run


def pinocchio_rate(at: Setting, theirs: Pinocchio) -> Callable[[float, Array], Array]:
    """dy/dt by ABA. Where Pinocchio's coordinates are ours and nothing is added, without our adapter between."""
    nq, zero = at.mechanism.nq, np.zeros(at.mechanism.nv)
    links = at.mechanism.links
    plain = all(link.joint.type in PLAIN and link.coupling is None for link in links)
    if plain and not at.scene.forces and theirs.model.nq == nq and same_velocities(at, theirs):
        aba, model, data = theirs.pin.aba, theirs.model, theirs.data
        damping = np.zeros(at.mechanism.nv)
        for link in links:
            damping[link.v] = float(link.joint.damping)
        turning = [link for link in links if link.joint.type in BALLS]
        if not turning:
            return lambda _t, y: np.concatenate([y[nq:], aba(model, data, y[:nq], y[nq:], -damping * y[nq:])])
        places = [(link.q.start, link.v.start, link.joint.type == "floating") for link in turning]
        vectors = [(link.q, link.v) for link in links if link not in turning]

        def lean(_t: float, y: Array) -> Array:
            found, q, v = np.empty(y.size), y[:nq], y[nq:]
            for to, of in vectors:
                found[to] = v[of]
            for place, first, floating in places:
                quaternion_rate(q, v, found, place, first, floating)
            found[nq:] = aba(model, data, q, v, -damping * v)
            return found

        return lean

    def rate(_t: float, y: Array) -> Array:
        q, v = y[:nq], y[nq:]
        return np.concatenate([position_rate(at.mechanism, q, v), theirs.forward_dynamics(q, v, zero)])

    return rate


def same_velocities(at: Setting, theirs: Pinocchio) -> bool:
    """Whether Pinocchio's v is ours, at two configurations."""
    maps = [theirs.velocity_map(q, at.v).S for q in (at.q, np.roll(at.q, 1))]
    return all(np.array_equal(found, np.eye(at.mechanism.nv)) for found in maps)


def quaternion_rate(q: Array, v: Array, found: Array, place: int, first: int, floating: bool) -> None:
    """dq/dt of a spherical joint, or of a floating one with velocities in its own axes; in plain floats, which are
    faster than arrays of three."""
    if floating:
        a, b, c = v[first : first + 3].tolist()
        x, y, z, w = q[place + 3 : place + 7].tolist()
        s = 2.0 / (x * x + y * y + z * z + w * w)
        k, m, n = s * (y * c - z * b), s * (z * a - x * c), s * (x * b - y * a)
        found[place] = a + w * k + y * n - z * m
        found[place + 1] = b + w * m + z * k - x * n
        found[place + 2] = c + w * n + x * m - y * k
        place, first = place + 3, first + 3
    a, b, c = v[first : first + 3].tolist()
    x, y, z, w = q[place : place + 4].tolist()
    found[place] = 0.5 * (w * a + y * c - z * b)
    found[place + 1] = 0.5 * (w * b + z * a - x * c)
    found[place + 2] = 0.5 * (w * c + x * b - y * a)
    found[place + 3] = -0.5 * (x * a + y * b + z * c)


def normalised(mechanism: Mechanism, q: Array) -> Array:
    for link in mechanism.links:
        if link.joint.type in BALLS:
            part = q[link.q]
            part[-4:] /= np.linalg.norm(part[-4:])
            q[link.q] = part
    return q


# --- Exudyn ----------------------------------------------------------------------------------------------------------


def _trees(at: Setting) -> Iterator[Program]:
    if any(link.joint.type == "helical" for link in at.mechanism.links):
        raise NotSupportedError("a helical joint is a constraint there, which its explicit solvers refuse")

    def build() -> Any:
        return exudyn_tree.build_exudyn_tree(at.scene, at.q, at.v).model

    build()
    for method in ("RK44", "RK67"):
        yield Program(TREE, method, "steps", _exudyn(at, build, method))
    yield Program(TREE, "DOPRI5", "rtol", _exudyn(at, build, "DOPRI5"))


def _redundant(at: Setting) -> Iterator[Program]:
    def build() -> Any:
        return exudyn_bodies.build_exudyn_bodies(at.scene, at.q, at.v)

    build()
    yield Program(BODIES, "GeneralizedAlpha", "steps", _exudyn(at, build, "GeneralizedAlpha"))


def _exudyn(at: Setting, build: Callable[[], Any], solver: str) -> Run:
    def run(knob: float) -> Outcome:
        model = build()
        if solver == "DOPRI5":
            return _adaptive(model, at.end, knob)
        began = time.process_time()
        found = model.simulate(round(knob), at.end, 1, solver)
        return Outcome(flat(found), time.process_time() - began)

    return run


def _adaptive(model: Any, end: float, tolerance: float) -> Outcome:
    """Exudyn's DOPRI5; sensors are read at its last step, which is the end."""
    options = settings(model.exu, 10, end)
    options.solutionSettings.sensorsWritePeriod = end
    options.timeIntegration.automaticStepSize = True
    options.timeIntegration.adaptiveStep = True
    options.timeIntegration.relativeTolerance = tolerance
    options.timeIntegration.absoluteTolerance = tolerance * 1e-2
    began = time.process_time()
    model.mbs.SolveDynamic(options, solverType=model.exu.DynamicSolverType.DOPRI5)
    spent = time.process_time() - began
    found = []
    for (place, turn), local in zip(model.sensors, model.local, strict=True):
        position, rotation = (np.array(model.mbs.GetSensorStoredData(sensor))[-1] for sensor in (place, turn))
        if abs(position[0] - end) > 1e-9 * end:
            raise RuntimeError(f"stopped at t = {position[0]:g} s")
        found.append(type(local)(rotation[1:].reshape(3, 3), position[1:]) @ local)
    return Outcome(flat([found]), spent)


def versions() -> dict[str, str]:
    """Of what is run beside ours, where it is installed."""
    found: dict[str, str] = {}
    with contextlib.suppress(SymgenError):
        found["Pinocchio"] = str(import_pinocchio().__version__)
    with contextlib.suppress(SymgenError):
        found["Exudyn"] = str(import_exudyn().config.Version())
    return found


__all__ = ["PROGRAMS", "Outcome", "Program", "pinocchio_end", "programs", "versions"]
