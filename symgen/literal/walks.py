"""R x and Rᵀ y of large trees by one walk each, without forming R.

R factors along the paths of the tree: the velocity of an entity follows from the motion of its body, which follows
from the parent's (paper (4.1), (4.3)); transposed, what acts on entities is summed from the leaves, and every joint
takes its part of the sum of what is beyond it. The numbers are those of R assembled block by block.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symgen.algebra.linear import ZERO, Vec, add, cross, dot, scale, vadd
from symgen.natural.entities import Entity
from symgen.natural.layout import NaturalCoordinates
from symgen.velocity import kinematics as motion
from symgen.velocity.values import Values

Scalar = Any
LARGE = 40
"""Trees of more bodies are walked."""


def velocities(
    at: motion.Kinematics,
    natural: NaturalCoordinates,
    values: Values,
    places: Sequence[tuple[Entity, Vec]],
    x: Sequence[Scalar],
) -> list[Vec]:
    """R x per entity, given with its place in ground axes."""
    moving = motion.twists(at, x)
    found: list[Vec] = []
    for entity, place in places:
        if entity.kind == "angle":
            body = at.tree.bodies[entity.home]
            found.append((scale(values.multiplier(body), (x[body.v],))[0],))
        elif entity.kind == "point":
            found.append(components(natural, values, motion.point_velocity(at, moving, entity.home, place)))
        else:
            found.append(components(natural, values, cross(moving[entity.home].angular, place)))
    return found


def components(natural: NaturalCoordinates, values: Values, x: Vec) -> Vec:
    """Ground-axes vector → the rows an entity occupies (its in-plane components in planar scenes)."""
    if natural.plane is None:
        return x
    return tuple(dot(values.vector(axis), x) for axis in natural.plane[:2])


def forces(
    at: motion.Kinematics,
    natural: NaturalCoordinates,
    values: Values,
    places: Sequence[tuple[Entity, Vec]],
    y: Sequence[Vec],
) -> list[Scalar]:
    """Rᵀ y, with y per entity."""
    tree = at.tree
    result: list[Scalar] = [0] * tree.nv
    sums = [(ZERO, ZERO) for _ in tree.bodies]
    for (entity, place), value in zip(places, y, strict=True):
        if entity.kind == "angle":
            body = tree.bodies[entity.home]
            result[body.v] = add(result[body.v], scale(values.multiplier(body), value)[0])
            continue
        full = _in_ground_axes(natural, values, value)
        own = (full if entity.kind == "point" else ZERO, cross(place, full))
        sums[entity.home] = _joined(sums[entity.home], own)
    for body in reversed(tree.bodies):
        force, moment = sums[body.index]
        joint = at.motions[body.index]
        turning = vadd(moment, cross(force, joint.reference))  # about the joint's reference: Σ (r − r_j) × f
        for k, column in enumerate(joint.columns):
            felt = add(dot(column.v, force), dot(column.w, turning))
            result[body.v + k] = add(result[body.v + k], felt)
        if body.parent >= 0:
            sums[body.parent] = _joined(sums[body.parent], sums[body.index])
    return result


def _joined(a: tuple[Vec, Vec], b: tuple[Vec, Vec]) -> tuple[Vec, Vec]:
    return vadd(a[0], b[0]), vadd(a[1], b[1])


def _in_ground_axes(natural: NaturalCoordinates, values: Values, value: Vec) -> Vec:
    if natural.plane is None:
        return value
    first, second = (values.vector(axis) for axis in natural.plane[:2])
    return vadd(scale(value[0], first), scale(value[1], second))
