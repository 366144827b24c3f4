"""What both Exudyn formulations share: a silent system, settings, and the system's matrices.

`exudyn_tree` builds the minimal-coordinate model, `exudyn_bodies` the redundant one; both return a `Model`.
Exudyn prints and writes files by default; nothing here does.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np

from symgen.errors import ToolError
from symgen.validation.mechanism import Array, Mechanism, Pose


def import_exudyn() -> ModuleType:
    """Exudyn, told to be quiet."""
    try:
        exudyn: Any = importlib.import_module("exudyn")
    except ModuleNotFoundError as error:
        raise ToolError("Exudyn is not installed: pip install 'symgen[validation]'") from error
    except ImportError as error:  # its module is linked with OpenGL
        hint = " (on Debian or Ubuntu: apt install libgl1)" if "libGL" in str(error) else ""
        raise ToolError(f"Exudyn is installed and cannot be loaded: {' '.join(str(error).split())}{hint}") from error
    exudyn.config.printToConsole = False
    exudyn.config.suppressWarnings = True
    return exudyn  # type: ignore[no-any-return]


def exudyn_items() -> Any:
    """Exudyn's module of nodes, objects, markers, loads and sensors."""
    return importlib.import_module("exudyn.itemInterface")


SPARSE_FROM = 8
"""Links from which Exudyn's sparse solver is the faster one."""


@dataclass(frozen=True)
class Terms:
    """M q̈ + Cᵀ λ = f, C q̈ = γ, of Exudyn's assembled system at its current state."""

    M: Array
    f: Array
    C: Array
    gamma: Array

    def accelerations(self) -> Array:
        """q̈ from the KKT system, refined once; by least squares where dependent constraint rows make it singular."""
        n, m = self.M.shape[0], self.C.shape[0]
        if not m:
            return np.asarray(np.linalg.solve(self.M, self.f))
        K = np.block([[self.M, self.C.T], [self.C, np.zeros((m, m))]])
        rhs = np.concatenate([self.f, self.gamma])
        try:
            solution = np.linalg.solve(K, rhs)
            solution = solution + np.linalg.solve(K, rhs - K @ solution)
        except np.linalg.LinAlgError:
            solution = np.linalg.lstsq(K, rhs, rcond=1e-14)[0]
            solution = solution + np.linalg.lstsq(K, rhs - K @ solution, rcond=1e-14)[0]
        return np.asarray(solution[:n])


