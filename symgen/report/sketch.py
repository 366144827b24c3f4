"""The sheet a mechanism is drawn on: shapes and labels as they come, and the sizes and colours they get."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from symgen.report import solids
from symgen.report.drawing import Label, Point, Rod, Shape
from symgen.report.solids import Array, Polygon
from symgen.scene.model import Joint
from symgen.system import System

COLOURS = ("#3d7ab8", "#d9623b", "#3f9259", "#b8862b", "#8a5fb0", "#2b96a5", "#c0557f", "#75803a")
"""Bodies; readable on light and dark ground."""
STEEL, GROUND_COLOUR, CUT = "#8d97a3", "#9a9288", "#c63d3d"


def array(values: Iterable[object]) -> Array:
    return np.array([float(x) for x in values], dtype=np.float64)  # type: ignore[arg-type]


def triple(v: Sequence[float] | Array) -> Point:
    x, y, z = (round(float(c), 6) + 0.0 for c in v)
    return (x, y, z)


def body_colour(index: int) -> str:
    return COLOURS[index % len(COLOURS)] if index >= 0 else GROUND_COLOUR


def distinct(points: Iterable[Array]) -> list[Array]:
    kept: list[Array] = []
    for point in points:
        if not any(np.allclose(point, other, atol=1e-9) for other in kept):
            kept.append(point)
    return kept


def cut_place(system: System, joint: Joint) -> tuple[int, Array, Array]:
    """Tree body, position and rotation there of a cut joint's frame, seen from its parent."""
    index, pose = system.tree.frames[joint.parent]
    rotation, translation = (np.array(pose.rotation, dtype=np.float64), array(pose.translation))
    inner = np.array(joint.origin.rotation, dtype=np.float64)
    return index, translation + rotation @ array(joint.origin.translation), rotation @ inner


@dataclass
class Sketch:
    """Shapes and labels as they come, with the sizes they are drawn in."""

    system: System
    scale: float
    shapes: list[Shape] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    rods: list[Rod] = field(default_factory=list)

    @property
    def symbol(self) -> float:
        """Radius of a joint's solid."""
        return 0.032 * self.scale

    def faces(self, body: int, faces: Iterable[Polygon], colour: str, lift: float = 0.0, kind: str = "face") -> None:
        self.shapes.extend(Shape(kind, body, tuple(triple(p) for p in face), colour, 0.0, lift) for face in faces)

    def line(self, body: int, points: Iterable[Array], style: str, width: float, lift: float = 0.0) -> None:
        self.shapes.append(Shape("line", body, tuple(triple(p) for p in points), style, width, lift))

    def place(
        self, kind: str, body: int, points: Iterable[Array], colour: str, size: float = 0.0, lift: float = 0.0
    ) -> None:
        self.shapes.append(Shape(kind, body, tuple(triple(p) for p in points), colour, size, lift))

    def rod(self, body: int, start: Array, end: Array, name: str = "") -> None:
        length = float(np.linalg.norm(end - start))
        if length > 0.02 * self.scale:
            self.rods.append(Rod(body, triple(start), triple(end), name))
            pieces = min(8, max(1, round(length / (0.12 * self.scale))))
            self.faces(body, solids.tube(start, end, 0.36 * self.symbol, 8, pieces), body_colour(body))
