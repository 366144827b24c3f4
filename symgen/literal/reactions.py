"""What joints transmit: the wrench on every child, and the multipliers of the constraints of natural coordinates.

Wrenches follow from the bodies beyond a joint: what their mass resists, less gravity and springs between points.
Multipliers solve Ψ_xᵀ λ = M ẍ − Q (paper (3.2)) as well as it can be solved: the remainder, which lies in the range of
R, is what actuators, joint springs, dampers and armatures do. Ψ_x has full row rank in every configuration (see
`symgen.natural.constraints`), so λ is unique.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from symgen.algebra.linear import Mat, Vec, add, cross, dot, matvec, mul, scale, sub, total, transpose, vadd, vneg, vsub
from symgen.algebra.sparse import gram, solve_symmetric
from symgen.errors import SceneError
from symgen.literal.frames import carriers, pseudo, resultant, weigh
from symgen.literal.regressor import accelerations
from symgen.scene.model import Spring
from symgen.velocity import kinematics as motion

if TYPE_CHECKING:
    from symgen.literal.equations import Literal

Scalar = Any


@dataclass(frozen=True)
class End:
    """One end of a spring between points: the tree body it pulls, where, and how (ground axes)."""

    body: int
    local: Vec
    """The point in the body's frame."""
    point: Vec
    force: Vec


def spring_ends(literal: Literal) -> Iterator[End]:
    """Ends of all springs between points, those in ground left out."""
    values = literal.values
    for spring in values.scene.forces:
        pulled = literal.spring_pull(spring) if isinstance(spring, Spring) else None
        if pulled is None:
            continue
        assert isinstance(spring, Spring)
        first, second, force = pulled
        for end, ((body, point), pull) in enumerate(((first, force), (second, vneg(force)))):
            if body >= 0:
                _, rotation, translation = values.frame(literal.tree, spring.between[end])
                local = vadd(matvec(rotation, values.point(spring, end)), translation)
                yield End(body, local, point, pull)


def joint_wrenches(literal: Literal) -> Mat:
    """W (moving bodies, 6), of each joint on its child: force, then moment about the child's origin, child axes."""
    bodies = literal.tree.bodies
    wrenches: list[tuple[Vec, Vec]] = []
    for body, field in zip(bodies, accelerations(literal), strict=True):
        wrenches.append(resultant(carriers(literal, body.index), weigh(pseudo(literal, body.index), field)))
    for end in spring_ends(literal):
        own, moment = wrenches[end.body]
        wrenches[end.body] = vsub(own, end.force), vsub(moment, cross(end.point, end.force))
    rows: list[Vec] = [()] * len(bodies)
    for body in reversed(bodies):
        force, moment = wrenches[body.index]
        if body.parent >= 0:
            above = wrenches[body.parent]
            wrenches[body.parent] = vadd(above[0], force), vadd(above[1], moment)
        pose = literal.at.poses[body.index]
        to_child = transpose(pose.rotation)
        rows[body.index] = (*matvec(to_child, force), *matvec(to_child, vsub(moment, cross(pose.origin, force))))
    return tuple(rows)


# --- multipliers ----------------------------------------------------------------------------------------------------


def spring_loads(literal: Literal) -> dict[int, Vec]:
    """Q of springs between points, per entity: a point is Σ c_n · (carrier n), carrier n gets c̄_n times its force."""
    natural, found = literal.natural, dict[int, Vec]()
    for end in spring_ends(literal):
        force = literal.components(end.force)
        for index, part in zip(natural.carriers[end.body], _shares(literal, end, force), strict=True):
            found[index] = vadd(found[index], part) if index in found else part
    return found


