"""A composed function for CasADi: an MX function whose nodes are calls of SX functions, read back call by call."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi

from symgen.algebra.field import FieldNumbers
from symgen.errors import CertificateError
from symgen.integrators.read import Inputs, Prepare
from symgen.program.composed import Call, ComposedProgram
from symgen.program.instructions import Program
from symgen.targets.casadi.emit import casadi_function, casadi_name, casadi_names, matrix_shape
from symgen.targets.casadi.read_back import Listing, evaluate_mod, listing


def _program(program: ComposedProgram, call: Call, callees: Mapping[str, Program]) -> Program:
    """What a call runs, under the name it has in CasADi."""
    if call.update is None:
        return callees[call.function]
    return replace(call.update, name=f"{program.name}_{call.function}")


def casadi_step(program: ComposedProgram, callees: Mapping[str, Program]) -> casadi.Function:
    """The function ``program.name``. ``callees``: emitted function → its straight-line program."""
    made: dict[str, casadi.Function] = {}
    arrays: dict[str, Any] = {port.name: casadi.MX.sym(port.name, *matrix_shape(port)) for port in program.inputs}
    inputs = [arrays[port.name] for port in program.inputs]
    for call in program.calls:
        own = _program(program, call, callees)
        if own.name not in made:
            made[own.name] = casadi_function(own)
        found = made[own.name].call([arrays[call.inputs[port.name]] for port in own.inputs])
        arrays.update({call.outputs[port.name]: x for port, x in zip(own.outputs, found, strict=True)})
    return casadi.Function(
        casadi_name(program.name),
        inputs,
        [arrays[port.name] for port in program.outputs],
        casadi_names(program.inputs),
        casadi_names(program.outputs),
    )


@dataclass(frozen=True)
class _Row:
    """One node: an argument, a call or a result, and the places of the work vector that it reads and writes."""

    sources: Sequence[int]
    targets: Sequence[int]
    kind: str
    called: casadi.Function | None = None


@dataclass(frozen=True)
class ReadStep:
    """What such a function does, in its order."""

    program: ComposedProgram
    callees: Mapping[str, Program]
    rows: Sequence[_Row]
    listings: Mapping[str, Listing]

    def evaluate(self, numbers: FieldNumbers, inputs: Inputs, prepare: Prepare) -> dict[str, list[int]]:
        """Outputs by name, flat, row-major, in GF(p)."""
        programs = {casadi_name(own.name): own for own in self._programs()}
        work: dict[int, list[int]] = {}
        results: dict[str, list[int]] = {}
        for row in self.rows:
            if row.kind == "argument":
                work[row.targets[0]] = list(inputs[self.program.inputs[row.sources[0]].name])
            elif row.kind == "result":
                results[self.program.outputs[row.targets[0]].name] = work[row.sources[0]]
            else:
                assert row.called is not None
                own = programs.get(row.called.name())
                if own is None:
                    raise CertificateError(f"{self.program.name}: the CasADi function calls {row.called.name()}")
                given = {port.name: work[place] for port, place in zip(own.inputs, row.sources, strict=True)}
                prepare(numbers, given, own)
                found = evaluate_mod(row.called, own, numbers, given, self.listings[own.name])
                work.update({place: found[port.name] for port, place in zip(own.outputs, row.targets, strict=True)})
        return results

    def _programs(self) -> Iterator[Program]:
        for call in self.program.calls:
            yield _program(self.program, call, self.callees)


def read_step(function: casadi.Function, program: ComposedProgram, callees: Mapping[str, Program]) -> ReadStep:
    """The calls that CasADi keeps. Raises CertificateError for anything else, and for other arguments or results."""
    wanted = [(casadi_names(ports), [matrix_shape(p) for p in ports]) for ports in (program.inputs, program.outputs)]
    found = [
        ([function.name_in(i) for i in range(function.n_in())], [function.size_in(i) for i in range(function.n_in())]),
        (
            [function.name_out(i) for i in range(function.n_out())],
            [function.size_out(i) for i in range(function.n_out())],
        ),
    ]
    if wanted != found:
        raise CertificateError(f"{program.name}: the CasADi function has other arguments or results")
    kinds = {casadi.OP_INPUT: "argument", casadi.OP_OUTPUT: "result", casadi.OP_CALL: "call"}
    rows = []
    for k in range(function.n_instructions()):
        kind, node = kinds.get(function.instruction_id(k)), function.instruction_MX(k)
        whole = kind == "call" or (kind is not None and node.info()["offset"] == 0 and node.info()["segment"] == 0)
        if kind is None or not whole:
            raise CertificateError(f"{program.name}: its CasADi function does other things than calling")
        called = node.which_function() if kind == "call" else None
        rows.append(_Row(function.instruction_input(k), function.instruction_output(k), kind, called))
    listings = {row.called.name(): listing(row.called) for row in rows if row.called is not None}
    by_name = {
        own.name: listings[casadi_name(own.name)]
        for own in (_program(program, call, callees) for call in program.calls)
        if casadi_name(own.name) in listings
    }
    return ReadStep(program, callees, rows, by_name)
