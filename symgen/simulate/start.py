"""Where a motion to look at starts: near rest where a mechanism hangs, turning where it does not, thrown where it
falls.

Rules, in this order:

* Joints are put where the potential energy of gravity and springs is least within their limits, and then turned (or
  drawn out) away from there, this way and that, within their limits.
* Angles on which the potential energy does not depend turn at `SPIN`.
* A ball joint whose body stands on it spins faster than the sleeping top must; one whose body hangs swings and turns.
* A free body tumbles about its middle principal axis, nearly.
* What falls, slides or climbs is thrown against its acceleration, as far as it would come back under that alone.
"""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symgen.errors import ToolError
from symgen.scene.joints import JOINT_TYPES
from symgen.simulate.model import Array, Model
from symgen.system import System
from symgen.topology.tree import TreeBody

SPIN = 0.8
"""rad/s."""
TUMBLE = 2.5
"""rad/s of a free body, at least."""
TILT = 0.4
"""rad that a ball joint starts turned about x."""
TOP = 1.5
"""Times the spin that keeps a top asleep."""
FALL = 5.0
"""A throw lasts sqrt(FALL · size / acceleration): it goes 0.6 sizes far."""
FLAT = 1e-9
"""A potential that changes by less than this part of its scale does not depend on a coordinate."""


@dataclass(frozen=True)
class Start:
    q: Array
    v: Array
    seconds: float
    size: float
    """Length of the mechanism, m."""
    words: str


@dataclass(frozen=True)
class _Coordinate:
    """An angle or a slide with an entry of its own in q and v."""

    q: int
    v: int
    metres: float
    """Per unit where it slides or climbs, else 0."""
    low: float
    high: float


@dataclass
class _Chooser:
    system: System
    model: Model
    size: float
    q: Array
    v: Array
    said: list[str] = field(default_factory=list)

    def potential(self, q: Array) -> float:
        return float(self.model.energies(q[None, :], np.zeros((1, self.model.nv)))[1][0])

    def depends(self, place: int, by: float) -> bool:
        """Whether the potential energy changes with an entry of q."""
        values = []
        for shift in (0.0, 0.5 * by, by, -by):
            moved = self.q.copy()
            moved[place] += shift
            values.append(self.potential(moved))
        return max(values) - min(values) > FLAT * max(1e-3, *(abs(x) for x in values))


def choose_start(system: System, model: Model, seconds: float) -> Start:
    """The start of a motion of at most ``seconds``. Raises ToolError without SciPy."""
    state = model.start(None, None)
    size = _size(system)
    chooser = _Chooser(system, model, size, state[: model.nq].copy(), state[model.nq :].copy())
    for body in _own(system, ("spherical", "floating")):
        _ball(chooser, body)
    coordinates = [one for body in _own(system) for one in _coordinates(body, size)]
    _hang(chooser, coordinates)
    _displace(chooser, coordinates)
    seconds = _throw(chooser, coordinates, seconds)
    for body in _own(system, ("floating",)):
        _tumble(chooser, body, seconds)
    return Start(chooser.q, chooser.v, seconds, size, " ".join(dict.fromkeys(chooser.said)))


def _own(system: System, types: tuple[str, ...] = ()) -> list[TreeBody]:
    """Bodies whose joints have coordinates of their own, of these types."""
    return [b for b in system.tree.bodies if b.coupling is None and (not types or b.joint.type in types)]


def _size(system: System) -> float:
    """The longest way from the root of the tree to a centre of mass, or the size of the largest body, m."""
    reach: list[float] = []
    for body in system.tree.bodies:
        above = reach[body.parent] if body.parent >= 0 else 0.0
        free = body.parent < 0
        reach.append(above + (0.0 if free else math.dist((0, 0, 0), [float(x) for x in body.joint.origin.translation])))
    sizes = [0.01]
    for body in system.tree.bodies:
        for part, place in body.parts:
            com = [float(x) for x in part.com]
            far = math.dist((0, 0, 0), com) + math.dist((0, 0, 0), [float(x) for x in place.translation])
            gyration = math.sqrt(max(0.0, sum(float(x) for x in part.inertia[:3])) / (float(part.mass) or 1.0))
            sizes.append(reach[body.index] + far + gyration)
    return max(sizes)


