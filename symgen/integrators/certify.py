"""How a step is certified: what was emitted is run over GF(p), call by call, and held to its definition.

What it calls runs as it was emitted, too, and is certified by itself besides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from symgen.algebra.field import FieldNumbers, Residue
from symgen.algebra.numbers import State
from symgen.certificate import Candidate, Certificate, Certifier
from symgen.integrators.read import Evaluate, Inputs, Prepare, ReadComposed
from symgen.program.angles import register_sums
from symgen.program.composed import ComposedProgram
from symgen.program.instructions import Program
from symgen.scene.model import Output
from symgen.system import System
from symgen.targets.c.read_back import Read

if TYPE_CHECKING:
    import casadi


def certify_step(
    certifier: Certifier,
    output: Output,
    program: ComposedProgram,
    texts: Mapping[str, Read],
    straight: Mapping[str, Program | None],
    function: casadi.Function | None,
) -> Certificate:
    """Certify a step. ``texts``: every emitted C function, read back; ``straight``: their straight-line programs, where
    they have any; ``function``: the step in CasADi, as its file is read."""
    prepare = partial(_prepare, certifier.system)
    candidates = []
    text = texts.get(program.name)
    if isinstance(text, ReadComposed):
        candidates.append(Candidate("C", _of_text(text, texts, straight, prepare)))
    if function is not None:
        candidates.append(_of_casadi(function, program, straight, prepare))
    found = certifier.certify(output, program, candidates)
    called = ", ".join(program.callees)
    return Certificate(
        f"{found.method}; made of calls of {called}, certified themselves",
        found.checked_against,
        found.points,
        found.failure_probability,
    )


def _prepare(system: System, numbers: FieldNumbers, inputs: Inputs, program: Program) -> None:
    """Tell the field of the angles at another configuration: the joints' own, then the sums that a program takes."""
    if "q" in inputs:
        p = numbers.p
        q, parameters = (tuple(Residue(x, p) for x in inputs.get(name, ())) for name in ("q", "p"))
        _ = system.literal(numbers, State(q=q, p=parameters)).at
    register_sums(program, numbers, inputs)


def _of_text(
    text: ReadComposed, texts: Mapping[str, Read], straight: Mapping[str, Program | None], prepare: Prepare
) -> Evaluate:
    def run(name: str, numbers: FieldNumbers, inputs: Inputs) -> Mapping[str, Sequence[int]]:
        called, program = texts[name], straight.get(name)
        prepare(numbers, inputs, program or text.program.callees[name])
        assert not isinstance(called, ReadComposed)
        return called.evaluate_mod(numbers.p, inputs, numbers.apply)

    functions = {name: partial(run, name) for name in text.program.callees}

    def evaluate(numbers: FieldNumbers, inputs: Inputs) -> Mapping[str, Sequence[int]]:
        return text.evaluate(numbers, inputs, functions)

    return evaluate


def _of_casadi(
    function: casadi.Function,
    program: ComposedProgram,
    straight: Mapping[str, Program | None],
    prepare: Prepare,
) -> Candidate:
    from symgen.integrators.casadi import read_step

    callees = {name: own for name in program.callees if (own := straight[name]) is not None}
    read = read_step(function, program, callees)
    return Candidate("CasADi", lambda numbers, inputs: read.evaluate(numbers, inputs, prepare))
