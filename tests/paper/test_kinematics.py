"""Paper §4: eqs (4.1)–(4.13) hold for what symgen derives, exactly; errata 2–6 and 8: as printed they do not."""

from __future__ import annotations

import pytest

from symgen.targets.sympy import block_matrix
from tests.paper.world import World, cross, example, notation, same, scale, vadd, vsub

THETA_1 = ["theta1", "theta2", "theta3", "theta5"]
THETA_2 = ["r1", "omega1", "theta2", "theta3", "theta4", "theta7"]

R_1 = {
    "r2": ["-D21 u1", "0", "0", "0"],
    "u2": ["-U2 u1", "0", "0", "0"],
    "r3": ["-D31 u1", "-D32 u2", "0", "0"],
    "u3": ["-U3 u1", "-U3 u2", "0", "0"],
    "r4": ["-D41 u1", "-D42 u2", "u3", "0"],
    "r5": ["-D51 u1", "-D52 u2", "u3", "0"],
    "u5": ["-U5 u1", "-U5 u2", "0", "0"],
    "r6": ["-D61 u1", "-D62 u2", "u3", "-D65 u5"],
    "u6": ["-U6 u1", "-U6 u2", "0", "-U6 u5"],
}
"""(4.9) with erratum 4 corrected."""

R_2 = {
    "r1": ["1", "0", "0", "0", "0", "0"],
    "u1": ["0", "-U1", "0", "0", "0", "0"],
    "r2": ["1", "-D21", "0", "0", "0", "0"],
    "u2": ["0", "-U2", "0", "0", "0", "0"],
    "r3": ["1", "-D31", "-D32 u2", "0", "0", "0"],
    "u3": ["0", "-U3", "-U3 u2", "0", "0", "0"],
    "r4": ["1", "-D41", "-D42 u2", "-D43 u3", "0", "0"],
    "u4": ["0", "-U4", "-U4 u2", "-U4 u3", "0", "0"],
    "r5": ["1", "-D51", "-D52 u2", "-D53 u3", "u4", "0"],
    "r6": ["1", "-D61", "-D62 u2", "-D63 u3", "u4", "0"],
    "u6": ["0", "-U6", "-U6 u2", "-U6 u3", "0", "0"],
    "r7": ["1", "-D71", "0", "0", "0", "0"],
    "u7": ["0", "-U7", "0", "0", "0", "0"],
    "r8": ["1", "-D81", "0", "0", "0", "-D87 u7"],
    "u8": ["0", "-U8", "0", "0", "0", "-U8 u7"],
}
"""(4.13) with erratum 5 corrected."""


@pytest.fixture(scope="module")
def fig1() -> World:
    return World(example("fig1"))


@pytest.fixture(scope="module")
def fig2() -> World:
    return World(example("fig2"))


def holds(world: World, label: str, row: list[str], columns: list[str]) -> bool:
    """ṙ or u̇ of an entity is the printed row times the joint velocities."""
    return same(world.rate(label), world.row(row, columns))


# -- the grounded system ---------------------------------------------------------------------------------------------


def test_4_1_velocities_of_points(fig1: World) -> None:
    r, v, w = fig1.vector, fig1.rate, fig1.omega
    assert same(v("r2"), cross(w(1), vsub(r("r2"), r("r1"))))
    assert same(v("r3"), vadd(v("r2"), cross(w(2), vsub(r("r3"), r("r2")))))
    assert same(v("r5"), vadd(v("r4"), cross(w(3), vsub(r("r5"), r("r4")))))
    assert same(v("r6"), vadd(v("r5"), cross(w(4), vsub(r("r6"), r("r5")))))


