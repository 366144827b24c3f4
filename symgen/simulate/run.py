"""Motions by SciPy's solvers and by generated steps."""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from symgen.errors import SceneError, ToolError
from symgen.scene.model import Scene
from symgen.scene.outputs import STEPS
from symgen.scene.schema import did_you_mean
from symgen.simulate.model import Array, Model, numbers
from symgen.simulate.motion import Monitors, Motion

Progress = Callable[[int, int, str], None]
Tau = Callable[[float, Array, Array], Sequence[float]]
"""tau(t, q, v): joint forces."""

SOLVERS = ("DOP853", "RK45", "RK23", "LSODA", "Radau", "BDF")
"""SciPy's, adaptive."""
IMPLICIT = ("LSODA", "Radau", "BDF")
METHODS = (*SOLVERS, *STEPS)
SAMPLES = 201
CHUNK = 100_000
"""Steps between two reports of progress."""
MOST = 1_000_000
"""States that are kept at most."""


def simulate(
    scene: Scene | str | Path | Model,
    q0: Sequence[float] | None = None,
    v0: Sequence[float] | None = None,
    t_end: float = 1.0,
    *,
    method: str = "DOP853",
    tau: Tau | Sequence[float] | None = None,
    dt: float | None = None,
    rtol: float = 1e-9,
    atol: float = 1e-11,
    samples: int | Sequence[float] | None = None,
    p: Sequence[float] | None = None,
    progress: Progress | None = None,
) -> Motion:
    """The motion of a scene from (q0, v0) at t = 0 to ``t_end`` (s).

    ``method``: one of SciPy's solvers (`SOLVERS`; ``rtol``, ``atol`` per step) or a generated step (`STEPS`; ``dt``,
    shortened so that a whole number of steps fits). ``tau``: nothing, constant forces, or tau(t, q, v), which steps
    hold constant over each. ``samples``: how many states are kept, or (solvers) at which times; steps keep all of them
    up to a million by default. A `Model` in place of the scene saves deriving and compiling again.

    Quaternions are normalised in the result; their norm does not act on the motion, since all functions divide by it.
    Raises SceneError for bad arguments, ToolError without SciPy or where the solver fails.
    """
    if method not in METHODS:
        raise SceneError(f"no method {method!r}{did_you_mean(method, METHODS)}", "method")
    if not (math.isfinite(t_end) and t_end > 0.0):
        raise SceneError("the time must be positive", "t_end")
    if isinstance(scene, Model) and p is not None:
        raise SceneError("a Model has its parameters already: give them to it", "p")
    model = scene if isinstance(scene, Model) else Model(scene, (method,) if method in STEPS else (), p)
    y = model.start(q0, v0)
    if method in STEPS:
        if dt is None or not (math.isfinite(dt) and dt > 0.0):
            raise SceneError(f"{method} needs a positive dt", "dt")
        return _stepped(model, y, t_end, method, _forces(tau, model), dt, samples, progress)
    if dt is not None:
        raise SceneError(f"{method} chooses its steps; dt is for {', '.join(STEPS)}", "dt")
    for name, value in (("rtol", rtol), ("atol", atol)):
        if not (math.isfinite(value) and value > 0.0):
            raise SceneError("a tolerance must be positive", name)
    return _solved(model, y, t_end, method, _forces(tau, model), (rtol, atol), samples, progress)


def _forces(tau: Tau | Sequence[float] | None, model: Model) -> Tau | Array:
    """A function, or constant forces."""
    if callable(tau):
        return tau
    return np.zeros(model.nv) if tau is None else np.ascontiguousarray(numbers(tau, model.nv, "force", "tau"))


def _at(tau: Tau | Array, t: float, y: Array, model: Model) -> Array:
    if not callable(tau):
        return tau
    found = np.ascontiguousarray(tau(t, y[: model.nq], y[model.nq :]), dtype=np.float64)
    if found.shape != (model.nv,):
        raise SceneError(f"tau must return {model.nv} forces, not an array {found.shape}", "tau")
    return found


# --- SciPy's solvers -------------------------------------------------------------------------------------------------


def integrators() -> Any:
    try:
        return importlib.import_module("scipy.integrate")
    except ImportError as error:
        raise ToolError("SciPy is not installed: pip install 'symgen[validation]'") from error


def _jacobian(rate: Callable[[Array], Array], y: Array) -> Array:
    """By differences. (SciPy's own steps grow without end along coordinates that nothing depends on.)"""
    here, found = rate(y), np.empty((y.size, y.size))
    for k in range(y.size):
        moved = y.copy()
        moved[k] += 1e-8 * max(1.0, abs(y[k]))
        found[:, k] = (rate(moved) - here) / (moved[k] - y[k])
    return found


