"""Seeing a drawing: parallel projection, depth order, light, and where labels go."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from symgen.report.drawing import Drawing, Label, Shape
from symgen.report.solids import Array, unit
from symgen.report.svg import figure, num, path, symbol, tag

WIDTH, HEIGHT, MARGIN = 720.0, 470.0, 34.0
LIGHT = unit(np.array([-0.45, 0.75, 0.6]))
"""Right, up, towards the viewer."""
INSET = 34.0
"""Size of the little triad of ground axes."""
CORNERS = ((58.0, HEIGHT - 62.0), (WIDTH - 58.0, HEIGHT - 62.0), (58.0, 62.0), (WIDTH - 58.0, 62.0))


def shade(colour: str, light: float) -> str:
    """A lit face: the colour darkened or lightened."""
    factor = 0.62 + 0.5 * max(0.0, light)
    channels = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{min(255, int(c * factor + 0.5)):02x}" for c in channels)


@dataclass(frozen=True)
class Camera:
    """``axes`` has rows right, up, towards the viewer; ``scale`` pixels per metre."""

    axes: Array
    centre: Array
    middle: Array
    """What stands in the middle of the picture, in view axes."""
    scale: float
    size: tuple[float, float] = (WIDTH, HEIGHT)

    def see(self, points: Array) -> Array:
        """(n, 3): x, y in pixels and depth (larger is nearer) in m."""
        seen = (points - self.centre) @ self.axes.T
        x = self.size[0] / 2 + self.scale * (seen[:, 0] - self.middle[0])
        y = self.size[1] / 2 - self.scale * (seen[:, 1] - self.middle[1])
        return np.column_stack([x, y, seen[:, 2]])


def placed(drawing: Drawing, body: int, points: Sequence[Sequence[float]]) -> Array:
    """Points of a body in ground axes."""
    local: Array = np.array(points, dtype=np.float64)
    if body >= 0:
        frame = drawing.frames[body]
        local = local @ np.array(frame.rotation).T + np.array(frame.position)
    return local


def shape_points(drawing: Drawing, shape: Shape) -> Array:
    """Points of a shape in ground axes."""
    if shape.end is None:
        return placed(drawing, shape.body, shape.points)
    first = placed(drawing, shape.body, shape.points[:-1])
    return np.vstack([first, placed(drawing, shape.end, shape.points[-1:])])


def view_axes(up: Array, azimuth: float, elevation: float) -> Array:
    """Rows right, up, towards the viewer; azimuth 0 looks along the ground's y axis where up is z."""
    e2 = np.array([0.0, 1.0, 0.0]) if abs(up[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    forward = unit(e2 - up * float(up @ e2))
    side = np.cross(forward, up)
    level = math.cos(azimuth) * -forward + math.sin(azimuth) * side
    towards = math.cos(elevation) * level + math.sin(elevation) * up
    right = unit(np.cross(up, towards))
    return np.array([right, np.cross(towards, right), towards])


AZIMUTHS = (25, 35, 45, 55, 65, -25, -35, -45, -55, -65)
"""Degrees; no axis of the ground points at the viewer."""


def choose_view(drawing: Drawing) -> Array:
    """Planar mechanisms are seen along their normal, a little from the side; others from where their points and
    arrows lie farthest apart in the picture."""
    up = np.array(drawing.up)
    if drawing.normal is not None and abs(float(np.array(drawing.normal) @ up)) < 0.1:
        return _along_normal(unit(np.array(drawing.normal)), up)
    dots = [shape_points(drawing, s)[0] for s in drawing.shapes if s.kind == "dot"]
    arrows = [shape_points(drawing, s) for s in drawing.shapes if s.kind == "arrow"]
    best, found = -1.0, view_axes(up, 0.5, 0.35)
    for azimuth, elevation in itertools.product((math.radians(a) for a in AZIMUTHS), (0.3, 0.45)):
        axes = view_axes(up, azimuth, elevation)
        value = _spread(axes, dots, arrows, drawing.radius) - 0.02 * abs(azimuth - 0.5)
        if value > best:
            best, found = value, axes
    return found


def _along_normal(normal: Array, up: Array) -> Array:
    up = unit(up - normal * float(normal @ up))
    right = np.cross(up, normal)
    if float(right.sum()) < 0:  # the ground's axes should point right rather than left
        normal, right = -normal, -right
    towards = unit(normal + 0.32 * up + 0.36 * right)
    right = unit(np.cross(up, towards))
    return np.array([right, np.cross(towards, right), towards])


def _spread(axes: Array, dots: list[Array], arrows: list[Array], radius: float) -> float:
    """Mean of the points' nearest distances in the picture, and of the arrows' lengths, in parts of the whole."""
    flat = [axes[:2] @ dot for dot in dots]
    pairs = [float(np.linalg.norm(a - b)) for a, b in itertools.combinations(flat, 2)]
    lengths = [float(np.linalg.norm(axes[:2] @ (a[1] - a[0]))) for a in arrows]
    far = float(np.mean([min(d, 0.6 * radius) for d in pairs])) if pairs else 0.0
    near = min([d for d in pairs if d > 0] or [0.0])
    return (far + 0.6 * near + (min(lengths) + float(np.mean(lengths)) if lengths else 0.0)) / radius


def aim(drawing: Drawing, axes: Array) -> Camera:
    """Fit everything into the picture."""
    centre = np.array(drawing.centre)
    points = np.vstack([shape_points(drawing, s) for s in drawing.shapes] or [centre[None]])
    seen = (points - centre) @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = np.maximum(high - low, 1e-9)
    scale = min((WIDTH - 2 * MARGIN) / float(size[0]), (HEIGHT - 2 * MARGIN) / float(size[1]))
    return Camera(axes, centre, (low + high) / 2, scale)


def hull(points: Array) -> list[Array]:
    """Convex outline of points in the plane (monotone chain)."""
    ordered = sorted((round(float(x), 3), round(float(y), 3)) for x, y in points[:, :2])
    outline: list[tuple[float, float]] = []
    for sweep in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for p in sweep:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2], chain[-1]
                if (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax) > 0:
                    break
                chain.pop()
            chain.append(p)
        outline.extend(chain[:-1])
    return [np.array(p) for p in outline]


def _arrow(seen: Array) -> str:
    """Shaft and head."""
    start, end = seen[0, :2], seen[1, :2]
    length = float(np.linalg.norm(end - start))
    if length < 1:
        return path([start, end])
    along = (end - start) / length
    side = np.array([-along[1], along[0]])
    head = min(9.0, 0.6 * length)
    base = end - head * along
    wings = [base + 0.38 * head * side, end, base - 0.38 * head * side]
    return path([start, base]) + path(wings, close=True)


COILS, COIL = 9, 6.0
"""Turns of a spring, and their half width in pixels."""


def zigzag(start: Array, end: Array, width: float = COIL) -> str:
    """A spring: straight ends and a zigzag between them, ``width`` pixels to either side."""
    length = float(np.linalg.norm(end - start))
    if length < 1:
        return path([start, end])
    side = np.array([-(end - start)[1], (end - start)[0]]) / length * width
    inner = [
        start + (end - start) * (0.15 + 0.7 * (k + 0.5) / (2 * COILS)) + (side if k % 2 else -side)
        for k in range(2 * COILS)
    ]
    ends = (start + 0.15 * (end - start), start + 0.85 * (end - start))
    return path([start, ends[0], *inner, ends[1], end])


def _element(shape: Shape, seen: Array, scale: float) -> Markup:
    kind = shape.kind
    if kind in ("face", "glass"):
        glass = "glass" if kind == "glass" else None
        a, b, c = seen[0], seen[1], seen[2]
        normal = unit(np.cross((b - a) * (1, -1, scale), (c - a) * (1, -1, scale)))
        colour = shade(shape.colour, float(normal @ LIGHT))
        return tag("path", d=path(seen[:, :2], close=True), fill=colour, stroke=colour, class_=glass)
    if kind == "sheet":
        return tag("path", class_=f"sheet {shape.colour}", d=path(seen[:, :2], close=True))
    if kind == "hull":
        return tag("path", class_="hull", d=path(hull(seen), close=True), fill=shape.colour, stroke=shape.colour)
    if kind == "line":
        return tag("path", class_=f"line {shape.colour}", d=path(seen[:, :2]), stroke_width=shape.size)
    if kind == "spring":
        return tag("path", class_="line spring", d=zigzag(seen[0, :2], seen[1, :2]), stroke_width=shape.size)
    if kind == "arrow":
        return tag("path", class_="arrow", d=_arrow(seen), stroke_width=shape.size)
    x, y = float(seen[0, 0]), float(seen[0, 1])
    if kind == "ball":
        r = shape.size * scale
        light = tag("circle", cx=x - 0.3 * r, cy=y - 0.35 * r, r=0.45 * r, fill="#fff", fill_opacity="0.35")
        return tag("g", tag("circle", cx=x, cy=y, r=r, fill=shade(shape.colour, 0.6)), light)
    if kind == "com":
        r = shape.size
        quarters = f"M{num(x)} {num(y)}h{num(r)}a{num(r)} {num(r)} 0 0 0-{num(r)}-{num(r)}z"
        quarters += f"M{num(x)} {num(y)}h-{num(r)}a{num(r)} {num(r)} 0 0 0 {num(r)} {num(r)}z"
        return tag("g", tag("circle", cx=x, cy=y, r=r), tag("path", d=quarters), class_="com")
    return tag("circle", class_="dot", cx=x, cy=y, r=shape.size)


def faces_viewer(seen: Array) -> bool:
    """Whether a flat polygon shows its front (corners run counter-clockwise; y points down in the picture)."""
    x, y = seen[:, 0], seen[:, 1]
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) < 0


