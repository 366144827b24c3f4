"""A function made of calls: other emitted functions, and short straight-line updates between them.

A `ComposedProgram` stands where a `Program` does: it has the same ports, name and summary, but no instructions of its
own. A step of Runge and Kutta calls forward dynamics four times instead of holding it four times over.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from symgen.program.instructions import Counts, Port, Program, count


@dataclass(frozen=True)
class Call:
    """Arrays in, arrays out: ``inputs`` and ``outputs`` say which array of the caller every port is."""

    function: str
    """Name of an emitted function, or of the update's program."""
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    update: Program | None = None
    """The straight-line program that is called, where it belongs to this function alone."""


@dataclass(frozen=True)
class ComposedProgram(Program):
    """``instructions`` is empty; ``guards`` is not where a function that is called may have no answer."""

    calls: tuple[Call, ...] = ()
    locals: Mapping[str, Port] = field(default_factory=dict)
    """Local arrays: name → a port of their shape."""
    callees: Mapping[str, Program] = field(default_factory=dict, repr=False, compare=False)
    """Emitted functions that are called, as they are emitted."""

    @property
    def steps(self) -> Iterator[Program]:
        """The updates."""
        return (call.update for call in self.calls if call.update is not None)

    def called(self, call: Call) -> Program:
        """What a call runs."""
        return call.update or self.callees[call.function]


def total(program: ComposedProgram, counts: Mapping[str, Counts]) -> Counts:
    """Operations of one call, from those of everything it calls, by name."""
    names = ("add", "mul", "div", "sqrt", "sincos")
    return Counts(**{name: sum(getattr(counts[call.function], name) for call in program.calls) for name in names})


def composed_counts(program: ComposedProgram, own: Mapping[str, Counts]) -> Counts:
    """The same where only the emitted functions have been counted."""
    return total(program, {**own, **{step.name: count(step) for step in program.steps}})
