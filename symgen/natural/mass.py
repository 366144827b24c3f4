"""The constant mass matrix of natural coordinates: M_b = (W⁻ᵀ P W⁻¹) ⊗ 1₃, summed over bodies (paper (3.3))."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Protocol

from symgen.algebra import linear
from symgen.algebra.linear import Mat, Scalar, Vec
from symgen.natural.layout import NaturalCoordinates, constant
from symgen.scene.model import Body, Joint, Transform
from symgen.topology.tree import Tree

HALF = Fraction(1, 2)


class InertialValues(Protocol):
    """Constants, and a body's inertial parameters (constants or run-time ones), as scalars of one number type."""

    def lift(self, value: Fraction) -> Scalar: ...
    def placed(self, chain: Sequence[Joint], pose: Transform) -> tuple[Mat, Vec]:
        """``pose``, with run-time origins of the joints in ``chain``, which make it up, in their places."""
        ...

    def mass(self, body: Body) -> Scalar: ...
    def com(self, body: Body) -> Vec:
        """Centre of mass in body axes (3)."""
        ...

    def inertia(self, body: Body) -> Vec:
        """(ixx, iyy, izz, ixy, ixz, iyz) about the centre of mass in body axes."""
        ...


class SceneValues:
    """The constants of the scene, as rationals."""

    def lift(self, value: Fraction) -> Scalar:
        return constant(value, None)

    def placed(self, chain: Sequence[Joint], pose: Transform) -> tuple[Mat, Vec]:
        return tuple(_lift(row, self) for row in pose.rotation), _lift(pose.translation, self)

    def mass(self, body: Body) -> Fraction:
        return body.mass

    def com(self, body: Body) -> tuple[Fraction, ...]:
        return body.com

    def inertia(self, body: Body) -> tuple[Fraction, ...]:
        return body.inertia


def _lift(row: Sequence[Fraction], values: InertialValues) -> Vec:
    return tuple(values.lift(value) for value in row)


def _structural(values: Sequence[Scalar]) -> Vec:
    """Rational zeros become the int that linear algebra skips."""
    return tuple(0 if isinstance(value, Fraction) and value == 0 else value for value in values)


def _own_pseudo_inertia(body: Body, values: InertialValues) -> Mat:
    """P about the body's own origin: [m, m cᵀ; m c, Σ_c + m c cᵀ], Σ_c = ½ tr(I_c)·1 − I_c."""
    (mass,), com = _structural((values.mass(body),)), _structural(values.com(body))
    xx, yy, zz, xy, xz, yz = _structural(values.inertia(body))
    trace = linear.mul(values.lift(HALF), linear.total((xx, yy, zz)))
    six = [linear.sub(trace, moment) for moment in (xx, yy, zz)] + [linear.sub(0, value) for value in (xy, xz, yz)]
    first = linear.scale(mass, com)
    second = linear.madd(linear.symmetric(six), linear.outer(first, com))
    return ((mass, *first), *((first[k], *second[k]) for k in range(3)))


def pseudo_inertia(
    parts: Sequence[tuple[Body, Transform]], values: InertialValues, welds: Sequence[Sequence[Joint]] = ()
) -> Mat:
    """P = ∫ρ [1; x][1; x]ᵀ (4×4: kg, kg·m, kg·m²) of bodies welded together, about the origin and in the axes of the
    frame that their transforms refer to: the sum of T P Tᵀ, T = [1, 0; t, R]. ``welds``: per part, the fixed joints
    that make up its transform."""
    total: Mat = ((0,) * 4,) * 4
    for (body, pose), chain in zip(parts, welds or [()] * len(parts), strict=True):
        own = _own_pseudo_inertia(body, values)
        rotation, translation = values.placed(chain, pose)
        turn = ((1, 0, 0, 0), *((shift, *row) for shift, row in zip(translation, rotation, strict=True)))
        moved = linear.matmul(linear.matmul(turn, own), linear.transpose(turn))
        total = linear.madd(total, _symmetric(moved))
    return total


def _symmetric(matrix: Mat) -> Mat:
    """The upper triangle, mirrored: the same scalar on both sides."""
    n = len(matrix)
    return tuple(tuple(matrix[min(i, j)][max(i, j)] for j in range(n)) for i in range(n))


def _spatial_blocks(inverse: Mat, pseudo: Mat, values: InertialValues) -> Mat:
    exact = tuple(_lift(row, values) for row in inverse)
    return _symmetric(linear.matmul(linear.transpose(exact), linear.matmul(pseudo, exact)))


