"""Exact orthonormal bases, and whether a mechanism is planar."""

from __future__ import annotations

from fractions import Fraction

from symgen.algebra import linear
from symgen.natural.entities import Vector
from symgen.natural.layout import Basis, Complex
from symgen.scene.model import Joint, Matrix3
from symgen.topology.tree import Tree

X: Vector = (Fraction(1), Fraction(0), Fraction(0))
Y: Vector = (Fraction(0), Fraction(1), Fraction(0))
Z: Vector = (Fraction(0), Fraction(0), Fraction(1))
NOTHING = Fraction(0)
AXES: Basis = (X, Y, Z)

TURNING = ("revolute", "continuous", "planar")
SLIDING = ("prismatic",)


def vector(values: linear.Vec) -> Vector:
    """Three exact components (ints of structural zeros become rationals)."""
    x, y, z = values
    return (Fraction(x), Fraction(y), Fraction(z))


def negated(a: Vector) -> Vector:
    return (-a[0], -a[1], -a[2])


def difference(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def product(a: Vector, b: Vector) -> Fraction:
    """a · b, zeros skipped (rational arithmetic is slow)."""
    found = [x * y for x, y in zip(a, b, strict=True) if x and y]
    return sum(found[1:], found[0]) if found else Fraction(0)


def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return (
        product((a[1], a[2], NOTHING), (b[2], -b[1], NOTHING)),
        product((a[2], a[0], NOTHING), (b[0], -b[2], NOTHING)),
        product((a[0], a[1], NOTHING), (b[1], -b[0], NOTHING)),
    )


def turned(rotation: Matrix3, local: Vector) -> Vector:
    """rotation · local."""
    return (product(rotation[0], local), product(rotation[1], local), product(rotation[2], local))


def turned_back(rotation: Matrix3, outer: Vector) -> Vector:
    """rotationᵀ · outer."""
    columns: list[Vector] = list(zip(*rotation, strict=True))
    return (product(columns[0], outer), product(columns[1], outer), product(columns[2], outer))


def complement(n: Vector) -> tuple[Vector, Vector]:
    """Rational unit vectors e1, e2 with e1 × e2 = n, for a rational unit vector n.

    The Householder reflection that takes the coordinate axis nearest to n into n is rational; it takes the two
    other axes into the vectors wanted.
    """
    k = max(range(3), key=lambda axis: abs(n[axis]))
    i, j = (k + 1) % 3, (k + 2) % 3
    sign = 1 if n[k] > 0 else -1
    nearest = AXES[k] if sign > 0 else negated(AXES[k])
    mirror = difference(n, nearest)
    square = product(mirror, mirror)
    first, second = AXES[i], AXES[j]
    if square:
        first = difference(AXES[i], vector(linear.scale(2 * mirror[i] / square, mirror)))
        second = difference(AXES[j], vector(linear.scale(2 * mirror[j] / square, mirror)))
        sign = -sign  # a reflection turns a right-handed basis into a left-handed one
    return (first, second) if sign > 0 else (second, first)


def ground_basis(normal: Vector) -> Basis:
    """The plane of a normal, seen as people draw it: (x, y), (x, z) or (y, z) where it is one of those."""
    for drawn in ((X, Y, Z), (X, Z, negated(Y)), (Y, Z, X)):
        if normal in (drawn[2], negated(drawn[2])):
            return drawn
    last = next(component for component in reversed(normal) if component)
    upright = normal if last > 0 else negated(normal)
    return (*complement(upright), upright)


def joint_axis(joint: Joint) -> Vector:
    """The axis (planar joints: the normal) in joint axes, which are the child's axes at zero position."""
    return Z if joint.axis is None else joint.axis


def fits(joint: Joint, normal: Vector) -> bool:
    """True when the joint moves within the plane of ``normal`` (joint axes)."""
    axis = joint_axis(joint)
    if joint.type in TURNING:
        return normal in (axis, negated(axis))
    return joint.type in SLIDING and product(normal, axis) == 0


def _first_normal(tree: Tree) -> Vector | None:
    """The axis of the first joint that turns, in ground axes at zero position."""
    for body in tree.bodies:
        if body.joint.type in TURNING:
            normal = joint_axis(body.joint)
            for index in reversed(tree.path(body.index)):
                normal = turned(tree.bodies[index].joint.origin.rotation, normal)
            return normal
        if body.joint.type not in SLIDING:
            return None
    return None


def find_plane(tree: Tree) -> tuple[Basis, tuple[Basis, ...]] | None:
    """The plane in which every motion of the tree lies, in ground axes and in each body's axes; else None.

    All joints must be revolute about the normal, prismatic across it, or planar; at least one of them must turn.
    A body's basis is its own: only its normal must be the ground's, so numbers stay short along chains.
    """
    start = _first_normal(tree)
    if start is None:
        return None
    ground = ground_basis(start)
    normals: list[Vector] = []
    for body in tree.bodies:
        parent = ground[2] if body.parent < 0 else normals[body.parent]
        normal = turned_back(body.joint.origin.rotation, parent)
        if not fits(body.joint, normal):
            return None
        normals.append(normal)
    for joint in tree.cut_joints:
        sides = []
        for name in (joint.parent, joint.child):
            home, pose = tree.frames[name]
            sides.append(turned_back(pose.rotation, ground[2] if home < 0 else normals[home]))
        if turned_back(joint.origin.rotation, sides[0]) != sides[1] or not fits(joint, sides[1]):
            return None
    return ground, tuple((*complement(normal), normal) for normal in normals)


def in_plane(basis: Basis, local: Vector) -> Complex:
    return (product(basis[0], local), product(basis[1], local))
