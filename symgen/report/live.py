"""The drawing as JSON for the script that turns it and moves its joints."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup

from symgen.report.camera import HEIGHT, INSET, LIGHT, MARGIN, WIDTH, aim, choose_view, inset_corner
from symgen.report.drawing import Drawing, Frame
from symgen.report.environment import script_json
from symgen.report.solids import Array


def _frame(frame: Frame) -> dict[str, Any]:
    return {
        "parent": frame.parent,
        "originRotation": frame.origin_rotation,
        "origin": frame.origin,
        "motions": [
            {"kind": m.kind, "axis": m.axis, "slider": m.slider, "factor": m.factor, "offset": m.offset}
            for m in frame.motions
        ],
        "rotation": frame.rotation,
        "position": frame.position,
    }


def _short(points: Any) -> Any:
    """Coordinates to a few digits: what a picture shows."""
    return [[float(f"{x:.5g}") for x in point] for point in points]


def _rows(matrix: Array) -> list[list[float]]:
    return [[round(float(x), 6) for x in row] for row in matrix]


def drawing_json(drawing: Drawing) -> Markup:
    """JSON that may stand inside a script element whatever the names are."""
    directions = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] + ([list(drawing.gravity)] if drawing.gravity else [])
    sizes = [INSET] * 3 + ([round(0.8 * INSET, 1)] if drawing.gravity else [])
    axes = choose_view(drawing)
    x, y = inset_corner(drawing, aim(drawing, axes))
    value = {
        "width": WIDTH,
        "height": HEIGHT,
        "margin": MARGIN,
        "light": [round(float(x), 6) for x in LIGHT],
        "inset": {"x": x, "y": y, "directions": directions, "sizes": sizes},
        "axes": _rows(axes),
        "centre": drawing.centre,
        "radius": drawing.radius,
        "up": drawing.up,
        "frames": [_frame(frame) for frame in drawing.frames],
        "sliders": [
            {"label": s.label, "unit": s.unit, "low": s.low, "high": s.high, "value": s.value} for s in drawing.sliders
        ],
        "labels": [{"body": label.body, "point": label.point} for label in drawing.labels],
        "shapes": [
            {
                "kind": shape.kind,
                "body": shape.body,
                "points": _short(shape.points),
                "colour": shape.colour,
                "size": round(shape.size, 6),
                "lift": round(shape.lift, 6),
                "end": shape.body if shape.end is None else shape.end,
            }
            for shape in drawing.shapes
        ],
    }
    return script_json(value)
