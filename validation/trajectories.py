"""Motions and initial accelerations against Exudyn: minimal coordinates and redundant DAE."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from symgen.errors import NotSupportedError, ToolError
from symgen.scene.model import Scene
from symgen.validation import exudyn_bodies, exudyn_tree
from symgen.validation.compare import CONDITION, norm, sample_states
from symgen.validation.exudyn_model import Model, import_exudyn
from symgen.validation.functions import Bound
from symgen.validation.mechanism import Array, Mechanism, Pose, build_mechanism, link_accelerations, rotation_of
from symgen.validation.reference import Motion, integrate_motion
from symgen.validation.result import Refinement, Row, Skip, Trajectory

EXTRAPOLATED = 1e-10
"""m and entries of rotation matrices, absolute."""
TREE_ACCELERATION, BODIES_ACCELERATION = 1e-12, 1e-9
ORDER_SLACK = 0.5
SEGMENTS = 4
STATES = 5
FASTEST = 25.0
"""rad/s or m/s: motions that stay below are compared over their whole second."""
NOISE = 1e-11
"""Differences between runs below this say nothing about the order."""

TREE, BODIES = "kinematic tree", "redundant bodies"


@dataclass(frozen=True)
class Formulation:
    """One way of modelling a scene in Exudyn, with the solver that suits it."""

    name: str
    solver: str
    order: int
    """Order of the solver; errors of the trapezoidal rule are even in h, of RK44 they are not."""
    build: Callable[[Array, Array], Model]
    refusal: str
    steps: int
    """Of the coarsest run, per second."""
    least: int
    most: int
    """Runs at least and at most, each with half the step of the one before."""


def formulations(scene: Scene) -> tuple[Formulation, ...]:
    """Both formulations; with a helical joint the tree is itself a constrained system and is solved as one."""

    def tree(q: Array, v: Array) -> Model:
        return exudyn_tree.build_exudyn_tree(scene, q, v).model

    def bodies(q: Array, v: Array) -> Model:
        return exudyn_bodies.build_exudyn_bodies(scene, q, v)

    constrained = any(joint.type == "helical" for joint in scene.joints)
    solver, order = ("TrapezoidalIndex2", 2) if constrained else ("RK44", 4)
    return (
        Formulation(TREE, solver, order, tree, exudyn_tree.refusal(scene), 64 if order == 4 else 256, 4, 7),
        Formulation(BODIES, "TrapezoidalIndex2", 2, bodies, exudyn_bodies.refusal(scene), 256, 3, 6),
    )


def acceleration_rows(scene: Scene, functions: Bound, seed: int) -> tuple[list[Row], list[Skip]]:
    """Mass matrix and accelerations at t = 0 from both formulations at a few random states."""
    mechanism = build_mechanism(scene)
    source = f"Exudyn {import_exudyn().config.Version()}"
    rows: list[Row] = []
    skipped: list[Skip] = []
    states = list(zip(*sample_states(mechanism, STATES, seed), strict=True))
    if exudyn_tree.refusal(scene):
        skipped.append(Skip(f"Exudyn {TREE}: accelerations", exudyn_tree.refusal(scene)))
    else:
        rows.extend(tree_rows(scene, functions, states, f"{source}, {TREE}"))
    if exudyn_bodies.refusal(scene):
        skipped.append(Skip(f"Exudyn {BODIES}: accelerations", exudyn_bodies.refusal(scene)))
    else:
        worst = 0.0
        for q, v, _a, _tau in states:
            a = functions("forward_dynamics", q, v, np.zeros(mechanism.nv))
            links = link_accelerations(mechanism, q, v, a)
            ours = np.concatenate([np.concatenate([x.linear, x.angular]) for x in links])
            model = exudyn_bodies.build_exudyn_bodies(scene, q, v)
            theirs = model.link_acceleration(model.terms().accelerations())
            worst = max(worst, norm(ours - theirs) / max(norm(theirs), 1e-3))
        note = "own KKT solve of Exudyn's M, f, C; bodies' accelerations"
        rows.append(Row("t = 0", f"accelerations, {BODIES}", worst, BODIES_ACCELERATION, note, f"{source}, {BODIES}"))
    return rows, skipped


def tree_rows(scene: Scene, functions: Bound, states: list[Any], source: str) -> list[Row]:
    mass, pairs = 0.0, []
    for q, v, _a, tau in states:
        tree = exudyn_tree.build_exudyn_tree(scene, q, v, tau)
        M = tree.mass_matrix()
        mass = max(mass, norm(functions("mass_matrix", q) - M) / norm(M)) if functions.has("mass_matrix") else mass
        theirs, ours = tree.accelerations(), functions("forward_dynamics", q, v, tau)
        inverse = float(np.linalg.norm(np.linalg.inv(M), np.inf))
        loads = float(np.linalg.norm(M, np.inf)) * norm(theirs) + 2.0 * norm(tau - M @ theirs) + norm(tau)
        size = max(norm(theirs), 1e-300)
        allowed = TREE_ACCELERATION * max(1.0, inverse * loads / size / CONDITION)
        error = norm(ours - theirs)
        pairs.append((error / size if error else 0.0, allowed))
    value, criterion = max(pairs, key=lambda pair: pair[0] / pair[1])
    note = (
        f"random loads; condition {criterion / TREE_ACCELERATION * CONDITION:.1e}"
        if criterion > 1e-12
        else "random loads"
    )
    rows = [Row("t = 0", f"accelerations, {TREE}", value, criterion, note, source)]
    if functions.has("mass_matrix"):
        rows.append(Row("t = 0", f"mass matrix, {TREE}", mass, TREE_ACCELERATION, "", source))
    return rows


def start_state(mechanism: Mechanism, seed: int) -> tuple[Array, Array]:
    """A generic, moderate start: angles within ±0.6 rad, displacements within ±0.2 m, velocities within ±1."""
    q, v, _a, _tau = sample_states(mechanism, 1, seed)
    start, units = q[0].copy(), 0.2
    for link in mechanism.links:
        if link.joint.type not in ("spherical", "floating") and link.coupling is None:
            start[link.q] *= units
    return start, 0.5 * v[0]


def tilt(mechanism: Mechanism, motion: Motion) -> float:
    """Largest |sin| of the middle angle by which the kinematic tree turns a spherical or floating joint."""
    worst = 0.0
    kind = mechanism.scene.options.base_velocity
    for link in mechanism.links:
        if link.joint.type in ("spherical", "floating"):
            start = exudyn_tree.unfold(link, motion.q[0][link.q], motion.v[0][link.v], kind)
            C = np.column_stack([piece.axis for piece in start.pieces[-3:]])
            first = rotation_of(motion.q[0][link.q][-4:])
            for q in motion.q:
                turn = C.T @ first.T @ rotation_of(q[link.q][-4:]) @ C
                worst = max(worst, abs(float(turn[0, 2])))
    return worst


def choose_motion(mechanism: Mechanism, functions: Bound, q: Array, v: Array) -> tuple[float, Motion]:
    """The longest of 1, ½, ¼, ⅛ s without violence (a falling arm whips), in which the kinematic tree's angles
    stay away from their singularity."""
    for end in (1.0, 0.5, 0.25, 0.125):
        motion = integrate_motion(mechanism, functions, q, v, end, SEGMENTS)
        if norm(motion.v) <= FASTEST and tilt(mechanism, motion) < 0.95:
            break
    return end, motion


def flat(poses: list[list[Pose]]) -> Array:
    """All positions and rotation matrices in one row."""
    return np.concatenate([np.append(x.rotation.ravel(), x.position) for row in poses for x in row])


def extrapolate(runs: list[Array], order: int) -> Array:
    """Richardson's limit of the three finest runs: h², h⁴ for the even rule of order 2, else h^p, h^(p+1)."""
    powers = (order, order + (2 if order == 2 else 1))
    rows = runs[-3:]
    for power in powers[: len(rows) - 1]:
        rows = [fine + (fine - coarse) / (2.0**power - 1.0) for coarse, fine in pairwise(rows)]
    return rows[-1]


