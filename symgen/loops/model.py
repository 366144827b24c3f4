"""What a function in loops is made of: straight-line steps of one link, tables, and the order in which they run.

A `LoopProgram` stands where a `Program` does: it has the same ports, name and summary, but no instructions of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from symgen.program.composed import ComposedProgram
from symgen.program.instructions import Counts, Program, count

CONSTANTS = "k"
"""Port of a step that holds the constants of its link."""


@dataclass(frozen=True)
class Sweep:
    """One pass over links: for every row of ``table``, the step that its first entry names, on the arrays that start
    at the offsets in the further entries."""

    name: str
    heading: str
    steps: tuple[Program, ...]
    """One straight-line program per class of links; all ports are arrays (but see ``columns``)."""
    arrays: Mapping[str, str]
    """Port → array of the function that it is part of; constants have one of their own."""
    offsets: Mapping[str, int]
    """Port → entry of a row that says where in the array it starts; ports that are not here start at 0."""
    table: tuple[tuple[int, ...], ...]
    constants: tuple[Fraction, ...] = ()
    """Constants of all links, one behind the other."""
    join: Join | None = None
    span: tuple[int, int] | None = None
    """For steps that run over columns j of a matrix: the entries of a row that say from where and up to where. Such
    steps read the scalars w0 … w5, rows of the array of six rows, and write x (six) there and m (rows of a matrix)."""

    @property
    def width(self) -> int:
        return len(self.table[0]) if self.table else 0


@dataclass(frozen=True)
class Join:
    """After every step, for i < size: array[to + i] += sent[i], array[used + i] = 0, ``to`` and ``used`` being entries
    of the row: the parent's place, and the link's own, which is free again. Links without a parent or children have the
    first place, which nobody reads."""

    array: str
    size: int
    to: int
    used: int


@dataclass(frozen=True)
class Angles:
    """Sines and cosines of the coordinates q[place]; filled up to a multiple of four with zeros."""

    places: tuple[int, ...]


@dataclass(frozen=True)
class Spread:
    """rows[k·n + j] = wrenches[6·j + k]: from one wrench after the other to six rows."""

    source: str
    target: str
    n: int


@dataclass(frozen=True)
class Zeros:
    """All entries of a matrix are set to zero: those between branches stay so."""

    matrix: str
    size: int


@dataclass(frozen=True)
class Diagonal:
    """matrix[i, i] += values[i]."""

    matrix: str
    values: tuple[Fraction, ...]


@dataclass(frozen=True)
class Mirror:
    """The lower half of a matrix from its upper one: of every row i up to column past[i]. Where all rows go to the end,
    ``past`` is empty and the matrix is taken in tiles."""

    matrix: str
    n: int
    past: tuple[int, ...] = ()


@dataclass(frozen=True)
class Clear:
    """The first ``size`` entries of an array are set to zero."""

    array: str
    size: int


Part = Angles | Sweep | Spread | Zeros | Diagonal | Mirror | Clear


@dataclass(frozen=True)
class LoopProgram(Program):
    """A function as loops over links. ``instructions`` and ``results`` are empty; ``guards`` is not where there may be
    no answer."""

    parts: tuple[Part, ...] = ()
    locals: Mapping[str, int] = field(default_factory=dict)
    """Local arrays and their sizes."""
    pivots: Mapping[str, int] = field(default_factory=dict)
    """Local arrays whose entries must all be positive, and their sizes."""

    @property
    def sweeps(self) -> Iterator[Sweep]:
        return (part for part in self.parts if isinstance(part, Sweep))

    @property
    def steps(self) -> Iterator[Program]:
        """The straight-line programs of all classes."""
        return (step for sweep in self.sweeps for step in sweep.steps)

    @property
    def performed(self) -> int:
        """Operations that one call performs."""
        return sum(
            _times(sweep, row) * len(sweep.steps[row[0]].instructions) for sweep in self.sweeps for row in sweep.table
        )


def _times(sweep: Sweep, row: tuple[int, ...]) -> int:
    return 1 if sweep.span is None else row[sweep.span[1]] - row[sweep.span[0]]


def straight_programs(program: Program) -> Iterator[Program]:
    """The straight-line programs that a function is made of: itself, or its steps."""
    if isinstance(program, LoopProgram | ComposedProgram):
        yield from program.steps
    else:
        yield program


def loop_counts(program: LoopProgram) -> Counts:
    """Operations of one call, as the steps' programs count them."""
    return performed(program, {step.name: count(step) for step in program.steps})


def performed(program: LoopProgram, counts: Mapping[str, Counts]) -> Counts:
    """Operations of one call, from those of the steps."""
    total = dict.fromkeys(("add", "mul", "div", "sqrt", "sincos"), 0)
    for sweep in program.sweeps:
        for row in sweep.table:
            times = 1 if sweep.span is None else row[sweep.span[1]] - row[sweep.span[0]]
            own = counts[sweep.steps[row[0]].name]
            for name in total:
                total[name] += times * getattr(own, name)
        if sweep.join:
            total["add"] += sweep.join.size * len(sweep.table)
    for part in program.parts:
        if isinstance(part, Angles):
            total["sincos"] += len(part.places)
        elif isinstance(part, Diagonal):
            total["add"] += len(part.values)
    return Counts(**total)
