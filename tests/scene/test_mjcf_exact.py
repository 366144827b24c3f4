"""MuJoCo's doubles made exact, and names for what has none. No MuJoCo is needed here."""

from __future__ import annotations

from fractions import Fraction as F
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from symgen.scene.exact import matmul, rotation_from_quaternion, transpose
from symgen.scene.mjcf_exact import FINE, QUARTER_TURNS, exact_turn, settled
from symgen.scene.mjcf_names import body_names, joint_names
from symgen.scene.model import IDENTITY3

SNAP = F(1, 10**6)
components = st.floats(-1, 1).map(lambda x: F(repr(x)))


@given(st.tuples(components, components, components, components).filter(lambda q: sum(x * x for x in q) > F(1, 100)))
def test_any_turn_is_orthogonal_and_the_one_described(q: tuple[F, F, F, F]) -> None:
    turn = exact_turn(q, SNAP)
    assert matmul(turn.matrix, transpose(turn.matrix)) == IDENTITY3
    exact, raw = np.array(turn.matrix, dtype=float), np.array(turn.raw)
    assert np.abs(exact - raw).max() <= max(1.01 * turn.snapped, 1e-15)
    assert turn.snapped <= 1e-6


def test_there_are_24_quarter_turns() -> None:
    assert len({matrix for _, matrix in QUARTER_TURNS}) == 24
    assert all(sum(abs(x) for x in row) == 1 for _, matrix in QUARTER_TURNS for row in matrix)
    assert QUARTER_TURNS[0][1] == IDENTITY3


@pytest.mark.parametrize("index", range(24))
@pytest.mark.parametrize("axis", range(3))
def test_structure_survives_rounding(index: int, axis: int) -> None:
    """A quarter turn and then a turn about an axis, in doubles: zeros of the matrix are zeros."""
    rest = [cos(0.2), 0.0, 0.0, 0.0]
    rest[1 + axis] = sin(0.2)
    quarter = [float(x) for x in QUARTER_TURNS[index][0]]
    noise = np.random.default_rng(index).uniform(-1, 1, 4) * 1e-16
    q = np.array(product(quarter, rest)) / np.linalg.norm(quarter) + noise
    turn = exact_turn([F(repr(float(x))) for x in q], FINE)
    assert sum(x == 0 for row in turn.matrix for x in row) == 4
    assert turn.snapped < 1e-15


def product(a: list[float], b: list[float]) -> list[float]:
    w, x, y, z = a
    p, q, r, s = b
    return [
        w * p - x * q - y * r - z * s, w * q + x * p + y * s - z * r,
        w * r - x * s + y * p + z * q, w * s + x * r - y * q + z * p,
    ]  # fmt: skip


def test_snapping_and_near_misses() -> None:
    def about_x(angle: float) -> list[F]:
        return [F(repr(cos(angle / 2))), F(repr(sin(angle / 2))), F(0), F(0)]

    quarter = ((1, 0, 0), (0, 0, -1), (0, 1, 0))
    turn = exact_turn(about_x(pi / 2 + 5e-7), SNAP)
    assert turn.matrix == quarter
    assert turn.snapped == pytest.approx(5e-7, rel=1e-6)
    assert turn.near == 0
    turn = exact_turn(about_x(1.5708), SNAP)
    assert turn.matrix != quarter
    assert turn.snapped == 0
    assert turn.near == pytest.approx(1.5708 - pi / 2, rel=1e-6)
    assert exact_turn(about_x(0.1), SNAP).near == 0
    assert exact_turn(about_x(1.5708), F(1, 10**4)).matrix == quarter


def test_a_general_turn_is_that_of_its_quaternion() -> None:
    q = (F(1), F(1, 10), F(1, 5), F(3, 10))
    assert exact_turn(q, SNAP).matrix == rotation_from_quaternion(*q)


def test_dust() -> None:
    assert settled((F(1), F(1, 10**16), F(-1, 10**14)), F(1)) == (1, 0, F(-1, 10**14))
    assert settled((F(1, 10**16), F(0), F(0)), F(1, 10**3)) == (F(1, 10**16), 0, 0)


def test_names_for_what_has_none() -> None:
    bodies = body_names(["world", "", "arm", "ground", "body_1", "", ""])
    assert bodies == ("ground", "body_1_2", "arm", "ground_2", "body_1", "body_5", "body_6")
    joints = joint_names(["", "", "h", "", "arm_hinge"], ["hinge", "hinge", "ball", "slide", "hinge"], ["arm"] * 5)
    assert joints == ("arm_hinge_2", "arm_hinge_3", "h", "arm_slide", "arm_hinge")
