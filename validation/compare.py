"""The generated functions against Pinocchio at the same random states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from symgen.scene.model import Scene
from symgen.validation.functions import Bound
from symgen.validation.mechanism import Array, Mechanism, build_mechanism, link_poses, order_matches, random_state
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio
from symgen.validation.result import Row, Skip

CRITERION = 1e-12
"""Relative, ‖x − x̂‖∞/‖x̂‖∞, per state."""

FLOOR = 1e-3
"""Where a force cancels to less than this part of the terms it is summed from, it is measured against that part:
the criterion is then 1e-15 of the terms, which is rounding."""

CONDITION = 1e3
"""Forward dynamics is a solve; from this condition number on, the criterion grows in proportion to it."""

SAME_STATE = "same state"


class Peer(Protocol):
    """A simulator's dynamics of a scene, in symgen's coordinates and units."""

    @property
    def mechanism(self) -> Mechanism: ...
    def mass_matrix(self, q: Array) -> Array: ...
    def bias_force(self, q: Array, v: Array) -> Array: ...
    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array: ...
    def forward_dynamics(self, q: Array, v: Array, tau: Array) -> Array: ...


@dataclass(frozen=True)
class Samples:
    """Random states, one per row, and a simulator's answers there."""

    q: Array
    v: Array
    a: Array
    tau: Array
    mass_matrix: Array
    bias_force: Array
    inverse_dynamics: Array
    forward_dynamics: Array
    terms: Array
    """Per state, the size of the terms that forces are summed from."""
    condition: Array
    """Per state, ‖M⁻¹‖ (‖M‖‖a‖ + ‖τ‖ + ‖h‖)/‖a‖: how a relative rounding error grows in forward dynamics."""


def norm(x: Array) -> float:
    """Largest magnitude."""
    return float(np.max(np.abs(x), initial=0.0))


def sample_states(mechanism: Mechanism, count: int, seed: int) -> tuple[Array, Array, Array, Array]:
    """q, v, a, tau with one state per row; the same for the same seed everywhere."""
    rng = np.random.default_rng(seed)
    states = [random_state(mechanism, rng) for _ in range(count)]
    q, v = np.array([s[0] for s in states]), np.array([s[1] for s in states])
    return q, v, rng.uniform(-2.0, 2.0, v.shape), rng.uniform(-2.0, 2.0, v.shape)


def draw(peer: Peer, count: int, seed: int) -> Samples:
    """The peer at ``count`` states."""
    q, v, a, tau = sample_states(peer.mechanism, count, seed)
    scene = peer.mechanism.scene
    weight = sum(float(b.mass) for b in scene.bodies) * float(np.linalg.norm([float(g) for g in scene.gravity]))
    M = np.array([peer.mass_matrix(x) for x in q])
    h = np.array([peer.bias_force(*s) for s in zip(q, v, strict=True)])
    inverse = np.array([peer.inverse_dynamics(*s) for s in zip(q, v, a, strict=True)])
    forward = np.array([peer.forward_dynamics(*s) for s in zip(q, v, tau, strict=True)])
    terms, condition = [], []
    for k in range(count):
        size = float(np.linalg.norm(M[k], np.inf))
        terms.append(size * (norm(v[k]) ** 2 + norm(a[k])) + weight)
        inverse_size = float(np.linalg.norm(np.linalg.inv(M[k]), np.inf))
        loads = size * norm(forward[k]) + norm(tau[k]) + norm(h[k])
        condition.append(inverse_size * loads / max(norm(forward[k]), 1e-300))
    return Samples(q, v, a, tau, M, h, inverse, forward, np.array(terms), np.array(condition))