@dataclass(frozen=True)
class Model:
    """An assembled Exudyn system of a mechanism at one state (t = 0)."""

    exu: Any
    mbs: Any
    mechanism: Mechanism
    sensors: tuple[tuple[Any, Any], ...]
    """Per link: position and rotation-matrix sensor."""
    local: tuple[Pose, ...]
    """Per link: the body's frame in the frame that its sensors show."""
    link_acceleration: Callable[[Array], Array]
    """q̈ of Exudyn → what is compared (joint accelerations, or links' accelerations stacked)."""
    constrained: bool

    def terms(self) -> Terms:
        """The system's matrices at t = 0."""
        solver = self.exu.MainSolverImplicitSecondOrder()
        solver.InitializeSolver(self.mbs, settings(self.exu, 1, 1.0))
        n, m = solver.GetODE2size(), solver.GetAEsize()
        solver.ComputeMassMatrix(self.mbs)
        M = np.array(solver.GetSystemMassMatrix())[:n, :n]
        solver.ComputeODE2RHS(self.mbs)
        f = np.array(solver.GetSystemResidual())[:n]
        # Multipliers of the solver's own initial accelerations must not enter f.
        jacobian = self._constraint_jacobian
        C = jacobian(solver, n, m)
        gamma = self._constraint_bias(solver, n, m) if m else np.zeros(0)
        solver.FinalizeSolver(self.mbs, settings(self.exu, 1, 1.0))
        return Terms(M, f, C, gamma)

    def _constraint_jacobian(self, solver: Any, n: int, m: int) -> Array:
        if not m:
            return np.zeros((0, n))
        solver.ComputeJacobianODE2RHS(self.mbs, 0, 0, 0)  # ComputeJacobianAE adds to what is there
        solver.ComputeJacobianAE(self.mbs)
        return np.array(solver.GetSystemJacobian())[n : n + m, :n].copy()

    def _constraint_bias(self, solver: Any, n: int, m: int) -> Array:
        """γ = −Ċ q̇ by central differences of C along q̇.

        C is a polynomial of low degree in Exudyn's coordinates, so that two extrapolations of large steps are exact.
        """
        data = self.mbs.systemData
        q, v = np.array(data.GetODE2Coordinates()), np.array(data.GetODE2Coordinates_t())
        size = float(np.abs(v).max())
        if size == 0.0:
            return np.zeros(m)

        def slope(h: float) -> Array:
            sides = []
            for sign in (1.0, -1.0):
                data.SetODE2Coordinates(list(q + sign * h * v))
                sides.append(self._constraint_jacobian(solver, n, m) @ v)
            return np.asarray((sides[0] - sides[1]) / (2.0 * h))

        table = [slope(0.5 / size * 0.5**k) for k in range(4)]
        data.SetODE2Coordinates(list(q))
        for level in range(1, 4):
            table = [(4.0**level * b - a) / (4.0**level - 1.0) for a, b in pairwise(table)]
        return -table[0]

    def simulate(self, steps: int, end: float, samples: int, solver: str) -> list[list[Pose]]:
        """Poses of every link at ``samples`` equal times after 0, the last being ``end``."""
        options = settings(self.exu, steps, end)
        options.solutionSettings.sensorsWritePeriod = end / samples
        if len(self.mechanism.links) > SPARSE_FROM:
            options.linearSolverType = self.exu.LinearSolverType.EigenSparse
        try:
            success = self.mbs.SolveDynamic(options, solverType=getattr(self.exu.DynamicSolverType, solver))
        except Exception as error:  # Exudyn's own SolverError is not importable
            said = " ".join(str(error).split())[:120]
            raise ToolError(f"Exudyn's {solver} gave up with {steps} steps: {said}") from None
        if success is False:
            raise ToolError(f"Exudyn's {solver} did not converge with {steps} steps")
        found: list[list[Pose]] = [[] for _ in range(samples)]
        for (place, turn), local in zip(self.sensors, self.local, strict=True):
            positions = np.array(self.mbs.GetSensorStoredData(place))
            rotations = np.array(self.mbs.GetSensorStoredData(turn))
            for k in range(samples):
                away = np.abs(positions[:, 0] - end * (k + 1) / samples)
                row = int(np.argmin(away))
                if away[row] > 1e-9 * end:
                    raise ToolError(f"Exudyn's {solver} stopped at t = {positions[-1, 0]:g} s with {steps} steps")
                found[k].append(Pose(rotations[row, 1:].reshape(3, 3), positions[row, 1:]) @ local)
        return found


def settings(exu: Any, steps: int, end: float) -> Any:
    """Simulation settings: tight Newton, fixed steps, no files, no output."""
    options = exu.SimulationSettings()
    options.solutionSettings.writeSolutionToFile = False
    options.solutionSettings.writeInitialValues = False
    options.displayComputationTime = False
    options.timeIntegration.numberOfSteps = steps
    options.timeIntegration.endTime = end
    options.timeIntegration.adaptiveStep = False
    options.timeIntegration.automaticStepSize = False
    options.timeIntegration.verboseMode = 0
    options.timeIntegration.newton.relativeTolerance = 1e-12
    options.timeIntegration.newton.absoluteTolerance = 1e-14
    options.timeIntegration.newton.numericalDifferentiation.forODE2 = False
    return options


def frame_with_z(axis: Array) -> Array:
    """A rotation whose third column is ``axis``."""
    z = axis / np.linalg.norm(axis)
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
