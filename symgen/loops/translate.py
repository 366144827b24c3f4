"""Emitted loops as Python that means the same, statement by statement; every other form is refused."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symgen.errors import CertificateError
from symgen.loops.model import LoopProgram
from symgen.targets.c.function_text import ReadFunction

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
class Known:
    """What the loops of a function may name."""

    place: str
    """For errors."""
    program: LoopProgram
    steps: Mapping[str, ReadFunction]
    """By C name."""
    columns: Mapping[str, int]
    """Steps over columns."""
    integers: Mapping[str, Any]
    """Tables of integers, of one dimension or two."""
    numbers: frozenset[str]
    """Tables of constants."""
    precision: str
    trigonometry: str


class Translator:
    """Turns loops into Python, line by line."""

    def __init__(self, known: Known) -> None:
        self.known = known
        self.steps = known.steps
        program = known.program
        self.writable = {port.name for port in program.outputs} | set(program.locals)
        self.readable = self.writable | {port.name for port in program.inputs} | known.numbers
        self.depth = 0
        self.stack: list[str] = []
        self.indices: list[str] = []
        self.cases: list[str] = []
        self.row = False

    def failed(self, what: str) -> CertificateError:
        return CertificateError(f"{self.known.place}: {what}")

    def refuse(self, line: str) -> CertificateError:
        return self.failed(f"not a statement of emitted loops: {line[:80]!r}")

    def translated(self, lines: Sequence[str]) -> Iterator[str]:
        for line in lines:
            for text in self.line(line):
                yield " " * self.depth + text
            self.open_or_close(line)
        if self.stack:
            raise self.failed("a loop that does not end")

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
        table: Any = self.known.integers.get(name, ())
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
        f = "f" if self.known.precision == "float" else ""
        turn = _TURN.fullmatch(value)
        if value == f"0.0{f}" and operator == "=":
            return f"{place} = 0"
        if turn and turn[1] in (f"sin{f}", f"cos{f}") and self.known.trigonometry == "libm" and operator == "=":
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
        size = self.known.program.locals.get("angles", 0)
        if line != f"sines_cosines(angles, sines, cosines, {size});" or self.known.trigonometry != "polynomial":
            raise self.refuse(line)
        if size % 4:
            raise self.refuse(line)
        yield f"for i in range({size}):"
        yield "  a_sines[i], a_cosines[i] = f_sin(a_angles[i]), f_cos(a_angles[i])"

    def call(self, line: str, name: str, text: str) -> str:
        step = self.steps.get(name)
        if step is None or not self.row:
            raise self.refuse(line)
        found, spans = [], name in self.known.columns
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
