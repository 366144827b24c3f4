"""Random trees of every joint type with exact rational geometry, and what the tests of this room compute on them."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction as F
from typing import Any

from symgen.algebra.field import FieldNumbers, Residue
from symgen.algebra.linear import cross, dot, matvec, symmetric, transpose, vadd
from symgen.algebra.numbers import State
from symgen.natural.coordinates import choose_coordinates, natural_coordinates
from symgen.natural.layout import NaturalCoordinates
from symgen.scene.model import GROUND, Body, Joint, Matrix3, Scene, Transform, Vector
from symgen.topology.tree import Tree, build_tree
from symgen.velocity.kinematics import Kinematics, kinematics, point_columns, twists, vector_columns
from symgen.velocity.values import Values

X, Y, Z = (F(1), F(0), F(0)), (F(0), F(1), F(0)), (F(0), F(0), F(1))
AXES: tuple[Vector, ...] = (
    X, Y, Z, (F(0), F(0), F(-1)), (F(3, 5), F(0), F(4, 5)), (F(-2, 3), F(1, 3), F(2, 3)), (F(6, 7), F(-3, 7), F(2, 7)),
)  # fmt: skip
SPATIAL_TYPES = (
    "revolute", "continuous", "prismatic", "helical", "cylindrical", "universal", "planar", "spherical", "floating",
    "fixed",
)  # fmt: skip
PLANAR_TYPES = ("revolute", "continuous", "prismatic", "planar")


def rotation(w: int, x: int, y: int, z: int) -> Matrix3:
    """The rational rotation of an integer quaternion."""
    n = F(w * w + x * x + y * y + z * z)
    return (
        ((w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n),
        (2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n),
        (2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n),
    )


def triple(values: Iterable[F]) -> Vector:
    x, y, z = values
    return (x, y, z)


def random_vector(rng: random.Random) -> Vector:
    """Often zero, often along an axis, so that points coincide and lie on axes."""
    choice = rng.randrange(5)
    if choice < 2:
        return (F(0), F(0), F(0))
    if choice == 2:
        k, length = rng.randrange(3), F(rng.randint(-8, 8), 8)
        return triple(length if k == i else F(0) for i in range(3))
    return triple(F(rng.randint(-9, 9), 10) for _ in range(3))


def random_rotation(rng: random.Random) -> Matrix3:
    if rng.randrange(3) == 0:
        return Transform().rotation
    x, y, z = (rng.randint(-2, 2) for _ in range(3))
    return rotation(1, x, y, z)


def random_body(rng: random.Random, name: str) -> Body:
    if rng.randrange(4) == 0:
        return Body(name)  # massless
    xx, yy, zz = (F(rng.randint(5, 9), 10) for _ in range(3))
    xy, xz, yz = (F(rng.randint(-9, 9), 100) for _ in range(3))
    points = tuple(random_vector(rng) for _ in range(rng.randrange(3)))
    vectors = tuple(rng.choice(AXES) for _ in range(rng.randrange(2)))
    return Body(name, F(rng.randint(1, 30), 10), random_vector(rng), (xx, yy, zz, xy, xz, yz), points, vectors)


def random_scene(rng: random.Random, count: int, types: tuple[str, ...] = SPATIAL_TYPES) -> Scene:
    """A branching tree; the axis is often the parent's, so that consecutive axes coincide."""
    names = [GROUND] + [f"b{k}" for k in range(count)]
    bodies, joints = [], []
    for k in range(count):
        axis = rng.choice(AXES)
        joint_type = rng.choice(types)
        axis2 = rng.choice([a for a in AXES if a not in (axis, tuple(-x for x in axis))])
        parent = names[max(0, k - rng.randrange(3))]
        origin = Transform(random_rotation(rng), random_vector(rng))
        pitch = F(rng.randint(-3, 3), 20)
        joints.append(Joint(f"j{k}", joint_type, parent, names[k + 1], origin, axis, axis2, pitch))
        bodies.append(random_body(rng, names[k + 1]))
    return Scene("random", tuple(bodies), tuple(strip(joint) for joint in joints))


def strip(joint: Joint) -> Joint:
    """Only the fields that the joint's type has."""
    has_axis = joint.type in ("revolute", "continuous", "prismatic", "helical", "cylindrical", "universal")
    return Joint(
        joint.name, joint.type, joint.parent, joint.child, joint.origin, joint.axis if has_axis else None,
        joint.axis2 if joint.type == "universal" else None, joint.pitch if joint.type == "helical" else None,
    )  # fmt: skip


