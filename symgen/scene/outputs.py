"""The function catalogue by name: what may be asked for, and what can be made today.

Only names live here; what a function is belongs to the rooms that derive it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.document import clean
from symgen.scene.model import Output, Scene
from symgen.scene.names import identifier
from symgen.scene.schema import did_you_mean

CATALOGUE: dict[str, str] = {
    "natural_coordinates": "points and unit vectors, ground axes",
    "natural_mass_matrix": "constant mass matrix of the natural coordinates",
    "constraints": "constraints of the natural coordinates",
    "constraint_jacobian": "their Jacobian",
    "velocity_transformation": "R with x' = R v",
    "velocity_transformation_rate": "dR/dt",
    "natural_bias_acceleration": "R' v, the natural accelerations when the joint accelerations vanish",
    "mass_matrix": "RᵀMR",
    "mass_matrix_inverse": "inverse of the mass matrix",
    "coriolis_matrix": "RᵀMR'",
    "gravity_force": "gravity, on the left-hand side",
    "passive_force": "springs and dampers, on the left-hand side",
    "bias_force": "Coriolis, centrifugal, gravity and passive forces",
    "inverse_dynamics": "mass_matrix·a + bias_force",
    "forward_dynamics": "accelerations",
    "inverse_dynamics_derivatives": "derivatives of the inverse dynamics",
    "forward_dynamics_derivatives": "derivatives of the forward dynamics",
    "joint_momentum": "momenta of the joints, RᵀMR v, and their rates without tau",
    "kinetic_energy": "kinetic energy",
    "potential_energy": "of gravity and springs, zero at the ground origin",
    "center_of_mass": "centre of mass, ground axes",
    "momentum": "linear, then angular about the centre of mass",
    "momentum_matrix": "momentum as a linear map of the velocities",
    "frame_pose": "pose of a frame (frame_pose:NAME)",
    "frame_jacobian": "Jacobian of a frame (frame_jacobian:NAME)",
    "frame_velocity": "twist of a frame (frame_velocity:NAME)",
    "frame_bias_acceleration": "acceleration of a frame at zero joint acceleration (frame_bias_acceleration:NAME)",
    "regressor": "inverse dynamics as a linear map of inertial parameters",
    "inverse_dynamics_second_derivatives": "second derivatives of the inverse dynamics",
    "base_regressor": "its columns that base parameters stand for",
    "base_parameters": "combinations of inertial parameters that the inverse dynamics can feel",
    "joint_wrenches": "force and moment that each joint transmits to its child",
    "constraint_forces": "multipliers of the constraints of the natural coordinates",
    "integrate": "a step on the configuration manifold",
    "configuration_rate": "dq/dt of the coordinates",
    "step": "q and v after a time step with constant tau (step:METHOD)",
    "closure": "closure of the loops",
    "closure_jacobian": "its Jacobian",
    "constrained_forward_dynamics": "accelerations with the loops closed",
}
"""Row of the catalogue → one-line summary."""

PRODUCTS = {
    "jvp": "change of a row's outputs along given changes of its inputs",
    "vjp": "gradient of a weighted sum of a row's outputs",
    "parameter_jacobian": "derivatives of a row's outputs by the run-time parameters",
}
"""Derivatives of any row, written PRODUCT:ROW."""

NOT_DERIVED = frozenset({
    "integrate", "natural_mass_matrix", "mass_matrix_inverse", "forward_dynamics_derivatives", "constraint_forces",
    "step", "inverse_dynamics_second_derivatives", "base_parameters", *PRODUCTS,
})  # fmt: skip
"""Rows without products."""

OF_A_FRAME = frozenset({"frame_pose", "frame_jacobian", "frame_velocity", "frame_bias_acceleration"})
"""Rows written ROW:FRAME."""

STEPS = ("semi_implicit_euler", "rk4", "lie", "implicit_midpoint", "variational")
"""Methods of steps, written step:METHOD."""

AVAILABLE = frozenset({
    "natural_coordinates", "natural_mass_matrix", "constraints", "constraint_jacobian", "velocity_transformation",
    "velocity_transformation_rate", "natural_bias_acceleration", "mass_matrix", "coriolis_matrix", "gravity_force",
    "passive_force", "bias_force", "inverse_dynamics", "forward_dynamics", "kinetic_energy", "potential_energy",
    "frame_pose", "integrate", "mass_matrix_inverse", "inverse_dynamics_derivatives", "forward_dynamics_derivatives",
    "inverse_dynamics_second_derivatives", "center_of_mass", "momentum", "momentum_matrix", "frame_jacobian",
    "frame_velocity", "frame_bias_acceleration", "regressor", "base_regressor", "base_parameters", "joint_wrenches",
    "constraint_forces", "configuration_rate", "joint_momentum", "step",
})  # fmt: skip
"""Rows that can be made now."""

_READS = {
    "a": frozenset({"inverse_dynamics", "inverse_dynamics_derivatives", "inverse_dynamics_second_derivatives",
                    "regressor", "base_regressor", "joint_wrenches", "constraint_forces"}),
    "tau": frozenset({"forward_dynamics", "forward_dynamics_derivatives", "constrained_forward_dynamics", "step"}),
}  # fmt: skip
_GIVES = {"inverse_dynamics": "tau", "forward_dynamics": "a", "constrained_forward_dynamics": "a"}
"""Names that are an argument of one row and the result of another: such rows cannot be one function."""


def _reads(row: str) -> frozenset[str]:
    name, _, argument = row.partition(":")
    return _reads(argument) if name in PRODUCTS else frozenset(x for x, rows in _READS.items() if name in rows)


def _gives(row: str) -> frozenset[str]:
    return frozenset({_GIVES[row]}) if row in _GIVES else frozenset()


LONGEST = 200
"""Characters of a function's name, which becomes the name of a file too."""

