"""½ ẋᵀ M ẋ is the kinetic energy and M γ the weight, exactly over GF(p); textbook matrices; degenerate bodies."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F
from typing import Any

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.algebra.linear import cross, dot, matvec, vadd
from symgen.algebra.numbers import FloatNumbers
from symgen.natural.coordinates import choose_coordinates, ground_coordinates
from symgen.natural.mass import SceneValues, entity_mass, natural_mass_matrix, pseudo_inertia
from symgen.scene.model import GROUND, Body, Joint, Parameter, Scene, Transform
from symgen.topology.tree import build_tree
from symgen.velocity.kinematics import twists
from symgen.velocity.values import Values
from tests.natural.trees import (
    Sample,
    X,
    Y,
    Z,
    body_energy_twice,
    quadratic,
    random_planar_scene,
    random_scene,
    random_vector,
    rates,
    rotation,
    sample,
)

NOTHING = (F(0),) * 6


def twice_energy(s: Sample) -> Any:
    return quadratic(natural_mass_matrix(s.natural, s.tree, s.values), rates(s))


@settings(max_examples=40, deadline=None)
@given(st.randoms(use_true_random=False), st.integers(1, 5))
def test_kinetic_energy(rng: random.Random, count: int) -> None:
    s = sample(random_scene(rng, count), rng)
    assert twice_energy(s) == body_energy_twice(s)


@settings(max_examples=25, deadline=None)
@given(st.randoms(use_true_random=False), st.integers(1, 5))
def test_planar_form_has_the_energy_of_the_spatial_form(rng: random.Random, count: int) -> None:
    scene = random_planar_scene(rng, count)
    seed = rng.randrange(1 << 30)
    planar, spatial = (sample(scene, random.Random(seed), planar=flag) for flag in (True, False))
    assert planar.natural.plane is not None
    assert spatial.natural.plane is None
    assert planar.state == spatial.state
    assert twice_energy(planar) == twice_energy(spatial) == body_energy_twice(spatial)


@settings(max_examples=25, deadline=None)
@given(st.randoms(use_true_random=False), st.integers(1, 5), st.booleans())
def test_weight(rng: random.Random, count: int, planar: bool) -> None:
    """The power of Q = M γ (γ = g at every point, 0 at vectors, ground-fixed ones included) is Σ m g·v_c."""
    s = sample(random_planar_scene(rng, count) if planar else random_scene(rng, count), rng)
    g = s.values.vector((F(1), F(-2), F(-981, 100)))
    seen = g if s.natural.plane is None else tuple(dot(s.values.vector(axis), g) for axis in s.natural.plane[:2])
    velocity, power = rates(s), s.numbers.const(0)
    for (i, j), block in entity_mass(s.natural, s.tree, s.values).items():
        start, other = s.natural.entities[i].start, s.natural.entities[j]
        if start is None or other.kind != "point":
            continue
        force = matvec(block, seen) if isinstance(block, tuple) else tuple(block * component for component in seen)
        power = power + dot(force, velocity[start : start + len(seen)])
    assert power == weight_power(s, g)


def weight_power(s: Sample, g: Any) -> Any:
    power: Any = s.numbers.const(0)
    for body, twist in zip(s.tree.bodies, twists(s.at, s.state.v), strict=True):
        for part, where in body.parts:
            turn, shift = s.values.transform(where)
            arm = s.at.poses[body.index].vector(vadd(shift, matvec(turn, s.values.com(part))))
            power = power + s.values.mass(part) * dot(g, vadd(twist.linear, cross(twist.angular, arm)))
    return power


def test_energy_check_can_fail() -> None:
    s = sample(random_scene(random.Random(8), 3, ("revolute", "spherical")), random.Random(9))
    inverse = [[list(row) for row in matrix] for matrix in s.natural.W_inverse]
    inverse[-1][1][2] += F(1, 1000)
    broken = replace(s, natural=replace(s.natural, W_inverse=tuple(inverse)))
    assert twice_energy(s) == body_energy_twice(s) != twice_energy(broken)


@settings(max_examples=20, deadline=None)
@given(st.randoms(use_true_random=False))
def test_run_time_parameters(rng: random.Random) -> None:
    """M with p in place of constants, at other values than the scene's."""
    scene = random_planar_scene(rng, 3) if rng.randrange(2) else random_scene(rng, 3)
    body = scene.bodies[-1].name
    parameters = (
        Parameter(f"{body}.mass", (F(1),), "kg", 0),
        Parameter(f"{body}.com", (F(0),) * 3, "m", 1),
        Parameter(f"{body}.inertia", NOTHING, "kg·m²", 4),
    )
    s = sample(replace(scene, parameters=parameters), rng)
    assert len(s.state.p) == 10
    assert twice_energy(s) == body_energy_twice(s)


def floating(body: Body) -> Scene:
    return Scene("free", (body,), (Joint("j", "floating", GROUND, body.name),))


def fixed_mass(scene: Scene) -> tuple[Any, Any, Any]:
    tree = build_tree(scene)
    natural = choose_coordinates(tree)
    return tree, natural, natural_mass_matrix(natural, tree, SceneValues())


