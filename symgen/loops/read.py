"""Loops read back: the emitted text of a function in loops, as a function over GF(p).

Steps are read as straight-line functions are (`symgen.targets.c.function_text`), every table entry with the exact
number it stands for, and the loops statement by statement: each of the few forms there are is turned into the Python
that means the same, everything else is refused. Running it checks every place of every array: what is read must have
been written, and nothing stands outside.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from symgen.algebra.field import inverse
from symgen.errors import CertificateError
from symgen.loops.model import CONSTANTS, Diagonal, LoopProgram, Sweep, performed
from symgen.loops.text import ROWS, arguments, in_rows, row_place, sweep_columns, symbol_of
from symgen.program.instructions import Counts, Port, Program
from symgen.targets.c.function_text import FunctionReader, ReadFunction
from symgen.targets.c.rounding import literal_value

Transcendental = Callable[[str, int], int]

_STEP = re.compile(r"\s*SYMGEN_STEP void (\w+)\(([^()]*)\)\n\{\n(.*?)\n\}\n", re.ASCII | re.DOTALL)
_TABLE = re.compile(
    r"\s*static const (unsigned short|int|double|float) (\w+)((?:\[\d{1,9}\])+) = \{\n(.*?)\n\};\n", re.DOTALL
)
_COLUMNS = re.compile(r"    for \(int j = first; j < past; \+\+j\) \{\n(.*)\n    \}", re.ASCII | re.DOTALL)

INDEX = r"[\w\[\] +*()]+?"
_LOOP = re.compile(rf"for \(int ([ije]) = ({INDEX}); \1 < ({INDEX}); \+\+\1\) \{{", re.ASCII)
_ROW = re.compile(r"const (?:unsigned short|int) \*at = (\w+)\[i\];", re.ASCII)
_SWITCH = re.compile(r"switch \(at\[0\]\) \{")
_CASE = re.compile(r"case (\d{1,4}):", re.ASCII)
_CALL = re.compile(r"(\w+)\(([^();]*)\);", re.ASCII)
_ARGUMENT = re.compile(r"(\w+)(?: \+ at\[(\d{1,3})\])?|at\[(\d{1,3})\]", re.ASCII)
_SET = re.compile(rf"(\w+)\[({INDEX})\] (\+?=) ([^=;]+);", re.ASCII)
_TERM = re.compile(rf"(\w+)\[({INDEX})\]", re.ASCII)
_TURN = re.compile(r"(\w+)\(angles\[i\]\)", re.ASCII)
_INDEX_WORD = re.compile(r"[A-Za-z_]\w*", re.ASCII)


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
        source = "\n".join(_Loops(self, steps).translated(lines))
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


class _Loops:
    """Turns loops into Python, line by line."""

    def __init__(self, reader: LoopReader, steps: Mapping[str, ReadFunction]) -> None:
        self.reader = reader
        self.steps = steps
        program = reader.program
        self.writable = {port.name for port in program.outputs} | set(program.locals)
        self.readable = self.writable | {port.name for port in program.inputs} | set(reader.numbers)
        self.depth = 0
        self.stack: list[str] = []
        self.indices: list[str] = []
        self.cases: list[str] = []
        self.row = False

    def refuse(self, line: str) -> CertificateError:
        return self.reader.refuse(f"not a statement of emitted loops: {line[:80]!r}")

    def translated(self, lines: Sequence[str]) -> Iterator[str]:
        for line in lines:
            for text in self.line(line):
                yield " " * self.depth + text
            self.open_or_close(line)
        if self.stack:
            raise self.reader.refuse("a loop that does not end")

    def open_or_close(self, line: str) -> None:
        """What a line opens or closes takes effect behind it."""
        if line.startswith("for ("):
            self.stack.append("for")
            self.indices.append(line[len("for (int ")])
            self.depth += 1
        elif _SWITCH.fullmatch(line):
            self.stack.append("switch")
            self.cases = []
        elif _CASE.fullmatch(line) or line == "default:":
            self.stack.append("case")
            self.depth += 1
        elif line == "break;":
            self.stack.pop()
            self.depth -= 1
        elif line == "}":
            kind = self.stack.pop()
            if kind == "for":
                self.indices.pop()
                self.depth -= 1
                self.row = self.row and bool(self.indices)

    def line(self, line: str) -> Iterator[str]:
        inside = self.stack[-1] if self.stack else ""
        if match := _LOOP.fullmatch(line):
            if match[1] in self.indices or inside == "switch":
                raise self.refuse(line)
            yield f"for {match[1]} in range({self.index(match[2])}, {self.index(match[3])}):"
        elif (match := _ROW.fullmatch(line)) and self.indices == ["i"] and self.is_table(match[1], 2):
            self.row = True
            yield f"at = t_{match[1]}[i]"
        elif _SWITCH.fullmatch(line) and self.row and inside == "for":
            return
        elif (match := _CASE.fullmatch(line)) and inside == "switch" and "else" not in self.cases:
            yield f"{'elif' if self.cases else 'if'} at[0] == {int(match[1])}:"
            self.cases.append(match[1])
        elif line == "default:" and inside == "switch" and self.cases and "else" not in self.cases:
            yield "else:"
            self.cases.append("else")
        elif (line == "break;" and inside == "case") or (line == "}" and inside in ("for", "switch")):
            return
        elif line.startswith("sines_cosines(") and not self.stack:
            yield from self.all_angles(line)
        elif match := _CALL.fullmatch(line):
            yield self.call(line, match[1], match[2])
        elif match := _SET.fullmatch(line):
            yield self.assignment(line, match)
        else:
            raise self.refuse(line)

    def is_table(self, name: str, dimensions: int) -> bool:
        table: Any = self.reader.integers.get(name, ())
        return len(table) > 0 and isinstance(table[0], tuple) == (dimensions == 2)

    def index(self, text: str) -> str:
        """An index: sums and products of numbers, loop variables, entries of the row and of tables."""

        def word(match: re.Match[str]) -> str:
            name = match[0]
            if name in self.indices or (name == "at" and self.row):
                return name
            if self.is_table(name, 1):
                return f"t_{name}"
            raise self.refuse(text)

        return _INDEX_WORD.sub(word, text)

    def element(self, text: str) -> str:
        match = _TERM.fullmatch(text)
        if match is None or match[1] not in self.readable:
            raise self.refuse(text)
        return f"a_{match[1]}[{self.index(match[2])}]"

    def assignment(self, line: str, match: re.Match[str]) -> str:
        target, operator, value = match[1], match[3], match[4]
        if target not in self.writable:
            raise self.refuse(line)
        place = f"a_{target}[{self.index(match[2])}]"
        f = "f" if self.reader.precision == "float" else ""
        turn = _TURN.fullmatch(value)
        if value == f"0.0{f}" and operator == "=":
            return f"{place} = 0"
        if turn and turn[1] in (f"sin{f}", f"cos{f}") and self.reader.trigonometry == "libm" and operator == "=":
            return f"{place} = f_{turn[1][:3]}(a_angles[i])"
        terms = self.terms(value)
        if operator == "+=":
            terms = [place, *terms]
        return f"{place} = ({' + '.join(terms)}) % p"

    def terms(self, value: str) -> list[str]:
        """The elements of a sum; an index may be a sum itself."""
        parts = re.findall(r"\w+\[(?:[^\[\]]|\[[^\[\]]*\])*\]", value)
        if " + ".join(parts) != value:
            raise self.refuse(value)
        return [self.element(part) for part in parts]

    def all_angles(self, line: str) -> Iterator[str]:
        size = self.reader.program.locals.get("angles", 0)
        if line != f"sines_cosines(angles, sines, cosines, {size});" or self.reader.trigonometry != "polynomial":
            raise self.refuse(line)
        if size % 4:
            raise self.refuse(line)
        yield f"for i in range({size}):"
        yield "  a_sines[i], a_cosines[i] = f_sin(a_angles[i]), f_cos(a_angles[i])"

    def call(self, line: str, name: str, text: str) -> str:
        step = self.steps.get(name)
        if step is None or not self.row:
            raise self.refuse(line)
        found, spans = [], name in self.reader.columns
        outputs = len(step.outputs) if not spans else 2
        items = [item.strip() for item in text.split(",")]
        arrays = items[:-2] if spans else items
        ports = [port for port in step.inputs if port.shape]
        if len(arrays) != len(ports) + outputs:
            raise self.refuse(line)
        for place, item in enumerate(arrays):
            match = _ARGUMENT.fullmatch(item)
            allowed = self.readable if place < len(ports) else self.writable
            if match is None or match[1] not in allowed:
                raise self.refuse(line)
            found.append(f"(a_{match[1]}, {f'at[{match[2]}]' if match[2] else '0'})")
        for item in items[len(arrays) :]:
            match = _ARGUMENT.fullmatch(item)
            if match is None or match[3] is None:
                raise self.refuse(line)
            found.append(item)
        return f"c_{name}({', '.join(found)})"