def _coordinates(body: TreeBody, size: float) -> list[_Coordinate]:
    """Angles and slides of a joint; none of ball joints and free bodies."""
    joint = body.joint
    if joint.type in ("spherical", "floating"):
        return []
    limits = dict(joint.limits)
    found = []
    for k, unit in enumerate(JOINT_TYPES[joint.type].q_units):
        metres = 1.0 if unit == "m" else abs(float(joint.pitch or 0)) if joint.type == "helical" else 0.0
        reach = size / metres if metres else math.inf
        low, high = (limits.get(name, sign * math.inf) for name, sign in (("lower", -1), ("upper", 1)))
        single = JOINT_TYPES[joint.type].nq == 1
        low, high = (max(low, -reach), min(high, reach)) if single and low < high else (-reach, reach)
        found.append(_Coordinate(body.q + k, body.v + k, metres, low, high))
    return found


def _hang(chooser: _Chooser, coordinates: list[_Coordinate]) -> None:
    """The least potential energy, from q = 0 (or the middle of the limits where 0 is outside)."""
    try:
        optimize: Any = importlib.import_module("scipy.optimize")
    except ImportError as error:
        raise ToolError("SciPy is not installed: pip install 'symgen[validation]'") from error
    for one in coordinates:
        chooser.q[one.q] = 0.0 if one.low <= 0.0 <= one.high else (one.low + one.high) / 2
    if not coordinates:
        return
    places = [one.q for one in coordinates]
    here = chooser.q.copy()
    if _changes(chooser, coordinates):
        # Off any balance: a pole that stands straight up would stay there.
        here[places] += [0.05 * _step(one, k) for k, one in enumerate(coordinates)]

        def energy(x: Array) -> float:
            q = here.copy()
            q[places] = x
            return chooser.potential(q)

        bounds = [(one.low, one.high) for one in coordinates]
        found = optimize.minimize(energy, here[places], method="L-BFGS-B", bounds=bounds, options={"maxiter": 500})
        here[places] = [_round(float(x)) for x in found.x]
    for one in coordinates:
        stops = one.metres and min(here[one.q] - one.low, one.high - here[one.q]) < 0.02 * (one.high - one.low)
        free = not chooser.depends(one.q, _step(one, 0))
        chooser.q[one.q] = chooser.q[one.q] if stops or free else here[one.q]


def _changes(chooser: _Chooser, coordinates: list[_Coordinate]) -> bool:
    return any(chooser.depends(one.q, _step(one, 0)) for one in coordinates)


def _round(x: float) -> float:
    return round(x, 3) + 0.0


def _step(one: _Coordinate, k: int) -> float:
    """How far a coordinate is moved away from rest: this way and that."""
    return (1.0 if k % 2 == 0 else -0.7) * (1.0 if not one.metres else 0.25 * min(one.high, 1e9))


def _held(chooser: _Chooser, one: _Coordinate) -> bool:
    """Whether something brings a coordinate back: an angle on which gravity acts, a slide on a spring."""
    if not one.metres:
        return chooser.depends(one.q, 1.0)
    moved = []
    for shift in (-0.02, 0.0, 0.02):
        q = chooser.q.copy()
        q[one.q] += shift * (one.high - one.low)
        moved.append(chooser.potential(q))
    return moved[0] > moved[1] < moved[2] or moved[0] - 2 * moved[1] + moved[2] > 1e-6 * max(map(abs, moved))


def _displace(chooser: _Chooser, coordinates: list[_Coordinate]) -> None:
    held = [one for one in coordinates if _held(chooser, one)]
    said = _let_go(chooser, held)
    angle = 1.1 / math.sqrt(max(1, len(held)))
    for k, one in enumerate(held):
        moved = chooser.q[one.q] + (angle if not one.metres else 1.0) * _step(one, k)
        room = 0.05 * (one.high - one.low) if math.isfinite(one.high - one.low) else 0.0
        chooser.q[one.q] = _round(min(max(moved, one.low + room), one.high - room))
    turning = [one for one in coordinates if one not in held and not one.metres]
    for k, one in enumerate(turning):
        chooser.v[one.v] = SPIN * (1.0 if k % 2 == 0 else -0.7)
    if held:
        chooser.said.append(said)
    if turning:
        chooser.said.append(f"What no force holds back turns at {SPIN} rad/s at first.")