def observed_order(runs: list[Array]) -> float:
    """log₂ of the ratio of the differences of successive runs, of the finest ones above rounding; NaN when none is."""
    differences = [norm(fine - coarse) for coarse, fine in pairwise(runs)]
    orders = [math.log2(a / b) for a, b in pairwise(differences) if b > NOISE]
    return orders[-1] if orders else math.nan


def refine(formulation: Formulation, q: Array, v: Array, end: float, reference: Array) -> Refinement:
    """Halve the step until the extrapolated run meets the criterion or the levels are used up."""
    runs: list[Array] = []
    counts: list[int] = []
    left = math.inf
    for level in range(formulation.most):
        counts.append(max(SEGMENTS, round(formulation.steps * end)) * 2**level)
        model = formulation.build(q, v)
        runs.append(flat(model.simulate(counts[-1], end, SEGMENTS, formulation.solver)))
        left = norm(extrapolate(runs, formulation.order) - reference)
        if len(runs) >= formulation.least and left <= EXTRAPOLATED / 3.0:
            break
    return Refinement(
        formulation.name,
        formulation.solver,
        tuple(end / count for count in counts),
        tuple(norm(run - reference) for run in runs),
        observed_order(runs),
        left,
        formulation.order,
    )


def refinement_rows(refinement: Refinement, source: str) -> list[Row]:
    name = f"{refinement.formulation}, {refinement.solver}"
    finest = f"h = {refinement.steps[-1]:.2g} s alone: {refinement.errors[-1]:.1e}"
    rows = [Row("trajectory", f"{name}: extrapolated error", refinement.extrapolated, EXTRAPOLATED, finest, source)]
    if math.isfinite(refinement.order):
        lack = refinement.expected_order - refinement.order
        note = f"observed {refinement.order:.2f}, expected {refinement.expected_order}"
        rows.append(
            Row("trajectory", f"{name}: how far the observed order falls short", lack, ORDER_SLACK, note, source)
        )
    return rows


