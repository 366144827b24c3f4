"""A generated and compiled scene against Pinocchio, at states that are awkward too."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import symgen
from symgen.scene.model import Scene
from symgen.scene.request import request
from symgen.validation.compare_rows import row_difference
from symgen.validation.functions import bind
from symgen.validation.mechanism import Mechanism, random_state
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio
from symgen.validation.pinocchio_rows import State

Array = NDArray[Any]

CORE = ["mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics"]
EPSILON = 2.0**-53
ROUNDING = 4096 * EPSILON
LONG = 250_000
"""Bytes of C from which compilers take long."""
SINGULAR = 1e-12
"""A mass matrix whose smallest eigenvalue is this small beside the largest has no accelerations worth comparing."""


def awkward_states(mechanism: Mechanism, seed: int) -> list[State]:
    """Zero; random; fast, with large angles. Quaternions of unit length."""
    rng = np.random.default_rng(seed)
    states = []
    for angles, speed in ((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (300.0, 20.0)):
        q, v = random_state(mechanism, rng)
        for link in mechanism.links:
            if link.joint.type in ("spherical", "floating"):
                last = slice(link.q.stop - 4, link.q.stop)
                q[last] = q[last] if angles else [0.0, 0.0, 0.0, 1.0]
            elif link.coupling is None:
                q[link.q] *= angles if link.joint.type in ("revolute", "continuous") else min(angles, 1.0)
        a, tau = rng.uniform(-2, 2, mechanism.nv), rng.uniform(-2, 2, mechanism.nv)
        states.append(State(q, speed * v, a, tau))
    return states


def off_unit(mechanism: Mechanism, q: Array, rng: np.random.Generator) -> Array:
    """``q`` with every quaternion of norm 1 ± 1e-7: the same rotation."""
    found = q.copy()
    for link in mechanism.links:
        if link.joint.type in ("spherical", "floating"):
            found[link.q.stop - 4 : link.q.stop] *= 1 + rng.choice([-1e-7, 0.0, 1e-7])
    return found


@dataclass(frozen=True)
class Comparison:
    """Functions of a scene, and its peer."""

    scene: Scene
    functions: Any
    peer: Pinocchio

    def core(self, s: State, rng: np.random.Generator) -> None:
        """Mass matrix, bias force and inverse dynamics to rounding; M a = tau − h for the accelerations."""
        f, q = self.functions, off_unit(self.peer.mechanism, s.q, rng)
        M, h = self.peer.mass_matrix(s.q), self.peer.bias_force(s.q, s.v)
        close(f.mass_matrix(q), M, np.max(np.abs(M)), "mass_matrix")
        terms = self.terms(M, s)
        close(f.bias_force(q, s.v), h, terms, "bias_force")
        close(f.inverse_dynamics(q, s.v, s.a), self.peer.inverse_dynamics(s.q, s.v, s.a), terms, "inverse_dynamics")
        if regular(M) and "forward_dynamics" in f:
            found = f.forward_dynamics(q, s.v, s.tau)
            loads = np.max(np.abs(M) @ np.abs(found)) + np.max(np.abs(s.tau)) + terms
            close(M @ found, s.tau - h, loads, "forward_dynamics")

    def terms(self, M: Array, s: State) -> float:
        """The size of what forces are summed from, springs and dampers included."""
        weight = sum(float(body.mass) for body in self.scene.bodies) * 9.81
        lever = max(
            [1.0, *(float(np.max(np.abs(self.peer.body_pose(s.q, b.name).position))) for b in self.scene.bodies)]
        )
        passive = float(np.max(np.abs(self.peer.passive_force(s.q, s.v)), initial=0.0))
        speed = float(np.max(np.abs(s.v), initial=0.0))
        return float(np.max(np.abs(M))) * lever * (speed**2 + 2) + weight * lever + passive

    def row(self, name: str, states: list[State]) -> None:
        """Another row of the catalogue, by the criterion of `symgen validate`."""
        row, _, frame = name.partition(":")
        difference = row_difference(self.peer, bind(self.functions, self.scene), row, frame, states)
        assert difference.share <= 1, f"{name}: {difference}"


def regular(M: Array) -> bool:
    scale = 1 / np.sqrt(np.maximum(np.diag(M), 1e-300))
    found = np.linalg.eigvalsh(M * np.outer(scale, scale))
    return bool(found[0] > SINGULAR * found[-1])


def close(found: Array, wanted: Array, scale: float, what: str) -> None:
    assert found.shape == wanted.shape, what
    error = float(np.max(np.abs(found - wanted), initial=0.0))
    assert error <= ROUNDING * scale, f"{what}: off by {error:.3g} at a size of {scale:.3g}"


def solvable(scene: Scene, peer: Pinocchio, seed: int) -> Scene:
    """``scene``; or, where some velocity moves no inertia, without the rows that need M⁻¹ or mass."""
    if all(regular(peer.mass_matrix(state.q)) for state in awkward_states(peer.mechanism, seed)[1:3]):
        return scene
    return request(scene, [output for output in scene.outputs if not needs_inverse(output.name)])


def needs_inverse(row: str) -> bool:
    return row.startswith(("forward_dynamics", "mass_matrix_inverse", "center_of_mass", "momentum"))


def compiled(scene: Scene, folder: Path) -> Any:
    """The functions, optimised unless that would take minutes."""
    artifact = symgen.generate(scene, folder / "out")
    size = sum(path.stat().st_size for path in (folder / "out").glob("*.c"))
    return artifact.load(flags=["-O1" if size < LONG else "-O0"], cache=folder / "cache")


def check(scene: Scene, folder: Path, seed: int, rows: tuple[str, ...] = ()) -> Comparison:
    """Generate, compile, compare the core rows at awkward states and ``rows`` at random ones."""
    peer = build_pinocchio(scene)
    scene = solvable(scene, peer, seed)
    comparison = Comparison(scene, compiled(scene, folder), peer)
    rng = np.random.default_rng(seed)
    states = awkward_states(comparison.peer.mechanism, seed)
    for state in states:
        comparison.core(state, rng)
    if all(regular(peer.mass_matrix(state.q)) for state in states[1:3]):
        for row in rows:
            comparison.row(row, states[1:3])
    return comparison
