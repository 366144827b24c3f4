"""Paper §3: (3.2)–(3.7) for what symgen derives, exactly where they are identities; erratum 7."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy

from symgen.algebra.linear import Mat, Vec, matmul, matvec, transpose, vadd, vneg, vsub
from symgen.natural.constraints import constraint_jacobian
from symgen.targets.sympy import sympy_matrix, system_symbols
from tests.paper.world import World, example, same


@pytest.fixture(scope="module", params=["fig1", "fig2"])
def world(request: pytest.FixtureRequest) -> World:
    return World(example(request.param))


def natural_acceleration(world: World) -> Vec:
    """q̈ = R θ̈ + Ṙ θ̇, (3.6) with erratum 7."""
    literal = world.literal
    return vadd(
        matvec(literal.velocity_transformation(), tuple(literal.state.a)),
        matvec(literal.velocity_transformation_rate(), tuple(literal.state.v)),
    )


def jacobian_rate(world: World) -> Mat:
    """Ψ̇_q: Ψ is quadratic in points and vectors, so Ψ_q is affine and its rate is Ψ_q(x + ẋ) − Ψ_q(x)."""
    natural, numbers = world.system.natural, world.literal.values.numbers
    moved = constraint_jacobian(natural, vadd(world.x, world.x_rate), numbers)
    here = constraint_jacobian(natural, world.x, numbers)
    return tuple(vsub(a, b) for a, b in zip(moved, here, strict=True))


def zero(value: Any) -> bool:
    return all(zero(x) for x in value) if isinstance(value, tuple) else bool(value == 0)


def test_3_1_constraints_hold(world: World) -> None:
    assert world.system.natural.nc > 0 and zero(world.literal.constraints())


def test_3_2_velocity_and_acceleration_equations(world: World) -> None:
    psi_q = world.literal.constraint_jacobian()
    assert zero(matvec(psi_q, world.x_rate))
    rest = vadd(matvec(psi_q, natural_acceleration(world)), matvec(jacobian_rate(world), world.x_rate))
    assert zero(rest)


def test_3_5_jacobian_times_transformation_vanishes(world: World) -> None:
    """Erratum 7: "R is orthogonal to Ψ_q" means Ψ_q R = 0; the columns of Ψ_q and R are not even of one length."""
    psi_q, r = world.literal.constraint_jacobian(), world.literal.velocity_transformation()
    assert len(psi_q[0]) == len(r) == world.system.natural.nn and len(psi_q) != len(r)
    assert zero(matmul(psi_q, r))
    broken = (vadd(r[0], (1,) * len(r[0])), *r[1:])
    assert not zero(matmul(psi_q, broken))


def test_3_6_erratum_7_the_second_term_is_r_dot(world: World) -> None:
    """As printed, R θ̈ + R θ̇, the accelerations violate (3.2)₂."""
    literal = world.literal
    printed = matvec(literal.velocity_transformation(), vadd(tuple(literal.state.a), tuple(literal.state.v)))
    rest = vadd(matvec(literal.constraint_jacobian(), printed), matvec(jacobian_rate(world), world.x_rate))
    assert not zero(rest)


def test_r_dot_theta_dot_without_r_dot(world: World) -> None:
    literal = world.literal
    wanted = matvec(literal.velocity_transformation_rate(), tuple(literal.state.v))
    assert same(literal.natural_bias_acceleration(), wanted)


def generalised_force(world: World) -> Vec:
    """Q = M γ with γ = g at every point, those fixed in ground included, and 0 at vectors; rows of x."""
    literal, natural = world.literal, world.system.natural
    g = literal.values.gravity()
    total: list[Vec] = [(0, 0, 0)] * len(natural.entities)
    for (i, k), mass in literal.entity_mass.items():
        if natural.entities[k].kind == "point":
            total[i] = vadd(total[i], tuple(mass * x for x in g))
    return tuple(x for k in natural.moving for x in total[k])


def test_3_7_reduced_equations(world: World) -> None:
    """RᵀMRθ̈ = Rᵀ(Q − MṘθ̇) + τ, and with (3.3): Rᵀ(M q̈ − Q) = τ, the multipliers gone."""
    literal = world.literal
    r, r_rate, mass = (
        literal.velocity_transformation(), literal.velocity_transformation_rate(), literal.natural_mass_matrix(),
    )  # fmt: skip
    rt, v, a = transpose(r), tuple(literal.state.v), tuple(literal.state.a)
    q = generalised_force(world)
    reduced = matmul(rt, matmul(mass, r))
    assert same(literal.mass_matrix(), reduced)
    bias = vsub(matvec(rt, matvec(mass, matvec(r_rate, v))), matvec(rt, q))
    assert same(literal.bias_force(), bias)
    assert same(literal.gravity_force(), vneg(matvec(rt, q)))
    tau = vadd(matvec(reduced, a), bias)
    assert same(literal.inverse_dynamics(), tau)
    assert same(matvec(rt, vsub(matvec(mass, natural_acceleration(world)), q)), tau)
    (solved,) = world.system.evaluate("forward_dynamics", literal.values.numbers, literal.state).values()
    right = vadd(vsub(matvec(rt, q), matvec(rt, matvec(mass, matvec(r_rate, v)))), tuple(literal.state.tau))
    assert same(matvec(reduced, tuple(solved)), right)


def test_3_4_and_the_rate_of_r_by_differentiation() -> None:
    """q̇ = R θ̇ and Ṙ = dR/dt, differentiated symbolically, evaluated in floats; the rows of r₆ and u₆."""
    system = example("fig1")
    symbols = system_symbols(system.scene, system.tree)
    x, r, r_rate = (
        sympy_matrix(system, row)[-6:, :]
        for row in ("natural_coordinates", "velocity_transformation", "velocity_transformation_rate")
    )
    known = dict(zip((*symbols.q, *symbols.v), (0.3, -0.7, 0.45, 1.1, 0.8, -0.2, 0.6, 1.4), strict=True))
    rate = sympy.zeros(*r.shape)
    for q, v in zip(symbols.q, symbols.v, strict=True):
        rate += r.diff(q) * v

    def value(matrix: sympy.Matrix) -> Any:
        return np.array(sympy.lambdify(list(known), matrix, cse=True)(*known.values()), dtype=float)

    for a, b in ((value(x.jacobian(symbols.q)), value(r)), (value(rate), value(r_rate))):
        assert np.abs(b).max() > 0.1 and np.abs(a - b).max() < 1e-12
