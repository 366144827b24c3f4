"""Every other row of the catalogue against Pinocchio at the same random states: whatever the functions offer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symgen.scene.model import Scene
from symgen.scene.outputs import function_name
from symgen.validation.compare import CONDITION, CRITERION, FLOOR, SAME_STATE, norm, sample_states
from symgen.validation.functions import Bound
from symgen.validation.mechanism import Array, link_poses
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio
from symgen.validation.pinocchio_rows import NEW, PEER_ROWS, State, inertial_force
from symgen.validation.result import Row

DERIVATIVE = 1e-10
"""Relative criterion of derivatives, each output against its own largest entry."""

DERIVATIVES = (
    "inverse_dynamics_derivatives", "forward_dynamics_derivatives", "inverse_dynamics_second_derivatives",
)  # fmt: skip
STATES = {"inverse_dynamics_second_derivatives": 2, **dict.fromkeys(DERIVATIVES[:2], 20)}
"""How many states are compared, at most; 100 of the others."""
OF_FRAMES = ("frame_jacobian", "frame_velocity", "frame_bias_acceleration")


@dataclass(frozen=True)
class Sizes:
    """What a state's numbers are summed from, in the largest entry: a result that cancels is measured against it."""

    mass: float
    inverse: float
    v: float
    a: float
    weight: float
    lever: float

    def forces(self, a: float) -> float:
        return self.mass * (self.v**2 + a) + self.weight

    def of(self, row: str, ports: int) -> tuple[float, ...]:
        """One size per output of a row."""
        by_q, by_v = self.forces(self.a), self.mass * self.v
        match row:
            case "inverse_dynamics_derivatives":
                return by_q, by_v
            case "inverse_dynamics_second_derivatives":
                return by_q, by_v, self.mass, self.mass
            case "joint_wrenches" | "bias_force" | "inverse_dynamics" | "gravity_force" | "passive_force":
                return (by_q,)
            case "regressor":
                return (self.v**2 + self.a + 1.0,)
            case "momentum" | "momentum_matrix":
                return (self.mass * (self.v if row == "momentum" else 1.0),)
            case "frame_velocity":
                return (self.lever * self.v,)
            case "frame_bias_acceleration":
                return (self.lever * self.v**2,)
        return (self.lever,) * ports if row in ("frame_jacobian", "center_of_mass") else (0.0,) * ports


def sizes(peer: Pinocchio, s: State) -> Sizes:
    scene = peer.mechanism.scene
    M = peer.mass_matrix(s.q)
    weight = sum(float(body.mass) for body in scene.bodies) * norm(np.array([float(x) for x in scene.gravity]))
    inverse = float(np.linalg.norm(np.linalg.inv(M), np.inf))
    lever = max([1.0, *(norm(pose.position) for pose in link_poses(peer.mechanism, s.q))])
    return Sizes(float(np.linalg.norm(M, np.inf)), inverse, norm(s.v), norm(s.a), weight, lever)


def growth(row: str, size: Sizes, theirs: tuple[Array, ...], peer: Pinocchio, s: State) -> tuple[float, ...]:
    """How a relative rounding error grows in each output, over `CONDITION`: these rows solve with the mass matrix."""
    if row == "mass_matrix_inverse":
        return (max(1.0, size.mass * size.inverse / CONDITION),)
    if row not in ("forward_dynamics", "forward_dynamics_derivatives"):
        return (1.0,) * len(theirs)
    a = norm(peer.forward_dynamics(s.q, s.v, s.tau))
    loads: tuple[float, ...] = (size.forces(a) + norm(s.tau), size.mass * size.v, 1.0)
    loads = loads[: len(theirs)]
    found = (
        size.inverse * (size.mass * norm(x) + load) / max(norm(x), 1e-300)
        for x, load in zip(theirs, loads, strict=True)
    )
    return tuple(max(1.0, x / CONDITION) for x in found)


@dataclass(frozen=True)
class Difference:
    """The state, and the output of the row, that come nearest to their criterion."""

    value: float
    criterion: float
    note: str

    @property
    def share(self) -> float:
        return self.value / self.criterion if np.isfinite(self.value) else float("inf")


