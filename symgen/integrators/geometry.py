"""What steps need to know of joints: where quaternions are, brackets of velocities, and which velocities meet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import Vec, add, cross, mul, sub, vadd, vsub
from symgen.integrators.model import Place
from symgen.scene.model import Spring
from symgen.topology.tree import Tree, TreeBody
from symgen.velocity.kinematics import configuration_rate
from symgen.velocity.rotation import renormalise

Scalar = Any
HALF, TWELFTH = Fraction(1, 2), Fraction(1, 12)


def rate(place: Place, q: Sequence[Scalar], v: Sequence[Scalar]) -> Vec:
    """dq/dt."""
    return configuration_rate(place.tree, place.values, q, v)


def moved(x: Sequence[Scalar], step: Scalar, rates: Sequence[Scalar]) -> Vec:
    """x + step · rates."""
    return tuple(add(a, mul(step, b)) for a, b in zip(x, rates, strict=True))


def normalised(place: Place, q: Sequence[Scalar]) -> Vec:
    """q with its quaternions brought back to norm one, as `integrate` does."""
    found = list(q)
    for start in quaternions(place.tree):
        found[start : start + 4] = renormalise(tuple(q[start : start + 4]))
    return tuple(found)


def turning(body: TreeBody) -> bool:
    """Whether the joint has a quaternion of its own."""
    return body.coupling is None and body.joint.type in ("spherical", "floating")


def quaternions(tree: Tree) -> Iterator[int]:
    """Where the quaternions start in q."""
    for body in tree.bodies:
        if turning(body):
            yield body.q + body.nq - 4


def logarithmic_rate(place: Place, u: Sequence[Scalar], v: Sequence[Scalar]) -> Vec:
    """The rate of w where q ⊕ w moves with velocity v and w = u is small: v ± ½ [u, v] + ¹⁄₁₂ [u, [u, v]], the inverse
    of the exponential's tangent up to third powers of u (Hairer, Lubich, Wanner, Geometric Numerical Integration,
    IV.7); the sign is that of the side from which ⊕ turns."""
    found = list(v)
    for body in place.tree.bodies:
        if turning(body):
            here = slice(body.v, body.v + body.nv)
            x, y, world = tuple(u[here]), tuple(v[here]), in_ground_axes(place, body)
            once = _bracket(place, body, x, y)
            twice = _bracket(place, body, x, once)
            half = tuple(mul(-HALF if world else HALF, z) for z in once)
            found[here] = vadd(vadd(y, half), tuple(mul(TWELFTH, z) for z in twice))
    return tuple(found)


def in_ground_axes(place: Place, body: TreeBody) -> bool:
    """Whether the joint's angular velocity is in ground axes, and ⊕ turns from the left."""
    return body.joint.type == "floating" and place.values.scene.options.base_velocity == "world"


def _bracket(place: Place, body: TreeBody, x: Vec, y: Vec) -> Vec:
    """[x, y]: of turns x × y, of rigid motions (linear, angular) in their own axes that of se(3)."""
    if body.joint.type == "spherical":
        return cross(x, y)
    angular = cross(x[3:], y[3:])
    if place.values.scene.options.base_velocity != "body":
        return (0, 0, 0, *angular)
    return (*vsub(cross(x[3:], y[:3]), cross(y[3:], x[:3])), *angular)


def related(place: Place) -> list[list[bool]]:
    """Which pairs of velocities can have a common entry in the mass matrix and in the derivatives of forces: those one
    of which is on the other's way to the root; all of them where springs or couplings join branches, or if not
    sparse."""
    tree, n = place.tree, place.tree.nv
    joined = tree.coupled or any(isinstance(force, Spring) for force in place.values.scene.forces)
    if joined or not place.sparse:
        return [[True] * n for _ in range(n)]
    found = [[False] * n for _ in range(n)]
    for body in tree.bodies:
        own = range(body.v, body.v + body.nv)
        for other in tree.path(body.index):
            above = tree.bodies[other]
            for i in own:
                for j in range(above.v, above.v + above.nv):
                    found[i][j] = found[j][i] = True
    return found


def square(x: Sequence[Scalar], n: int) -> list[list[Scalar]]:
    """Row-major entries as n rows."""
    return [list(x[n * i : n * i + n]) for i in range(n)]


def reciprocal(x: Scalar) -> Scalar:
    """1/x; of a plain number exact."""
    return 1 / (Fraction(x) if isinstance(x, int) else x)


def factored(place: Place, matrix: list[list[Scalar]]) -> list[list[Scalar]]:
    """A = U L from the last row up, so that a tree fills nothing in: U above the diagonal (its own is one), L below, on
    the diagonal the reciprocals of L's. No pivoting: A is a mass matrix and what a short step adds to it."""
    n, pairs = len(matrix), related(place)
    a = [[x if pairs[i][j] else 0 for j, x in enumerate(row)] for i, row in enumerate(matrix)]
    for k in reversed(range(n)):
        a[k][k] = reciprocal(a[k][k])
        for i in range(k):
            if pairs[i][k]:
                a[i][k] = mul(a[i][k], a[k][k])
                for j in range(k):
                    if pairs[k][j]:
                        a[i][j] = sub(a[i][j], mul(a[i][k], a[k][j]))
    return a


def solved(place: Place, a: list[list[Scalar]], right: Sequence[Scalar]) -> list[Scalar]:
    """x with U L x = right, for what `factored` leaves."""
    x, n, pairs = list(right), len(right), related(place)
    for k in reversed(range(n)):
        for i in range(k):
            if pairs[i][k]:
                x[i] = sub(x[i], mul(a[i][k], x[k]))
    for k in range(n):
        for j in range(k):
            if pairs[k][j]:
                x[k] = sub(x[k], mul(a[k][j], x[j]))
        x[k] = mul(x[k], a[k][k])
    return x
