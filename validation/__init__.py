"""Validation: generated functions against independent simulators, closed forms and first integrals.

    result = symgen.validation.validate("pendulum.scene.yaml")
    print(result.to_text())

The simulators are imported when they are used, never with this module.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symgen.errors import NotSupportedError, ToolError
from symgen.scene.model import Output, Scene
from symgen.validation.result import Refinement, Row, Skip, Trajectory, ValidationResult

if TYPE_CHECKING:
    from symgen.system import System

__all__ = ["Refinement", "Row", "Skip", "Trajectory", "ValidationResult", "validate"]

PEERS = ("pinocchio", "exudyn")
"""Simulators that a scene is compared with unless others are named."""

KNOWN = (*PEERS, "mujoco")
PACKAGES = {"pinocchio": "pin", "exudyn": "exudyn", "mujoco": "mujoco"}
NEEDED = (
    "natural_coordinates",
    "natural_mass_matrix",
    "constraints",
    "constraint_jacobian",
    "velocity_transformation",
    "velocity_transformation_rate",
    "natural_bias_acceleration",
    "mass_matrix",
    "coriolis_matrix",
    "gravity_force",
    "passive_force",
    "bias_force",
    "inverse_dynamics",
    "forward_dynamics",
    "kinetic_energy",
    "potential_energy",
    "integrate",
)
"""What is generated for a validation, whatever the scene asks for; poses of all its bodies and frames besides."""

Progress = Callable[[int, int, str], None]
SEED = 20240
STEPS = 7
DYNAMICS = ("mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics")


def validate(
    scene: Scene | str | Path,
    against: Sequence[str] = PEERS,
    states: int = 1000,
    functions: Any = None,
    progress: Progress | None = None,
    seed: int = SEED,
) -> ValidationResult:
    """Check a scene's functions.

    ``functions`` is an object with one attribute per function (``artifact.load()``); without it they are generated
    and compiled in a temporary folder. ``against`` names simulators; closed forms, first integrals and finite
    differences are always checked. ``states`` random states are compared with Pinocchio.

    Raises `SceneError` on a bad scene, `NotSupportedError` on closed loops, `ToolError` when a simulator or compiler
    is missing.
    """
    unknown = [name for name in against if name not in KNOWN]
    if unknown:
        raise ToolError(f"unknown simulator {unknown[0]}: choose from {', '.join(KNOWN)}")
    if not isinstance(scene, Scene):
        from symgen.scene.load import load

        scene = load(scene)
    if functions is not None:
        return _run(scene, tuple(against), states, functions, progress, seed)
    with tempfile.TemporaryDirectory(prefix="symgen-validate-") as folder:
        if progress is not None:
            progress(0, STEPS, "generate")
        functions = _generate(scene, wanted_outputs(scene), "double", Path(folder))
        result = _run(scene, tuple(against), states, functions, progress, seed)
        if scene.options.precision == "double" or "pinocchio" not in against:
            return result
        single = _generate(scene, _single_outputs(scene), "float", Path(folder))
        rows, skipped = _single_precision(scene, single, states, seed)
        return replace(result, rows=(*result.rows, *rows), skipped=(*result.skipped, *skipped))


def wanted_outputs(scene: Scene) -> tuple[Output, ...]:
    """Every function the checks can use, and every row that the scene asks for by itself."""
    from symgen.validation.compare_products import asked_products

    frames = [body.name for body in scene.bodies] + [frame.name for frame in scene.frames]
    names = [*NEEDED, *(f"frame_pose:{name}" for name in frames)]
    names += [row for output in scene.outputs for row in output.of]
    for _kind, row, frame in asked_products(scene):  # a product is held to its row
        names.append(f"{row}:{frame}" if frame else row)
    if "base_regressor" in names:
        names.append("base_parameters")
    combined = (output for output in scene.outputs if len(output.of) > 1)
    return (*(Output(name.replace(":", "_"), (name,)) for name in dict.fromkeys(names)), *combined)


def _generate(scene: Scene, outputs: tuple[Output, ...], precision: str, folder: Path) -> Any:
    from symgen.generate import generate
    from symgen.system import derive

    options = replace(scene.options, precision=precision, targets=("c",), batch=False)
    system = derive(replace(scene, outputs=outputs, options=options))
    asked = {row for output in scene.outputs for row in output.of}
    possible = tuple(output for output in outputs if asked.issuperset(output.of) or _can(system, output))
    system = replace(system, scene=replace(system.scene, outputs=possible))
    return generate(system.scene, folder / precision, system=system).load()


def _can(system: System, output: Output) -> bool:
    """Not every scene has every row that the checks could use (constraints, with joint origins given at run time)."""
    try:
        system.program(output.name)
    except NotSupportedError:
        return False
    return True


def _single_outputs(scene: Scene) -> tuple[Output, ...]:
    """What is compared in single precision: the dynamics, and rows that the scene asks for and Pinocchio has."""
    from symgen.validation.pinocchio_rows import PEER_ROWS

    asked = [row for output in scene.outputs for row in output.of if row.partition(":")[0] in PEER_ROWS]
    return tuple(Output(name.replace(":", "_"), (name,)) for name in dict.fromkeys((*DYNAMICS, *asked)))


def _single_precision(scene: Scene, functions: Any, states: int, seed: int) -> tuple[list[Row], list[Skip]]:
    """The float functions at the same states; the criterion grows with the unit roundoff, 2⁻²⁴ : 2⁻⁵³."""
    from symgen.validation.compare import compare_with_pinocchio
    from symgen.validation.compare_rows import compare_rows
    from symgen.validation.functions import bind

    bound, loosen = bind(functions, scene), 2.0**29
    rows, skipped = compare_with_pinocchio(scene, bound, states, seed, ", float", loosen)
    return [*rows, *compare_rows(scene, bound, states, seed, ", float", loosen)], skipped


@dataclass
class _Report:
    """Rows as they come, and the progress bar."""

    total: int
    progress: Progress | None
    rows: list[Row] = field(default_factory=list)
    skipped: list[Skip] = field(default_factory=list)
    done: int = 0

    def step(self, what: str) -> None:
        if self.progress is not None:
            self.progress(self.done, self.total, what)
        self.done += 1

    def take(self, rows: Sequence[Row], skipped: Sequence[Skip] = ()) -> None:
        self.rows.extend(rows)
        self.skipped.extend(skipped)


def _run(
    scene: Scene, against: tuple[str, ...], states: int, functions: Any, progress: Progress | None, seed: int
) -> ValidationResult:
    from symgen.validation.closed_forms import closed_form_rows
    from symgen.validation.compare import combined_rows, order_row
    from symgen.validation.differences import check_differences
    from symgen.validation.functions import bind
    from symgen.validation.mechanism import build_mechanism
    from symgen.validation.reference import MotionError

    mechanism = build_mechanism(scene)
    bound = bind(functions, scene)
    report = _Report(STEPS, progress, done=1)
    report.step("Pinocchio")
    if "pinocchio" in against:
        _against_pinocchio(report, scene, bound, states, seed)
    if "mujoco" in against:
        _against_mujoco(report, scene, bound, states, seed)
    report.take([order_row(scene), *combined_rows(scene, bound, seed)])
    report.step("finite differences")
    report.take(*check_differences(mechanism, bound, seed + 1))
    trajectory = None
    try:
        if not bound.has("forward_dynamics"):
            report.take([], [Skip("motions", "needs forward_dynamics")])
        else:
            report.step("closed forms")
            report.take(closed_form_rows(mechanism, bound, seed + 2))
            report.step("first integrals")
            _first_integrals(report, mechanism, bound, seed + 3)
            report.step("Exudyn")
            trajectory = _against_exudyn(report, scene, bound, seed + 4, "exudyn" in against)
    except MotionError as error:
        report.take([Row("motions", "forward_dynamics leads a motion on", math.nan, 0.0, str(error))])
    if progress is not None:
        progress(report.total, report.total, "")
    rows, skipped = tuple(report.rows), tuple(report.skipped)
    used = {name: _version(PACKAGES[name]) for name in against}
    return ValidationResult(scene.name, scene.sha256, against, states, seed, rows, skipped, trajectory, used)


def _against_pinocchio(report: _Report, scene: Scene, bound: Any, states: int, seed: int) -> None:
    import numpy as np

    from symgen.validation.compare import (
        SAME_STATE,
        adapters_agree,
        compare_with_pinocchio,
        snapping_rows,
    )
    from symgen.validation.compare_products import compare_products
    from symgen.validation.compare_rows import compare_rows
    from symgen.validation.functions import Bound, vary_parameters

    report.take(
        [Row(SAME_STATE, "Pinocchio's body poses against plain kinematics", adapters_agree(scene, seed), 1e-12)]
    )
    report.take(*compare_with_pinocchio(scene, bound, states, seed))
    report.take(compare_rows(scene, bound, states, seed))
    report.take(*compare_products(scene, bound, seed))
    if scene.parameters:
        changed, p = vary_parameters(scene, np.random.default_rng(seed))
        again = Bound(bound.functions, p)
        few = max(1, states // 10)
        report.take(*compare_with_pinocchio(changed, again, few, seed, ", other parameters"))
        report.take(compare_rows(changed, again, few, seed, ", other parameters"))
    report.take(snapping_rows(scene, seed))


def _against_mujoco(report: _Report, scene: Scene, bound: Any, states: int, seed: int) -> None:
    import numpy as np

    from symgen.validation.functions import Bound, vary_parameters
    from symgen.validation.mujoco_model import compare_with_mujoco

    report.take(*compare_with_mujoco(scene, bound, states, seed))
    if scene.parameters:
        changed, p = vary_parameters(scene, np.random.default_rng(seed))
        again = Bound(bound.functions, p)
        report.take(*compare_with_mujoco(changed, again, max(1, states // 10), seed, ", other parameters"))


def _first_integrals(report: _Report, mechanism: Any, bound: Any, seed: int) -> None:
    from symgen.validation.invariants import energy_row, momentum_rows
    from symgen.validation.trajectories import choose_motion, start_state

    _end, motion = choose_motion(mechanism, bound, *start_state(mechanism, seed))
    report.take([energy_row(mechanism, motion), *momentum_rows(mechanism, motion)])


def _against_exudyn(report: _Report, scene: Scene, bound: Any, seed: int, wanted: bool) -> Trajectory | None:
    from symgen.validation.trajectories import acceleration_rows, plain_trajectory, trajectory_rows

    if not wanted:
        return plain_trajectory(scene, bound, seed)
    report.take(*acceleration_rows(scene, bound, seed))
    report.step("Exudyn, motions")
    rows, skipped, trajectory = trajectory_rows(scene, bound, seed)
    report.take(rows, skipped)
    return trajectory


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"