def _solved(
    model: Model,
    y: Array,
    t_end: float,
    method: str,
    tau: Tau | Array,
    tolerances: tuple[float, float],
    samples: int | Sequence[float] | None,
    progress: Progress | None,
) -> Motion:
    scipy, compute = integrators(), model.rate()
    if samples is None or isinstance(samples, int):
        times = np.linspace(0.0, t_end, max(2, SAMPLES if samples is None else samples))
    else:
        times = np.asarray(samples, dtype=np.float64)
        if times.ndim != 1 or times.size == 0 or times[0] < 0.0 or times[-1] > t_end or np.any(np.diff(times) <= 0.0):
            raise SceneError("times must rise from 0 or later up to t_end", "samples")

    def rate(t: float, state: Array) -> Array:
        return compute(state, _at(tau, t, state, model))

    def slopes(t: float, state: Array) -> Array:
        return _jacobian(lambda x: rate(t, x), state)

    began = time.process_time()
    rtol, atol = tolerances
    own = {"jac": slopes} if method in IMPLICIT else {}
    solver = getattr(scipy, method)(rate, 0.0, y, t_end, rtol=rtol, atol=atol, **own)
    knots, pieces, steps, shown = [0.0], [], 0, 0
    while solver.status == "running":
        try:
            message = solver.step()
        except (ValueError, ArithmeticError) as error:
            raise ToolError(f"{method} stopped at t = {solver.t:g} s: {error}") from None
        if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
            raise ToolError(f"{method} stopped at t = {solver.t:g} s: {message or 'a value is not finite'}")
        steps += 1
        knots.append(float(solver.t))
        pieces.append(solver.dense_output())
        if progress is not None and int(1000 * solver.t / t_end) > shown:
            shown = int(1000 * solver.t / t_end)
            progress(shown, 1000, f"t = {solver.t:.3g} s")
    dense = scipy.OdeSolution(np.array(knots), pieces)
    spent = time.process_time() - began
    states = dense(times).T
    states[times == t_end] = solver.y
    return _motion(model, times, states, lambda t: dense(t).T, method, steps, int(solver.nfev), spent)


# --- generated steps -------------------------------------------------------------------------------------------------


def _stepped(
    model: Model,
    y: Array,
    t_end: float,
    method: str,
    tau: Tau | Array,
    dt: float,
    samples: int | Sequence[float] | None,
    progress: Progress | None,
) -> Motion:
    steps = max(1, math.ceil(t_end / dt - 1e-9))
    if samples is not None and not isinstance(samples, int):
        raise SceneError("steps keep every so many states: give their number", "samples")
    wanted = min(steps, MOST) if samples is None else max(1, min(steps, samples - 1))
    every = -(-steps // wanted)
    steps = every * -(-steps // every)
    dt = t_end / steps
    began = time.process_time()
    rows, done, state = [y[None, :].copy()], 0, y.copy()
    block = every * max(1, CHUNK // every) if not callable(tau) else 1
    while done < steps:
        count = min(block, steps - done)
        if callable(tau):
            model.step(method, 1, 1, _at(tau, done * dt, state, model), dt, state)
            if (done + 1) % every == 0:
                rows.append(state[None, :].copy())
        else:
            rows.append(model.step(method, count, every, tau, dt, state))
        done += count
        if progress is not None and (not callable(tau) or done % 1000 == 0):
            progress(done, steps, f"t = {done * dt:.3g} s")
        if not np.all(np.isfinite(state)):
            raise ToolError(f"{method} with dt = {dt:g} s left the numbers before t = {done * dt:g} s")
    states = np.concatenate(rows)
    times: Array = np.arange(len(states), dtype=np.float64) * (every * dt)
    times[-1] = t_end
    spent = time.process_time() - began
    return _motion(model, times, states, _cubic(model, times, states, tau), method, steps, 0, spent)


def _cubic(model: Model, times: Array, states: Array, tau: Tau | Array) -> Callable[[Array], Array]:
    """Between states, the cubic with their rates (Hermite)."""

    compute = model.rate()

    def rate(k: int) -> Array:
        return compute(states[k], _at(tau, float(times[k]), states[k], model))

    def between(asked: Array) -> Array:
        found = np.empty((asked.size, states.shape[1]))
        for row, t in enumerate(asked):
            k = min(max(int(np.searchsorted(times, t, side="right")) - 1, 0), len(times) - 2)
            h = times[k + 1] - times[k]
            s = (t - times[k]) / h
            jump, first, last = states[k + 1] - states[k], h * rate(k), h * rate(k + 1)
            curve = (first - jump) * (1.0 - s) + (jump - last) * s
            found[row] = states[k] + s * jump + s * (1.0 - s) * curve
        return found

    return between


def _motion(
    model: Model,
    times: Array,
    states: Array,
    between: Callable[[Array], Array],
    method: str,
    steps: int,
    evaluations: int,
    spent: float,
) -> Motion:
    nq, drift = model.nq, 0.0

    def normalised(rows: Array) -> Array:
        rows = np.array(rows)
        for place in model.quaternions:
            rows[:, place : place + 4] /= np.linalg.norm(rows[:, place : place + 4], axis=1, keepdims=True)
        return rows

    for place in model.quaternions:
        norms = np.linalg.norm(states[:, place : place + 4], axis=1)
        drift = max(drift, float(np.max(np.abs(norms - 1.0))))
    states = normalised(states)
    q, v = np.ascontiguousarray(states[:, :nq]), np.ascontiguousarray(states[:, nq:])
    kinetic, potential = model.energies(q, v)
    energy = kinetic + potential
    scale = max(abs(float(energy[0])), float(np.max(kinetic)), 1e-300)
    names = tuple(tuple(row) for row in model.names)
    return Motion(
        times,
        q,
        v,
        kinetic,
        potential,
        Monitors(float(np.max(np.abs(energy - energy[0]))) / scale, drift),
        method,
        steps,
        evaluations,
        spent,
        (names[0], names[1]),
        lambda t: normalised(between(t)),
    )