def _shares(literal: Literal, end: End, force: Vec) -> list[Vec]:
    """The force's part on each carrier: (1, x) W⁻¹, complex in planar scenes."""
    natural, values = literal.natural, literal.values
    inverse = natural.W_inverse[end.body]
    if natural.plane is None:
        rows = [values.vector(row) for row in inverse]
        head = (1, *end.local)
        return [
            scale(total(mul(x, row[n]) for x, row in zip(head, rows, strict=True)), force) for n in range(len(rows))
        ]
    x, y = (dot(values.vector(axis), end.local) for axis in natural.body_planes[end.body][:2])
    found = []
    for one, turn in zip(*inverse, strict=True):
        (a, b), (c, d) = values.vector(one), values.vector(turn)
        real = add(a, sub(mul(x, c), mul(y, d)))
        imaginary = add(b, add(mul(x, d), mul(y, c)))
        f, g = force
        found.append((add(mul(real, f), mul(imaginary, g)), sub(mul(real, g), mul(imaginary, f))))
    return found


def natural_accelerations(literal: Literal) -> list[Vec]:
    """ẍ = R a + Ṙ v per moving entity, by outward passes that form neither."""
    at, twists = literal.at, literal.twists
    bias = motion.bias_accelerations(at, twists, literal.state.v)
    moved = motion.twists(at, literal.state.a)
    summed = [
        motion.Twist(vadd(x.angular, y.angular), vadd(x.linear, y.linear)) for x, y in zip(bias, moved, strict=True)
    ]
    found: list[Vec] = []
    for entity in literal.moving:
        if entity.kind == "angle":
            found.append((0,))  # carries no mass
            continue
        place = literal.place(entity)
        if entity.kind == "point":
            found.append(literal.components(motion.point_bias(at, twists, summed, entity.home, place)))
        else:
            found.append(literal.components(motion.vector_bias(twists, summed, entity.home, place)))
    return found


def unconstrained_loads(literal: Literal, rates: list[Vec]) -> Vec:
    """M ẍ − Q (nn): gravity and springs between points in Q, ẍ per moving entity given."""
    natural = literal.natural
    gravity = literal.components(literal.values.gravity())
    field: dict[int, Vec] = dict(zip(natural.moving, rates, strict=True))
    for index, entity in enumerate(natural.entities):
        if entity.kind == "point":
            field[index] = vsub(field.get(index, (0,) * entity.size), gravity)
    loads: Mapping[int, Vec] = spring_loads(literal)
    found: list[Scalar] = []
    for index, value in zip(natural.moving, literal.mass_times_field(field), strict=True):
        found.extend(vsub(value, loads[index]) if index in loads else value)
    return tuple(found)


def constraint_forces_and_pivots(literal: Literal) -> tuple[list[Scalar], list[Scalar]]:
    """λ (nc) of the normal equations Ψ Ψᵀ λ = Ψ (M ẍ − Q), and the pivots, positive where they can be solved."""
    jacobian = literal.constraint_jacobian()
    load = unconstrained_loads(literal, natural_accelerations(literal))
    try:
        return solve_symmetric(gram(jacobian), [dot(row, load) for row in jacobian])
    except ZeroDivisionError:
        scene = literal.values.scene
        where = scene.source or scene.name
        raise SceneError("constraints of the natural coordinates depend on each other", where) from None


def constraint_forces(literal: Literal) -> Vec:
    """λ (nc), the least-squares solution of Ψ_xᵀ λ = M ẍ − Q."""
    return tuple(constraint_forces_and_pivots(literal)[0])


def normal_equations(literal: Literal, multipliers: Vec) -> Iterator[tuple[Scalar, Scalar]]:
    """(left, right) of Ψ (Ψᵀ λ) = Ψ (M (R a + Ṙ v) − Q), R and Ṙ by columns: what defines λ."""
    jacobian = literal.constraint_jacobian()
    bias = iter(literal.natural_bias_acceleration())
    moved = literal.apply(literal.r_columns, literal.state.a)
    load = unconstrained_loads(literal, [vadd(value, tuple(next(bias) for _ in value)) for value in moved])
    force: list[Scalar] = [0] * len(load)
    for row, multiplier in zip(jacobian, multipliers, strict=True):
        for k, x in enumerate(row):
            force[k] = add(force[k], mul(x, multiplier))
    for row in jacobian:
        yield dot(row, force), dot(row, load)
