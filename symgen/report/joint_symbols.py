"""The solid that stands for each joint type, and the ground."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from symgen.report import solids
from symgen.report.drawing import Label, Shape
from symgen.report.sketch import CUT, GROUND_COLOUR, STEEL, Sketch, array, cut_place, distinct, triple
from symgen.report.solids import Array, across, unit
from symgen.scene.model import Joint
from symgen.topology.tree import TreeBody


class _Place:
    """Where a symbol is drawn: the parent's side (fixed) and the child's side (moving)."""

    def __init__(self, sketch: Sketch, joint: Joint, parent: int, origin: Array, rotation: Array, child: int) -> None:
        self.sketch, self.joint, self.parent, self.child = sketch, joint, parent, child
        self.origin, self.rotation = origin, rotation
        self.cut = child < 0
        self.colour = CUT if self.cut else STEEL
        self.r = sketch.symbol

    def axis(self) -> Array:
        local = array(self.joint.axis) if self.joint.axis is not None else np.array([0.0, 0.0, 1.0])
        return unit(self.rotation @ local)


def _cylinder(at: _Place, length: float, radius: float = 1.0) -> None:
    half = length * at.r * at.axis()
    at.sketch.faces(
        at.parent, solids.tube(at.origin - half, at.origin + half, radius * at.r, 14), at.colour, 0.8 * at.r
    )


def _rail(at: _Place, q: float) -> None:
    """The guide of a sliding joint, from the parent's point to beyond the child's."""
    axis, reach = at.axis(), 3.2 * at.r
    low, high = min(0.0, q) - reach, max(0.0, q) + reach
    ends = (at.origin + low * axis, at.origin + high * axis)
    at.sketch.faces(at.parent, solids.tube(*ends, 0.26 * at.r, 6, 4), at.colour)
    if not at.cut:  # however far it slides, it is seen what it slides on
        points = (triple(at.origin), (0.0, 0.0, 0.0))
        at.sketch.shapes.append(Shape("line", at.parent, points, "slide", 3.0, -0.1 * at.r, at.child))


def _revolute(at: _Place, q: Sequence[float]) -> None:
    _cylinder(at, 1.5)


def _prismatic(at: _Place, q: Sequence[float]) -> None:
    _rail(at, q[0])
    body, axis = at.child, unit(array(at.joint.axis or ()))
    if at.cut:
        body, axis = at.parent, at.axis()
    e1, e2 = across(axis)
    centre = at.origin if at.cut else np.zeros(3)
    axes = np.column_stack([e1, e2, axis])
    at.sketch.faces(body, solids.box(centre, axes, (at.r, at.r, 1.7 * at.r)), at.colour, 0.8 * at.r)


def _helical(at: _Place, q: Sequence[float]) -> None:
    _cylinder(at, 2.6, 0.7)
    at.sketch.line(at.parent, solids.thread(at.origin, at.axis(), 1.05 * at.r, 5 * at.r), "thread", 1.4, 1.2 * at.r)


def _cylindrical(at: _Place, q: Sequence[float]) -> None:
    _rail(at, q[1] if len(q) > 1 else 0.0)
    axis = unit(array(at.joint.axis or ()))
    body, centre = at.child, np.zeros(3)
    if at.cut:
        body, centre, axis = at.parent, at.origin, at.axis()
    ends = (centre - 1.8 * at.r * axis, centre + 1.8 * at.r * axis)
    at.sketch.faces(body, solids.tube(*ends, at.r, 14), at.colour, 0.8 * at.r)


def _universal(at: _Place, q: Sequence[float]) -> None:
    """The cross: one bar along each axis."""
    arm = 2.1 * at.r * at.axis()
    at.sketch.faces(at.parent, solids.tube(at.origin - arm, at.origin + arm, 0.5 * at.r, 10), at.colour, 0.8 * at.r)
    second = unit(array(at.joint.axis2 or ()))
    body, centre = (at.parent, at.origin) if at.cut else (at.child, np.zeros(3))
    if at.cut:
        second = unit(at.rotation @ second)
    ends = (centre - 2.1 * at.r * second, centre + 2.1 * at.r * second)
    at.sketch.faces(body, solids.tube(*ends, 0.5 * at.r, 10), at.colour, 0.8 * at.r)


def _planar(at: _Place, q: Sequence[float]) -> None:
    e1, e2 = at.rotation[:, 0], at.rotation[:, 1]
    half = 0.34 * at.sketch.scale
    for line in solids.hatch(at.origin, e1, e2, half, 6):
        at.sketch.line(at.parent, line, "hatch", 1.0, -0.5 * at.sketch.scale)
    at.sketch.place("sheet", at.parent, solids.plate(at.origin, e1, e2, half), "plane", 0.0, -0.5 * at.sketch.scale)


def _spherical(at: _Place, q: Sequence[float]) -> None:
    at.sketch.place("ball", at.parent, [at.origin], at.colour, 1.35 * at.r, at.r)


def _floating(at: _Place, q: Sequence[float]) -> None:
    """Nothing holds it: nothing is drawn."""


SYMBOLS: dict[str, Callable[[_Place, Sequence[float]], None]] = {
    "revolute": _revolute,
    "continuous": _revolute,
    "prismatic": _prismatic,
    "helical": _helical,
    "cylindrical": _cylindrical,
    "universal": _universal,
    "planar": _planar,
    "spherical": _spherical,
    "floating": _floating,
    "fixed": _floating,
}


def draw_joint(sketch: Sketch, joint: TreeBody | Joint, q: Sequence[float]) -> None:
    """The symbol of a tree body's incoming joint, or of a cut joint (in red, on its parent's side)."""
    if isinstance(joint, TreeBody):
        origin = joint.joint.origin
        rotation = np.array(origin.rotation, dtype=np.float64)
        place = _Place(sketch, joint.joint, joint.parent, array(origin.translation), rotation, joint.index)
    else:
        body, point, rotation = cut_place(sketch.system, joint)
        place = _Place(sketch, joint, body, point, rotation, -1)
        sketch.labels.append(Label(body, triple(point), f"{joint.name}, cut", "joint"))
    SYMBOLS[place.joint.type](place, q)


def draw_ground(sketch: Sketch) -> None:
    """A hatched plate and a post under every joint that stands on the ground."""
    gravity = array(sketch.system.scene.gravity)
    down = unit(gravity) if float(np.linalg.norm(gravity)) > 0 else np.array([0.0, 0.0, -1.0])
    e1, e2 = across(down)
    tree = sketch.system.tree
    places = [
        array(b.joint.origin.translation)
        for b in tree.bodies
        if b.parent < 0 and b.joint.type not in ("floating", "planar")
    ]
    places += [point for body, point, _ in (cut_place(sketch.system, joint) for joint in tree.cut_joints) if body < 0]
    drop, half = 0.13 * sketch.scale, 0.09 * sketch.scale
    for point in distinct(places):
        foot = point + drop * down
        sketch.faces(-1, solids.tube(foot, point, 0.45 * sketch.symbol, 8, 2), GROUND_COLOUR)
        sketch.place("sheet", -1, solids.plate(foot, e1, e2, half), "ground", 0.0, -0.05 * sketch.scale)
        for line in solids.hatch(foot, e1, e2, half):
            sketch.line(-1, line, "hatch", 1.0, -0.04 * sketch.scale)
