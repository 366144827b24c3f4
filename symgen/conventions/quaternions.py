"""Quaternions x y z w as NumPy arrays whose last axis they are on. A rotation is divided by the squared norm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def product(a: Array, b: Array) -> Array:
    """a ∘ b."""
    s, t = a[..., :3], b[..., :3]
    w, u = a[..., 3:], b[..., 3:]
    return np.concatenate([w * t + u * s + np.cross(s, t), w * u - np.sum(s * t, -1, keepdims=True)], -1)


def rotated(quaternion: Array, vector: Array) -> Array:
    """R(quaternion) vector."""
    s, w = quaternion[..., :3], quaternion[..., 3:]
    inner = np.cross(s, vector)
    twist = 2.0 * (w * inner + np.cross(s, inner))
    return np.asarray(vector + twist / np.sum(quaternion * quaternion, -1, keepdims=True))


def rotated_back(quaternion: Array, vector: Array) -> Array:
    """R(quaternion)ᵀ vector."""
    return rotated(np.concatenate([-quaternion[..., :3], quaternion[..., 3:]], -1), vector)


def of_rotation(matrix: Array) -> Array:
    """The unit quaternion (4,) of a rotation matrix (3, 3), by its largest component (Shepperd 1978)."""
    r = np.asarray(matrix, dtype=float)
    squares = np.array([
        1 + r[0, 0] - r[1, 1] - r[2, 2], 1 - r[0, 0] + r[1, 1] - r[2, 2], 1 - r[0, 0] - r[1, 1] + r[2, 2],
        1 + r[0, 0] + r[1, 1] + r[2, 2],
    ])  # fmt: skip
    k = int(np.argmax(squares))
    sums = r + r.T
    x, y, z = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    rows = (
        (squares[0], sums[0, 1], sums[0, 2], x),
        (sums[0, 1], squares[1], sums[1, 2], y),
        (sums[0, 2], sums[1, 2], squares[2], z),
        (x, y, z, squares[3]),
    )
    found = np.array(rows[k])
    return np.asarray(found / np.linalg.norm(found))