_SUFFIXES = ("_batch", "_batch_p", "_soa", "_f32")

DEFAULT_OUTPUTS: tuple[Output, ...] = tuple(
    Output(name, (name,))
    for name in (
        "natural_coordinates", "natural_mass_matrix", "constraints", "constraint_jacobian", "velocity_transformation",
        "velocity_transformation_rate", "natural_bias_acceleration", "mass_matrix", "coriolis_matrix", "gravity_force",
        "passive_force", "bias_force", "inverse_dynamics", "forward_dynamics", "kinetic_energy", "potential_energy",
        "integrate",
    )
)  # fmt: skip
"""What an empty ``outputs`` stands for."""


def function_name(row: str) -> str:
    """``frame_pose:tool`` → ``frame_pose_tool``: an identifier, whatever the frame is called.

    A frame whose name is none is told from others by six digits of its hash: ``frame_pose:tool tip`` →
    ``frame_pose_tool_tip_8a5d74``, the same in every scene.
    """
    product, _, argument = row.partition(":")
    if product in PRODUCTS:
        return f"{product}_{function_name(argument)}"
    name = row.replace(":", "_", 1)
    if len(name) <= LONGEST and name.isascii() and name.isidentifier():
        return name
    digits = hashlib.sha256(row.encode("utf-8", "surrogatepass")).hexdigest()[:6]
    return f"{identifier(name, LONGEST - 7).rstrip('_')}_{digits}"


def frame_names(scene: Scene) -> list[str]:
    """What may stand after ``frame_pose:``: every body and every frame of the scene."""
    return [*(body.name for body in scene.bodies), *(frame.name for frame in scene.frames)]