def test_erratum_2_the_slide_is_crossed_with_its_length(fig1: World) -> None:
    """(4.1), ṙ₄: ω₂ × (r₄ − r₃) with r₄ − r₃ = θ₃ u₃; printed with u₃ alone."""
    v, u3 = fig1.rate, fig1.vector("u3")
    slide = scale(fig1.joint_rates["3"], u3)
    arm = vsub(fig1.vector("r4"), fig1.vector("r3"))
    assert same(arm, scale(fig1.literal.state.q[2], u3))
    assert same(v("r4"), vadd(v("r3"), vadd(cross(fig1.omega(2), arm), slide)))
    assert not same(v("r4"), vadd(v("r3"), vadd(cross(fig1.omega(2), u3), slide)))


def test_4_2_with_skew_matrices(fig1: World) -> None:
    v = fig1.rate
    for label, before, block, body in (("r2", "r1", "-D21", 1), ("r3", "r2", "-D32", 2), ("r5", "r4", "-D54", 3),
                                       ("r6", "r5", "-D65", 4)):  # fmt: skip
        assert same(v(label), vadd(v(before), fig1.row([block], [f"omega{body}"])))
    assert same(v("r4"), vadd(v("r3"), fig1.row(["-D43", "u3"], ["omega2", "theta3"])))


def test_4_3_angular_velocities(fig1: World) -> None:
    u, w, rate = fig1.vector, fig1.omega, fig1.joint_rates
    assert same(w(1), scale(rate["1"], u("u1")))
    assert same(w(2), vadd(w(1), scale(rate["2"], u("u2"))))
    assert same(w(3), w(2))
    assert same(w(4), vadd(w(3), scale(rate["5"], u("u5"))))


def test_4_4_velocities_of_points_in_joint_velocities(fig1: World) -> None:
    for label in ("r2", "r3", "r4", "r5", "r6"):
        assert holds(fig1, label, R_1[label], THETA_1)


def test_erratum_3_d_52_not_d_51(fig1: World) -> None:
    """(4.4), ṙ₅: −D₅₂u₂θ̇₂, as in (4.9)."""
    assert not holds(fig1, "r5", ["-D51 u1", "-D51 u2", "u3", "0"], THETA_1)
    assert holds(fig1, "r5", ["-D51 u1", "-D52 u2", "u3", "0"], THETA_1)


def test_4_5_to_4_7_velocities_of_vectors(fig1: World) -> None:
    for label, body in (("u2", 1), ("u3", 2), ("u5", 3), ("u6", 4)):
        assert same(fig1.rate(label), cross(fig1.omega(body), fig1.vector(label)))
        assert same(fig1.rate(label), fig1.row([f"-U{label[1:]}"], [f"omega{body}"]))


def test_erratum_8_total_angular_velocity(fig1: World) -> None:
    """After (4.6): u_i θ̇_i is the relative velocity; (4.5)–(4.7) need the body's total one."""
    relative = scale(fig1.joint_rates["2"], fig1.vector("u2"))
    assert not same(fig1.rate("u3"), cross(relative, fig1.vector("u3")))
    assert same(fig1.rate("u3"), cross(vadd(relative, fig1.omega(1)), fig1.vector("u3")))


def test_4_8_blank_in_the_paper(fig1: World) -> None:
    for label in ("u2", "u3", "u5", "u6"):
        assert holds(fig1, label, R_1[label], THETA_1)


def test_4_9_is_what_is_printed_and_derived(fig1: World) -> None:
    matrix = block_matrix(fig1.system)
    rows = {row.label: [notation(b) for b in blocks] for row, blocks in zip(matrix.rows, matrix.blocks, strict=True)}
    assert {label: rows[label] for label in R_1} == R_1
    assert [unit.indices for unit in matrix.columns] == [("1",), ("2",), ("3",), ("5",)]
    for label, row in R_1.items():
        assert holds(fig1, label, row, THETA_1)