def _times(a: Vec, b: Vec) -> Vec:
    """Complex product of pairs."""
    real = linear.sub(linear.mul(a[0], b[0]), linear.mul(a[1], b[1]))
    return (real, linear.add(linear.mul(a[0], b[1]), linear.mul(a[1], b[0])))


def _conjugate(a: Vec) -> Vec:
    return (a[0], linear.sub(0, a[1]))


def planar_pseudo_inertia(pseudo: Mat, basis: Mat) -> tuple[Scalar, Vec, Scalar]:
    """(m, m c, I_o) in a plane: c as a pair along e1 and e2, I_o about the normal through the body's origin."""
    e1, e2 = basis[0], basis[1]
    first = pseudo[0][1:]
    second = tuple(row[1:] for row in pseudo[1:])
    moment = linear.add(linear.dot(e1, linear.matvec(second, e1)), linear.dot(e2, linear.matvec(second, e2)))
    return pseudo[0][0], (linear.dot(e1, first), linear.dot(e2, first)), moment


def _planar_blocks(inverse: Mat, pseudo: Mat, basis: Mat, values: InertialValues) -> Mat:
    """W⁻ᴴ P W⁻¹ with P = [m, m c; m c̄, I_o], each complex a + ib written as [[a, −b], [b, a]]."""
    mass, first, moment = planar_pseudo_inertia(pseudo, tuple(_lift(axis, values) for axis in basis))
    complex_p = (((mass, 0), first), (_conjugate(first), (moment, 0)))
    w = tuple(tuple(_lift(entry, values) for entry in row) for row in inverse)

    def entry(i: int, j: int) -> Vec:
        total: Vec = (0, 0)
        for k in range(2):
            for n in range(2):
                total = linear.vadd(total, _times(_times(_conjugate(w[k][i]), complex_p[k][n]), w[n][j]))
        return total

    coupling = entry(0, 1)
    diagonal = [entry(0, 0)[0], entry(1, 1)[0]]
    a, b = coupling
    minus = linear.sub(0, b)
    return (
        (((diagonal[0], 0), (0, diagonal[0])), ((a, minus), (b, a))),
        (((a, b), (minus, a)), ((diagonal[1], 0), (0, diagonal[1]))),
    )


def entity_mass(
    natural: NaturalCoordinates, tree: Tree, values: InertialValues, given: Sequence[Mat] | None = None
) -> dict[tuple[int, int], Any]:
    """(i, j) → block of M between entities i and j, ground-fixed ones included, both orders, zeros left out.

    In space a block is a scalar μ that stands for μ·1₃; in planar scenes a 2×2 tuple of rows. Needed with the
    ground's rows and columns for gravity: Q_b = M_b γ, γ = g at points and 0 at vectors. ``given``: pseudo-inertias in
    place of the bodies' own.
    """
    total: dict[tuple[int, int], Any] = {}
    for body in tree.bodies:
        pseudo = given[body.index] if given is not None else pseudo_inertia(body.parts, values, body.welds)
        inverse, carriers = natural.W_inverse[body.index], natural.carriers[body.index]
        if natural.plane is None:
            blocks = _spatial_blocks(inverse, pseudo, values)
        else:
            blocks = _planar_blocks(inverse, pseudo, natural.body_planes[body.index], values)
        for i, row in zip(carriers, blocks, strict=True):
            for j, block in zip(carriers, row, strict=True):
                _accumulate(total, (i, j), block)
    return total


def _accumulate(total: dict[tuple[int, int], Any], key: tuple[int, int], block: Any) -> None:
    if isinstance(block, tuple):
        if any(not linear.is_zero(value) for row in block for value in row):
            total[key] = linear.madd(total[key], block) if key in total else block
    elif not linear.is_zero(block):
        total[key] = linear.add(total[key], block) if key in total else block


def natural_mass_matrix(natural: NaturalCoordinates, tree: Tree, values: InertialValues) -> Mat:
    """M (nn × nn), constant and symmetric: T = ½ ẋᵀ M ẋ. Rows and columns of ground-fixed entities are dropped."""
    matrix: list[list[Scalar]] = [[0] * natural.nn for _ in range(natural.nn)]
    for (i, j), block in entity_mass(natural, tree, values).items():
        row, column = natural.entities[i].start, natural.entities[j].start
        if row is None or column is None:
            continue
        for k in range(natural.entities[i].size):
            for n in range(natural.entities[j].size):
                if isinstance(block, tuple):
                    matrix[row + k][column + n] = block[k][n]
                elif k == n:
                    matrix[row + k][column + n] = block
    return tuple(tuple(row) for row in matrix)