def render(drawing: Drawing) -> Markup:
    """The picture, from where most is to be seen."""
    camera = aim(drawing, choose_view(drawing))
    queue = []
    for index, shape in enumerate(drawing.shapes):
        seen = camera.see(shape_points(drawing, shape))
        if shape.kind in ("face", "glass") and not faces_viewer(seen):
            continue
        depth = float(seen[:, 2].mean()) + shape.lift
        queue.append((depth, index, _element(shape, seen, camera.scale)))
    solids = [element for _, _, element in sorted(queue, key=lambda entry: entry[:2])]
    labels = _labels(drawing, camera)
    children = [
        tag("desc", drawing.description),
        tag("g", *solids, class_="solids"),
        tag("g", *_inset(drawing, camera), class_="inset"),
        tag("g", *labels, class_="labels"),
    ]
    return figure(children, WIDTH, HEIGHT, drawing.title, class_="mechanism")


def inset_corner(drawing: Drawing, camera: Camera) -> tuple[float, float]:
    """The corner with least in it."""
    seen = np.vstack([camera.see(shape_points(drawing, s)) for s in drawing.shapes] or [np.zeros((1, 3))])

    def crowd(corner: tuple[float, float]) -> int:
        near = (abs(seen[:, 0] - corner[0]) < 75) & (abs(seen[:, 1] - corner[1]) < 75)
        return int(np.sum(near))

    return min(CORNERS, key=crowd)


