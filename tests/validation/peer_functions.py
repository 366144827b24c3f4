"""Functions of the catalogue made from Pinocchio: the validation can be tried before, and without, generated code."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from symgen.scene.model import Scene
from symgen.validation.pinocchio_model import build_pinocchio


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


def batched(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: Any) -> Any:
        if np.ndim(arguments[0]) == 1:
            return function(*arguments)
        return np.array([function(*rows) for rows in zip(*arguments, strict=True)])

    return call
