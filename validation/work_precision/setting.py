"""A scene, its start, and where its motion ends: by the reference, and how sure that is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from symgen.scene.canonical import with_hash
from symgen.scene.model import Scene
from symgen.scene.outputs import STEPS
from symgen.simulate.model import Model
from symgen.simulate.run import simulate
from symgen.validation.invariants import is_conservative
from symgen.validation.mechanism import Array, Mechanism, build_mechanism, link_poses
from symgen.validation.trajectories import flat, start_state

FINEST: dict[str, Any] = {"rtol": 1e-13, "atol": 1e-15}
SEED = 7
EXTRAPOLATED = (8192, 16384)
"""Steps of the two runs of order 4 that are extrapolated beside the reference."""
BALLS = ("spherical", "floating")


@dataclass(frozen=True)
class Energy:
    """What energy is compared with: its value at the start and what its changes are divided by, J."""

    start: float
    scale: float
    kept: bool
    """Nothing drives or damps."""


@dataclass(frozen=True)
class Setting:
    """``right``: positions and entries of rotation matrices of all links at ``end`` (s); ``checks``: (what, how far it
    is from that)."""

    scene: Scene
    mechanism: Mechanism
    q: Array
    v: Array
    end: float
    model: Model
    right: Array
    energy: Energy
    checks: tuple[tuple[str, float], ...]

    @property
    def uncertainty(self) -> float:
        """Of the reference: nothing below can be told apart."""
        return max((by for _, by in self.checks), default=0.0)

    def poses(self, q: Array) -> Array:
        return flat([link_poses(self.mechanism, q)])

    def energy_error(self, q: Array, v: Array) -> float | None:
        """Relative change of the energy since the start; None where it is not kept."""
        if not self.energy.kept:
            return None
        kinetic, potential = self.model.energies(q[None, :].copy(), v[None, :].copy())
        return abs(float(kinetic[0] + potential[0]) - self.energy.start) / self.energy.scale


def undamped(scene: Scene) -> Scene:
    """The same without dampers."""
    return replace(
        scene,
        joints=tuple(replace(joint, damping=Fraction(0)) for joint in scene.joints),
        forces=tuple(replace(force, damping=Fraction(0)) for force in scene.forces),
    )


def turns(mechanism: Mechanism) -> bool:
    """Whether there are quaternions."""
    return any(link.joint.type in BALLS for link in mechanism.links)


def methods(mechanism: Mechanism) -> list[str]:
    """The generated steps; without quaternions ``lie`` is ``rk4``."""
    return [name for name in STEPS if name != "lie" or turns(mechanism)]


def in_body_axes(scene: Scene) -> Scene:
    """Velocities of a free base as Pinocchio has them, so that nothing is converted while the clock runs."""
    return with_hash(replace(scene, options=replace(scene.options, base_velocity="body")))


def prepare(scene: Scene, end: float) -> Setting:
    """The setting, compiled; `checks` holds our own extrapolated steps, others are added by who has them."""
    scene = in_body_axes(scene)
    mechanism = build_mechanism(scene)
    model = Model(scene, methods(mechanism))
    q, v = start_state(mechanism, SEED)
    motion = simulate(model, list(q), list(v), end, **FINEST)
    scale = max(abs(float(motion.energy[0])), float(np.max(motion.kinetic)), 1e-300)
    energy = Energy(float(motion.energy[0]), scale, is_conservative(mechanism))
    right = flat([link_poses(mechanism, motion.q[-1])])
    at = Setting(scene, mechanism, q, v, end, model, right, energy, ())
    return checked(at, "steps of order 4, extrapolated", lambda: extrapolated(at))


def extrapolated(at: Setting) -> Array:
    """Poses at the end from two runs of order 4, the error of the finer one taken off (Richardson)."""
    method = "lie" if "lie" in at.model.steps else "rk4"
    coarse, fine = (
        at.poses(simulate(at.model, list(at.q), list(at.v), at.end, method=method, dt=at.end / n, samples=2).q[-1])
        for n in EXTRAPOLATED
    )
    return np.asarray(fine + (fine - coarse) / 15.0)


def checked(at: Setting, what: str, poses: Callable[[], Array]) -> Setting:
    """With one more reference beside ours."""
    return replace(at, checks=(*at.checks, (what, float(np.abs(poses() - at.right).max()))))
