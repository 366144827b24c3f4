"""A system as a drawing: rods between a body's basic points, a solid for every joint, arrows for unit vectors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from symgen.algebra.numbers import FloatNumbers
from symgen.natural.entities import Entity
from symgen.report import solids
from symgen.report.drawing import Drawing, Frame, Label, Motion, Shape, Slider
from symgen.report.joint_symbols import draw_ground, draw_joint
from symgen.report.place_names import place_name
from symgen.report.sketch import Sketch, array, body_colour, cut_place, distinct, triple
from symgen.report.solids import Array, unit
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import GROUND, Body, Joint, Spring, Transform
from symgen.system import System
from symgen.topology.tree import TreeBody
from symgen.velocity.kinematics import GROUND_POSE, Pose, kinematics
from symgen.velocity.values import Values

CROWDED = 16
"""Bodies beyond which points and vectors would cover the mechanism."""
ANGLE, SLIDE = 0.35, 0.22
"""Where joints are drawn: rad, and parts of the mechanism's size."""
TILT = (math.sin(ANGLE / 2), 0.0, 0.0, math.cos(ANGLE / 2))
"""Where spherical joints are drawn: turned about x."""


def inertia_box(body: Body) -> tuple[Array, tuple[float, float, float]]:
    """The uniform box with a body's mass and inertia: its axes as columns, its half lengths (body axes)."""
    xx, yy, zz, xy, xz, yz = (float(x) for x in body.inertia)
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    moments, axes = (np.diag(matrix), np.eye(3)) if not (xy or xz or yz) else np.linalg.eigh(matrix)
    mass = float(body.mass) or 1.0
    total = float(sum(moments))
    a, b, c = (math.sqrt(max(0.0, 6 * (total - 2 * float(m)) / mass)) / 2 for m in moments)
    return axes, (a, b, c)


def skeleton(system: System) -> dict[int, list[Array]]:
    """Per body (−1: ground): its origin, the origins of the joints it carries, frames, and the basic points that
    the scene declares (not the auxiliary ones that only carry mass)."""
    found: dict[int, list[Array]] = {body.index: [np.zeros(3)] for body in system.tree.bodies}
    found[-1] = []
    for body in system.tree.bodies:
        found[body.parent].append(array(body.joint.origin.translation))
    for body in system.tree.bodies:
        for part, place in body.parts:
            found[body.index].extend(part_point(place, point) for point in part.basic_points)
    for index, pose in system.tree.frames.values():
        if index >= 0:
            found[index].append(array(pose.translation))
    for joint in system.tree.cut_joints:
        parent, meeting, _ = cut_place(system, joint)
        found[parent].append(meeting)
    return {index: distinct(points) for index, points in found.items()}


def part_point(place: Transform, local: Iterable[object]) -> Array:
    """A point of a welded part in the frame of its tree body."""
    return array(place.translation) + np.array(place.rotation, dtype=np.float64) @ array(local)


def display_position(system: System, scale: float) -> list[float]:
    """Where the joints are drawn: a little off zero, so that nothing hides behind something else; closed loops at 0."""
    q: list[float] = []
    loops = bool(system.tree.cut_joints)
    for body in system.tree.bodies:
        if body.coupling is not None:
            continue  # it has no coordinate of its own
        for k, name in enumerate(JOINT_TYPES[body.joint.type].q_units):
            quaternion = body.joint.type in ("spherical", "floating") and name == "1"
            if quaternion:
                turn = TILT if body.joint.type == "spherical" and not loops else (0.0, 0.0, 0.0, 1.0)
                q.append(turn[k - body.nq])
            elif loops or body.joint.type == "floating":
                q.append(0.0)
            else:
                q.append(ANGLE if name == "rad" else round(SLIDE * scale, 2))
    return q


def positions(body: TreeBody, q: Sequence[float]) -> list[float]:
    """The positions of a body's joint: its own entries of q, or what those of the joint it is coupled to make them."""
    own = list(q[body.q : body.q + body.nq])
    if body.coupling is None:
        return own
    return [float(body.coupling.multiplier) * x + float(body.coupling.offset) for x in own]