def _inset(drawing: Drawing, camera: Camera) -> list[Markup]:
    """Ground axes and the direction of gravity, in a corner."""
    (x0, y0), size, axes = inset_corner(drawing, camera), INSET, camera.axes
    rows = [
        ("x", np.array([1.0, 0, 0]), "axis"),
        ("y", np.array([0, 1.0, 0]), "axis"),
        ("z", np.array([0, 0, 1.0]), "axis"),
    ]
    if drawing.gravity is not None:
        rows.append(("g", np.array(drawing.gravity), "gravity"))
    found = []
    for name, direction, style in rows:
        seen = axes @ direction
        reach = size if style == "axis" else 0.8 * size
        x, y = x0 + reach * float(seen[0]), y0 - reach * float(seen[1])
        shaft = tag("path", class_="arrow", d=_arrow(np.array([[x0, y0, 0], [x, y, 0]])), stroke_width="1.4")
        beyond = unit(np.array([x - x0, y - y0, 1e-9]))
        text = tag("text", name, x=x + 10 * float(beyond[0]), y=y + 10 * float(beyond[1]) + 4, text_anchor="middle")
        found.append(tag("g", shaft, text, class_=style))
    return found


DIRECTIONS = [(math.cos(t), math.sin(t)) for t in (math.radians(a) for a in (-45, -135, 45, 135, -90, 0, 180, 90))]


def _labels(drawing: Drawing, camera: Camera) -> list[Markup]:
    """Each label beside its point, where it covers least of what is there already."""
    anchors = [camera.see(placed(drawing, label.body, [label.point]))[0] for label in drawing.labels]
    busy = [(float(a[0]), float(a[1])) for a in anchors]
    for shape in drawing.shapes:
        if shape.kind in ("arrow", "com", "face"):
            busy += _samples(drawing, camera, shape)
    found = []
    for label, anchor in zip(drawing.labels, anchors, strict=True):
        half = _half_width(label)
        reach = (1.0,) if label.kind == "vector" else (1.0, 1.5)
        options = [(anchor[0] + (10 * r + half) * dx, anchor[1] + 18 * r * dy) for r in reach for dx, dy in DIRECTIONS]
        x, y = min(options, key=lambda place: _clutter(place, half, np.array(busy)))
        busy.extend((x + t * half, y) for t in (-0.8, 0.0, 0.8))
        children = [symbol(label.text)] if label.kind != "joint" else [label.text]
        place = f"{num(x - anchor[0])} {num(y - anchor[1])}"
        where = f"translate({num(float(anchor[0]))} {num(float(anchor[1]))})"
        dx, dy = place.split()
        text = tag("text", *children, x=dx, y=num(float(dy) + 5), text_anchor="middle", class_=label.kind)
        found.append(tag("g", text, transform=where))
    return found


def _half_width(label: Label) -> float:
    return 3.4 * len(label.text) + (3 if label.kind != "joint" else 6)


def _samples(drawing: Drawing, camera: Camera, shape: Shape) -> list[tuple[float, float]]:
    seen = camera.see(shape_points(drawing, shape))[:, :2]
    if shape.kind == "face":
        x, y = seen.mean(axis=0)
        return [(float(x), float(y))]
    return [tuple(float(c) for c in seen[0] + (seen[-1] - seen[0]) * t) for t in (0.0, 0.35, 0.7, 1.0)]  # type: ignore[misc]


def _clutter(place: tuple[float, float], half: float, busy: Array) -> float:
    """What a label at ``place`` covers or comes near to, and how far it sticks out of the picture."""
    x, y = place
    outside = max(0.0, half - x) + max(0.0, x + half - WIDTH) + max(0.0, 10 - y) + max(0.0, y + 10 - HEIGHT)
    gaps = np.maximum(0.0, np.abs(busy - (x, y)) - (half, 6.0))
    return float(np.sum(1.0 / (1.0 + np.sum(gaps * gaps, axis=1) / 9.0))) + outside
