"""Ψ(x(q)) = 0, Ψ_q R = 0, and the nullity of Ψ_q is the number of degrees of freedom, exactly over GF(p)."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.algebra.linear import dot
from symgen.algebra.numbers import FloatNumbers, State
from symgen.natural.constraints import constraint_jacobian, evaluate_constraints
from symgen.natural.coordinates import choose_coordinates, natural_coordinates
from symgen.scene.model import GROUND, Body, Joint, Scene, Transform
from symgen.topology.tree import build_tree
from symgen.velocity.kinematics import kinematics
from symgen.velocity.values import Values
from tests.natural.trees import (
    SPATIAL_TYPES,
    Sample,
    X,
    Y,
    Z,
    random_planar_scene,
    random_scene,
    rank,
    rotation,
    sample,
    strip,
    transformation,
    triple,
)

MOVING_TYPES = tuple(name for name in SPATIAL_TYPES if name != "fixed")


def check(s: Sample) -> None:
    """The whole contract of Ψ at one configuration."""
    psi = evaluate_constraints(s.natural, s.x, s.numbers)
    assert [c.name for c, value in zip(s.natural.constraints, psi, strict=True) if value != 0] == []
    jacobian, r = constraint_jacobian(s.natural, s.x, s.numbers), transformation(s)
    columns = list(zip(*r, strict=True))
    assert all(dot(row, column) == 0 for row in jacobian for column in columns)
    assert rank(r, s.numbers.p) == s.tree.nv
    assert rank(jacobian, s.numbers.p) == s.natural.nc  # no redundant row
    assert s.natural.nn - s.natural.nc == s.tree.nv


@settings(max_examples=40, deadline=None)
@given(st.randoms(use_true_random=False), st.integers(1, 6))
def test_random_trees(rng: random.Random, count: int) -> None:
    check(sample(random_scene(rng, count), rng))


@settings(max_examples=30, deadline=None)
@given(st.randoms(use_true_random=False), st.integers(1, 6))
def test_random_planar_trees(rng: random.Random, count: int) -> None:
    s = sample(random_planar_scene(rng, count), rng)
    assert s.natural.plane is not None
    check(s)


@pytest.mark.parametrize("inner", MOVING_TYPES)
@pytest.mark.parametrize("outer", MOVING_TYPES)
@pytest.mark.parametrize("offset", [(0, 0, 0), (0, 0, 1), (1, 2, 3)])
def test_every_pair_of_joints(inner: str, outer: str, offset: tuple[int, int, int]) -> None:
    """Ground, ``inner``, massless body, ``outer``: coincident, coaxial and skew; universal axes not orthogonal."""
    oblique = (F(3, 5), F(0), F(4, 5))
    place = Transform(rotation(1, 0, 0, 1), triple(F(c) for c in offset))
    joints = (
        strip(Joint("inner", inner, GROUND, "a", Transform(), Z, oblique, F(1, 10))),
        strip(Joint("outer", outer, "a", "b", place, Z, oblique, F(0))),
    )
    scene = Scene("pair", (Body("a"), Body("b", F(1), X, (F(1),) * 3 + (F(0),) * 3)), joints)
    check(sample(scene, random.Random(5), planar=False))
    check(sample(scene, random.Random(6)))


def crossing_wrist(count: int) -> Scene:
    """Revolutes whose axes all pass through one point, bodies without mass between them."""
    axes = (Z, Y, Z, X, Z)
    names = [GROUND, *(f"b{k}" for k in range(count))]
    joints = [Joint(f"j{k}", "revolute", names[k], names[k + 1], axis=axes[k]) for k in range(count)]
    return Scene("wrist", tuple(Body(name) for name in names[1:]), tuple(joints))


def test_axes_through_one_point_share_it() -> None:
    s = sample(crossing_wrist(5), random.Random(1))
    check(s)
    assert [entity.kind for entity in s.natural.entities].count("point") == 1
    assert sorted(s.natural.entities[0].local) == [-1, 0, 1, 2, 3, 4]


def test_float_ranks_and_residuals_at_zero_and_elsewhere() -> None:
    """Singular values, so that a row that is independent only generically does not pass."""
    numbers = FloatNumbers()
    for seed in range(12):
        rng = random.Random(seed)
        scene = random_planar_scene(rng, 5) if seed % 3 == 0 else random_scene(rng, 5)
        tree = build_tree(scene)
        natural, values = choose_coordinates(tree), Values(scene, numbers)
        for at_zero in (True, False):
            state = State(q=_float_configuration(tree, rng, at_zero))
            poses = kinematics(tree, values, state.q).poses
            x = natural_coordinates(natural, tree, poses, state, numbers)
            residual = evaluate_constraints(natural, x, numbers)
            assert max((abs(value) for value in residual), default=0.0) < 1e-12
            jacobian = np.array(constraint_jacobian(natural, x, numbers), dtype=float).reshape(-1, natural.nn)
            if natural.nc:
                assert np.linalg.svd(jacobian, compute_uv=False)[natural.nc - 1] > 1e-4


def _float_configuration(tree: Any, rng: random.Random, at_zero: bool) -> list[float]:
    q: list[float] = []
    for body in tree.bodies:
        own = [0.0 if at_zero else rng.uniform(-2, 2) for _ in range(body.nq)]
        if body.joint.type in ("spherical", "floating"):
            turn = np.array([0.0, 0.0, 0.0, 1.0]) if at_zero else np.array([rng.gauss(0, 1) for _ in range(4)])
            own[-4:] = list(turn / np.linalg.norm(turn))
        q.extend(own)
    return q


def test_jacobian_is_the_derivative() -> None:
    """Central differences of Ψ at an x that need not satisfy it (cos φ, sin φ of the screw included)."""
    rng = random.Random(11)
    kinds = ("helical", "prismatic", "universal")
    links = [GROUND, "a", "b", "c"]
    place = Transform(rotation(1, 2, 0, -1), triple((F(1), F(1, 2), F(1, 3))))
    joints = [strip(Joint(kind, kind, links[k], links[k + 1], place, Z, X, F(1, 5))) for k, kind in enumerate(kinds)]
    scene = Scene("three", tuple(Body(name) for name in links[1:]), tuple(joints))
    natural, numbers = choose_coordinates(build_tree(scene)), FloatNumbers()
    x = [rng.uniform(-1, 1) for _ in range(natural.nn)]
    jacobian = np.array(constraint_jacobian(natural, x, numbers), dtype=float)
    h = 1e-6
    for k in range(natural.nn):
        ahead, behind = list(x), list(x)
        ahead[k] += h
        behind[k] -= h
        after = np.array(evaluate_constraints(natural, ahead, numbers))
        before = np.array(evaluate_constraints(natural, behind, numbers))
        assert np.abs((after - before) / (2 * h) - jacobian[:, k]).max() < 1e-8
    assert any(term.turn for row in natural.constraints for term in row.terms)


def test_the_checks_can_fail() -> None:
    """A lost row, a doubled row, a wrong constant and a wrong coefficient are all seen."""
    s = sample(random_scene(random.Random(3), 4, ("revolute", "prismatic", "universal")), random.Random(4))
    check(s)
    rows = s.natural.constraints
    last = rows[-1]
    wrong = replace(last, terms=(last.terms[0]._replace(coefficient=last.terms[0].coefficient * 2), *last.terms[1:]))
    shifted = replace(last, terms=tuple(t if t.factors else t._replace(coefficient=F(7)) for t in rows[0].terms))
    for mutant in ((*rows[:-1],), (*rows, rows[0]), (*rows[:-1], wrong), (shifted, *rows[1:])):
        with pytest.raises(AssertionError):
            check(replace(s, natural=replace(s.natural, constraints=mutant)))