def trajectory_rows(scene: Scene, functions: Bound, seed: int) -> tuple[list[Row], list[Skip], Trajectory]:
    """The motion from a generic start against both formulations."""
    mechanism = build_mechanism(scene)
    source = f"Exudyn {import_exudyn().config.Version()}"
    q, v = start_state(mechanism, seed)
    end, motion = choose_motion(mechanism, functions, q, v)
    reference = flat(motion.poses(mechanism))
    rows: list[Row] = []
    skipped: list[Skip] = []
    refinements: list[Refinement] = []
    for formulation in formulations(scene):
        title = f"Exudyn {formulation.name}: trajectory"
        if formulation.refusal:
            skipped.append(Skip(title, formulation.refusal))
            continue
        try:
            refinements.append(refine(formulation, q, v, end, reference))
        except (ToolError, NotSupportedError) as error:
            rows.append(Row("trajectory", formulation.name, math.nan, EXTRAPOLATED, str(error), source))
            continue
        rows.extend(refinement_rows(refinements[-1], source))
    return rows, skipped, as_trajectory(mechanism, functions, motion, tuple(refinements))


def plain_trajectory(scene: Scene, functions: Bound, seed: int) -> Trajectory:
    """The same motion without a simulator beside it."""
    mechanism = build_mechanism(scene)
    _end, motion = choose_motion(mechanism, functions, *start_state(mechanism, seed))
    return as_trajectory(mechanism, functions, motion, ())


def coordinate_names(mechanism: Mechanism) -> tuple[str, ...]:
    names: list[str] = []
    parts = {"planar": ("x", "y", "angle"), "cylindrical": ("angle", "slide"), "universal": ("1", "2")}
    quaternion = ("qx", "qy", "qz", "qw")
    parts |= {"spherical": quaternion, "floating": ("x", "y", "z", *quaternion)}
    for link in mechanism.links:
        if link.coupling is not None:
            continue
        suffixes = parts.get(link.joint.type, ())
        names.extend([f"{link.joint.name}.{suffix}" for suffix in suffixes] or [link.joint.name])
    return tuple(names)


def as_trajectory(
    mechanism: Mechanism, functions: Bound, motion: Motion, refinements: tuple[Refinement, ...]
) -> Trajectory:
    energy: tuple[float, ...] = ()
    if functions.has("kinetic_energy", "potential_energy"):
        total = (
            functions("kinetic_energy", motion.q, motion.v).ravel() + functions("potential_energy", motion.q).ravel()
        )
        energy = tuple(float(x) for x in total)
    return Trajectory(
        tuple(motion.q[0].tolist()),
        tuple(motion.v[0].tolist()),
        tuple(motion.t.tolist()),
        tuple(tuple(row) for row in motion.q.tolist()),
        energy,
        coordinate_names(mechanism),
        refinements,
    )
