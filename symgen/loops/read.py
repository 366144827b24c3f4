"""Loops read back: the emitted text of a function in loops, as a function over GF(p).

Steps are read as straight-line functions are (`symgen.targets.c.function_text`), every table entry with the exact
number it stands for, and the loops statement by statement (`symgen.loops.translate`); `symgen.loops.run` runs them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from symgen.errors import CertificateError
from symgen.loops.model import CONSTANTS, Diagonal, LoopProgram, Sweep, performed
from symgen.loops.run import ReadLoops, TableLiteral
from symgen.loops.text import arguments, in_rows, row_place, sweep_columns, symbol_of
from symgen.loops.translate import Known, Translator
from symgen.program.instructions import Program
from symgen.targets.c.function_text import FunctionReader, ReadFunction
from symgen.targets.c.rounding import literal_value

_STEP = re.compile(r"\s*SYMGEN_STEP void (\w+)\(([^()]*)\)\n\{\n(.*?)\n\}\n", re.ASCII | re.DOTALL)
_TABLE = re.compile(
    r"\s*static const (unsigned short|int|double|float) (\w+)((?:\[\d{1,9}\])+) = \{\n(.*?)\n\};\n", re.DOTALL
)
_COLUMNS = re.compile(r"    for \(int j = first; j < past; \+\+j\) \{\n(.*)\n    \}", re.ASCII | re.DOTALL)


class LoopReader:
    """Reads the text of one function in loops; used once."""

    def __init__(
        self, place: str, program: LoopProgram, symbol: str, constants: Mapping[str, Fraction], precision: str,
        trigonometry: str, status: bool,
    ) -> None:  # fmt: skip
        self.place = place
        self.program = program
        self.symbol = symbol
        self.constants = constants
        self.precision = precision
        self.trigonometry = trigonometry
        self.status = status
        self.integers: dict[str, Any] = {}
        self.numbers: dict[str, tuple[Fraction, ...]] = {}
        self.literals: list[TableLiteral] = []
        self.columns: dict[str, int] = {}

    def refuse(self, what: str) -> CertificateError:
        return CertificateError(f"{self.place}: {what}")

    def before(self, text: str, position: int) -> tuple[dict[str, ReadFunction], int]:
        """Steps and tables, which stand before the function; where they end."""
        steps: dict[str, ReadFunction] = {}
        for sweep in self.program.sweeps:
            for step in sweep.steps:
                name = symbol_of(self.symbol, step.name)
                match = _STEP.match(text, position)
                if match is None or match[1] != name:
                    raise self.refuse(f"step {name} expected here, found something else")
                if [" ".join(item.split()) for item in match[2].split(",")] != arguments(sweep, step, self.precision):
                    raise self.refuse(f"arguments of {name} are ({match[2]})")
                steps[name] = self.step(sweep, step, name, match[3])
                position = match.end()
        while match := _TABLE.match(text, position):
            self.table(match[1], match[2], match[3], match[4])
            position = match.end()
        return steps, position

    def step(self, sweep: Sweep, step: Program, name: str, body: str) -> ReadFunction:
        if sweep.span is not None:
            n = self.columns[name] = sweep_columns(self.program, sweep)
            body = self.of_one_column(name, step, body, n)
        return FunctionReader(
            f"{self.place}: {name}", step, self.constants, self.precision, self.trigonometry, False
        ).read(body)

    def of_one_column(self, name: str, step: Program, body: str, n: int) -> str:
        """The statements for column j as statements for one column: rows become entries of x and m."""
        match = _COLUMNS.fullmatch(body.rstrip())
        if match is None:
            raise self.refuse(f"{name} is no loop over columns")
        lines = match[1].split("\n")
        for port in step.inputs:
            if not port.shape:
                wanted = f"const {self.precision} {port.name} = columns[{row_place(n, int(port.name[1:]))}];"
                if not lines or lines.pop(0).strip() != wanted:
                    raise self.refuse(f"{name} does not read {port.name} where it should")
        stores = {
            in_rows(f"{port.name}[{k}] =", n): f"{port.name}[{k}] =" for port in step.outputs for k in range(port.size)
        }
        found = []
        for line in lines:
            target = line.strip().partition(" =")[0] + " ="
            found.append(line.replace(target, stores[target], 1) if target in stores else line)
        return "\n".join(found)

    def table(self, kind: str, name: str, size: str, text: str) -> None:
        shape = [int(x) for x in re.findall(r"\d+", size)]
        short = name.removeprefix(f"{self.symbol}_")
        if name in self.integers or name in self.numbers or short == name:
            raise self.refuse(f"table {name} out of place")
        if kind in ("double", "float"):
            self.number_table(kind, name, short, shape, text)
            return
        body = " ".join(text.split())
        if len(shape) == 2:
            rows = re.findall(r"\{([\d, ]+)\},", body)
            found: Any = tuple(tuple(int(x) for x in row.split(", ")) for row in rows)
            again = " ".join(f"{{{', '.join(map(str, row))}}}," for row in found)
            good = again == body and len(found) == shape[0] and all(len(row) == shape[1] for row in found)
        else:
            found = tuple(int(x) for x in re.findall(r"\d+", body))
            good = " ".join(f"{x}," for x in found) == body and [len(found)] == shape
        limit = 1 << (16 if kind == "unsigned short" else 31)
        if not good or any(x >= limit for row in found for x in (row if len(shape) == 2 else (row,))):
            raise self.refuse(f"table {name} does not have its form")
        self.integers[name] = found

    def number_table(self, kind: str, name: str, short: str, shape: Sequence[int], text: str) -> None:
        exact = self.exact_numbers(short)
        items = text.split()
        if kind != self.precision or exact is None or [len(items)] != list(shape) or len(items) != len(exact):
            raise self.refuse(f"table {name} does not have its form")
        for k, (item, value) in enumerate(zip(items, exact, strict=True)):
            sign, literal = item.startswith("-"), item.removesuffix(",").removeprefix("-")
            literal_value(literal, self.precision)
            if not item.endswith(",") or sign != (value < 0):
                raise self.refuse(f"{name}[{k}] is not {float(value)}")
            self.literals.append(TableLiteral(f"{name}[{k}]", literal, abs(value)))
        self.numbers[name] = exact

    def exact_numbers(self, short: str) -> tuple[Fraction, ...] | None:
        for part in self.program.parts:
            if isinstance(part, Sweep) and short == f"{part.name}_{CONSTANTS}":
                return part.constants
            if isinstance(part, Diagonal) and short == "armature":
                return part.values
        return None

    def read(self, steps: Mapping[str, ReadFunction], body: str) -> ReadLoops:
        """The function whose loops are ``body`` (without comments)."""
        lines = [line.strip() for line in body.split("\n") if line.strip()]
        lines = self.without_locals(self.without_tail(lines))
        known = Known(
            self.place, self.program, steps, self.columns, self.integers, frozenset(self.numbers), self.precision,
            self.trigonometry,
        )  # fmt: skip
        source = "\n".join(Translator(known).translated(lines))
        try:
            compile(source, "<loops>", "exec")
        except SyntaxError:
            raise self.refuse("a loop or a case without a statement") from None
        own = {step.name: steps[symbol_of(self.symbol, step.name)].operations for step in self.program.steps}
        return ReadLoops(
            self.program,
            self.program.inputs,
            self.program.outputs,
            steps,
            self.columns,
            self.integers,
            self.numbers,
            tuple(self.literals),
            source,
            frozenset(name for step in steps.values() for name in step.constants),
            performed(self.program, own),
        )

    def without_locals(self, lines: list[str]) -> list[str]:
        wanted = [f"{self.precision} {name}[{size}];" for name, size in self.program.locals.items()]
        if lines[: len(wanted)] != wanted:
            raise self.refuse("its arrays are not declared as they should be")
        rest = lines[len(wanted) :]
        while rest and re.fullmatch(r"\(void\)\w+;", rest[0]):
            rest.pop(0)
        return rest

    def without_tail(self, lines: list[str]) -> list[str]:
        """The status and the guards, which must have their form."""
        wanted: list[str] = []
        if self.program.guards:
            f = "f" if self.precision == "float" else ""
            nan = "NAN" if self.precision == "float" else "(double)NAN"
            for name, size in self.program.pivots.items():
                wanted += [f"for (int i = 0; i < {size}; ++i) {{", f"if (!({name}[i] > 0.0{f})) {{"]
                for port in self.program.outputs:
                    wanted += [f"for (int j = 0; j < {port.size}; ++j) {{", f"{port.name}[j] = {nan};", "}"]
                wanted += ["return 1;" if self.status else "return;", "}", "}"]
        if self.status:
            wanted.append("return 0;")
        if wanted and lines[-len(wanted) :] != wanted:
            raise self.refuse("the guards do not have their form")
        return lines[: -len(wanted)] if wanted else lines


__all__ = ["LoopReader", "ReadLoops"]
