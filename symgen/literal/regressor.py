"""The regressor: inverse dynamics without springs, dampers and armature as a linear map of inertial parameters.

A body's ten parameters are the entries of its pseudo-inertia P = [m, mcᵀ; mc, Σ], Σ = ½ tr(I) 1 − I (theory, §2), and
M is linear in P. Order per moving body: m, mcx, mcy, mcz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz, with I about the origin of the
body's frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from symgen.algebra.linear import (
    Mat,
    Vec,
    add,
    cross,
    dot,
    half,
    is_zero,
    matvec,
    scale,
    sub,
    symmetric,
    total,
    vadd,
    vsub,
)
from symgen.literal.frames import Field, carriers, pseudo, velocity_field
from symgen.natural.mass import entity_mass
from symgen.velocity import kinematics as motion

if TYPE_CHECKING:
    from symgen.literal.equations import Literal

Scalar = Any
PARAMETERS = ("m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
TEN = len(PARAMETERS)


# --- parameters ---------------------------------------------------------------------------------------------------


def pseudo_inertia(ten: Sequence[Scalar]) -> Mat:
    """P (4×4) of ten parameters."""
    mass, x, y, z, xx, xy, yy, xz, yz, zz = ten
    trace = total((xx, yy, zz))
    second = symmetric(
        (sub(half(trace), xx), sub(half(trace), yy), sub(half(trace), zz), sub(0, xy), sub(0, xz), sub(0, yz))
    )
    return ((mass, x, y, z), *((first, *row) for first, row in zip((x, y, z), second, strict=True)))


def ten_parameters(p: Mat) -> Vec:
    """The ten parameters of P."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (row[1:] for row in p[1:])
    return (*p[0], add(yy, zz), sub(0, xy), add(xx, zz), sub(0, xz), sub(0, yz), add(xx, yy))


def inertial_parameters(literal: Literal) -> Vec:
    """π (10 per moving body) of the scene; bodies welded together are one."""
    return tuple(x for body in literal.tree.bodies for x in ten_parameters(pseudo(literal, body.index)))


# --- products -----------------------------------------------------------------------------------------------------


def acceleration_field(literal: Literal, body: int, alpha: Vec, linear: Vec) -> Field:
    """ẍ at the body's origin and axes: its origin's acceleration, and α × u + ω × (ω × u)."""
    _, *axes = carriers(literal, body)
    spin = literal.twists[body].angular
    x, y, z = (vadd(cross(alpha, u), cross(spin, cross(spin, u))) for u in axes)
    return linear, x, y, z


def accelerations(literal: Literal) -> list[Field]:
    """R v̇ + Ṙ v less gravity at the origins and axes of all bodies: what their mass resists."""
    gravity = literal.values.gravity()
    bias = motion.bias_accelerations(literal.at, literal.twists, literal.state.v)
    moved = motion.twists(literal.at, literal.state.a)
    found = []
    for body in literal.tree.bodies:
        here, own = bias[body.index], moved[body.index]
        linear = vsub(vadd(here.linear, own.linear), gravity)
        found.append(acceleration_field(literal, body.index, vadd(here.angular, own.angular), linear))
    return found


def regressor_times(literal: Literal, parameters: Sequence[Scalar]) -> list[Scalar]:
    """Y π: Rᵀ(M (R a + Ṙ v − γ)) in natural coordinates, M of bodies with the parameters π."""
    given = [pseudo_inertia(parameters[TEN * i : TEN * (i + 1)]) for i in range(len(literal.tree.bodies))]
    bias, gravity = iter(literal.natural_bias_acceleration()), literal.components(literal.values.gravity())
    field: dict[int, Vec] = {}
    moving = zip(literal.natural.moving, literal.apply(literal.r_columns, literal.state.a), strict=True)
    for index, value in moving:
        field[index] = vadd(value, tuple(next(bias) for _ in value))
    for index, entity in enumerate(literal.natural.entities):
        if entity.kind == "point":
            field[index] = vsub(field.get(index, (0,) * entity.size), gravity)
    force: dict[int, Vec] = {}
    for (i, k), block in entity_mass(literal.natural, literal.tree, literal.values, given).items():
        if k in field:
            part = matvec(block, field[k]) if isinstance(block, tuple) else scale(block, field[k])
            force[i] = vadd(force[i], part) if i in force else part
    return literal.apply_transposed(
        [force.get(i, (0,) * entity.size) for i, entity in zip(literal.natural.moving, literal.moving, strict=True)]
    )


def regressor(literal: Literal) -> Mat:
    """Y (nv, 10 · moving bodies): the virtual power of every parameter's forces in every column of R."""
    rows: list[list[Scalar]] = [[] for _ in range(literal.tree.nv)]
    columns = _columns(literal)
    for body, field in zip(literal.tree.bodies, accelerations(literal), strict=True):
        for row, column in zip(rows, columns, strict=True):
            seen = column[body.index]
            row.extend((0,) * TEN if seen is None else _powers(seen, field))
    return tuple(tuple(row) for row in rows)


def _powers(seen: Field, field: Field) -> Vec:
    """Σ x_α · (∂P_αβ/∂parameter) ẍ_β for the ten parameters."""
    g = [[dot(x, y) for y in field] for x in seen]
    xx, yy, zz = g[1][1], g[2][2], g[3][3]
    return (
        g[0][0],
        *(add(g[0][k], g[k][0]) for k in (1, 2, 3)),
        half(sub(add(yy, zz), xx)),
        sub(0, add(g[1][2], g[2][1])),
        half(sub(add(xx, zz), yy)),
        sub(0, add(g[1][3], g[3][1])),
        sub(0, add(g[2][3], g[3][2])),
        half(sub(add(xx, yy), zz)),
    )


def _columns(literal: Literal) -> list[list[Field | None]]:
    """Per velocity and body: R's column at the body's origin and axes; None where the body does not move with it."""
    found = []
    for j in range(literal.tree.nv):
        moved = motion.twists(literal.at, [1 if i == j else 0 for i in range(literal.tree.nv)])
        row: list[Field | None] = []
        for body, twist in zip(literal.tree.bodies, moved, strict=True):
            still = all(is_zero(x) for x in (*twist.angular, *twist.linear))
            row.append(None if still else velocity_field(literal, body.index, twist))
        found.append(row)
    return found
