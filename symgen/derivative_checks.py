"""How derivative rows are certified: against the literal form run in dual numbers over GF(p), along random directions.

Accelerations that forward dynamics asks for are solved for in body axes and then held to the literal equation of
motion, in the same numbers: nothing of the plans is trusted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from symgen.algebra.dual import parts
from symgen.algebra.field import NotInField, Residue
from symgen.algebra.field_dual import FieldDual
from symgen.algebra.linear import Vec, dot, vadd
from symgen.catalogue import row_of, split_row
from symgen.emitted import Check, Emitted, Pairs
from symgen.literal.derivatives import SECOND, along, change
from symgen.literal.equations import Literal
from symgen.plans.build import flatten
from symgen.plans.composite import mass_matrix
from symgen.plans.factor import factor
from symgen.plans.walk import Lowered


def accelerations(literal: Literal, lowered: Lowered) -> list[Any]:
    """a with mass_matrix a + bias_force = tau in the number type of ``literal``, GF(p) or duals over it. Found by the
    plans, accepted only if the literal equation holds."""
    state, values = literal.state, literal.values
    links = lowered.at(values, state.q)
    m = lowered.reduce_matrix(values, mass_matrix(links))
    for i, extra in enumerate(literal.armature):
        m[i][i] = m[i][i] + extra
    a = factor(links, m).solve([x - y for x, y in zip(state.tau, literal.bias_force(), strict=True)])
    for left, bias, tau in zip(literal.mass_matrix_times(a), literal.bias_force(), state.tau, strict=True):
        if any(not x == y for x, y in zip(parts(left + bias), parts(tau), strict=True)):
            raise NotInField("the equation of motion does not hold")
    return a


def _inverse_dynamics(literal: Literal, emitted: Emitted) -> Pairs:
    """Both matrices times random directions of their own, against the change of the literal inverse dynamics along both
    at once: a polynomial in the two directions that vanishes only where neither matrix is wrong."""
    n = literal.tree.nv
    x, y = emitted.random(n), emitted.random(n)
    expected = change(along(literal, {"dq": x, "dv": y}).inverse_dynamics())
    yield from zip(expected, vadd(_times(emitted, "dtau_dq", x), _times(emitted, "dtau_dv", y)), strict=True)


def _times(emitted: Emitted, port: str, x: Sequence[Residue]) -> Vec:
    return tuple(emitted.times(port, x))


def _forward_dynamics(literal: Literal, emitted: Emitted) -> Pairs:
    """Along any direction of q, v and τ the literal inverse dynamics at (q, v, a) changes as τ does."""
    a, n = accelerations(literal, emitted.lowered), literal.tree.nv
    moved = Literal(literal.tree, literal.natural, literal.values, replace(literal.state, a=tuple(a)))
    x, y, z = (emitted.random(n) for _ in range(3))
    da = vadd(vadd(_times(emitted, "da_dq", x), _times(emitted, "da_dv", y)), _times(emitted, "da_dtau", z))
    yield from zip(z, change(along(moved, {"dq": x, "dv": y, "da": da}).inverse_dynamics()), strict=True)


def _second(literal: Literal, emitted: Emitted) -> Pairs:
    """All tensors times random directions, against nested duals: the change along (x_q, x_v, x_a), changed along
    (y_q, y_v). Every tensor has a product of directions of its own, so none can make up for another."""
    n = literal.tree.nv
    x = {name: emitted.random(n) for name in ("dq", "dv", "da")}
    y = {name: emitted.random(n) for name in ("dq", "dv")}
    nested = along(
        along(literal, y), {name: [FieldDual(value.x, 0, value.p) for value in row] for name, row in x.items()}
    )
    expected = change(change(nested.inverse_dynamics()))
    found: Vec = (0,) * n
    for first, second in (*SECOND, ("dv", "dq")):
        port = f"d2tau_{first}{second}"
        if port == "d2tau_dvdq":  # d2tau_dqdv, its indices exchanged
            by_last, other = _times(emitted, "d2tau_dqdv", x["dv"]), y["dq"]
        else:
            by_last, other = _times(emitted, port, y[second]), x[first]
        found = vadd(found, tuple(dot(by_last[i * n : (i + 1) * n], other) for i in range(n)))
    yield from zip(expected, found, strict=True)


def _changes(literal: Literal, emitted: Emitted, row: str, direction: Mapping[str, Sequence[Any]]) -> list[Any]:
    """Changes of the outputs of a row along a direction, flat."""
    name, frame = split_row(row)
    dual = along(literal, direction)
    if name == "forward_dynamics":
        return list(change(tuple(accelerations(dual, emitted.lowered))))
    definition = row_of(row).literal
    assert definition is not None
    return [change(x) for value in definition(dual, frame) for x in flatten(value)]


def _jvp(literal: Literal, emitted: Emitted) -> Pairs:
    row = split_row(emitted.row)[1]
    names = [f"d{name}" for name in (*row_of(row).inputs, "p") if f"d{name}" in emitted.inputs]
    expected = _changes(literal, emitted, row, {name: emitted.inputs[name] for name in names})
    yield from zip(expected, [x for port in emitted.ports for x in emitted.values.get(port, [])], strict=True)


def _vjp(literal: Literal, emitted: Emitted) -> Pairs:
    """Gradient times a random direction = weights times the change along it."""
    row = split_row(emitted.row)[1]
    base = row_of(row)
    direction, found = {}, Residue(0, emitted.p)
    for name, port in zip((*base.inputs, "p"), emitted.ports, strict=True):
        size = len(literal.state.p) if name == "p" else literal.tree.nv
        if size:
            x = direction[f"d{name}"] = emitted.random(size)
            found = found + dot(emitted.values[port], x)
    weights = [x for name, _, _ in base.outputs for x in emitted.inputs.get(f"w_{name}", [])]
    yield dot(weights, _changes(literal, emitted, row, direction)), found


def _parameter_jacobian(literal: Literal, emitted: Emitted) -> Pairs:
    x = emitted.random(len(literal.state.p))
    found = [y for port in emitted.ports for y in emitted.times(port, x)]
    yield from zip(_changes(literal, emitted, split_row(emitted.row)[1], {"dp": x}), found, strict=True)


CHECKS: dict[str, tuple[str, Check]] = {
    "inverse_dynamics_derivatives": (
        "literal inverse_dynamics in dual numbers along random directions", _inverse_dynamics
    ),
    "forward_dynamics_derivatives": (
        "literal inverse_dynamics in dual numbers: tau changes as it should along random directions", _forward_dynamics
    ),
    "inverse_dynamics_second_derivatives": ("literal inverse_dynamics in nested dual numbers", _second),
    "jvp": ("literal row in dual numbers", _jvp),
    "vjp": ("literal row in dual numbers along random directions", _vjp),
    "parameter_jacobian": ("literal row in dual numbers along random parameters", _parameter_jacobian),
}  # fmt: skip