def port_difference(ours: Array, theirs: Array, floor: float) -> float:
    """‖x − x̂‖∞/‖x̂‖∞, not below `FLOOR` of what x̂ is summed from; NaN when x is none."""
    if ours.shape != theirs.shape or not np.all(np.isfinite(ours)):
        return float("nan")
    error, size = norm(ours - theirs), max(norm(theirs), FLOOR * floor)
    return error / size if error else 0.0


def row_difference(peer: Pinocchio, functions: Bound, row: str, frame: str, states: list[State]) -> Difference:
    """One row (of one frame) at every state."""
    name = function_name(f"{row}:{frame}" if frame else row)
    criterion = DERIVATIVE if row in DERIVATIVES else CRITERION
    worst = Difference(0.0, criterion, "")
    for s in states:
        theirs = PEER_ROWS[row](peer, s, frame)
        found = functions.all(name, *(getattr(s, x) for x in functions.inputs(name)))
        ours = found if isinstance(found, tuple) else (found,)
        size = sizes(peer, s)
        floors, grown = size.of(row, len(theirs)), growth(row, size, theirs, peer, s)
        for k, (x, y) in enumerate(zip(ours, theirs, strict=True)):
            value = port_difference(np.asarray(x, dtype=float), y, floors[k])
            note = f"output {k + 1}" if len(theirs) > 1 else ""
            if grown[k] > 1.0:
                note += f"{', ' if note else ''}condition {grown[k] * CONDITION:.1e}"
            if not np.isfinite(value):
                return Difference(value, criterion, f"not a number, or another shape than {y.shape}")
            here = Difference(value, criterion * grown[k], note)
            worst = here if here.share > worst.share else worst
    return worst


def states_of(peer: Pinocchio, count: int, seed: int) -> list[State]:
    return [State(*row) for row in zip(*sample_states(peer.mechanism, count, seed), strict=True)]


def compare_rows(
    scene: Scene, functions: Bound, states: int, seed: int, label: str = "", loosen: float = 1.0
) -> list[Row]:
    """One line for every row beyond the plain dynamics that ``functions`` has; frames are taken together."""
    peer = build_pinocchio(scene)
    source = f"Pinocchio {peer.pin.__version__}"
    drawn = states_of(peer, min(states, 100), seed)
    rows: list[Row] = []
    for row in (row.__name__ for row in NEW):
        names = list(peer.mechanism.frames) if row in OF_FRAMES else [""]
        names = [frame for frame in names if functions.has(function_name(f"{row}:{frame}" if frame else row))]
        if not names:
            continue
        count = min(STATES.get(row, 100), max(1, 200 // len(names)))
        found = {frame: row_difference(peer, functions, row, frame, drawn[:count]) for frame in names}
        frame = max(found, key=lambda name: found[name].share)
        worst = found[frame]
        note = (
            f"{len(names)} frame{'s' * (len(names) > 1)}, worst {frame}; {worst.note}".rstrip("; ")
            if frame
            else worst.note
        )
        rows.append(Row(SAME_STATE, row + label, worst.value, loosen * worst.criterion, note, source))
    rows.extend(base_rows(peer, functions, drawn, label, loosen * CRITERION, source))
    return rows


def base_rows(
    peer: Pinocchio, functions: Bound, states: list[State], label: str, criterion: float, source: str
) -> Iterator[Row]:
    """base_regressor · base_parameters = inverse dynamics without springs, dampers and armature."""
    if not functions.has("base_regressor", "base_parameters"):
        return
    beta = functions("base_parameters")
    worst = 0.0
    for s in states:
        Y, expected = functions("base_regressor", s.q, s.v, s.a), inertial_force(peer, s)
        floor = norm(Y) * norm(beta)
        worst = max(worst, port_difference(Y @ beta, expected, floor))
    note = f"{len(beta)} base parameters of {10 * len(peer.joints)}"
    yield Row(SAME_STATE, "base_regressor · base_parameters" + label, worst, criterion, note, source)
