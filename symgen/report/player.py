"""A motion in the drawing: what the player is told, and six stills for paper."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from symgen.report.camera import Camera, choose_view, faces_viewer, hull, shade, zigzag
from symgen.report.drawing import Drawing, Point, Shape
from symgen.report.environment import script_json
from symgen.report.sketch import body_colour
from symgen.report.solids import Array
from symgen.report.svg import figure, path, tag
from symgen.report.words import minus

STILLS = 6
WIDTH, HEIGHT, MARGIN = 220.0, 190.0, 12.0
POINTS = 24
"""Points whose path may be chosen."""
PLAIN = ("glass", "hull", "ball", "spring", "sheet", "com")
"""Shapes in a still; rods are lines there."""


@dataclass(frozen=True)
class Still:
    picture: Markup
    time: float
    label: str


@dataclass(frozen=True)
class Player:
    """``points``: names of the points whose path may be drawn."""

    data: Markup
    points: tuple[str, ...]
    stills: tuple[Still, ...]


def player(drawing: Drawing, data: Mapping[str, Any], speed: float) -> Player:
    """``data``: of `symgen.simulate.motion_data`, for the scene that is drawn; ``speed``: at which it first plays."""
    poses = _Poses(np.array(data["poses"], dtype=np.float64).reshape(len(data["poses"]), -1, 7))
    traced = _traced(drawing, data["bodies"], poses)
    value = {
        "end": data["times"][-1],
        "speed": speed,
        "points": [{"body": one.body, "point": one.point} for one in traced],
        "corners": [_corners(drawing, body) for body in range(len(drawing.frames))],
        "frames": data["poses"],
    }
    return Player(
        script_json(value), tuple(one.name for one in traced), _stills(drawing, poses, data["times"], traced[:1])
    )


@dataclass(frozen=True)
class _Traced:
    """A point of a body whose path may be drawn."""

    body: int
    point: Point
    name: str


@dataclass(frozen=True)
class _Poses:
    """``rows``: (times, bodies, 7)."""

    rows: Array

    def rotation(self, k: int, body: int) -> Array:
        x, y, z, w = self.rows[k, body, 3:] / np.linalg.norm(self.rows[k, body, 3:])
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    def points(self, k: int, body: int, local: Any) -> Array:
        """Points of a body in ground axes."""
        array = np.array(local, dtype=np.float64).reshape(-1, 3)
        return array if body < 0 else array @ self.rotation(k, body).T + self.rows[k, body, :3]

    def path(self, body: int, point: Sequence[float]) -> Array:
        return np.vstack([self.points(k, body, [point]) for k in range(len(self.rows))])


def _candidates(drawing: Drawing, bodies: Sequence[str]) -> list[_Traced]:
    """Ends of rods, and of bodies that have none basic points and ends of unit vectors."""
    found: dict[tuple[int, Point], str] = {}
    labels = {(label.body, label.point): label.text for label in drawing.labels if label.kind == "point"}
    for rod in drawing.rods:
        text = labels.get((rod.body, rod.end))
        own = f"{text} of {bodies[rod.body]}" if text else f"the tip of {bodies[rod.body]}"
        found.setdefault((rod.body, rod.end), rod.name or own)
    bare = set(range(len(bodies))) - {rod.body for rod in drawing.rods}
    for label in drawing.labels:
        if label.body in bare and label.kind in ("point", "vector"):
            text = label.text if label.kind == "point" else f"the end of {label.text}"
            found.setdefault((label.body, label.point), f"{text} of {bodies[label.body]}")
    names = list(found.values())
    return [
        _Traced(body, point, f"{name} ({names[:k].count(name) + 1})" if names.count(name) > 1 else name)
        for k, ((body, point), name) in enumerate(found.items())
    ]


def _traced(drawing: Drawing, bodies: Sequence[str], poses: _Poses) -> list[_Traced]:
    """What moves of the candidates, the one that goes farthest first."""
    found = _candidates(drawing, bodies)[: 4 * POINTS]
    lengths = []
    for one in found:
        line = poses.path(one.body, one.point)
        lengths.append(float(np.sum(np.linalg.norm(np.diff(line, axis=0), axis=1))))
    far = max(lengths, default=0.0)
    moving = [k for k, length in enumerate(lengths) if length > 1e-3 * far > 0]
    return [found[k] for k in sorted(moving, key=lambda k: (lengths[k] < far, k))][:POINTS]


def _corners(drawing: Drawing, body: int) -> list[list[float]]:
    """Of the box, in the body's axes, that holds what is drawn of it."""
    points = [
        p for shape in drawing.shapes if shape.body == body and shape.kind not in ("arrow", "dot") for p in shape.points
    ]
    if not points:
        return [[0.0, 0.0, 0.0]]
    array = np.array(points)
    ends = np.array([array.min(axis=0), array.max(axis=0)])
    return [
        [float(f"{ends[i][k]:.4g}") for k, i in enumerate(choice)] for choice in itertools.product((0, 1), repeat=3)
    ]