def test_slender_rod_between_two_points() -> None:
    """Uniform rod: m/3 and m/6 between its ends, nothing on the vectors (semidefinite P)."""
    m, length = F(6), F(2)
    moment = m * length**2 / 12
    rod = Body("rod", m, (length / 2, F(0), F(0)), (F(0), moment, moment, *NOTHING[:3]), ((length, F(0), F(0)),), (Y,))
    _, natural, matrix = fixed_mass(floating(rod))
    place = {entity.label: entity.start or 0 for entity in natural.entities}
    r1, r2 = place["r1"], place["r2"]
    assert [matrix[r1][r1], matrix[r2][r2], matrix[r1][r2]] == [m / 3, m / 3, m / 6]
    assert sum(1 for row in matrix for value in row if value != 0) == 12


@pytest.mark.parametrize("com", [(F(0),) * 3, (F(1, 3), F(-1, 2), F(2))])
def test_point_mass_and_plate(com: tuple[F, F, F]) -> None:
    """Rank of P: one for a point mass, three for a plate; the energy still right; nothing is ever factored."""
    plate = (F(1, 5), F(3, 10), F(1, 2), *NOTHING[:3])
    for six in (NOTHING, plate):
        rng = random.Random(2)
        s = sample(floating(Body("a", F(2), com, six)), rng)
        assert twice_energy(s) == body_energy_twice(s)
        p = sympy.Matrix(pseudo_inertia(s.tree.bodies[0].parts, SceneValues()))
        assert p.rank() == (1 if six is NOTHING else 3)


def test_massless_body_has_no_mass_matrix() -> None:
    tree, natural, matrix = fixed_mass(floating(Body("a")))
    assert entity_mass(natural, tree, SceneValues()) == {}
    assert all(type(value) is int and value == 0 for row in matrix for value in row)


def test_planar_bar_of_the_textbook() -> None:
    """García de Jalón & Bayo, planar element with two points, x_G and y_G of the centre of mass:
    [m + I/L² − 2m x/L, 0, m x/L − I/L², −m y/L; …]."""
    m, x, y, inertia, length = sympy.symbols("m x y I L", positive=True)

    class Symbols(SceneValues):
        def lift(self, value: F) -> Any:
            return sympy.Rational(value.numerator, value.denominator)

        def mass(self, body: Body) -> Any:
            return m if body.name == "bar" else F(0)

        def com(self, body: Body) -> Any:
            return (x, y, 0)

        def inertia(self, body: Body) -> Any:
            about_centre = inertia - m * (x**2 + y**2)  # I is about the first point
            return (0, 0, about_centre if body.name == "bar" else 0, 0, 0, 0)

    slider = Joint("slide", "prismatic", GROUND, "cart", axis=X)
    joints = (slider, Joint("turn", "revolute", "cart", "bar", axis=Z))
    scene = Scene("bar", (Body("cart"), Body("bar", basic_points=((F(3), F(0), F(0)),))), joints)
    tree = build_tree(scene)
    natural = choose_coordinates(tree)
    found = natural_mass_matrix(natural, tree, Symbols())
    start = {entity.label: entity.start or 0 for entity in natural.entities}
    assert natural.plane is not None
    rows = [start["r2"], start["r2"] + 1, start["r3"], start["r3"] + 1]
    a, b, c = m + inertia / length**2 - 2 * m * x / length, m * x / length - inertia / length**2, m * y / length
    d = inertia / length**2
    book = [[a, 0, b, -c], [0, a, c, b], [b, c, d, 0], [-c, b, 0, d]]
    for i, row in enumerate(book):
        for j, value in enumerate(row):
            assert sympy.simplify(found[rows[i]][rows[j]] - sympy.sympify(value).subs(length, 3)) == 0


def test_welded_bodies_add() -> None:
    """Two bodies welded with a turn and an offset have the P of one body computed by hand (parallel axes)."""
    rng, six = random.Random(7), (F(3), F(4), F(5), F(1, 3), F(-1, 4), F(1, 5))
    parts = []
    for k in range(2):
        pose = Transform(rotation(1, k, 2, -1), random_vector(rng))
        parts.append((Body(f"b{k}", F(k + 1), random_vector(rng), six), pose))
    together = pseudo_inertia(parts, SceneValues())
    separate = [pseudo_inertia([part], SceneValues()) for part in parts]
    assert together == tuple(tuple(a + b for a, b in zip(*rows, strict=True)) for rows in zip(*separate, strict=True))
    assert together[0][0] == 3
    for (body, pose), p in zip(parts, separate, strict=True):
        com = vadd(matvec(pose.rotation, body.com), pose.translation)
        assert tuple(p[0][1:]) == tuple(body.mass * c for c in com)
        trace = sum(p[k + 1][k + 1] - body.mass * com[k] ** 2 for k in range(3))
        assert 2 * trace == sum(body.inertia[:3])  # tr I = 2 tr Σ, whatever the axes


def test_run_time_mass_keeps_structural_zeros() -> None:
    """A parameter in one body leaves the zeros of the others the int 0, so nothing is computed for them."""
    scene = floating(Body("a", F(1), (F(0),) * 3, (F(1), F(1), F(1), *NOTHING[:3])))
    tree = build_tree(scene)
    natural = choose_coordinates(tree)
    values = Values(replace(scene, parameters=(Parameter("a.mass", (F(1),), "kg", 0),)), FloatNumbers(), (5.0,))
    matrix = natural_mass_matrix(natural, tree, values)
    assert matrix[0][0] == 5
    assert sum(1 for row in matrix for value in row if type(value) is int and value == 0) == 144 - 12
    assert ground_coordinates(natural) == {}
