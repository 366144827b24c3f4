"""The reference motion: our forward_dynamics integrated by SciPy's DOP853 (Hairer, Nørsett & Wanner 1993)."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from symgen.errors import ToolError
from symgen.validation.functions import Bound
from symgen.validation.mechanism import Array, Mechanism, Pose, link_poses, position_rate

RTOL, ATOL = 1e-12, 1e-13
POINTS = 25
"""Points per segment kept for plots."""


class MotionError(ToolError):
    """The functions under test do not lead a motion on: a failed check, not a missing tool."""


@dataclass(frozen=True)
class Motion:
    """States along time; ``marks`` are the rows at the ends of the segments, which are full steps of the integrator."""

    t: Array
    q: Array
    v: Array
    marks: tuple[int, ...]

    def poses(self, mechanism: Mechanism) -> list[list[Pose]]:
        """Poses of every link at the marks."""
        return [link_poses(mechanism, self.q[k]) for k in self.marks]


def import_scipy_integrate() -> Any:
    try:
        return importlib.import_module("scipy.integrate")
    except ImportError as error:
        raise ToolError("SciPy is not installed: pip install 'symgen[validation]'") from error


def integrate_motion(
    mechanism: Mechanism, functions: Bound, q: Array, v: Array, end: float, segments: int, points: int = POINTS
) -> Motion:
    """From (q, v) at t = 0 to ``end``, no joint forces; q̇ = G(q) v, v̇ = forward_dynamics(q, v, 0)."""
    solve = import_scipy_integrate().solve_ivp
    nq, zero = mechanism.nq, np.zeros(mechanism.nv)

    def rate(t: float, y: Array) -> Array:
        here, velocity = y[:nq], y[nq:]
        a = functions("forward_dynamics", here, velocity, zero)
        if not np.all(np.isfinite(a)):
            raise MotionError(f"forward_dynamics is not a number at t = {t:g} s")
        return np.concatenate([position_rate(mechanism, here, velocity), a])

    times, states, marks = [0.0], [np.concatenate([q, v])], []
    for k in range(segments):
        span = (end * k / segments, end * (k + 1) / segments)
        asked = np.linspace(*span, points + 1)[1:]
        found = solve(rate, span, states[-1], method="DOP853", rtol=RTOL, atol=ATOL, t_eval=asked)
        if not found.success:
            raise MotionError(f"the reference integration stopped after t = {times[-1]:g} s")
        times.extend(found.t)
        states.extend(found.y.T)
        marks.append(len(times) - 1)
    y = np.array(states)
    return Motion(np.array(times), y[:, :nq], y[:, nq:], tuple(marks))
