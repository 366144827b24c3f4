"""A program as C statements: what is used once stands inline, what is used more often gets a name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby

from symgen.program.instructions import TURNING, Counts, Port, Program
from symgen.targets.c.comments import comment_text
from symgen.targets.c.expressions import ATOM, Expression, call, count_operations, product, quotient, total
from symgen.targets.c.literals import ConstantTable
from symgen.targets.c.names import Names

WIDTH = 100
"""Columns a statement may take."""
INLINE_WIDTH = 64
"""Columns an expression may take that stands inside another one."""
FEW = 12
"""Constant entries that stand on a line each; more share lines."""
DEPTH = 4
"""Parentheses within parentheses."""

_WORD = re.compile(r"[A-Za-z_]\w*")

ENTIRE = ("cos_sqrt", "sinc_sqrt", "sinc3_sqrt")


@dataclass(frozen=True)
class Functions:
    """How a file calls its functions."""

    by_operation: dict[str, str]
    """Operation → C function."""
    pair: str = ""
    """The function that gives sine and cosine together, if there is one."""


LANES = 4
"""Angles come to a multiple of this."""
GROUPED = 2
"""From so many angles on their sines and cosines are taken together."""
CLEARED = 8
"""So many zeros in a row are set by a loop."""


@dataclass(frozen=True)
class Body:
    """The inside of a C function."""

    lines: tuple[tuple[str, str], ...]
    """("heading" | "code", text)."""
    guards: tuple[str, ...]
    """Expressions that must be positive."""
    unused: tuple[str, ...]
    """Inputs nothing reads."""
    called: frozenset[str]
    words: frozenset[str]
    """Every identifier in the statements."""
    counts: Counts


def write_body(
    program: Program, table: ConstantTable, functions: Functions, taken: frozenset[str], grouped: bool = False
) -> Body:
    """The statements of ``program``. ``taken``: names of the file that a local one must not hide; ``grouped``: sines
    and cosines that depend on no others are taken together."""
    writer = _Writer(program, table, functions, taken)
    if grouped and functions.pair:
        writer.group_angles()
    for index in range(len(program.instructions)):
        writer.step(index)
    writer.finish(program)
    text = "\n".join(text for kind, text in writer.lines if kind == "code")
    guards = tuple(writer.at(i).signed() for i in program.guards)
    read = {i.value[0] for i in program.instructions if i.op == "input" and isinstance(i.value, tuple)}
    return Body(
        lines=tuple(writer.lines),
        guards=tuple(dict.fromkeys(guards)),
        unused=tuple(port.name for port in program.inputs if port.size and port.name not in read),
        called=frozenset(writer.called),
        words=frozenset(_WORD.findall(text)),
        counts=count_operations(text, (constant.name for constant in table)),
    )


class _Writer:
    """Writes one program, instruction by instruction; used once."""

    def __init__(self, program: Program, table: ConstantTable, functions: Functions, taken: frozenset[str]) -> None:
        self.instructions = program.instructions
        self.roots = _roots(program)
        self.table = table
        self.functions = functions
        self.names = Names(taken | {port.name for port in program.inputs + program.outputs})
        self.scalars = {port.name for port in program.inputs if port.shape == ()}
        self.constants = {i for i, instruction in enumerate(program.instructions) if instruction.op == "const"}
        self.forced = {self.roots[i][0] for i in program.guards}
        self.stores = _stores(program)
        self.pairs = _pairs(program, functions)
        self.uses = self.count_uses()
        self.expressions: dict[int, Expression] = {}
        self.lines: list[tuple[str, str]] = []
        self.called: set[str] = set()
        self.stepped: set[int] = set()
        self.heading = ""
        self.temporaries = 0
        self.angles: dict[int, int] = {}
        self.width = WIDTH - len(f"    const {table.precision.c_type}  = -;")

    def at(self, index: int) -> Expression:
        origin, negative = self.roots[index]
        found = self.expressions[origin]
        return found.negated() if negative else found

    def count_uses(self) -> list[int]:
        """How often each instruction is written, were it inline."""
        uses = [0] * len(self.instructions)
        for index, (op, args, _, _, _) in enumerate(self.instructions):
            if op == "neg":
                continue
            if op in ("cos", "sin") and self.pairs.get(args[0], (-1, -1))[1] == index:
                continue  # one call takes both: the argument is written once
            for argument in args:
                uses[self.roots[argument][0]] += 1
        for index, entries in self.stores.items():
            uses[self.roots[index][0]] += len(entries)
        return uses

    def group_angles(self) -> None:
        """One call for the sines and cosines of all angles that are plain functions of the inputs."""
        wanted: dict[int, dict[str, int]] = {}
        plain: list[bool] = []
        for index, instruction in enumerate(self.instructions):
            if instruction.op not in TURNING:
                plain.append(False not in [plain[k] for k in instruction.args])
                continue
            plain.append(False)
            if instruction.op in ("cos", "sin") and plain[instruction.args[0]]:
                wanted.setdefault(instruction.args[0], {})[instruction.op] = index
        if len(wanted) < GROUPED:
            return
        for index in self.cone(wanted):
            self.step(index)
        zero = f"0.0{self.table.precision.literal_suffix}"
        angles = [self.at(argument).signed() for argument in wanted]
        angles += [zero] * (-len(angles) % LANES)
        real, size = self.table.precision.c_type, len(angles)
        self.called.add("sines_cosines")
        table = _fill([f"const {real} angles[{size}] = {{{angles[0]},", *(f"{angle}," for angle in angles[1:])])
        self.code("\n        ".join(table).removesuffix(",") + "};", "")
        self.code(f"{real} sines[{size}], cosines[{size}];", "")
        self.code(f"sines_cosines(angles, sines, cosines, {size});", "")
        for k, (argument, both) in enumerate(wanted.items()):
            for op, index in sorted(both.items(), reverse=True):
                name = self.trigonometric_name(index, self.at(argument))
                self.code(f"const {real} {name} = {'sines' if op == 'sin' else 'cosines'}[{k}];", "")
                self.expressions[index] = Expression(name)

    def cone(self, roots: Iterable[int]) -> list[int]:
        """Instructions that these depend on, themselves included, in order."""
        found: set[int] = set()
        stack = list(roots)
        while stack:
            index = stack.pop()
            if index not in found:
                found.add(index)
                stack.extend(self.instructions[index].args)
        return sorted(found)

    def step(self, index: int) -> None:
        if index in self.stepped:
            return
        self.stepped.add(index)
        op, _, _, label, phase = self.instructions[index]
        if op in ("cos", "sin"):
            self.write_trigonometry(index)
        elif op != "neg":
            self.expressions[index] = self.compose(index)
            named = self.uses[index] > 1 or index in self.forced or op in ENTIRE
            if named and op not in ("const", "input"):
                self.assign(index, phase)
        stores = self.stores.get(index)
        if not stores or self.roots[index][0] in self.constants:
            return  # constants: see finish
        text = self.at(index).signed()
        if op == "neg" and len(stores) > 1:  # one negation, stored more than once
            name = self.names.take(label) if label else self.temporary()
            self.code(f"const {self.table.precision.c_type} {name} = {text};", phase)
            text = name
        for port, entry in stores:
            self.code(f"{port.name}[{entry}] = {text};", phase)

    def zero_runs(self, row: Sequence[int]) -> list[tuple[int, int]]:
        """[start, end) of the long runs of zeros in an output: loops, because thousands of stores of nothing are slow
        to compile."""
        zeros = [self.instructions[self.roots[index][0]].value == 0 for index in row]
        runs = [(key, len(list(group))) for key, group in groupby(zeros)]
        found, start = [], 0
        for zero, length in runs:
            if zero and length >= CLEARED:
                found.append((start, start + length))
            start += length
        return found

    def finish(self, program: Program) -> None:
        """The entries that are constants, in their order, after all others."""
        texts, loops = list[str](), list[str]()
        for port, row in zip(program.outputs, program.results, strict=True):
            runs = self.zero_runs(row)
            loops += [f"for (int i = {start}; i < {end}; ++i) {port.name}[i] = 0;" for start, end in runs]
            cleared = {entry for start, end in runs for entry in range(start, end)}
            texts += [
                f"{port.name}[{entry}] = {self.at(index).signed()};"
                for entry, index in enumerate(row)
                if self.roots[index][0] in self.constants and entry not in cleared
            ]
        heading = "constant entries" if self.lines else ""
        packed = _fill(texts) if len(texts) > FEW else texts
        for text in (*loops, *packed):
            self.code(text, heading)

    def compose(self, index: int) -> Expression:
        """The expression of an instruction; operands get statements of their own until it fits."""
        op, args, value, _, phase = self.instructions[index]
        if op == "const":
            assert isinstance(value, Fraction)
            return Expression(self.table.text(abs(value)), negative=value < 0, constant=True)
        if op == "input":
            assert isinstance(value, tuple)
            name, entry = value
            return Expression(name if name in self.scalars else f"{name}[{entry}]")
        room = self.room(index)
        while True:
            result = self.combine(op, [self.at(i) for i in args])
            if len(result.text) < room and result.depth <= DEPTH:
                return result
            pending = [i for i in args if self.at(i).level < ATOM or self.at(i).depth]
            if not pending:
                return result
            longest = max(pending, key=lambda i: len(self.at(i).text))
            self.assign(self.roots[longest][0], phase)

    def room(self, index: int) -> int:
        """Columns the expression of an instruction may take."""
        if self.uses[index] != 1:
            return self.width - len(self.instructions[index].label or "t1234")
        stores = self.stores.get(index)
        if not stores and index not in self.forced:
            return INLINE_WIDTH
        if stores:
            return WIDTH - len(f"    {stores[0][0].name}[{stores[0][1]}] = -;")
        return self.width - len(self.instructions[index].label or "t1234")

    def combine(self, op: str, operands: list[Expression]) -> Expression:
        if op == "mul":
            return product(operands[0], operands[1])
        if op == "add":
            return total(operands[0], operands[1])
        if op == "sub":
            return total(operands[0], operands[1].negated())
        if op == "div":
            return quotient(operands[0], operands[1])
        return self.call(op, operands[0])

    def call(self, op: str, argument: Expression) -> Expression:
        function = self.functions.by_operation[op]
        self.called.add(function)
        return call(function, argument)

    def assign(self, index: int, phase: str) -> None:
        """Give an instruction a statement. A label names the signed value; without one the sign stays outside."""
        instruction, expression = self.instructions[index], self.expressions[index]
        if instruction.label:
            name, text, negative = self.names.take(instruction.label), expression.signed(), False
        else:
            name, text, negative = self.temporary(), expression.text, expression.negative
        self.code(f"const {self.table.precision.c_type} {name} = {text};", phase)
        self.expressions[index] = Expression(name, negative=negative)

    def write_trigonometry(self, index: int) -> None:
        """One call for the sine and the cosine of an argument, or one for the only one that is needed."""
        if index in self.expressions:
            return
        instruction = self.instructions[index]
        argument = self.at(instruction.args[0])
        both = self.pairs.get(instruction.args[0], ())
        c_type = self.table.precision.c_type
        if index not in both:
            name = self.trigonometric_name(index, argument)
            self.code(f"const {c_type} {name} = {self.call(instruction.op, argument).text};", instruction.phase)
            self.expressions[index] = Expression(name)
            return
        sine, cosine = sorted(both, key=lambda i: self.instructions[i].op == "cos")
        names = {i: self.trigonometric_name(i, argument) for i in (sine, cosine)}
        self.called.add(self.functions.pair)
        self.code(f"{c_type} {names[sine]}, {names[cosine]};", instruction.phase)
        call_text = f"{self.functions.pair}({argument.signed()}, &{names[sine]}, &{names[cosine]});"
        self.code(call_text, instruction.phase)
        self.expressions.update((i, Expression(name)) for i, name in names.items())

    def trigonometric_name(self, index: int, argument: Expression) -> str:
        instruction = self.instructions[index]
        if instruction.label:
            return self.names.take(instruction.label)
        plain = argument.text.replace("[", "").replace("]", "")
        known = plain.isidentifier() and not argument.negative
        if not known:
            plain = str(self.angles.setdefault(instruction.args[0], len(self.angles) + 1))
        return self.names.take(f"{instruction.op}_{plain}")

    def temporary(self) -> str:
        self.temporaries += 1
        return self.names.take_numbered("t", self.temporaries)

    def code(self, text: str, phase: str) -> None:
        if phase and phase != self.heading:
            self.lines.append(("heading", comment_text(phase)))
            self.heading = phase
        self.lines.append(("code", text))


def _roots(program: Program) -> list[tuple[int, bool]]:
    """Per instruction: the one behind its chain of negations, and whether its sign is changed."""
    roots: list[tuple[int, bool]] = []
    for index, instruction in enumerate(program.instructions):
        if instruction.op == "neg":
            origin, negative = roots[instruction.args[0]]
            roots.append((origin, not negative))
        else:
            roots.append((index, False))
    return roots


def _stores(program: Program) -> dict[int, list[tuple[Port, int]]]:
    """Instruction → the output entries it is stored in."""
    stores: dict[int, list[tuple[Port, int]]] = {}
    for port, row in zip(program.outputs, program.results, strict=True):
        for entry, index in enumerate(row):
            stores.setdefault(index, []).append((port, entry))
    return stores


def _pairs(program: Program, functions: Functions) -> dict[int, tuple[int, int]]:
    """Argument → the two instructions that take its cosine and its sine, where both are there."""
    if not functions.pair:
        return {}
    found: dict[int, dict[str, int]] = {}
    for index, instruction in enumerate(program.instructions):
        if instruction.op in ("cos", "sin"):
            found.setdefault(instruction.args[0], {}).setdefault(instruction.op, index)
    return {argument: (min(both.values()), max(both.values())) for argument, both in found.items() if len(both) == 2}


def _fill(texts: list[str]) -> list[str]:
    """Statements side by side, lines filled but never broken inside a statement."""
    lines = [""]
    for text in texts:
        if len(lines[-1]) + len(text) > WIDTH - 5:
            lines.append("")
        lines[-1] = f"{lines[-1]} {text}".strip()
    return lines