def check_row(row: str, frames: Iterable[str], place: str) -> str:
    """``row``, if the catalogue has it, its frame exists, and it can be made."""
    name, colon, frame = row.partition(":")
    if name in PRODUCTS:
        if not frame:
            raise SceneError(f"{name} needs a row: {name}:ROW", place)
        if frame.partition(":")[0] in NOT_DERIVED:
            raise SceneError(f"{name} is not available for {clean(frame)!r}", place)
        check_row(frame, frames, place)
        return row
    if name not in CATALOGUE:
        raise SceneError(f"unknown output {clean(row)!r}{did_you_mean(name, [*CATALOGUE, *PRODUCTS])}", place)
    if name in OF_A_FRAME and not frame:
        raise SceneError(f"{name} needs a frame: {name}:NAME", place)
    if name == "step":
        if frame not in STEPS:
            known_methods = f"step needs a method: {', '.join(f'step:{method}' for method in STEPS)}"
            raise SceneError(f"{known_methods}{did_you_mean(frame, STEPS) if frame else ''}", place)
        return row
    if colon and name not in OF_A_FRAME:
        raise SceneError(f"{name} takes no frame; write {name!r}", place)
    known = list(frames)
    if frame and frame not in known:
        raise SceneError(f"unknown frame {clean(frame)!r} in {name}{did_you_mean(frame, known)}", place)
    if name not in AVAILABLE:
        raise NotSupportedError(f"{place}: {name} is not available yet")
    return row


def check_outputs(outputs: Sequence[Output], frames: Sequence[str], places: Sequence[str]) -> None:
    """Every row known, no function twice, no two outputs of one function under one name."""
    seen: dict[str, str] = {}
    for output, place in zip(outputs, places, strict=True):
        for row in output.of:
            check_row(row, frames, place)
        name = function_name(output.name)
        if name in seen:
            both = f"{clean(output.name)!r} and {clean(seen[name])!r} would both be the function {clean(name)}"
            both += "; give one a name: {name: …, of: […]}"
            twice = f"the output {clean(output.name)!r} is asked for twice"
            raise SceneError(twice if seen[name] == output.name else both, place)
        if name in CATALOGUE and output.of != (name,):
            raise SceneError(f"{name!r} is the name of a catalogue function; give the combined one another", place)
        _check_together(output, place)
        seen[name] = output.name


def _check_together(output: Output, place: str) -> None:
    """The rows of one function: none twice, none whose result has the name of another's argument."""
    if len(set(output.of)) < len(output.of):
        twice = next(row for row in output.of if output.of.count(row) > 1)
        raise SceneError(f"{clean(twice)!r} is listed twice in {clean(output.name)!r}", place)
    step = next((row for row in output.of if row.startswith("step:")), None)
    if step is not None and (len(output.of) > 1 or output.name != step):
        raise SceneError(
            f"{clean(step)} is a function of its own: it calls others, and shares no work with them", place
        )
    if output.of != (output.name,) and output.name.endswith(_SUFFIXES):
        raise SceneError(f"{clean(output.name)!r} ends like a form of another function ({', '.join(_SUFFIXES)})", place)
    weighted = [row.partition(":")[2].partition(":")[0] for row in output.of if row.startswith("vjp:")]
    if len(set(weighted)) < len(weighted):
        raise SceneError(f"{clean(output.name)!r}: these products would share one argument of weights", place)
    for row in output.of:
        clash = next((other for other in output.of if _reads(other) & _gives(row)), None)
        if clash is not None:
            raise SceneError(
                f"{row} and {clash} cannot share a function: {_GIVES[row]!r} is a result of one and an argument of the "
                "other",
                place,
            )


def parse_outputs(text: str) -> tuple[Output, ...]:
    """The command line's form: ``mass_matrix,dynamics=mass_matrix+bias_force``. Names are checked later."""
    outputs = []
    for item in text.split(","):
        name, equals, rows = (part.strip() for part in item.partition("="))
        of = tuple(row.strip() for row in rows.split("+")) if equals else (name,)
        if not name or not all(of):
            raise SceneError(f"{clean(item)!r} is no output; write NAME or NAME=ROW+ROW", "--outputs")
        if equals and not (name.isidentifier() and name.isascii()):
            raise SceneError(f"{clean(name)!r} is no identifier", "--outputs")
        outputs.append(Output(name, of))
    return tuple(outputs)
