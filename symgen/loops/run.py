"""Loops that have been read back, run over GF(p).

Running them checks every place of every array: what is read must have been written, and nothing stands outside.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from symgen.algebra.field import inverse
from symgen.errors import CertificateError
from symgen.loops.model import LoopProgram
from symgen.loops.text import ROWS
from symgen.program.instructions import Counts, Port
from symgen.targets.c.function_text import ReadFunction

Transcendental = Callable[[str, int], int]


@dataclass(frozen=True)
class TableLiteral:
    """An entry of a table of constants: the text and the number that it must be the rounded value of."""

    name: str
    text: str
    value: Fraction


@dataclass(frozen=True)
class ReadLoops:
    """An emitted function in loops as a function over GF(p)."""

    program: LoopProgram
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    steps: Mapping[str, ReadFunction]
    """By C name."""
    columns: Mapping[str, int]
    """Steps over columns, and how many columns there are."""
    integers: Mapping[str, Any]
    constants_of: Mapping[str, tuple[Fraction, ...]]
    literals: tuple[TableLiteral, ...]
    source: str
    """The loops as Python."""
    constants: frozenset[str]
    """Named constants that steps read."""
    operations: Counts

    @property
    def name(self) -> str:
        return self.program.name

    def evaluate_mod(
        self, p: int, inputs: Mapping[str, Sequence[int]], transcendental: Transcendental
    ) -> dict[str, list[int]]:
        """Outputs by name, flat, in GF(p). Raises `symgen.algebra.field.NotInField` where it divides by zero, and
        CertificateError where it reads what was not written, leaves an output open or guards other than its pivots."""
        run = _Run(self, p, inputs, transcendental)
        try:
            run.run()
        except (IndexError, KeyError, TypeError, ValueError) as error:
            raise CertificateError(f"{self.name}: its loops read or write where nothing is ({error})") from None
        found = {port.name: run.arrays[port.name] for port in self.outputs}
        if any(x is None for row in found.values() for x in row):
            raise CertificateError(f"{self.name}: an output entry is never assigned")
        run.check_pivots()
        return found


@dataclass
class _Run:
    """One evaluation."""

    text: ReadLoops
    p: int
    inputs: Mapping[str, Sequence[int]]
    transcendental: Transcendental
    arrays: dict[str, Any] = field(default_factory=dict)

    def run(self) -> None:
        text, p = self.text, self.p
        for port in text.inputs:
            self.arrays[port.name] = [x % p for x in self.inputs[port.name]]
        for port in text.outputs:
            self.arrays[port.name] = [None] * port.size
        for name, size in text.program.locals.items():
            self.arrays[name] = [None] * size
        for name, values in text.constants_of.items():
            self.arrays[name] = [x.numerator * inverse(x.denominator, p) % p for x in values]
        functions = {name: self.step(name, step) for name, step in text.steps.items()}
        names: dict[str, Any] = {f"a_{name}": array for name, array in self.arrays.items()}
        names |= {f"t_{name}": table for name, table in text.integers.items()}
        names |= {f"c_{name}": function for name, function in functions.items()}
        names |= {"f_cos": lambda x: self.transcendental("cos", x), "f_sin": lambda x: self.transcendental("sin", x)}
        names |= {"p": p, "range": range, "len": len, "__builtins__": {}}
        exec(compile(text.source, f"<{text.name} as read back>", "exec"), names)

    def step(self, name: str, step: ReadFunction) -> Callable[..., None]:
        compute = step.runner(self.p, self.transcendental)
        sizes = [port.size for port in step.inputs if port.shape]
        outputs = [port.size for port in step.outputs]
        if name in self.text.columns:
            return self.columns(step, compute, self.text.columns[name])

        def call(*places: tuple[list[Any], int]) -> None:
            _check_apart(places, (*sizes, *outputs), len(sizes))
            given = []
            for (array, start), size in zip(places, sizes, strict=False):
                row = array[start : start + size]
                if start < 0 or len(row) != size:
                    raise IndexError(f"{name} reads beyond an array")
                given.append(row)
            found = [[None] * size for size in outputs]
            compute(*given, *found)
            for (array, start), row in zip(places[len(sizes) :], found, strict=True):
                if start < 0 or start + len(row) > len(array):
                    raise IndexError(f"{name} writes beyond an array")
                array[start : start + len(row)] = row

        return call

    def columns(self, step: ReadFunction, compute: Callable[..., Any], n: int) -> Callable[..., None]:
        shared = [port.size for port in step.inputs if port.shape]
        order = [(bool(port.shape), int(port.name[1:]) if not port.shape else 0) for port in step.inputs]
        widths = {port.name: port.size for port in step.outputs}

        def call(*places: Any) -> None:
            *arrays, columns, m, first, past = places
            given = [array[start : start + size] for (array, start), size in zip(arrays, shared, strict=True)]
            wrenches, at = columns
            matrix, start = m
            apart = all(array is not wrenches and array is not matrix for array, _ in arrays) and matrix is not wrenches
            if not (0 <= first <= past <= n and apart and at == 0 and len(wrenches) == ROWS * n):
                raise IndexError("columns that are not there")
            for j in range(first, past):
                found = {name: [None] * width for name, width in widths.items()}
                rest = iter(given)
                compute(*(next(rest) if array else wrenches[n * row + j] for array, row in order), *found.values())
                for k, value in enumerate(found.get("x", ())):
                    wrenches[n * k + j] = value
                for k, value in enumerate(found["m"]):
                    matrix[start + n * k + j] = value

        return call

    def check_pivots(self) -> None:
        """What the guard asks to be positive is what was divided by: their reciprocals are in what was kept."""
        for name, size in self.text.program.pivots.items():
            pivots, kept = self.arrays[name], self.arrays["kept"]
            width = len(kept) // size
            if any(x is None or kept[width * k + 6] * x % self.p != 1 for k, x in enumerate(pivots)):
                raise CertificateError(f"{self.text.name}: the emitted C does not guard the pivots")


def _check_apart(places: Sequence[tuple[list[Any], int]], sizes: Sequence[int], inputs: int) -> None:
    """What a step writes is promised to be apart from everything else that it is given."""
    for k in range(inputs, len(places)):
        written, start = places[k]
        for i, (array, other) in enumerate(places):
            if i != k and array is written and start < other + sizes[i] and other < start + sizes[k]:
                raise IndexError("what is written overlaps with something else")
