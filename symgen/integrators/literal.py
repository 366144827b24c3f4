"""The definition of a step: its method, every row evaluated by its literal definition, in any number type."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symgen.algebra.numbers import State
from symgen.catalogue import CATALOGUE, split_row
from symgen.derivative_checks import accelerations
from symgen.emitted import Check, Emitted, Pairs
from symgen.integrators.methods import METHODS
from symgen.integrators.model import Evaluate, Method, Place
from symgen.literal.equations import Literal
from symgen.plans.build import flatten
from symgen.plans.walk import Lowered

Scalar = Any


def step(method: Method, literal: Literal, lowered: Lowered) -> dict[str, Sequence[Scalar]]:
    """All arrays of a step from the state of ``literal``: q_next, v_next, and what lies between."""
    state = literal.state
    arrays: dict[str, Sequence[Scalar]] = {"q": state.q, "v": state.v, "tau": state.tau, "dt": [state.dt]}
    place = Place(literal.tree, literal.values, sparse=False)
    for operation in method.operations:
        given = {port: arrays[name] for port, name in operation.inputs.items()}
        if isinstance(operation, Evaluate):
            found = _row(operation.row, literal, given, lowered)
        else:
            found = operation.function(place, given)
        arrays.update(zip(operation.outputs.values(), found, strict=True))
    return arrays


def _row(
    row: str, literal: Literal, given: dict[str, Sequence[Scalar]], lowered: Lowered
) -> tuple[Sequence[Scalar], ...]:
    """A row at other arrays: by its definition, or, of forward dynamics, what satisfies the literal equation."""
    fields: dict[str, Any] = {name: tuple(x) for name, x in given.items()}
    fields["dt"] = fields["dt"][0] if "dt" in fields else literal.state.dt
    zero = tuple(literal.values.numbers.const(0) for _ in range(literal.tree.nv))
    state = State(**({"v": zero, "a": zero, "tau": zero, "p": literal.state.p} | fields))
    here = Literal(literal.tree, literal.natural, literal.values, state)
    if row == "forward_dynamics":
        return (accelerations(here, lowered),)
    definition = CATALOGUE[row].literal
    assert definition is not None
    return tuple(flatten(value) for value in definition(here, ""))


def _check(literal: Literal, emitted: Emitted) -> Pairs:
    found = step(METHODS[split_row(emitted.row)[1]], literal, emitted.lowered)
    for port in emitted.ports:
        yield from zip(found[port], emitted.values[port], strict=True)


CHECKS: dict[str, tuple[str, Check]] = {
    "step": ("the method with every row by its literal definition", _check),
}
