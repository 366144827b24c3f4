"""Solids of the mechanism drawing as lists of flat faces: tubes, boxes, plates, and lines such as screw threads."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Polygon = list[Array]


def unit(v: Array) -> Array:
    length = float(np.linalg.norm(v))
    return v / length if length > 0 else np.array([0.0, 0.0, 1.0])


def across(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors that complete ``axis`` to a right-handed frame (e1, e2, axis)."""
    n = unit(axis)
    helper = np.eye(3)[int(np.argmin(np.abs(n)))]
    e1 = unit(helper - n * float(helper @ n))
    return e1, np.cross(n, e1)


def ring(centre: Array, axis: Array, radius: float, sides: int) -> Polygon:
    """Corners of a regular polygon about ``axis``, counter-clockwise seen against it."""
    e1, e2 = across(axis)
    angles = [2 * math.pi * (k + 0.5) / sides for k in range(sides)]
    return [centre + radius * (math.cos(t) * e1 + math.sin(t) * e2) for t in angles]


def tube(start: Array, end: Array, radius: float, sides: int = 8, pieces: int = 1, caps: bool = True) -> list[Polygon]:
    """A prism from ``start`` to ``end``; in several ``pieces`` its faces sort better against its neighbours."""
    axis = unit(end - start)
    rings = [ring(start + (end - start) * k / pieces, axis, radius, sides) for k in range(pieces + 1)]
    faces = [
        [low[k], low[(k + 1) % sides], high[(k + 1) % sides], high[k]]
        for low, high in itertools.pairwise(rings)
        for k in range(sides)
    ]
    return [*faces, rings[-1], rings[0][::-1]] if caps else faces


def box(centre: Array, axes: Array, half: Sequence[float]) -> list[Polygon]:
    """A cuboid; ``axes`` holds its three directions as columns."""
    x, y, z = (axes[:, k] * half[k] for k in range(3))
    faces = []
    for normal, a, b in ((x, y, z), (y, z, x), (z, x, y)):
        faces.append(
            [centre + normal - a - b, centre + normal + a - b, centre + normal + a + b, centre + normal - a + b]
        )
        faces.append(
            [centre - normal - a - b, centre - normal - a + b, centre - normal + a + b, centre - normal + a - b]
        )
    return faces


def plate(centre: Array, e1: Array, e2: Array, half: float) -> Polygon:
    return [centre + half * (s * e1 + t * e2) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def hatch(centre: Array, e1: Array, e2: Array, half: float, strokes: int = 5) -> list[Polygon]:
    """Parallel strokes at 45° across a square plate."""
    lines = []
    for k in range(1, 2 * strokes):
        s = -2.0 + 2.0 * k / strokes  # s = x + y along the plate's diagonal, −2 … 2
        low, high = max(-1.0, s - 1.0), min(1.0, s + 1.0)
        lines.append([centre + half * (low * e1 + (s - low) * e2), centre + half * (high * e1 + (s - high) * e2)])
    return lines


def thread(centre: Array, axis: Array, radius: float, length: float, turns: int = 4) -> Polygon:
    """A helix about ``axis``."""
    e1, e2 = across(axis)
    points = []
    for k in range(turns * 12 + 1):
        angle = 2 * math.pi * k / 12
        along = length * (k / (turns * 12) - 0.5)
        points.append(centre + radius * (math.cos(angle) * e1 + math.sin(angle) * e2) + along * unit(axis))
    return points
