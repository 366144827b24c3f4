"""Derivatives of the literal form by dual numbers: the definition that derivative rows are held to.

A direction is a change of the state: ``dq`` and ``dv`` velocities (dq moves the configuration along its manifold,
q̇ = G(q) dq, which on quaternion joints is the tangent of `integrate`), ``da``, ``dtau``, ``dp`` plain changes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from symgen.algebra.dual import change_of, dual, dual_numbers
from symgen.algebra.linear import transpose
from symgen.algebra.numbers import State
from symgen.literal.equations import Literal
from symgen.velocity.kinematics import configuration_rate
from symgen.velocity.values import Values

Scalar = Any
Direction = Mapping[str, Sequence[Scalar]]


def along(literal: Literal, direction: Direction) -> Literal:
    """The same quantities in dual numbers: what `change` reads off them is their derivative along ``direction``."""
    state, values = literal.state, literal.values
    rates = {"q": _rate(literal, direction), **{name: direction.get(f"d{name}") for name in ("v", "a", "tau", "p")}}
    numbers = dual_numbers(values.numbers)
    fields = {name: _dual(numbers, getattr(state, name), rate) for name, rate in rates.items()}
    changed = State(**fields, dt=dual(numbers, state.dt))
    return Literal(literal.tree, literal.natural, Values(values.scene, numbers, changed.p), changed)


def _rate(literal: Literal, direction: Direction) -> Sequence[Scalar] | None:
    if "dq" not in direction:
        return None
    return configuration_rate(literal.tree, literal.values, literal.state.q, direction["dq"])


def _dual(numbers: Any, values: Sequence[Scalar], rates: Sequence[Scalar] | None) -> tuple[Scalar, ...]:
    if rates is None:
        return tuple(dual(numbers, x) for x in values)
    return tuple(dual(numbers, x, rate) for x, rate in zip(values, rates, strict=True))


def change(value: Any) -> Any:
    """The derivative part of a scalar or of nested tuples of them."""
    if isinstance(value, tuple | list):
        return tuple(change(x) for x in value)
    return change_of(value)


def columns(literal: Literal, name: str, of: Callable[[Literal], Any]) -> tuple[Any, ...]:
    """Per unit direction of ``name`` (dq, dv, da, dp), the derivative of ``of``."""
    size = len(literal.state.p) if name == "dp" else literal.tree.nv
    return tuple(change(of(along(literal, {name: [1 if i == j else 0 for i in range(size)]}))) for j in range(size))


def _inverse_dynamics(literal: Literal) -> Any:
    return literal.inverse_dynamics()


def inverse_dynamics_derivatives(literal: Literal) -> tuple[Any, ...]:
    """∂τ/∂q, ∂τ/∂v."""
    return tuple(transpose(columns(literal, name, _inverse_dynamics)) for name in ("dq", "dv"))


SECOND = (("dq", "dq"), ("dq", "dv"), ("dv", "dv"), ("da", "dq"))
"""Of the second derivatives: the variable derived by first, then the other."""


def inverse_dynamics_second_derivatives(literal: Literal) -> tuple[Any, ...]:
    """[i][j][k] = derivative of τ_i by the j-th of the first, then by the k-th of the second."""
    found = []
    for first, second in SECOND:
        by_second = columns(literal, second, partial(columns, name=first, of=_inverse_dynamics))
        nv = literal.tree.nv
        found.append(tuple(tuple(tuple(by_second[k][j][i] for k in range(nv)) for j in range(nv)) for i in range(nv)))
    return tuple(found)
