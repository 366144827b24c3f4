"""Composed functions read back: updates as straight-line functions are, the rest call by call.

Nothing but declarations of local arrays and calls is accepted. Running it checks that every array is written once,
before it is read, and by nothing that reads it too.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symgen.algebra.field import FieldNumbers
from symgen.errors import CertificateError
from symgen.integrators.text import update_arguments
from symgen.loops.text import symbol_of
from symgen.program.composed import ComposedProgram
from symgen.program.instructions import Counts, Port, Program
from symgen.targets.c.function_text import FunctionReader, ReadFunction

Inputs = Mapping[str, Sequence[int]]
Evaluate = Callable[[FieldNumbers, Inputs], Mapping[str, Sequence[int]]]

Prepare = Callable[[FieldNumbers, Inputs, Program], None]
"""Called before a function is run at a configuration that the field does not know of yet."""

_STEP = re.compile(r"\s*SYMGEN_STEP void (\w+)\(([^()]*)\)\n\{\n(.*?)\n\}\n", re.ASCII | re.DOTALL)
_LOCAL = re.compile(r"(double|float) (\w+)\[(\d{1,9})\];", re.ASCII)
_CALL = re.compile(r"(status \|= )?(\w+)\(([\w, ]+)\);", re.ASCII)


@dataclass(frozen=True)
class ReadCall:
    """A call as it stands: the C name and what is passed."""

    symbol: str
    arguments: tuple[str, ...]


@dataclass(frozen=True)
class ReadComposed:
    """An emitted composed function as a function over GF(p), once it is told what it calls."""

    program: ComposedProgram
    updates: Mapping[str, ReadFunction]
    """By C name."""
    symbols: Mapping[str, str]
    """C name → emitted function."""
    locals: Mapping[str, int]
    calls: tuple[ReadCall, ...]
    constants: frozenset[str]
    operations: Counts

    @property
    def name(self) -> str:
        return self.program.name

    def evaluate(
        self, numbers: FieldNumbers, inputs: Inputs, functions: Mapping[str, Evaluate]
    ) -> dict[str, list[int]]:
        """Outputs by name, flat, in GF(p). ``functions``: emitted function → what its text computes. Raises NotInField
        where something divides by zero, CertificateError where an array is read before it is written."""
        arrays: dict[str, list[int] | None] = dict.fromkeys((*self.locals, *(p.name for p in self.program.outputs)))
        given = {port.name: list(inputs[port.name]) for port in self.program.inputs}
        for call in self.calls:
            ports_in, ports_out, run = self._called(call, functions)
            passed = dict(zip((port.name for port in ports_in), call.arguments, strict=False))
            targets = call.arguments[len(ports_in) :]
            values: dict[str, list[int]] = {}
            for port in ports_in:
                name = passed[port.name]
                value = given[name] if name in given else arrays.get(name)
                if value is None or len(value) != port.size or name in targets:
                    raise CertificateError(f"{self.name}: {call.symbol} reads {name}, which is not there")
                values[port.name] = value
            found = run(numbers, values)
            for port, name in zip(ports_out, targets, strict=True):
                if name not in arrays or arrays[name] is not None or self._size(name) != port.size:
                    raise CertificateError(f"{self.name}: {call.symbol} writes {name}")
                arrays[name] = list(found[port.name])
        results = {port.name: arrays[port.name] for port in self.program.outputs}
        if any(value is None for value in results.values()):
            raise CertificateError(f"{self.name}: an output is never written")
        return {name: value for name, value in results.items() if value is not None}

    def _size(self, name: str) -> int:
        outputs = {port.name: port.size for port in self.program.outputs}
        return self.locals.get(name) or outputs[name]

    def _called(self, call: ReadCall, functions: Mapping[str, Evaluate]) -> tuple[list[Port], list[Port], Evaluate]:
        if call.symbol in self.updates:
            update = self.updates[call.symbol]
            ports: Program | ReadFunction = update

            def run(numbers: FieldNumbers, inputs: Inputs) -> Mapping[str, Sequence[int]]:
                return update.evaluate_mod(numbers.p, inputs, numbers.apply)
        else:
            function = self.symbols[call.symbol]
            ports, run = self.program.callees[function], functions[function]  # type: ignore[assignment]
        inputs, outputs = ([port for port in side if port.size] for side in (ports.inputs, ports.outputs))
        if len(call.arguments) != len(inputs) + len(outputs):
            raise CertificateError(f"{self.name}: {call.symbol} is called with {len(call.arguments)} arguments")
        return inputs, outputs, run


class ComposedReader:
    """Reads the text of one composed function; used once. ``symbols``: emitted function → its C name."""

    def __init__(
        self, place: str, program: ComposedProgram, symbol: str, symbols: Mapping[str, str],
        constants: Mapping[str, Fraction], precision: str, trigonometry: str, status: bool,
    ) -> None:  # fmt: skip
        self.place = place
        self.program = program
        self.symbol = symbol
        self.names = {symbols[function]: function for function in program.callees}
        self.constants = constants
        self.precision = precision
        self.trigonometry = trigonometry
        self.status = status

    def refuse(self, what: str) -> CertificateError:
        return CertificateError(f"{self.place}: {what}")

    def before(self, text: str, position: int) -> tuple[dict[str, ReadFunction], int]:
        """The updates, which stand before the function; where they end."""
        found: dict[str, ReadFunction] = {}
        for update in {step.name: step for step in self.program.steps}.values():
            name = symbol_of(self.symbol, update.name)
            match = _STEP.match(text, position)
            if match is None or match[1] != name:
                raise self.refuse(f"{name} expected here, found something else")
            declared = [" ".join(item.split()) for item in match[2].split(",")]
            if declared != update_arguments(update, self.precision):
                raise self.refuse(f"arguments of {name} are ({match[2]})")
            place = f"{self.place}: {name}"
            reader = FunctionReader(place, update, self.constants, self.precision, self.trigonometry, False)
            found[name] = reader.read(match[3])
            position = match.end()
        return found, position

    def read(self, updates: Mapping[str, ReadFunction], body: str, operations: Counts) -> ReadComposed:
        """The function whose body this is (without comments)."""
        lines = [line.strip() for line in body.split("\n") if line.strip()]
        arrays: dict[str, int] = {}
        while lines and (match := _LOCAL.fullmatch(lines[0])):
            if match[1] != self.precision or match[2] in arrays or match[2] in self.ports:
                raise self.refuse(f"{match[2]} is declared as it should not be")
            arrays[match[2]] = int(match[3])
            lines.pop(0)
        answers = self.status and bool(self.program.guards)
        if answers and (lines[:1] != ["int status = 0;"] or lines[-1:] != ["return status;"]):
            raise self.refuse("does not return its status")
        lines = lines[1:-1] if answers else lines
        calls = [self.call(line, updates) for line in lines]
        constants = frozenset(name for update in updates.values() for name in update.constants)
        return ReadComposed(self.program, updates, self.names, arrays, tuple(calls), constants, operations)

    @property
    def ports(self) -> set[str]:
        return {port.name for port in (*self.program.inputs, *self.program.outputs)}

    def call(self, line: str, updates: Mapping[str, ReadFunction]) -> ReadCall:
        match = _CALL.fullmatch(line)
        if match is None or (match[2] not in updates and match[2] not in self.names):
            raise self.refuse(f"not a statement of emitted C: {line[:80]!r}")
        fails = match[2] in self.names and bool(self.program.callees[self.names[match[2]]].guards)
        if bool(match[1]) != (self.status and fails):
            raise self.refuse(f"the status of {match[2]} is not kept")
        return ReadCall(match[2], tuple(item.strip() for item in match[3].split(",")))