def compare_with_pinocchio(
    scene: Scene, functions: Bound, states: int, seed: int, label: str = "", loosen: float = 1.0
) -> tuple[list[Row], list[Skip]]:
    """Rows for mass_matrix, bias_force, inverse_dynamics and forward_dynamics.

    ``label`` is appended to the quantities; ``loosen`` multiplies the criterion (single precision: 2²⁹).
    """
    peer = build_pinocchio(scene)
    samples = draw(peer, states, seed)
    source = f"Pinocchio {peer.pin.__version__}"
    rows: list[Row] = []
    skipped: list[Skip] = []
    if not label:
        title = "Pinocchio's CRBA against its RNEA columns"
        rows.append(Row(SAME_STATE, title, crba_check(peer, samples), CRITERION, "", source))
    arguments = {
        "mass_matrix": (samples.q,),
        "bias_force": (samples.q, samples.v),
        "inverse_dynamics": (samples.q, samples.v, samples.a),
        "forward_dynamics": (samples.q, samples.v, samples.tau),
    }
    for name, inputs in arguments.items():
        if not functions.has(name):
            skipped.append(Skip(f"{SAME_STATE}: {name}", "not among the functions"))
            continue
        ours, theirs = functions(name, *inputs), getattr(samples, name)
        rows.append(same_state_row(name, label, ours, theirs, samples, loosen * CRITERION, source))
    rows.extend(kinematics_rows(peer, functions, samples, label, loosen * CRITERION, source))
    return rows, skipped


def crba_check(peer: Pinocchio, samples: Samples) -> float:
    pairs = zip(samples.q[:20], samples.mass_matrix[:20], strict=True)
    return max(norm(M - peer.mass_matrix_by_columns(q)) / norm(M) for q, M in pairs)


def same_state_row(
    name: str, label: str, ours: Array, theirs: Array, samples: Samples, criterion: float, source: str
) -> Row:
    """The state that comes nearest to its criterion."""
    n = len(theirs)
    error = np.abs(ours.reshape(n, -1) - theirs.reshape(n, -1)).max(axis=1)
    size = np.abs(theirs.reshape(n, -1)).max(axis=1)
    allowed, note = np.full(n, criterion), ""
    if name == "forward_dynamics":
        allowed = criterion * np.maximum(1.0, samples.condition / CONDITION)
    elif name != "mass_matrix":
        small = int(np.sum(size < FLOOR * samples.terms))
        size = np.maximum(size, FLOOR * samples.terms)
        note = f"{small} states where it cancels, measured against {FLOOR:g} of its terms" if small else ""
    relative = np.where(error == 0.0, 0.0, error / np.where(size > 0.0, size, 1.0))
    if not np.all(np.isfinite(ours)):
        bad = int(np.sum(~np.isfinite(ours.reshape(n, -1)).all(axis=1)))
        return Row(SAME_STATE, name + label, float("nan"), criterion, f"not a number at {bad} of {n} states", source)
    worst = int(np.argmax(relative / allowed))
    if name == "forward_dynamics" and allowed[worst] > criterion:
        note = f"condition {samples.condition[worst]:.1e} at this state; worst error of all {relative.max():.1e}"
    return Row(SAME_STATE, name + label, float(relative[worst]), float(allowed[worst]), note, source)


def kinematics_rows(
    peer: Pinocchio, functions: Bound, samples: Samples, label: str, criterion: float, source: str
) -> Iterator[Row]:
    """Frame poses and kinetic energy where the functions offer them."""
    few = slice(0, 100)
    q, v = samples.q[few], samples.v[few]
    if functions.has("kinetic_energy"):
        theirs = np.array([0.5 * x @ M @ x for x, M in zip(v, samples.mass_matrix[few], strict=True)])
        ours = functions("kinetic_energy", q, v).reshape(-1)
        yield Row(SAME_STATE, "kinetic_energy" + label, norm((ours - theirs) / theirs), criterion, "½vᵀMv", source)
    frames = [name for name in peer.mechanism.frames if functions.has(f"frame_pose_{name}")]
    if not frames:
        return
    errors = [
        max(pose_error(peer, frame, x, H) for x, H in zip(q, functions(f"frame_pose_{frame}", q), strict=True))
        for frame in frames
    ]
    worst = int(np.argmax(errors))
    note = f"{len(frames)} frames, worst {frames[worst]}; rotation; position per max(1 m, |r|)"
    yield Row(SAME_STATE, "frame_pose" + label, errors[worst], criterion, note, source)


