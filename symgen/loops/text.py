"""A function in loops as C: its steps, its tables, and the loops that run them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symgen.loops.model import (
    Angles,
    Clear,
    Diagonal,
    LoopProgram,
    Mirror,
    Part,
    Spread,
    Sweep,
    Zeros,
    performed,
)
from symgen.program.instructions import Port, Program
from symgen.targets.c.literals import ConstantTable, Precision, inline_literal, rounded_literal
from symgen.targets.c.statements import Body, Functions, write_body
from symgen.targets.c.templates import render

ROWS = 6
"""A column of wrenches has six rows."""
WIDTH = 92
TILE = 8
"""Matrices are mirrored in tiles of so many rows."""


@dataclass(frozen=True)
class LoopBody(Body):
    """What stands in the source file for one function in loops; ``lines`` is all of it, for its length."""

    steps: tuple[Mapping[str, object], ...] = ()
    tables: tuple[Mapping[str, object], ...] = ()
    loops: tuple[str, ...] = ()
    stack: int = 0
    """Kilobytes of local arrays."""

    def text(self, comment: Sequence[str], prototype: str) -> str:
        """The C text, with this comment above the function."""
        return render(
            "c/loops.c.j2",
            steps=self.steps,
            tables=self.tables,
            comment=comment,
            prototype=prototype,
            lines=self.loops,
        ).rstrip("\n")


def symbol_of(function: str, name: str) -> str:
    """The C name of a part of a function."""
    return f"{function}_{name}"


def write_loops(
    program: LoopProgram, symbol: str, table: ConstantTable, functions: Functions, taken: frozenset[str], status: bool
) -> LoopBody:
    """The text of one function. ``symbol``: its C name; ``functions``: how the file calls sine and cosine."""
    writer = _Writer(program, symbol, table.precision, functions, status)
    bodies = {step.name: write_body(step, table, functions, taken) for step in program.steps}
    steps = [writer.step(sweep, step, bodies[step.name]) for sweep in program.sweeps for step in sweep.steps]
    tables = [row for part in program.parts for row in writer.tables(part)]
    lines = list(writer.body())
    called = {functions.by_operation[op] for op in writer.turned}
    text = [line for step in steps for line in step["lines"]]  # type: ignore[attr-defined]
    text += [line for row in tables for line in row["lines"]]  # type: ignore[attr-defined]
    return LoopBody(
        tuple(("code", line) for line in (*text, *lines)),
        (),
        (),
        frozenset({"sines_cosines"} if called and functions.pair else called),
        frozenset(word for body in bodies.values() for word in body.words),
        performed(program, {name: body.counts for name, body in bodies.items()}),
        tuple(steps),
        tuple(tables),
        tuple(lines),
        -(-sum(program.locals.values()) * (8 if table.precision.name == "double" else 4) // 1024) or 1,
    )


def arguments(sweep: Sweep, step: Program, real: str) -> list[str]:
    """How a step is declared."""
    if sweep.span is None:
        inputs = [f"const {real} *SYMGEN_ALONE {port.name}" for port in step.inputs]
        return [*inputs, *(f"{real} *SYMGEN_ALONE {port.name}" for port in step.outputs)]
    inputs = [f"const {real} *SYMGEN_ALONE {port.name}" for port in step.inputs if port.shape]
    found = [*inputs, f"{real} *SYMGEN_ALONE columns", f"{real} *SYMGEN_ALONE m"]
    return [*found, "int first", "int past"]


class _Writer:
    def __init__(
        self, program: LoopProgram, symbol: str, precision: Precision, functions: Functions, status: bool
    ) -> None:
        self.program = program
        self.symbol = symbol
        self.precision = precision
        self.real = precision.c_type
        self.functions = functions
        self.zero = f"0.0{precision.literal_suffix}"
        self.status = status and bool(program.guards)
        self.turned = ("sin", "cos") if any(isinstance(part, Angles) for part in program.parts) else ()
        self.n = {port.name: port.shape[-1] for port in program.outputs if port.shape}

    def name(self, part: str) -> str:
        return symbol_of(self.symbol, part)

    # --- steps -----------------------------------------------------------------------------------------------------

    def step(self, sweep: Sweep, step: Program, body: Body) -> Mapping[str, object]:
        own = arguments(sweep, step, self.real)
        lines = [text for kind, text in body.lines if kind == "code"]
        if sweep.span is not None:
            lines = list(self.columns(sweep, step, lines))
        declaration = f"{self.name(step.name)}({', '.join(own)})"
        if len(declaration) > WIDTH:
            declaration = f"{self.name(step.name)}(\n    " + ",\n    ".join(own) + ")"
        return {"declaration": declaration, "lines": lines}

    def columns(self, sweep: Sweep, step: Program, body: Sequence[str]) -> Iterator[str]:
        """The body of a step over columns: reads its six scalars, and stores in rows."""
        n = sweep_columns(self.program, sweep)
        yield "for (int j = first; j < past; ++j) {"
        for port in step.inputs:
            if not port.shape:
                yield f"    const {self.real} {port.name} = columns[{row_place(n, int(port.name[1:]))}];"
        for line in body:
            yield f"    {in_rows(line, n)}"
        yield "}"

    # --- tables ----------------------------------------------------------------------------------------------------

    def tables(self, part: Part) -> Iterator[dict[str, object]]:
        if isinstance(part, Sweep):
            if part.constants:
                yield self.numbers(f"{part.name}_k", part.constants, f"Constants of links: {part.heading}.")
            rows = [f"{{{', '.join(map(str, row))}}}," for row in part.table]
            yield {
                "comment": f"Class of link, and where its arrays start: {part.heading}.",
                "type": integer_type(x for row in part.table for x in row),
                "name": self.name(f"{part.name}_at"),
                "size": f"[{len(part.table)}][{part.width}]",
                "lines": _filled(rows),
            }
        elif isinstance(part, Angles) and not _running(part.places):
            yield self.integers("places", part.places, "Coordinates that are angles.")
        elif isinstance(part, Mirror) and part.past:
            yield self.integers("past", part.past, "Per velocity, the first one not beyond it.")
        elif isinstance(part, Diagonal):
            yield self.numbers("armature", part.values, "Armature of every velocity.")

    def integers(self, name: str, values: Sequence[int], comment: str) -> dict[str, object]:
        return {
            "comment": comment,
            "type": integer_type(values),
            "name": self.name(name),
            "size": f"[{len(values)}]",
            "lines": _filled([f"{x}," for x in values]),
        }

    def numbers(self, name: str, values: Sequence[Fraction], comment: str) -> dict[str, object]:
        return {
            "comment": comment,
            "type": self.real,
            "name": self.name(name),
            "size": f"[{len(values)}]",
            "lines": _filled([f"{number(x, self.precision)}," for x in values]),
        }

    # --- loops -----------------------------------------------------------------------------------------------------

    def body(self) -> Iterator[str]:
        for name, size in self.program.locals.items():
            yield f"{self.real} {name}[{size}];"
        read = {array for part in self.program.parts for array in _arrays(part)}
        for port in self.program.inputs:
            if port.name not in read:
                yield f"(void){port.name};"
        for part in self.program.parts:
            yield from WRITERS[type(part)](self, part)
        if self.program.guards:
            yield from self.guard()
        if self.status:
            yield "return 0;"

    def angles(self, part: Angles) -> Iterator[str]:
        count = len(part.places)
        padded = count + -count % 4
        place = _plus(part.places[0], "i") if _running(part.places) else f"{self.name('places')}[i]"
        yield from _loop("i", "0", count, [f"angles[i] = q[{place}];"])
        for k in range(count, padded):
            yield f"angles[{k}] = {self.zero};"
        if self.functions.pair:
            yield f"sines_cosines(angles, sines, cosines, {padded});"
        else:
            calls = [
                f"{table}[i] = {self.functions.by_operation[op]}(angles[i]);"
                for table, op in (("sines", "sin"), ("cosines", "cos"))
            ]
            yield from _loop("i", "0", padded, calls)

    def sweep(self, part: Sweep) -> Iterator[str]:
        inside = [
            f"const {integer_type(x for row in part.table for x in row)} *at = {self.name(f'{part.name}_at')}[i];"
        ]
        if len(part.steps) == 1:
            inside.append(self.call(part, part.steps[0]))
        else:
            inside.append("switch (at[0]) {")
            for number, step in enumerate(part.steps):
                last = number == len(part.steps) - 1
                inside += ["default:" if last else f"case {number}:", f"    {self.call(part, step)}", "    break;"]
            inside.append("}")
        if part.join:
            array, size = part.join.array, part.join.size
            inside += _loop("e", "0", size, [f"{array}[at[{part.join.to}] + e] += sent[e];"])
            inside += _loop("e", "0", size, [f"{array}[at[{part.join.used}] + e] = {self.zero};"])
        yield f"/* {part.heading} */"
        yield from _loop("i", "0", len(part.table), inside)

    def call(self, sweep: Sweep, step: Program) -> str:
        return f"{self.name(step.name)}({', '.join(call_arguments(sweep, step, self.symbol))});"

    def spread(self, part: Spread) -> Iterator[str]:
        line = f"{part.target}[{part.n} * e + j] = {part.source}[{ROWS} * j + e];"
        yield from _loop("j", "0", part.n, _loop("e", "0", ROWS, [line]))

    def zeros(self, part: Zeros) -> Iterator[str]:
        yield from _loop("i", "0", part.size, [f"{part.matrix}[i] = {self.zero};"])

    def mirror(self, part: Mirror) -> Iterator[str]:
        n, matrix = part.n, part.matrix
        line = [f"{matrix}[{n} * j + i] = {matrix}[{n} * i + j];"]
        if part.past:
            yield from _loop("i", "0", n, _loop("j", "i + 1", f"{self.name('past')}[i]", line))
            return
        tiles = n // TILE
        before, ahead = f"{TILE} * e", f"{TILE} * e + {TILE}"
        if tiles > 1:
            inside = _loop("i", "0", before, _loop("j", before, ahead, line))
            inside += _loop("i", before, ahead, _loop("j", "i + 1", ahead, line))
            yield from _loop("e", "0", tiles, inside)
        rest = TILE * tiles if tiles > 1 else 0
        if rest:
            yield from _loop("i", "0", rest, _loop("j", rest, n, line)) if rest < n else ()
        yield from _loop("i", rest, n, _loop("j", "i + 1", n, line)) if rest < n else ()

    def diagonal(self, part: Diagonal) -> Iterator[str]:
        n = len(part.values)
        yield from _loop("i", "0", n, [f"{part.matrix}[{n + 1} * i] += {self.name('armature')}[i];"])

    def clear(self, part: Clear) -> Iterator[str]:
        yield from _loop("e", "0", part.size, [f"{part.array}[e] = {self.zero};"])

    def guard(self) -> Iterator[str]:
        nan = "NAN" if self.precision.name == "float" else "(double)NAN"
        yield "/* no answer unless these are positive */"
        for name, size in self.program.pivots.items():
            inside = [
                line
                for port in self.program.outputs
                for line in _loop("j", "0", port.size, [f"{port.name}[j] = {nan};"])
            ]
            inside.append("return 1;" if self.status else "return;")
            check = [f"if (!({name}[i] > {self.zero})) {{", *(f"    {line}" for line in inside), "}"]
            yield from _loop("i", "0", size, check)


WRITERS: dict[type, Callable[[_Writer, object], Iterator[str]]] = {
    Angles: _Writer.angles,  # type: ignore[dict-item]
    Sweep: _Writer.sweep,  # type: ignore[dict-item]
    Spread: _Writer.spread,  # type: ignore[dict-item]
    Zeros: _Writer.zeros,  # type: ignore[dict-item]
    Mirror: _Writer.mirror,  # type: ignore[dict-item]
    Diagonal: _Writer.diagonal,  # type: ignore[dict-item]
    Clear: _Writer.clear,  # type: ignore[dict-item]
}


def call_arguments(sweep: Sweep, step: Program, symbol: str) -> list[str]:
    """What a step is called with."""
    ports: list[Port] = [port for port in (*step.inputs, *step.outputs) if port.shape]
    names = [port.name for port in ports]
    if sweep.span is not None:
        names = [port.name for port in step.inputs if port.shape] + ["x", "m"]
    found = []
    for name in names:
        array = symbol_of(symbol, f"{sweep.name}_k") if name == "k" else sweep.arrays.get(name, "columns")
        found.append(f"{array} + at[{sweep.offsets[name]}]" if name in sweep.offsets else array)
    if sweep.span is not None:
        found += [f"at[{entry}]" for entry in sweep.span]
    return found


def sweep_columns(program: LoopProgram, sweep: Sweep) -> int:
    """Columns of the matrix that a sweep fills."""
    return program.locals["columns"] // ROWS


def row_place(n: int, row: int) -> str:
    """Where entry j of a row is."""
    return f"{n * row} + j" if row else "j"


def in_rows(line: str, n: int) -> str:
    """A statement that stores x[k] or m[k], storing entry j of row k instead."""
    for name, array in (("x", "columns"), ("m", "m")):
        if line.startswith(f"{name}["):
            index, rest = line[2:].split("]", 1)
            return f"{array}[{row_place(n, int(index))}]{rest}"
    return line


def integer_type(values: Iterable[int]) -> str:
    return "unsigned short" if max(values, default=0) < 65536 else "int"


def number(value: Fraction, precision: Precision) -> str:
    """A literal with its sign."""
    magnitude = abs(value)
    text = inline_literal(magnitude, precision) or rounded_literal(magnitude, precision)
    return f"-{text}" if value < 0 else text


def _running(places: Sequence[int]) -> bool:
    return all(place == places[0] + k for k, place in enumerate(places))


def _plus(start: int, index: str) -> str:
    return f"{start} + {index}" if start else index


def _loop(index: str, first: int | str, past: int | str, inside: Iterable[str]) -> list[str]:
    return [f"for (int {index} = {first}; {index} < {past}; ++{index}) {{", *(f"    {line}" for line in inside), "}"]


def _filled(items: Sequence[str]) -> list[str]:
    lines = [""]
    for item in items:
        if len(lines[-1]) + len(item) > WIDTH:
            lines.append("")
        lines[-1] += f" {item}" if lines[-1] else item
    return lines


def _arrays(part: Part) -> list[str]:
    if isinstance(part, Angles):
        return ["q"]
    return list(part.arrays.values()) if isinstance(part, Sweep) else []