def test_erratum_4_ten_rows_for_nine(fig1: World) -> None:
    """(4.9): the left side has ṙ₃ twice, the row of u̇₃ being printed as a second row of ṙ₃, and θ̇ is missing."""
    printed = ["r2", "u2", "r3", "r3", "u3", "r4", "r5", "u5", "r6", "u6"]
    assert len(printed) == 10
    assert list(dict.fromkeys(printed)) == [entity.label for entity in block_matrix(fig1.system).rows]
    assert not holds(fig1, "u3", ["-D31 u1", "-D32 u2", "0", "0"], THETA_1)
    assert not holds(fig1, "u5", ["-U5 u1", "-D52 u2", "u3", "0"], THETA_1)
    assert not holds(fig1, "u6", ["-D61 u1", "-D62 u2", "u3", "-D65 u5"], THETA_1)
    for label in ("u3", "u5", "u6"):
        assert holds(fig1, label, R_1[label], THETA_1)


def test_erratum_6_four_joint_coordinates(fig1: World) -> None:
    """Called θ₁…θ₅, but they are four, numbered by basic point: edge 4 carries θ₅."""
    assert fig1.system.tree.nv == len(fig1.system.tree.bodies) == 4
    assert list(fig1.joint_rates) == ["1", "2", "3", "5"]
    assert block_matrix(fig1.system).columns[3].indices == ("5",)


# -- the floating system ---------------------------------------------------------------------------------------------


def test_4_10_angular_velocities(fig2: World) -> None:
    u, w, rate = fig2.vector, fig2.omega, fig2.joint_rates
    assert same(w(2), vadd(w(1), scale(rate["2"], u("u2"))))
    assert same(w(3), vadd(w(2), scale(rate["3"], u("u3"))))
    assert same(w(4), w(3))
    assert same(w(5), vadd(w(1), scale(rate["7"], u("u7"))))


def test_4_11_velocities_of_points(fig2: World) -> None:
    for label in ("r2", "r3", "r4", "r5", "r6", "r7", "r8"):
        assert holds(fig2, label, R_2[label], THETA_2)


def test_4_12_blank_in_the_paper(fig2: World) -> None:
    for label, body in (("u1", 1), ("u2", 1), ("u3", 2), ("u4", 3), ("u6", 4), ("u7", 1), ("u8", 5)):
        assert same(fig2.rate(label), fig2.row([f"-U{label[1:]}"], [f"omega{body}"]))
        assert holds(fig2, label, R_2[label], THETA_2)


def test_4_13_is_what_is_printed_and_derived(fig2: World) -> None:
    matrix = block_matrix(fig2.system)
    rows = {row.label: [notation(b) for b in blocks] for row, blocks in zip(matrix.rows, matrix.blocks, strict=True)}
    assert rows == R_2
    for label, row in R_2.items():
        assert holds(fig2, label, row, THETA_2)


def test_erratum_5_fourteen_rows_for_fifteen(fig2: World) -> None:
    """(4.13): 15 rows on the left, 14 on the right; seven block columns for six; rows out of place."""
    left = ["r1", "u1", "r2", "u2", "r3", "u3", "r4", "u4", "r5", "r6", "u6", "r7", "u7", "r8", "u8"]
    matrix = block_matrix(fig2.system)
    assert [entity.label for entity in matrix.rows] == left
    assert len(matrix.columns) == 6 and sum(len(unit.columns) for unit in matrix.columns) == fig2.system.tree.nv == 10
    # as printed, the stray seventh column left out
    printed = {
        "u4": ["1", "-D51", "-D52 u2", "-D53 u3", "u4", "0"],
        "u6": ["0", "-U6", "-U6 u2", "-D63 u3", "u4", "0"],
        "u7": ["1", "-D71", "0", "0", "0", "0"],
        "r8": ["0", "-U7", "0", "0", "0", "-D87 u7"],
        "u8": ["0", "-U8", "0", "0", "0", "-D87 u7"],
    }
    for label, row in printed.items():
        assert not holds(fig2, label, row, THETA_2)
        assert holds(fig2, label, R_2[label], THETA_2)


def test_d_chains(fig1: World) -> None:
    """d_ik + d_kj = d_ij, the relation that turns (4.2) into (4.4)."""
    r = fig1.vector
    assert same(vadd(vsub(r("r6"), r("r4")), vsub(r("r4"), r("r1"))), vsub(r("r6"), r("r1")))