def _let_go(chooser: _Chooser, held: list[_Coordinate]) -> str:
    """What is said of the start: a place where limits hold a joint is not one where it hangs at rest."""
    close = 2e-3  # coordinates at rest are rounded to three digits
    names = [body.joint.name for one in held for body in _own(chooser.system) if body.q <= one.q < body.q + body.nq]
    limited = {
        name for name, one in zip(names, held, strict=True)
        if not one.metres and min(chooser.q[one.q] - one.low, one.high - chooser.q[one.q]) < close
    }  # fmt: skip
    if not limited:
        return "The joints are let go away from where they would hang at rest."
    names = [name for name in dict.fromkeys(names) if name in limited]
    there = f"{', '.join(names[:-1])} and {names[-1]} are at a limit" if len(names) > 1 else f"{names[0]} is at a limit"
    text = "The joints are let go away from where their potential energy is least within their limits"
    return f"{text} ({there} there; the equations have no stops, so the motion may go beyond)."


def _throw(chooser: _Chooser, coordinates: list[_Coordinate], seconds: float) -> float:
    """Velocities against what accelerates slides and free bodies, and how long it takes until they are back."""
    model = chooser.model
    given = {"p": model.p} if model.p.size else {}
    a = np.asarray(model.functions.forward_dynamics(chooser.q, 0 * chooser.v, 0 * chooser.v, **given)).ravel()
    falling = [one for one in coordinates if one.metres and chooser.depends(one.q, _step(one, 0))]
    loose = [(one.v, one.metres) for one in falling if not _held(chooser, one)]
    loose += [(body.v + k, 1.0) for body in _own(chooser.system, ("floating",)) for k in range(3)]
    fastest = max((abs(a[place]) * metres for place, metres in loose), default=0.0)
    if fastest < 1e-2 * chooser.size:
        return seconds
    seconds = min(seconds, float(f"{math.sqrt(FALL * chooser.size / fastest):.2g}"))
    for place, _ in loose:
        chooser.v[place] = float(f"{-a[place] * seconds / 2:.3g}")
    chooser.said.append("What falls or slides is thrown against its fall.")
    return seconds


def _ball(chooser: _Chooser, body: TreeBody) -> None:
    """A ball joint: a spinning top where its body stands on it, else a pendulum that also turns."""
    if body.joint.type != "spherical":
        return
    quaternion = slice(body.q, body.q + 4)
    upright, upside = chooser.q.copy(), chooser.q.copy()
    upside[quaternion] = (1.0, 0.0, 0.0, 0.0)
    difference = chooser.potential(upright) - chooser.potential(upside)
    chooser.q[quaternion] = (math.sin(TILT / 2), 0.0, 0.0, math.cos(TILT / 2))
    part = body.parts[0][0]
    com = np.array([float(x) for x in part.com])
    far = float(np.linalg.norm(com))
    if difference > 0 and far > 0 and not chooser.system.tree.children[body.index]:
        axis, inertia = com / far, _inertia(body)
        own = float(axis @ inertia @ axis)
        across = (float(np.trace(inertia)) - own) / 2 + float(part.mass) * far * far
        spin = TOP * 2 * math.sqrt(across * difference / 2) / own if own > 0 else 0.0
        if spin > 0:
            chooser.v[body.v : body.v + 3] = [float(f"{spin * x:.3g}") for x in axis]
            chooser.said.append(f"The top spins {TOP} times as fast as it must to sleep, tilted by {TILT} rad.")
            return
    chooser.v[body.v : body.v + 3] = (0.0, 1.2, 0.5) if far else (0.2, 1.2, 0.1)
    chooser.said.append(f"The ball joint starts tilted by {TILT} rad, turning across and about itself.")


def _inertia(body: TreeBody) -> Array:
    xx, yy, zz, xy, xz, yz = (float(x) for x in body.parts[0][0].inertia)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _tumble(chooser: _Chooser, body: TreeBody, seconds: float) -> None:
    """About the middle principal axis, a few hundredths off it."""
    axes = np.linalg.eigh(_inertia(body))[1]
    spin = max(TUMBLE, math.pi / seconds)
    omega = spin * (axes[:, 1] * _sign(axes[:, 1]) + 0.04 * axes[:, 0] * _sign(axes[:, 0]))
    chooser.v[body.v + 3 : body.v + 6] = [float(f"{x:.3g}") + 0.0 for x in omega]
    chooser.said.append("The free body tumbles about nearly its middle principal axis.")


def _sign(axis: Array) -> float:
    return 1.0 if axis[int(np.argmax(np.abs(axis)))] > 0 else -1.0
