"""The exact program of one function: a flat list of instructions over exact constants.

This is what optimiser passes transform, targets print and certificates check. The operation
set is closed; one table here says what each operation is, every interpreter (evaluate, count, render)
is a table with one entry per operation.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

OPERATIONS: dict[str, int] = {
    "const": 0,  # value: Fraction
    "input": 0,  # value: (input name, flat index)
    "add": 2,
    "sub": 2,
    "mul": 2,
    "div": 2,
    "neg": 1,
    "sqrt": 1,
    "cos": 1,
    "sin": 1,
    "cos_sqrt": 1,  # cos √x
    "sinc_sqrt": 1,  # sin √x / √x
    "sinc3_sqrt": 1,  # (√x − sin √x)/√x³
}
"""Every operation and its number of arguments."""


TURNING = frozenset({"cos", "sin", "cos_sqrt", "sinc_sqrt", "sinc3_sqrt"})
"""What counts as a sine or cosine."""


class Instruction(NamedTuple):
    """One operation. (A named tuple: programs have tens of thousands.)"""

    op: str
    args: tuple[int, ...] = ()
    """Indices of earlier instructions."""
    value: Fraction | tuple[str, int] | None = None
    label: str = ""
    """What a reader would call it (``omega_link3_x``); may be empty, need not be unique, always an identifier."""
    phase: str = ""
    """The heading it stands under (``outward pass: link3``); a heading is printed when it changes. Plain text from
    symgen and sanitised names only."""


@dataclass(frozen=True)
class Port:
    """An input or output array. ``shape`` () is a scalar."""

    name: str
    shape: tuple[int, ...]
    unit: str = ""

    @property
    def size(self) -> int:
        size = 1
        for n in self.shape:
            size *= n
        return size


@dataclass(frozen=True)
class Counts:
    """Operations performed. sincos counts (cos, sin) pairs of one argument."""

    add: int = 0
    mul: int = 0
    div: int = 0
    sqrt: int = 0
    sincos: int = 0

    @property
    def flops(self) -> int:
        return self.add + self.mul + self.div + self.sqrt


@dataclass(frozen=True)
class Program:
    name: str
    """Name of the emitted function (``mass_matrix``, ``frame_pose_tool``)."""
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    instructions: tuple[Instruction, ...]
    """Topologically ordered; no dead code."""
    results: tuple[tuple[int, ...], ...]
    """Per output, row-major: the instruction that holds each entry."""
    guards: tuple[int, ...] = ()
    """Instructions that must be > 0 for the function to have an answer; otherwise every output is NaN."""
    plan: str = ""
    summary: str = ""
    """One line for the comment above the C function (``RᵀMR`` and what it is), from the catalogue."""


def count(program: Program) -> Counts:
    """Operation counts of a program: neg counts as nothing where it folds into an add or sub; here it is
    counted as an add, since a C compiler may need an instruction for it."""
    tally = dict.fromkeys(OPERATIONS, 0)
    pairs: set[tuple[str, int]] = set()
    for op, args, _, _, _ in program.instructions:
        tally[op] += 1
        if op in TURNING:
            pairs.add(("" if op in ("cos", "sin") else op, args[0]))
    return Counts(
        add=tally["add"] + tally["sub"] + tally["neg"],
        mul=tally["mul"],
        div=tally["div"],
        sqrt=tally["sqrt"],
        sincos=len(pairs),
    )
