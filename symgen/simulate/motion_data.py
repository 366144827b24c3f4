"""A motion to look at: where every body is, many times a second, from a start that shows what the mechanism does.

The start needs nobody to choose it, and is gentle: joints start apart from their least potential energy.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symgen.algebra.numbers import FloatNumbers
from symgen.errors import SceneError
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import Scene
from symgen.simulate.model import Array, Model
from symgen.simulate.motion import Motion
from symgen.simulate.run import simulate
from symgen.simulate.start import Start, choose_start
from symgen.system import System, derive
from symgen.velocity.kinematics import kinematics
from symgen.velocity.values import Values

SECONDS, FRAMES = 10.0, 250
NUMBERS = 48_000
"""Numbers in the data at most: large scenes get fewer frames."""
TURN = 2.0
"""rad that a body may turn between two frames: more, and a viewer would see it turn the other way."""
REACH = 0.8
"""Sizes of the mechanism that a slide may move before the motion ends."""
SMOOTH = 101
"""Frames of short motions, which are shown slowly."""
FEWEST = 0.2
"""Seconds shown at least."""


def motion_data(
    scene: Scene, say: Callable[[str], None], *, seconds: float = SECONDS, frames: int = FRAMES
) -> dict[str, Any]:
    """A motion of the scene without joint forces as JSON data (SI units, ground axes, five digits).

    ``seconds``: how long at most. It is shorter where something slides or flies away, and where bodies turn so fast
    that ``frames`` pictures (at most) would not show it. Keys: ``start`` (in words), ``q0``, ``v0``, ``times``, ``q``,
    ``v``, ``kinetic``, ``potential``, ``monitors``, ``joints``, ``bodies``, and per time the ``poses``:
    x, y, z and the quaternion x, y, z, w of every moving body's frame. Raises NotSupportedError for closed loops,
    ToolError without SciPy or a C compiler.
    """
    if not (math.isfinite(seconds) and seconds > 0.0) or frames < 2:
        raise SceneError("a motion needs a positive time and two frames", "motion")
    system = derive(scene)
    system.require_tree()
    say(f"{scene.name}: compiling for a motion")
    model = Model(scene)
    start = choose_start(system, model, seconds)
    each = 7 * len(system.tree.bodies) + model.nq + model.nv + 3
    frames = max(2, min(frames, NUMBERS // each))
    say(f"{scene.name}: simulating")
    whole = simulate(model, start.q.tolist(), start.v.tolist(), start.seconds, samples=2001)
    end = _end(system, model, whole, start, frames)
    count = max(2, min(frames, max(SMOOTH, math.ceil(_fastest(system, whole, end) * end / TURN) + 1, _a_second(end))))
    motion = whole if end == start.seconds else simulate(model, start.q.tolist(), start.v.tolist(), end, samples=2001)
    return _data(system, model, motion, start, np.linspace(0.0, end, count))


def _end(system: System, model: Model, motion: Motion, start: Start, frames: int) -> float:
    """When what slides has left, or what turns has turned as far as ``frames`` pictures show."""
    end = start.seconds
    for place, per_metre in _slides(system):
        away = np.abs(motion.q[:, place] - motion.q[0, place]) > REACH * start.size / per_metre
        if away.any():
            end = min(end, float(motion.t[int(np.argmax(away))]))
    end = max(end, FEWEST)
    fastest = _fastest(system, motion, end)
    if fastest * end > TURN * (frames - 1):
        end = max(FEWEST, TURN * (frames - 1) / fastest)
    return min(start.seconds, float(f"{end:.2g}"))


def _a_second(end: float) -> int:
    """25 pictures a second."""
    return math.ceil(25 * end) + 1


def _slides(system: System) -> Iterator[tuple[int, float]]:
    """(entry of q, metres per unit) of everything that moves along a line."""
    for body in system.tree.bodies:
        if body.coupling is not None:
            continue
        for k, unit in enumerate(JOINT_TYPES[body.joint.type].q_units):
            if unit == "m":
                yield body.q + k, 1.0
            elif body.joint.type == "helical" and body.joint.pitch:
                yield body.q + k, abs(float(body.joint.pitch))


def _fastest(system: System, motion: Motion, end: float) -> float:
    """The largest angular velocity of a body until ``end``, rad/s (of its joints, added up along the way there)."""
    rows = motion.v[motion.t <= end]
    spin = np.zeros((len(system.tree.bodies), len(rows)))
    for body in system.tree.bodies:
        units = JOINT_TYPES[body.joint.type].v_units
        own = [body.v + k for k, unit in enumerate(units) if unit == "rad/s"]
        factor = abs(float(body.coupling.multiplier)) if body.coupling is not None else 1.0
        if own:
            spin[body.index] = factor * np.linalg.norm(rows[:, own], axis=1)
        if body.parent >= 0:
            spin[body.index] += spin[body.parent]
    return float(np.max(spin)) if spin.size else 0.0


def _quaternion(rotation: Array) -> Array:
    """x, y, z, w of a rotation matrix, by its largest entry (Shepperd)."""
    trace = float(np.trace(rotation))
    squares = np.array([*(1 - trace + 2 * np.diag(rotation)), 1 + trace]) / 4
    k = int(np.argmax(squares))
    largest = math.sqrt(squares[k])
    r = rotation
    rows = {
        0: (4 * squares[0], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]),
        1: (r[0, 1] + r[1, 0], 4 * squares[1], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]),
        2: (r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 4 * squares[2], r[1, 0] - r[0, 1]),
        3: (r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 4 * squares[3]),
    }
    return np.array(rows[k]) / (4 * largest)


@dataclass
class _Poses:
    """Quaternions that follow each other without a jump of sign."""

    system: System
    values: Values
    last: list[Array] = field(default_factory=list)

    def at(self, q: Array) -> list[float]:
        found: list[float] = []
        turns = []
        poses = kinematics(self.system.tree, self.values, [float(x) for x in q]).poses
        for k, pose in enumerate(poses):
            turn = _quaternion(np.array(pose.rotation, dtype=np.float64))
            if self.last and float(turn @ self.last[k]) < 0:
                turn = -turn
            turns.append(turn)
            found += [short(float(x)) for x in (*pose.origin, *turn)]
        self.last = turns
        return found


def short(x: float) -> float:
    """Five digits, and nothing below what shows."""
    return float(f"{x:.5g}") if abs(x) > 1e-7 else 0.0


def _data(system: System, model: Model, motion: Motion, start: Start, times: Array) -> dict[str, Any]:
    q, v = motion.at(times)
    kinetic, potential = model.energies(q, v)
    poses = _Poses(system, Values(system.scene, FloatNumbers(), [float(x) for x in model.p]))
    return {
        "scene": system.scene.name,
        "scene_sha256": system.scene.sha256,
        "start": start.words,
        "q0": [short(x) for x in start.q],
        "v0": [short(x) for x in start.v],
        "method": motion.method,
        "monitors": {
            "energy_drift": float(f"{motion.monitors.energy_drift:.2g}"),
            "quaternion_drift": float(f"{motion.monitors.quaternion_drift:.2g}"),
        },
        "conservative": _conservative(system),
        "joints": [
            {"name": body.joint.name, "type": body.joint.type, "q": [body.q, body.nq], "v": [body.v, body.nv]}
            for body in system.tree.bodies
            if body.coupling is None
        ],
        "bodies": [body.name for body in system.tree.bodies],
        "times": [float(f"{t:.6g}") for t in times],
        "q": [[short(x) for x in row] for row in q.tolist()],
        "v": [[short(x) for x in row] for row in v.tolist()],
        "kinetic": [short(float(x)) for x in kinetic],
        "potential": [short(float(x)) for x in potential],
        "poses": [poses.at(row) for row in q],
    }


def _conservative(system: System) -> bool:
    """Whether nothing takes energy away."""
    scene = system.scene
    damped = any(getattr(force, "damping", 0) for force in scene.forces)
    return not (damped or any(joint.damping for joint in scene.joints))
