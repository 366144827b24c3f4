"""Functions of the catalogue made from Pinocchio: the validation can be tried before, and without, generated code."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from symgen.scene.model import Scene
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio
from symgen.validation.pinocchio_rows import PEER_ROWS, State


class PeerFunctions:
    """mass_matrix, bias_force, … of ``scene`` on (n,) or (N, n) arrays."""

    NAMES = ("mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics", "gravity_force", "passive_force")

    def __init__(self, scene: Scene) -> None:
        peer = build_pinocchio(scene)
        for name in self.NAMES:
            setattr(self, name, batched(getattr(peer, name)))

        def kinetic_energy(q: Any, v: Any) -> Any:
            return np.asarray(0.5 * v @ peer.mass_matrix(q) @ v)

        self.kinetic_energy = batched(kinetic_energy)
        for row, inputs in ROWS.items():
            frames = list(peer.mechanism.frames) if row.startswith("frame_") else [""]
            for frame in frames:
                setattr(self, f"{row}_{frame}" if frame else row, of_peer(peer, row, frame, inputs))


ROWS = {
    "mass_matrix_inverse": ("q",), "inverse_dynamics_derivatives": ("q", "v", "a"),
    "forward_dynamics_derivatives": ("q", "v", "tau"), "inverse_dynamics_second_derivatives": ("q", "v", "a"),
    "center_of_mass": ("q",), "momentum": ("q", "v"), "momentum_matrix": ("q",), "frame_jacobian": ("q",),
    "frame_velocity": ("q", "v"), "frame_bias_acceleration": ("q", "v"), "regressor": ("q", "v", "a"),
    "joint_wrenches": ("q", "v", "a"),
}  # fmt: skip
"""Rows beyond the plain dynamics, and what they read."""


def of_peer(peer: Pinocchio, row: str, frame: str, inputs: tuple[str, ...]) -> Callable[..., Any]:
    n = peer.mechanism.nv

    def call(*arguments: Any) -> Any:
        given = dict.fromkeys(("v", "a", "tau"), np.zeros(n)) | dict(zip(inputs, arguments, strict=True))
        found = PEER_ROWS[row](peer, State(**given), frame)
        return found if len(found) > 1 else found[0]

    call.inputs = inputs  # type: ignore[attr-defined]
    return call


def batched(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: Any) -> Any:
        if np.ndim(arguments[0]) == 1:
            return function(*arguments)
        return np.array([function(*rows) for rows in zip(*arguments, strict=True)])

    return call
