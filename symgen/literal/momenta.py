"""The equation of motion in momenta, by the definition: P = RᵀMR θ̇ changes with ṘᵀMR θ̇ + RᵀQ + τ."""

from __future__ import annotations

from typing import Any

from symgen.algebra.linear import Vec, add, dot, vsub
from symgen.literal.equations import Literal

Scalar = Any


def joint_momentum(literal: Literal) -> tuple[Vec, Vec]:
    """RᵀMR θ̇, and its rate without τ: d(RᵀMR θ̇)/dt = ṘᵀMR θ̇ + RᵀM ẍ, and RᵀM ẍ = RᵀQ + τ (paper, (3.7))."""
    momentum = literal.mass_times(literal.velocities(literal.state.v))
    rate: list[Scalar] = [0] * literal.tree.nv
    for block, value in zip(literal.r_rate_columns, momentum, strict=True):
        for j, column in block.items():
            rate[j] = add(rate[j], dot(column, value))
    found = tuple(literal.mass_matrix_times(literal.state.v))
    return found, vsub(vsub(tuple(rate), literal.gravity_force()), literal.passive_force())