def poses_at(system: System, q: Sequence[float]) -> tuple[Pose, ...]:
    values = Values(system.scene, FloatNumbers(), defaults(system))
    return kinematics(system.tree, values, list(q)).poses


def defaults(system: System) -> list[float]:
    return [float(x) for parameter in system.scene.parameters for x in parameter.default]


def ground_point(pose: Pose, local: Array) -> Array:
    return array(pose.point(tuple(local)))


def extent(system: System, bones: dict[int, list[Array]], poses: Sequence[Pose]) -> Array:
    """Points in ground axes that the picture must hold."""
    points = [] if not any(b.joint.type != "floating" and b.parent < 0 for b in system.tree.bodies) else [*bones[-1]]
    for body in system.tree.bodies:
        pose = poses[body.index]
        points.extend(ground_point(pose, point) for point in bones[body.index])
        if len(bones[body.index]) < 2 and not system.tree.children[body.index]:
            points.extend(
                ground_point(pose, corner) for part, place in body.parts for corner in box_corners(part, place)
            )
    return np.array(points)


def box_corners(part: Body, place: Transform) -> list[Array]:
    rotation, translation = np.array(place.rotation, dtype=np.float64), array(place.translation)
    axes, half = inertia_box(part)
    centre = array(part.com)
    signs = [(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    return [translation + rotation @ (centre + axes @ (np.array(s) * np.array(half))) for s in signs]


def draw(system: System) -> Drawing:
    """The mechanism in its display position."""
    bones = skeleton(system)
    at_zero = extent(system, bones, poses_at(system, display_position(system, 0.0)))
    scale = float(np.linalg.norm(at_zero.max(axis=0) - at_zero.min(axis=0))) or 1.0
    q = display_position(system, scale)
    poses = poses_at(system, q)
    sketch = Sketch(system, scale)
    draw_ground(sketch)
    for body in system.tree.bodies:
        _draw_body(sketch, body, bones[body.index])
        draw_joint(sketch, body, positions(body, q))
    for joint in system.tree.cut_joints:
        draw_joint(sketch, joint, [0.0])
    _draw_springs(sketch)
    if len(system.tree.bodies) <= CROWDED:
        _draw_entities(sketch, bones)
    return _finish(sketch, bones, poses, q)


def _draw_body(sketch: Sketch, body: TreeBody, bones: list[Array]) -> None:
    """Rods from the body's origin to its other points, a translucent hull, centres of mass; where there is nothing
    to join, the uniform box that has the body's mass and inertia."""
    colour = body_colour(body.index)
    for point in bones[1:]:
        sketch.rod(body.index, bones[0], point, place_name(sketch.system, body.index, point))
    if len(bones) > 2:
        sketch.place("hull", body.index, bones, colour, lift=-0.1 * sketch.scale)
    for part, place in body.parts:
        rotation, translation = np.array(place.rotation, dtype=np.float64), array(place.translation)
        centre = translation + rotation @ array(part.com)
        if len(bones) < 2 and part.mass and not sketch.system.tree.children[body.index]:
            _draw_inertia(sketch, body.index, part, rotation, centre)
        if len(bones) < 2 and part.mass:
            sketch.rod(body.index, np.zeros(3), centre, f"the centre of mass of {part.name}")
        if part.mass:
            sketch.place("com", body.index, [centre], "com", 4.5, 0.3 * sketch.scale)


def _draw_inertia(sketch: Sketch, index: int, part: Body, rotation: Array, centre: Array) -> None:
    axes, half = inertia_box(part)
    if max(half) == 0:
        sketch.place("ball", index, [centre], body_colour(index), 1.6 * sketch.symbol)
        return
    least = 0.012 * sketch.scale
    sizes = [max(h, least) for h in half]
    sketch.faces(index, solids.box(centre, rotation @ axes, sizes), body_colour(index), kind="glass")


def _entity_place(system: System, entity: Entity) -> tuple[int, Array]:
    """Where a vector's arrow starts: at its joint, or at the point of its body that has the same number."""
    home = entity.home
    if entity.joint is not None:
        body = system.tree.bodies[entity.joint]
        if home == body.parent and body.joint.type not in ("planar",):
            return home, array(body.joint.origin.translation)
        return body.index, np.zeros(3)
    for other in system.natural.entities:
        if other.kind == "point" and other.label[1:] == entity.label[1:] and home in other.local:
            return home, array(other.local[home])
    return home, np.zeros(3)


def _draw_springs(sketch: Sketch) -> None:
    frames = sketch.system.tree.frames
    for force in sketch.system.scene.forces:
        if isinstance(force, Spring):
            ends = [frames[name] for name in force.between]
            points = [part_point(place, point) for (_, place), point in zip(ends, force.points, strict=True)]
            shape = Shape("spring", ends[0][0], tuple(triple(p) for p in points), "spring", 1.6, 0.0, ends[1][0])
            sketch.shapes.append(shape)


def _draw_entities(sketch: Sketch, bones: dict[int, list[Array]]) -> None:
    """Basic points with a dashed line to those that only carry mass; unit vectors as arrows."""
    system = sketch.system
    for entity in system.natural.entities:
        if entity.kind == "point":
            home = entity.home
            local = array(entity.local[home])
            if not any(np.allclose(local, bone, atol=1e-9) for bone in bones[home]):
                sketch.line(home, [np.zeros(3), local], "auxiliary", 1.2)
            sketch.place("dot", home, [local], "point", 3.2, 0.35 * sketch.scale)
            sketch.labels.append(Label(home, triple(local), entity.label, "point"))
        elif entity.kind == "vector":
            home, start = _entity_place(system, entity)
            if home not in entity.local:
                home, start = entity.home, np.zeros(3)
            tip = start + 0.2 * sketch.scale * unit(array(entity.local[home]))
            sketch.place("arrow", home, [start, tip], "vector", 1.8, 0.3 * sketch.scale)
            sketch.labels.append(Label(home, triple(tip), entity.label, "vector"))


def _finish(sketch: Sketch, bones: dict[int, list[Array]], poses: tuple[Pose, ...], q: list[float]) -> Drawing:
    system = sketch.system
    points = extent(system, bones, poses)
    arrows = [
        ground_point(poses[s.body] if s.body >= 0 else GROUND_POSE, array(p))
        for s in sketch.shapes if s.kind in ("arrow", "sheet", "face") for p in s.points
    ]  # fmt: skip
    everything = np.array([*points, *arrows])
    low, high = everything.min(axis=0), everything.max(axis=0)
    centre = (low + high) / 2
    gravity = array(system.scene.gravity)
    size = float(np.linalg.norm(gravity))
    up = -gravity / size if size else np.array([0.0, 0.0, 1.0])
    sliders, frames = _frames(system, poses, q, sketch.scale)
    plane = system.natural.plane
    return Drawing(
        title=f"Mechanism of {system.scene.name}",
        shapes=tuple(sketch.shapes),
        labels=tuple(sketch.labels),
        frames=frames,
        sliders=sliders,
        centre=triple(centre),
        radius=round(float(np.max(np.linalg.norm(everything - centre, axis=1))), 6) or 1.0,
        up=triple(up),
        gravity=triple(-up) if size else None,
        normal=triple(array(plane[2])) if plane is not None else None,
        description=describe(system),
        rods=tuple(sketch.rods),
    )


def display_words(system: System) -> str:
    """The caption of the drawing."""
    if system.tree.cut_joints:
        return "Drawn with every joint at zero; cut joints in red. Basic points are rings, unit vectors red arrows."
    start = f"Drawn with angles at {ANGLE} rad and slides drawn out, so that nothing hides behind something else. "
    if len(system.tree.bodies) > CROWDED:
        return start + "Grey solids are joints; points and vectors, too many to be drawn, stand in the tables below."
    return (
        start + "Basic points are rings, unit vectors red arrows, dashed lines lead to points that only carry mass; "
        "grey solids are joints."
    )


def describe(system: System) -> str:
    joints = "; ".join(
        f"{body.joint.name} ({body.joint.type}) from "
        f"{system.tree.bodies[body.parent].name if body.parent >= 0 else GROUND} to {body.name}"
        for body in system.tree.bodies
    )
    return f"Drawing of {system.scene.name}: {joints}."


def _frames(
    system: System, poses: Sequence[Pose], q: Sequence[float], scale: float
) -> tuple[tuple[Slider, ...], tuple[Frame, ...]]:
    sliders: list[Slider] = []
    frames = []
    movable = not system.tree.cut_joints
    first: dict[int, int] = {}  # where a joint's coordinates start in q → its first slider
    for body in system.tree.bodies:
        if body.coupling is not None:
            continue
        first[body.q] = len(sliders)
        for k, (label, unit_name, reach) in enumerate(elementary(body.joint, 0, scale)[1] if movable else []):
            spherical = body.joint.type == "spherical"
            value = (ANGLE if k == 0 else 0.0) if spherical else q[body.q + k]
            sliders.append(Slider(label, unit_name, round(-reach, 3), round(reach, 3), value))
    for body in system.tree.bodies:
        motions = elementary(body.joint, first[body.q], scale)[0]
        if body.coupling is not None:
            factor, offset = float(body.coupling.multiplier), float(body.coupling.offset)
            motions = tuple(replace(m, factor=m.factor * factor, offset=m.factor * offset) for m in motions)
        origin = body.joint.origin
        frames.append(
            Frame(
                body.parent,
                tuple(triple(array(row)) for row in origin.rotation),
                triple(array(origin.translation)),
                motions if movable else (),
                tuple(triple(array(row)) for row in poses[body.index].rotation),
                triple(array(poses[body.index].origin)),
            )
        )
    return tuple(sliders), tuple(frames)


def elementary(joint: Joint, first: int, scale: float) -> tuple[tuple[Motion, ...], list[tuple[str, str, float]]]:
    """A joint as turns and slides, each moved by a slider; a spherical joint as three turns (for show only)."""
    name = joint.name
    half, reach = round(math.pi, 3), round(0.5 * scale, 3)
    axis = triple(array(joint.axis)) if joint.axis is not None else (0.0, 0.0, 1.0)
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    if joint.type in ("revolute", "continuous"):
        return (Motion("turn", axis, first),), [(name, "rad", half)]
    if joint.type == "prismatic":
        return (Motion("slide", axis, first),), [(name, "m", reach)]
    if joint.type == "helical":
        pitch = float(joint.pitch or 0)
        return (Motion("turn", axis, first), Motion("slide", axis, first, pitch)), [(name, "rad", 4 * half)]
    if joint.type == "cylindrical":
        return (Motion("turn", axis, first), Motion("slide", axis, first + 1)), [
            (f"{name}, angle", "rad", half),
            (f"{name}, slide", "m", reach),
        ]
    if joint.type == "universal":
        second = triple(array(joint.axis2 or ()))
        return (Motion("turn", axis, first), Motion("turn", second, first + 1)), [
            (f"{name}, first", "rad", half),
            (f"{name}, second", "rad", half),
        ]
    if joint.type == "planar":
        return (Motion("slide", x, first), Motion("slide", y, first + 1), Motion("turn", z, first + 2)), [
            (f"{name}, x", "m", reach),
            (f"{name}, y", "m", reach),
            (f"{name}, angle", "rad", half),
        ]
    if joint.type == "spherical":
        return (Motion("turn", x, first), Motion("turn", y, first + 1), Motion("turn", z, first + 2)), [
            (f"{name}, about x", "rad", half),
            (f"{name}, about y", "rad", half),
            (f"{name}, about z", "rad", half),
        ]
    return (), []
