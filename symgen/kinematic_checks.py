"""How certificates check frames, momenta, regressors and constraint forces: products with random vectors, and the
normal equations of λ."""

from __future__ import annotations

from symgen.algebra.linear import dot
from symgen.catalogue import split_row
from symgen.emitted import Check, Emitted, Pairs
from symgen.literal import base_parameters, frames, reactions, regressor
from symgen.literal.equations import Literal


def _momentum_matrix(literal: Literal, emitted: Emitted) -> Pairs:
    """A x is the momentum at the velocities x."""
    x = emitted.random(literal.tree.nv)
    yield from zip(frames.momentum_of(literal, x), emitted.times(emitted.ports[0], x), strict=True)


def _frame_jacobian(literal: Literal, emitted: Emitted) -> Pairs:
    """J x is the frame's twist at the velocities x."""
    x = emitted.random(literal.tree.nv)
    _, frame = split_row(emitted.row)
    yield from zip(frames.twist_of(literal, frame, x), emitted.times(emitted.ports[0], x), strict=True)


def _regressor(literal: Literal, emitted: Emitted) -> Pairs:
    """Y π is the inverse dynamics of bodies with the parameters π."""
    pi = emitted.random(regressor.TEN * len(literal.tree.bodies))
    yield from zip(regressor.regressor_times(literal, pi), emitted.times(emitted.ports[0], pi), strict=True)


def _base_regressor(literal: Literal, emitted: Emitted) -> Pairs:
    """Yb K π likewise: with K's unit columns this holds for all π only where Yb is those columns of Y."""
    base = base_parameters.of_literal(literal)
    pi = emitted.random(len(base.names))
    const = literal.values.numbers.const
    beta = [dot([const(x) for x in row.values()], [pi[k] for k in row]) for row in base.rows]
    yield from zip(regressor.regressor_times(literal, pi), emitted.times(emitted.ports[0], beta), strict=True)


def _base_parameters(literal: Literal, emitted: Emitted) -> Pairs:
    """β entry by entry, and Yb β is the inverse dynamics of the scene's own bodies."""
    beta = emitted.values.get(emitted.ports[0], [])
    yield from zip(base_parameters.base_parameter_values(literal), beta, strict=True)
    pi = regressor.inertial_parameters(literal)
    yb = base_parameters.base_regressor(literal)
    yield from zip(regressor.regressor_times(literal, pi), [dot(row, beta) for row in yb], strict=True)


def _constraint_forces(literal: Literal, emitted: Emitted) -> Pairs:
    yield from reactions.normal_equations(literal, tuple(emitted.values[emitted.ports[0]]))


CHECKS: dict[str, tuple[str, Check]] = {
    "momentum_matrix": ("literal momentum at random velocities x = A x", _momentum_matrix),
    "frame_jacobian": ("literal twist at random velocities x = J x", _frame_jacobian),
    "regressor": ("literal R^T(M(R a + dR/dt v) - Q) of bodies with random parameters pi = Y pi", _regressor),
    "base_regressor": ("literal inverse dynamics of random parameters pi = Yb K pi", _base_regressor),
    "base_parameters": ("literal K pi, and Yb beta = literal inverse dynamics", _base_parameters),
    "constraint_forces": ("Psi_x (Psi_x^T lambda) = Psi_x (Mn xddot - Q), literal", _constraint_forces),
}
