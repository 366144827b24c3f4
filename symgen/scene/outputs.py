"""The function catalogue by name: what may be asked for, and what can be made today.

Only names live here; what a function is belongs to the rooms that derive it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.document import clean
from symgen.scene.model import Output, Scene
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
    "kinetic_energy": "kinetic energy",
    "potential_energy": "of gravity and springs, zero at the ground origin",
    "center_of_mass": "centre of mass, ground axes",
    "momentum": "linear, then angular about the centre of mass",
    "frame_pose": "pose of a frame (frame_pose:NAME)",
    "frame_jacobian": "Jacobian of a frame (frame_jacobian:NAME)",
    "frame_velocity": "twist of a frame (frame_velocity:NAME)",
    "regressor": "inverse dynamics as a linear map of inertial parameters",
    "integrate": "a step on the configuration manifold",
    "closure": "closure of the loops",
    "closure_jacobian": "its Jacobian",
    "constrained_forward_dynamics": "accelerations with the loops closed",
}
"""Row of the catalogue → one-line summary."""

OF_A_FRAME = frozenset({"frame_pose", "frame_jacobian", "frame_velocity"})
"""Rows written ROW:FRAME."""

AVAILABLE = frozenset({
    "natural_coordinates", "natural_mass_matrix", "constraints", "constraint_jacobian", "velocity_transformation",
    "velocity_transformation_rate", "natural_bias_acceleration", "mass_matrix", "coriolis_matrix", "gravity_force",
    "passive_force", "bias_force", "inverse_dynamics", "forward_dynamics", "kinetic_energy", "potential_energy",
    "frame_pose", "integrate",
})  # fmt: skip
"""Rows that can be made now."""

_READS = {"inverse_dynamics": "a", "inverse_dynamics_derivatives": "a", "regressor": "a", "forward_dynamics": "tau",
          "forward_dynamics_derivatives": "tau", "constrained_forward_dynamics": "tau"}  # fmt: skip
_GIVES = {"inverse_dynamics": "tau", "forward_dynamics": "a", "constrained_forward_dynamics": "a"}
"""Names that are an argument of one row and the result of another: such rows cannot be one function."""

_SUFFIXES = ("_batch", "_batch_p", "_f32")

DEFAULT_OUTPUTS: tuple[Output, ...] = tuple(
    Output(name, (name,)) for name in CATALOGUE if name in AVAILABLE and name not in OF_A_FRAME
)
"""What an empty ``outputs`` stands for."""


def function_name(row: str) -> str:
    """``frame_pose:tool`` → ``frame_pose_tool``, the name of the function before it is made an identifier."""
    return row.replace(":", "_", 1)


def frame_names(scene: Scene) -> list[str]:
    """What may stand after ``frame_pose:``: every body and every frame of the scene."""
    return [*(body.name for body in scene.bodies), *(frame.name for frame in scene.frames)]


def check_row(row: str, frames: Iterable[str], place: str) -> str:
    """``row``, if the catalogue has it, its frame exists, and it can be made."""
    name, colon, frame = row.partition(":")
    if name not in CATALOGUE:
        raise SceneError(f"unknown output {clean(row)!r}{did_you_mean(name, CATALOGUE)}", place)
    if name in OF_A_FRAME and not frame:
        raise SceneError(f"{name} needs a frame: {name}:NAME", place)
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
            raise SceneError(f"the output {clean(output.name)!r} is asked for twice", place)
        if name in CATALOGUE and output.of != (name,):
            raise SceneError(f"{name!r} is the name of a catalogue function; give the combined one another", place)
        _check_together(output, place)
        seen[name] = output.name


def _check_together(output: Output, place: str) -> None:
    """The rows of one function: none twice, none whose result has the name of another's argument."""
    if len(set(output.of)) < len(output.of):
        twice = next(row for row in output.of if output.of.count(row) > 1)
        raise SceneError(f"{clean(twice)!r} is listed twice in {clean(output.name)!r}", place)
    if output.of != (output.name,) and output.name.endswith(_SUFFIXES):
        raise SceneError(f"{clean(output.name)!r} ends like a form of another function ({', '.join(_SUFFIXES)})", place)
    for row in output.of:
        clash = next((other for other in output.of if _READS.get(other, "") == _GIVES.get(row)), None)
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
