"""Sums of angles in GF(p): cosine and sine of a sum follow from those of its terms.

In the field the cosine and sine of an angle are a random point of the circle. Where a program takes those of a sum of
angles, the point is the product that the addition theorem makes of the terms' points: then what holds for all angles
holds there too, and nothing else is assumed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from symgen.algebra.field import FieldNumbers, inverse
from symgen.program.instructions import Program


def register_sums(program: Program, numbers: FieldNumbers, inputs: Mapping[str, Sequence[int]]) -> None:
    """Tell ``numbers`` of every sum or difference of angles whose cosine or sine the program takes. Terms are what is
    known as an angle already, or is no sum."""
    arguments = [step.args[0] for step in program.instructions if step.op in ("cos", "sin")]
    if not any(program.instructions[i].op in ("add", "sub") for i in arguments):
        return
    reader = _Reader(program, numbers, inputs)
    for argument in arguments:
        reader.register(argument)


class _Reader:
    def __init__(self, program: Program, numbers: FieldNumbers, inputs: Mapping[str, Sequence[int]]) -> None:
        self.program, self.numbers, self.inputs = program, numbers, inputs
        self.values: dict[int, int | None] = {}

    def register(self, index: int) -> None:
        """The sum at an instruction, its terms first."""
        step, value = self.program.instructions[index], self.value(index)
        if step.op not in ("add", "sub") or value is None or self.numbers.angle_known(value):
            return
        for argument in step.args:
            self.register(argument)
        x, y = (self.value(argument) for argument in step.args)
        assert x is not None and y is not None
        self.numbers.add_angles(x, y if step.op == "add" else -y % self.numbers.p)

    def value(self, index: int) -> int | None:
        """The residue of an instruction that is arithmetic on inputs and constants; None for any other."""
        if index not in self.values:
            self.values[index] = self._value(index)
        return self.values[index]

    def _value(self, index: int) -> int | None:
        op, args, constant, _, _ = self.program.instructions[index]
        p = self.numbers.p
        if op == "const":
            assert isinstance(constant, Fraction)
            return constant.numerator * inverse(constant.denominator, p) % p
        if op == "input":
            assert isinstance(constant, tuple)
            return self.inputs[constant[0]][constant[1]] % p
        operands = [self.value(i) for i in args]
        if op not in ("add", "sub", "neg", "mul") or any(x is None for x in operands):
            return None
        x, y = operands[0] or 0, operands[-1] or 0
        return {"add": x + y, "sub": x - y, "neg": -x, "mul": x * y}[op] % p
