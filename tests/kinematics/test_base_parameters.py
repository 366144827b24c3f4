"""Base parameters: published numbers, the textbook's regrouping, and Y π = Yb β in numbers."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.algebra.numbers import FloatNumbers, State
from symgen.literal.base_parameters import BaseParameters, reconstruct
from symgen.literal.regressor import inertial_parameters
from symgen.scene.model import Body, Joint, Parameter, Scene, Transform
from symgen.system import System, derive
from tests.kinematics.scenes import DOWN, X, Y, Z, arm, kinematic_scene, planar_arm, puma

NONE, ASIDE = (F(0), F(0), F(0)), (F(0), F(-10), F(0))


@pytest.mark.parametrize(
    ("scene", "number"),
    [
        (planar_arm(NONE), 4),  # I₁ + m₂ l², I₂, and two components of m₂ c₂
        (planar_arm(DOWN), 4),  # gravity along the axes is not felt
        (planar_arm(ASIDE), 6),  # and two components of m₁ c₁ + m₂ l
        (puma(), 36),  # Mayeda, Yoshida & Osuka 1990
        ("examples/panda.scene.yaml", 43),  # Gaz, Cognetti, Oliva, Robuffo Giordano & De Luca 2019
        ("examples/ur5.scene.yaml", 36),
        ("examples/fig1.scene.yaml", 21),
        ("examples/fig2.scene.yaml", 35),
        ("examples/free_body.scene.yaml", 10),
    ],
    ids=str,
)
def test_published_numbers(scene: Scene | str, number: int) -> None:
    base = derive(scene).base_parameters
    assert len(base.rows) == number
    assert len(base.matrix) == number and all(len(row) == len(base.names) for row in base.matrix)


def test_a_symmetric_two_link_arm_has_the_textbook_three() -> None:
    """Without gravity and with m₂ c₂ along the link: I₁ + m₂ l², I₂ and m₂ c₂x (and its other component)."""
    base = derive(planar_arm(NONE)).base_parameters
    terms = [{base.names[k]: value for k, value in row.items()} for row in base.rows]
    assert terms == [{"l1.Izz": 1, "l2.m": 1}, {"l2.mcx": 1}, {"l2.mcy": 1}, {"l2.Izz": 1}]
    assert "l1.m" in base.unfelt and "l2.Ixx" in base.unfelt


def test_a_revolute_joint_regroups_as_khalil_has_it() -> None:
    """About z: m, mcz and Iyy of the child go to the parent; Ixx − Iyy stays, and the parent's take up the rest."""
    scene = arm("generic", (X, Z), ((F(0), F(0), F(0)), (F(1), F(2), F(3))))
    base = derive(scene).base_parameters
    terms = {base.names[next(iter(row))]: {base.names[k]: v for k, v in row.items()} for row in base.rows}
    assert terms["l2.Ixx"] == {"l2.Ixx": 1, "l2.Iyy": -1}
    assert "l2.m" not in terms and "l2.mcz" not in terms and "l2.Iyy" not in terms
    assert terms["l1.Ixx"] == {"l1.Ixx": 1, "l2.m": 2**2 + 3**2, "l2.mcz": 2 * 3, "l2.Iyy": 1}


def at_random(system: System, seed: int) -> State:
    rng, size = random.Random(seed), system.sizes
    q, v, a, p = ([rng.uniform(-1, 1) for _ in range(n)] for n in (size.nq, size.nv, size.nv, size.np))
    return State(q=q, v=v, a=a, p=p)


def products(system: System, seed: int) -> tuple[np.ndarray, np.ndarray, BaseParameters]:
    """Y π and Yb β by floats, for the scene's π."""
    state = at_random(system, seed)
    y, yb, beta = (
        np.array(next(iter(system.evaluate(row, FloatNumbers(), state).values())), dtype=float)
        for row in ("regressor", "base_regressor", "base_parameters")
    )
    literal = system.literal(FloatNumbers(), state)
    pi = np.array(inertial_parameters(literal), dtype=float)
    return y @ pi, yb @ beta, system.base_parameters


@given(st.integers(0, 2**32))
@settings(max_examples=6, deadline=None)
def test_they_give_the_same_forces(seed: int) -> None:
    system = derive(kinematic_scene(seed))
    whole, reduced, base = products(system, seed)
    assert np.allclose(whole, reduced, rtol=1e-9, atol=1e-9 * (1 + np.abs(whole).max(initial=0)))
    matrix = np.array(base.matrix, dtype=float).reshape(len(base.rows), len(base.names))
    assert np.array_equal(matrix[:, base.independent], np.eye(len(base.rows)))


def test_run_time_parameters_make_beta_a_function_of_p() -> None:
    scene = puma()
    mass = Parameter("l3.mass", (F(5, 3),), "kg", 0)
    system = derive(replace(scene, parameters=(mass,)))
    program = system.program("base_parameters")
    assert [port.name for port in program.inputs] == ["p"] and program.outputs[0].shape == (36,)
    assert np.allclose(*products(system, 3)[:2])


def test_gravity_at_run_time_is_felt_in_every_direction() -> None:
    """Gravity that may have any direction makes the first body's first moment felt."""
    gravity = Parameter("gravity", NONE, "m/s^2", 0)
    assert len(derive(replace(planar_arm(NONE), parameters=(gravity,))).base_parameters.rows) == 6


def test_origins_at_run_time_leave_more_base_parameters() -> None:
    """A combination must hold for every value of the parameter, and K is constant."""
    fixed = arm("offsets", (Z, Y), ((F(0), F(0), F(0)), (F(1), F(0), F(0))))
    loose = replace(fixed, parameters=(Parameter("j2.xyz", (F(1), F(0), F(0)), "m", 0),))
    assert len(derive(loose).base_parameters.rows) > len(derive(fixed).base_parameters.rows)
    assert np.allclose(*products(derive(loose), 5)[:2])


def test_a_body_that_only_slides_feels_its_mass_alone() -> None:
    scene = Scene("slide", (Body("b", F(1)),), (Joint("j", "prismatic", "ground", "b", Transform(), Z),))
    base = derive(scene).base_parameters
    assert [base.names[k] for k in base.independent] == ["b.m"]


@given(st.fractions(max_denominator=10**12), st.integers(60, 90))
def test_rationals_come_back_from_their_residues(value: F, bits: int) -> None:
    modulus = 2 ** (2 * bits) + 1
    while np.gcd(value.denominator, modulus % value.denominator or value.denominator) != 1:
        modulus += 2
    if abs(value.numerator) < 2 ** (bits - 2):
        residue = value.numerator * pow(value.denominator, -1, modulus) % modulus
        assert reconstruct(residue, modulus) == value


def test_a_number_that_is_no_small_rational_is_none() -> None:
    assert sum(reconstruct(x, 10007) is None for x in range(10007)) > 3000
