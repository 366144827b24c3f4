"""Exact numbers: on the sphere and in the rotation group exactly, and where they were described to be."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from itertools import permutations, product

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.scene.exact import (
    cross,
    decimal,
    matmul,
    matvec,
    rotation_about,
    rotation_from_quaternion,
    rotation_from_rpy,
    transpose,
    unit_vector,
)
from symgen.scene.model import IDENTITY3, Matrix3, Vector

REAL = mpmath.MPContext()
REAL.dps = 80

numbers = st.decimals(-(10**6), 10**6, places=6, allow_nan=False, allow_infinity=False).map(Fraction)
vectors = st.tuples(numbers, numbers, numbers).filter(any)
angles = st.decimals(-10, 10, places=9).map(Fraction)


def real(x: Fraction) -> mpmath.mpf:
    return REAL.mpf(x.numerator) / x.denominator


def turn(axis: int, angle: Fraction) -> mpmath.matrix:
    c, s = REAL.cos(real(angle)), REAL.sin(real(angle))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    m = REAL.eye(3)
    m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
    return m


def deviation(exact: Matrix3, wanted: mpmath.matrix) -> float:
    return float(max(abs(real(exact[i][j]) - wanted[i, j]) for i in range(3) for j in range(3)))


def determinant(m: Matrix3) -> Fraction:
    return sum((a * b for a, b in zip(m[0], cross(m[1], m[2]), strict=True)), Fraction(0))


def is_rotation(m: Matrix3) -> bool:
    return matmul(m, transpose(m)) == IDENTITY3 and determinant(m) == 1


# -- decimals ------------------------------------------------------------------------------------------------------


@given(st.decimals(allow_nan=False, allow_infinity=False, min_value=-(10**20), max_value=10**20))
def test_a_decimal_is_its_exact_value(number: Decimal) -> None:
    if number == 0 or abs(number) > Decimal("1e-300"):
        assert decimal(str(number)) == Fraction(number)


@pytest.mark.parametrize(
    ("text", "value"),
    [("0.1", Fraction(1, 10)), ("1e-3", Fraction(1, 1000)), (".5", Fraction(1, 2)), ("-3.", Fraction(-3)),
     ("+2E+2", Fraction(200)), ("0e9", Fraction(0)), ("1e-300", Fraction(1, 10**300))],
)  # fmt: skip
def test_spellings(text: str, value: Fraction) -> None:
    assert decimal(text) == value


@pytest.mark.parametrize(
    "text",
    ["", ".", "e5", "1e", "1_000", "0x10", "nan", "inf", "1e401", "1e-301", "1e301", "1" * 401, "1 2", "١", "--1"],
)
def test_what_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"\S"):
        decimal(text)


# -- directions ----------------------------------------------------------------------------------------------------


@given(vectors)
def test_a_direction_is_exactly_unit_and_within_1e_17(v: Vector) -> None:
    u = unit_vector(v)
    assert sum(x * x for x in u) == 1
    length = REAL.sqrt(sum(real(x) ** 2 for x in v))
    assert max(abs(real(a) - real(b) / length) for a, b in zip(u, v, strict=True)) < 1e-17
    assert all((a == 0) == (b == 0) or abs(b) < 1e-9 * max(map(abs, v)) for a, b in zip(u, v, strict=True))


@given(vectors, numbers.filter(bool))
def test_parallel_directions_are_the_same_point(v: Vector, scale: Fraction) -> None:
    u = unit_vector(v)
    scaled = unit_vector((v[0] * scale, v[1] * scale, v[2] * scale))
    assert scaled == (u if scale > 0 else tuple(-x for x in u))


@pytest.mark.parametrize("v", [("0.6", "0", "0.8"), ("0.36", "0.48", "0.8"), ("0.48", "-0.6", "0.64")])
def test_a_rational_direction_stays(v: tuple[str, str, str]) -> None:
    x, y, z = (Fraction(t) for t in v)
    assert unit_vector((x, y, z)) == (x, y, z)
    assert unit_vector((5 * x, 5 * y, 5 * z)) == (x, y, z)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("tilt", ["0", "1e-3", "1e-17", "1e-30"])
def test_the_poles(axis: int, sign: int, tilt: str) -> None:
    v = [Fraction(0)] * 3
    v[axis], v[(axis + 1) % 3] = Fraction(sign), Fraction(tilt)
    u = unit_vector((v[0], v[1], v[2]))
    assert sum(x * x for x in u) == 1
    assert abs(u[axis] - sign) <= Fraction(tilt) ** 2
    assert abs(u[(axis + 1) % 3] - Fraction(tilt)) < Fraction(1, 10**17) + Fraction(tilt) ** 3


def test_a_long_decimal_direction() -> None:
    u = unit_vector((Fraction(10) ** 300 + 1, Fraction(1, 10**300), Fraction(10) ** 300))
    assert sum(x * x for x in u) == 1


def test_the_zero_vector_is_refused() -> None:
    with pytest.raises(ValueError, match="no direction"):
        unit_vector((Fraction(0), Fraction(0), Fraction(0)))


# -- rotations -----------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(st.tuples(angles, angles, angles))
def test_rpy_is_exactly_orthogonal_and_urdfs(rpy: Vector) -> None:
    rotation = rotation_from_rpy(rpy, Fraction(0))
    assert is_rotation(rotation.matrix)
    wanted = turn(2, rpy[2]) * turn(1, rpy[1]) * turn(0, rpy[0])
    assert deviation(rotation.matrix, wanted) < 1e-17
    assert max(abs(rotation.raw[i][j] - float(wanted[i, j])) for i in range(3) for j in range(3)) < 1e-15


QUARTERS = ["0", "1.5707963267948966", "-1.5707963267949", "3.141592653589793", "-3.14159265359", "4.71238898038469"]


@pytest.mark.parametrize("rpy", list(product(QUARTERS, repeat=3)))
def test_quarter_turns_are_signed_permutations(rpy: tuple[str, str, str]) -> None:
    a, b, c = (Fraction(t) for t in rpy)
    rotation = rotation_from_rpy((a, b, c))
    assert is_rotation(rotation.matrix)
    assert all(x in (-1, 0, 1) for row in rotation.matrix for x in row)
    assert deviation(rotation.matrix, turn(2, c) * turn(1, b) * turn(0, a)) < 1e-10
    assert (rotation.snapped is None) == (rpy == ("0", "0", "0"))


def test_all_24_are_reached() -> None:
    reached = {rotation_from_rpy([Fraction(t) for t in rpy]).matrix for rpy in product(QUARTERS, repeat=3)}
    proper = [
        m
        for order in permutations(range(3))
        for signs in product((1, -1), repeat=3)
        if determinant(
            m := tuple(tuple(Fraction(s * (j == k)) for j in range(3)) for s, k in zip(signs, order, strict=True))
        )
        == 1  # type: ignore[arg-type]
    ]
    assert reached == set(proper)


@pytest.mark.parametrize(
    ("angle", "near"), [("1.57", True), ("1.5708", True), ("3.14", True), ("1.5", False), ("0.001", False)]
)
def test_near_misses_are_told_and_not_snapped(angle: str, near: bool) -> None:
    rotation = rotation_from_rpy((Fraction(angle), Fraction(0), Fraction(0)))
    assert rotation.snapped is None
    assert bool(rotation.near_misses) is near
    if near:
        given_, exact = rotation.near_misses[0]
        assert given_ == angle
        assert rotation_from_rpy((Fraction(exact), Fraction(0), Fraction(0))).snapped is not None


def test_the_snap_angle_decides() -> None:
    rpy = (Fraction("1.5708"), Fraction(0), Fraction(0))
    assert rotation_from_rpy(rpy, Fraction("3.6e-6")).snapped is None
    snapped = rotation_from_rpy(rpy, Fraction("3.7e-6"))
    assert snapped.snapped == pytest.approx(3.6732051e-6)
    assert snapped.raw[2][1] != 1.0


def test_a_whole_rotation_near_the_identity_snaps() -> None:
    rpy = (Fraction("0.3"), Fraction("1.5707963267948966"), Fraction("0.3"))  # gimbal lock: Ry(π/2) and nothing else
    rotation = rotation_from_rpy(rpy)
    assert rotation.matrix == rotation_from_rpy((Fraction(0), rpy[1], Fraction(0))).matrix


def test_structural_zeros_are_exact() -> None:
    matrix = rotation_from_rpy((Fraction("0.7"), Fraction(0), Fraction("0.3"))).matrix
    assert matrix[2][0] == 0
    matrix = rotation_from_rpy((Fraction("1.5707963267948966"), Fraction(0), Fraction("0.3"))).matrix
    assert [x == 0 for row in matrix for x in row] == [False, True, False, False, True, False, True, False, True]


@settings(deadline=None)
@given(vectors, angles)
def test_a_turn_about_an_axis_is_exact(v: Vector, angle: Fraction) -> None:
    u = unit_vector(v)
    rotation = rotation_about(u, angle, Fraction(0))
    assert is_rotation(rotation)
    assert matvec(rotation, u) == u
    trace = real(rotation[0][0] + rotation[1][1] + rotation[2][2])
    assert abs(trace - (1 + 2 * REAL.cos(real(angle)))) < 1e-17


def test_a_turn_follows_the_right_hand() -> None:
    quarter = rotation_about((Fraction(0), Fraction(0), Fraction(1)), Fraction("1.5707963267948966"))
    assert matvec(quarter, (Fraction(1), Fraction(0), Fraction(0))) == (0, 1, 0)


def test_quaternions_need_no_length() -> None:
    matrix = rotation_from_quaternion(Fraction(3), Fraction(0), Fraction(0), Fraction(3))
    assert matvec(matrix, (Fraction(1), Fraction(0), Fraction(0))) == (0, 1, 0)
    with pytest.raises(ValueError, match="zero quaternion"):
        rotation_from_quaternion(Fraction(0), Fraction(0), Fraction(0), Fraction(0))
