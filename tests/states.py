"""States of a system at random, and what the literal definition says there, as arrays of floats."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.algebra.numbers import FloatNumbers, State
from symgen.system import System

Array = NDArray[np.float64]


def random_states(system: System, count: int, seed: int = 7) -> tuple[Array, Array, Array]:
    """q, v, a, one state per row; quaternions of unit length, angles within ±π."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2.0, 2.0, (count, system.tree.nq))
    for body in system.tree.bodies:
        if body.nq > body.nv:
            part = q[:, body.q + body.nq - 4 : body.q + body.nq]
            part /= np.linalg.norm(part, axis=1, keepdims=True)
    v, a = rng.uniform(-2.0, 2.0, (2, count, system.tree.nv))
    return q, v, a


def ours(system: System, name: str, **state: Any) -> Array:
    given = {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in state.items()}
    (found,) = system.evaluate(name, FloatNumbers(), State(**given)).values()
    return np.array(found, dtype=float)