def pose_error(peer: Pinocchio, frame: str, q: Array, H: Array) -> float:
    there = peer.body_pose(q, frame)
    place = norm(H[:3, 3] - there.position) / max(1.0, norm(there.position))
    return max(norm(H[:3, :3] - there.rotation), place, norm(H[3] - np.array([0.0, 0.0, 0.0, 1.0])))


def order_row(scene: Scene) -> Row:
    """Positions and velocities lie where the derivation puts them, body by body and by name."""
    from symgen.topology.tree import build_tree

    bodies = build_tree(scene).bodies
    names, starts = [body.name for body in bodies], [(body.q, body.v) for body in bodies]
    agrees = order_matches(build_mechanism(scene), names, starts)
    note = "depth first, by name"
    return Row(SAME_STATE, "coordinate order differs", 0.0 if agrees else 1.0, 0.0, note, "symgen.topology")


def combined_rows(scene: Scene, functions: Bound, seed: int) -> list[Row]:
    """Functions that join several rows of the catalogue, against the single ones."""
    rows: list[Row] = []
    q, v, a, tau = sample_states(build_mechanism(scene), 20, seed)
    arguments = {"q": q, "v": v, "a": a, "tau": tau, "dt": 0.1}
    for output in scene.outputs:
        parts = [part.replace(":", "_") for part in output.of]
        if len(parts) < 2 or not functions.has(output.name, *parts):
            continue
        if not set(functions.inputs(output.name)) <= set(arguments):
            continue  # directions of derivatives: each product is held to its row by itself
        joined = functions.all(output.name, *(arguments[x] for x in functions.inputs(output.name)))
        single: list[Array] = []
        for part in parts:
            found = functions.all(part, *(arguments[x] for x in functions.inputs(part)))
            single.extend(found if isinstance(found, tuple) else (found,))
        pairs = zip(joined, single, strict=True)
        worst = max(norm(np.asarray(ours) - alone) / max(1.0, norm(alone)) for ours, alone in pairs)
        note = f"{' + '.join(output.of)}, 20 states"
        rows.append(Row("combined functions", output.name, worst, CRITERION, note, "the single functions"))
    return rows


def adapters_agree(scene: Scene, seed: int) -> float:
    """Pinocchio's body poses against this package's own kinematics: guards the adapter itself."""
    peer = build_pinocchio(scene)
    q = sample_states(peer.mechanism, 5, seed)[0]
    worst = 0.0
    for x in q:
        poses = link_poses(peer.mechanism, x)
        for name in peer.mechanism.frames:
            here, there = peer.mechanism.place(name, poses), peer.body_pose(x, name)
            worst = max(worst, norm(here.rotation - there.rotation), norm(here.position - there.position))
    return worst


def snapping_rows(scene: Scene, seed: int) -> list[Row]:
    """What snapping mounting rotations changed, for the record: no criterion can fail here but 'finite'."""
    raw = {
        name: np.array(value, dtype=float) for name, value in scene.raw.items() if np.shape(np.array(value)) == (3, 3)
    }
    if not raw:
        return []
    exact, original = build_pinocchio(scene), build_pinocchio(scene, raw)
    q = sample_states(exact.mechanism, 100, seed)[0]
    moved = max(norm(exact.mass_matrix(x) - original.mass_matrix(x)) / norm(original.mass_matrix(x)) for x in q)
    note = f"{len(raw)} mounting rotations were snapped; every other row uses the snapped scene"
    return [Row("snapping", "mass matrix, snapped scene against the raw file", moved, float("inf"), note, "Pinocchio")]
