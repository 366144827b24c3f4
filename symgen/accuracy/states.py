"""States to measure at: sampled over a scene's range, or anywhere in it for searches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.program.instructions import Program
from symgen.scene.joints import JOINT_TYPES
from symgen.system import System

Array = NDArray[np.float64]
States = Mapping[str, Array]
"""Input → (states, size); dt has size 1."""

RATES = 2.0
FORCES = 5.0


@dataclass(frozen=True)
class Box:
    """Where states are taken from: angles within ±π, displacements within ±1 m, velocities within ±2, accelerations
    and forces within ±5, dt within 0 … 10 ms, directions of products within ±1; quaternions have unit length."""

    system: System
    program: Program

    @property
    def size(self) -> int:
        return sum(port.size for port in self.program.inputs if port.name != "p")

    def states(self, points: Array) -> dict[str, Array]:
        """States of points of the cube [−1, 1]^size, one per row."""
        found, start = dict[str, Array](), 0
        for port in self.program.inputs:
            if port.name == "p":
                defaults = [float(x) for parameter in self.system.scene.parameters for x in parameter.default]
                found["p"] = np.tile(defaults, (len(points), 1))
                continue
            part = np.ascontiguousarray(points[:, start : start + port.size])
            start += port.size
            found[port.name] = self._scaled(port.name, part)
        return found

    def _scaled(self, name: str, part: Array) -> Array:
        if name == "q":
            return self._positions(part)
        if name == "dt":
            return 0.005 * (part + 1)
        return part * {"v": RATES, "a": FORCES, "tau": FORCES}.get(name, 1.0)

    def _positions(self, part: Array) -> Array:
        q = part.copy()
        for body in self.system.tree.bodies:
            if body.coupling is not None:
                continue
            units = JOINT_TYPES[body.joint.type].q_units
            q[:, body.q : body.q + body.nq] *= [np.pi if unit == "rad" else 1.0 for unit in units]
            if body.nq > body.nv:
                quaternion = q[:, body.q + body.nq - 4 : body.q + body.nq]
                length = np.linalg.norm(quaternion, axis=1, keepdims=True)
                quaternion[:] = np.where(length > 0, quaternion / np.where(length > 0, length, 1), [0, 0, 0, 1])
        return q

    def intervals(self) -> list[tuple[float, float]]:
        """The box, one interval per scalar input: parameters at their defaults, entries of quaternions within ±1."""
        low, high = (self.states(end * np.ones((1, self.size))) for end in (-1.0, 1.0))
        found = [
            (float(a), float(b))
            for port in self.program.inputs
            for a, b in zip(low[port.name][0], high[port.name][0], strict=True)
        ]
        for start in self.spheres():
            found[start : start + 4] = [(-1.0, 1.0)] * 4
        return found

    def spheres(self) -> list[int]:
        """Where unit quaternions begin among the scalar inputs."""
        if not any(port.name == "q" for port in self.program.inputs):
            return []
        before = sum(port.size for port in self.program.inputs[: [p.name for p in self.program.inputs].index("q")])
        bodies = [body for body in self.system.tree.bodies if body.coupling is None and body.nq > body.nv]
        return [before + body.q + body.nq - 4 for body in bodies]

    def sample(self, count: int, seed: int = 1) -> dict[str, Array]:
        return self.states(np.random.default_rng(seed).uniform(-1, 1, (count, self.size)))


def rounded(states: States, precision: str) -> dict[str, Array]:
    """The states as a function of that precision is given them."""
    if precision == "double":
        return dict(states)
    return {name: rows.astype(np.float32).astype(np.float64) for name, rows in states.items()}


def joined(*parts: States) -> dict[str, Array]:
    """States one behind the other."""
    return {name: np.vstack([part[name] for part in parts]) for name in parts[0]}


def picked(states: States, rows: NDArray[np.int64] | slice) -> dict[str, Array]:
    """Some of the states."""
    return {name: values[rows] for name, values in states.items()}