# --- stills ----------------------------------------------------------------------------------------------------------


def _stills(drawing: Drawing, poses: _Poses, times: Sequence[float], traced: Sequence[_Traced]) -> tuple[Still, ...]:
    chosen = [round(k * (len(times) - 1) / (STILLS - 1)) for k in range(STILLS)]
    axes = choose_view(drawing)
    everywhere = [
        poses.points(k, body, _corners(drawing, body))
        for k in range(0, len(times), max(1, len(times) // 60))
        for body in range(len(drawing.frames))
    ]
    still = [np.array(shape.points) for shape in drawing.shapes if shape.body < 0]
    seen = (np.vstack([*everywhere, *still]) - np.array(drawing.centre)) @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = np.maximum(high - low, 1e-9)
    scale = min((WIDTH - 2 * MARGIN) / float(size[0]), (HEIGHT - 2 * MARGIN) / float(size[1]))
    camera = Camera(axes, np.array(drawing.centre), (low + high) / 2, scale, (WIDTH, HEIGHT))
    lines = [poses.path(one.body, one.point) for one in traced]
    return tuple(_still(drawing, poses, k, camera, lines, float(times[k])) for k in chosen)


def _still(drawing: Drawing, poses: _Poses, k: int, camera: Camera, lines: Sequence[Array], time: float) -> Still:
    label = minus(f"t = {time:.2f} s")
    parts = [(float("-inf"), tag("path", class_="trace all", d=path(camera.see(line)[:, :2]))) for line in lines]
    for shape in drawing.shapes:
        if shape.kind in PLAIN or shape.colour == "slide":
            parts += _shape(shape, poses, k, camera)
    for rod in drawing.rods:
        seen = camera.see(poses.points(k, rod.body, [rod.start, rod.end]))
        drawn = tag("path", class_="rod", d=path(seen[:, :2]), stroke=body_colour(rod.body))
        parts.append((float(seen[:, 2].mean()), drawn))
    ordered = [element for _, element in sorted(parts, key=lambda part: part[0])]
    solids = tag("g", *ordered, class_="solids")
    title = f"{drawing.title} at {label}"
    return Still(figure([solids], WIDTH, HEIGHT, title, class_="mechanism"), time, label)


def _shape(shape: Shape, poses: _Poses, k: int, camera: Camera) -> list[tuple[float, Markup]]:
    """A shape where it is at a time, with its depth; nothing where it shows its back."""
    points = poses.points(k, shape.body, shape.points)
    if shape.end is not None:
        points = np.vstack([points[:-1], poses.points(k, shape.end, shape.points[-1:])])
    seen = camera.see(points)
    flat = seen[:, :2]
    if shape.kind == "glass":
        if not faces_viewer(seen):
            return []
        drawn = tag("path", class_="glass", d=path(flat, close=True), fill=shape.colour, stroke=shape.colour)
    elif shape.kind == "hull":
        drawn = tag("path", class_="hull", d=path(hull(seen), close=True), fill=shape.colour, stroke=shape.colour)
    elif shape.kind == "sheet":
        drawn = tag("path", class_=f"sheet {shape.colour}", d=path(flat, close=True))
    elif shape.kind == "line":
        drawn = tag("path", class_="line slide", d=path(flat), stroke_width="1.6")
    elif shape.kind == "spring":
        drawn = tag("path", class_="line spring", d=zigzag(seen[0, :2], seen[1, :2], 3.0), stroke_width="1")
    else:
        radius = max(2.0, shape.size * camera.scale) if shape.kind == "ball" else 2.2
        colour = shade(shape.colour, 0.6) if shape.kind == "ball" else None
        drawn = tag("circle", class_=None if colour else "joint", cx=flat[0, 0], cy=flat[0, 1], r=radius, fill=colour)
    return [(float(seen[:, 2].mean()) + shape.lift, drawn)]


__all__ = ["Player", "Still", "player"]