def random_planar_scene(rng: random.Random, count: int) -> Scene:
    """A tree in the plane through a random normal; every frame is turned about it, some are mounted upside down."""
    names = [GROUND] + [f"b{k}" for k in range(count)]
    tilt = random_rotation(rng)
    in_frame = {"prismatic": ((F(3, 5), F(4, 5), F(0)), X, Y)}
    bodies, joints = [], []
    for k in range(count):
        joint_type = "revolute" if k == 0 else rng.choice(PLANAR_TYPES)
        parent = names[max(0, k - rng.randrange(3))]
        about = rotation(rng.randint(1, 3), 0, 0, rng.randint(-3, 3))
        if rng.randrange(3) == 0:
            about = times(about, rotation(0, 1, 0, 0))  # turned over about x
        if parent == GROUND:
            about = times(tilt, about)
        axis = rng.choice(in_frame.get(joint_type, (Z, (F(0), F(0), F(-1)))))
        joints.append(
            strip(Joint(f"j{k}", joint_type, parent, names[k + 1], Transform(about, random_vector(rng)), axis))
        )
        body = random_body(rng, names[k + 1])
        bodies.append(Body(body.name, body.mass, body.com, body.inertia, body.basic_points))
    return Scene("random_planar", tuple(bodies), tuple(joints))


def times(a: Matrix3, b: Matrix3) -> Matrix3:
    x, y, z = (triple(sum((row[k] * b[k][j] for k in range(3)), F(0)) for j in range(3)) for row in a)
    return (x, y, z)


@dataclass(frozen=True)
class Sample:
    """A tree at a random configuration and velocity in GF(p)."""

    tree: Tree
    natural: NaturalCoordinates
    values: Values
    numbers: FieldNumbers
    at: Kinematics
    state: State

    @property
    def x(self) -> tuple[Any, ...]:
        return natural_coordinates(self.natural, self.tree, self.at.poses, self.state, self.numbers)


def sample(scene: Scene, rng: random.Random, planar: bool = True) -> Sample:
    tree = build_tree(scene)
    numbers = FieldNumbers(seed=rng.randrange(1 << 30))

    def draw(n: int) -> tuple[Residue, ...]:
        return tuple(Residue(rng.randrange(numbers.p), numbers.p) for _ in range(n))

    state = State(q=draw(tree.nq), v=draw(tree.nv), p=draw(sum(parameter.size for parameter in scene.parameters)))
    values = Values(scene, numbers, state.p)
    return Sample(tree, choose_coordinates(tree, planar), values, numbers, kinematics(tree, values, state.q), state)


def transformation(s: Sample) -> list[list[Any]]:
    """R (nn × nv): for an entity of home body i, v + w × d or w × u for every joint on the way to i."""
    rows: list[list[Any]] = [[0] * s.tree.nv for _ in range(s.natural.nn)]
    for k in s.natural.moving:
        entity = s.natural.entities[k]
        start, pose = entity.start, s.at.pose(entity.home)
        assert start is not None
        if entity.kind == "angle":
            rows[start][s.tree.bodies[entity.home].v] = 1
            continue
        local = s.values.vector(entity.local[entity.home])
        if entity.kind == "point":
            columns = point_columns(s.at, entity.home, pose.point(local))
        else:
            columns = vector_columns(s.at, entity.home, pose.vector(local))
        for column, value in columns.items():
            components = value
            if s.natural.plane is not None:
                basis = [s.values.vector(axis) for axis in s.natural.plane[:2]]
                components = tuple(dot(axis, value) for axis in basis)
            for m in range(entity.size):
                rows[start + m][column] = components[m]
    return rows


def number(value: Any, p: int) -> int:
    if isinstance(value, Residue):
        return value.x
    value = F(value)
    return int(value.numerator * pow(value.denominator, -1, p)) % p


def rank(matrix: Any, p: int) -> int:
    """Rank over GF(p)."""
    rows = [[number(value, p) for value in row] for row in matrix]
    found = 0
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((k for k in range(found, len(rows)) if rows[k][column]), None)
        if pivot is None:
            continue
        rows[found], rows[pivot] = rows[pivot], rows[found]
        over = pow(rows[found][column], -1, p)
        for k in range(found + 1, len(rows)):
            if rows[k][column]:
                factor = rows[k][column] * over % p
                rows[k] = [(a - factor * b) % p for a, b in zip(rows[k], rows[found], strict=True)]
        found += 1
    return found


def body_energy_twice(s: Sample) -> Any:
    """Σ m |v_c|² + ωᵀ I_c ω over all bodies, straight from the twists."""
    total: Any = 0
    for body, twist in zip(s.tree.bodies, twists(s.at, s.state.v), strict=True):
        pose = s.at.poses[body.index]
        for part, where in body.parts:
            turn, shift = s.values.transform(where)
            arm = pose.vector(vadd(shift, matvec(turn, s.values.com(part))))
            velocity = vadd(twist.linear, cross(twist.angular, arm))
            spin = matvec(transpose(turn), matvec(transpose(pose.rotation), twist.angular))
            momentum = matvec(symmetric(s.values.inertia(part)), spin)
            total = total + s.values.mass(part) * dot(velocity, velocity) + dot(momentum, spin)
    return total


def rates(s: Sample) -> tuple[Any, ...]:
    """ẋ = R θ̇."""
    return tuple(dot(row, s.state.v) for row in transformation(s))


def quadratic(matrix: Any, x: Any) -> Any:
    """xᵀ matrix x."""
    return dot(x, matvec(matrix, x))
