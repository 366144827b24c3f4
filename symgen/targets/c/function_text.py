"""One emitted C function, read statement by statement and turned into Python that means the same."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Any

from symgen.algebra.field import inverse
from symgen.algebra.numbers import Numbers
from symgen.errors import CertificateError
from symgen.program.instructions import Counts, Port, Program
from symgen.targets.c.compiled import compiled, zeros
from symgen.targets.c.expressions import count_operations
from symgen.targets.c.rounding import literal_value

Transcendental = Callable[[str, int], int]

_DEFINITION = re.compile(r"const (double|float) ([A-Za-z_]\w*) = ([^=]+)", re.ASCII)
_STORE = re.compile(r"([A-Za-z_]\w*)\[(\d+)\] = ([^=]+)", re.ASCII)
_DECLARE_PAIR = re.compile(r"(double|float) ([A-Za-z_]\w*), ([A-Za-z_]\w*)", re.ASCII)
_CALL_PAIR = re.compile(r"sine_cosine\(([^=,]+), &([A-Za-z_]\w*), &([A-Za-z_]\w*)\)", re.ASCII)
_ANGLES = re.compile(r"const (double|float) angles\[(\d+)\] = \{([^{}=]+)\}", re.ASCII)
_TABLES = re.compile(r"(double|float) sines\[(\d+)\], cosines\[(\d+)\]", re.ASCII)
_CALL_ALL = re.compile(r"sines_cosines\(angles, sines, cosines, (\d+)\)", re.ASCII)
_VOID = re.compile(r"\(void\)([A-Za-z_]\w*)", re.ASCII)
_CLEAR_LOOP = re.compile(r"[ \n]for \(int i = (\d{1,6}); i < (\d{1,6}); \+\+i\) ([A-Za-z_]\w*)\[i\] = 0;", re.ASCII)
_GUARD = re.compile(
    r"    if \(!\(([^{}=]+)\)\) \{\n((?:        for \(int i = 0; i < \d+; \+\+i\) \{\n            \w+\[i\] = [()\w]+;\n"
    r"        \}\n)+)((?:        return 1;\n)?)    \}\n?",
    re.ASCII,
)
_NAN_LOOP = re.compile(
    r"for \(int i = 0; i < (\d+); \+\+i\) \{\n            (\w+)\[i\] = ([()\w]+);\n        \}", re.ASCII
)

_FOREIGN = re.compile(r"[^A-Za-z0-9_.\[\]()+\-*/ \n]")
_MISREAD = re.compile(r"\*\s*\*|/\s*/|--|\+\+|[(]\s*\*|[)\]]\s*[(]|\(\s*\)|/\s*\*|^\s*\*")
"""What C and Python do not read alike, or what no arithmetic needs."""
_ATOM = re.compile(
    r"(?P<name>[A-Za-z_]\w*)(?:\[(?P<index>[^\]]*)\]|(?P<call>\s*\())?|(?P<number>\.?\d(?:[eEpP][+-]|[\w.])*)|[\[\].]",
    re.ASCII,
)

_OPERATIONS = ("sqrt", "cos", "sin", "cos_sqrt", "sinc_sqrt", "sinc3_sqrt")


@dataclass(frozen=True)
class ReadFunction:
    """An emitted function as a function over any numbers."""

    name: str
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    literals: tuple[Fraction, ...]
    """Exact values of what the code calls l0, l1, … (inline literals and named constants)."""
    constants: frozenset[str]
    """Named constants it reads."""
    statements: tuple[tuple[str, str], ...]
    """(target, expression) as Python."""
    guards: tuple[str, ...]
    operations: Counts
    """Counted in the C text."""
    _compiled: dict[str, Callable[..., Any]] = field(default_factory=dict, compare=False, repr=False)

    def evaluate(self, numbers: Numbers, inputs: Mapping[str, Sequence[Any]]) -> dict[str, list[Any]]:
        """Outputs by name, flat, in any number type. ``inputs``: name → flat values; literals enter exactly."""
        functions = [getattr(numbers, operation) for operation in _OPERATIONS]
        literals = [numbers.const(value) for value in self.literals]
        outputs, _ = self._run("exact", [*functions, None, None], literals, inputs)
        return outputs

    def evaluate_mod(
        self, p: int, inputs: Mapping[str, Sequence[int]], transcendental: Transcendental
    ) -> dict[str, list[int]]:
        """Outputs by name, flat, in GF(p). ``transcendental("cos", x)`` gives cos, sin, sqrt, cos_sqrt, … as
        functions on GF(p). Raises `symgen.algebra.field.NotInField` where it divides by zero."""
        outputs, _ = self.outputs_and_guards_mod(p, inputs, transcendental)
        return outputs

    def guards_mod(self, p: int, inputs: Mapping[str, Sequence[int]], transcendental: Transcendental) -> list[int]:
        """What the function requires to be positive, in GF(p)."""
        _, guards = self.outputs_and_guards_mod(p, inputs, transcendental)
        return guards

    def runner(self, p: int, transcendental: Transcendental) -> Callable[..., list[int]]:
        """The function in GF(p) on lists: its inputs, then its outputs, which it fills; what guards ask is returned."""
        if "mod" not in self._compiled:
            self._compiled["mod"] = self._compile("mod")
        return partial(self._compiled["mod"], *self._context_mod(p, transcendental))

    def _context_mod(self, p: int, transcendental: Transcendental) -> tuple[Any, ...]:
        def function(operation: str) -> Callable[[int], int]:
            return lambda x: transcendental(operation, x % p)

        literals = [value.numerator * inverse(value.denominator, p) % p for value in self.literals]
        return (*(function(operation) for operation in _OPERATIONS), lambda x: inverse(x, p), p, literals)

    def outputs_and_guards_mod(
        self, p: int, inputs: Mapping[str, Sequence[int]], transcendental: Transcendental
    ) -> tuple[dict[str, list[int]], list[int]]:
        """`evaluate_mod` and `guards_mod` at once."""
        *context, literals = self._context_mod(p, transcendental)
        return self._run("mod", context, literals, inputs)

    def _run(
        self, mode: str, context: Sequence[Any], literals: Sequence[Any], inputs: Mapping[str, Sequence[Any]]
    ) -> tuple[dict[str, list[Any]], list[Any]]:
        if mode not in self._compiled:
            self._compiled[mode] = self._compile(mode)
        values = [inputs[port.name] for port in self.inputs]
        for port, row in zip(self.inputs, values, strict=True):
            if len(row) != port.size:
                raise ValueError(f"{self.name}: {port.name} has {port.size} values, not {len(row)}")
        arguments = [row[0] if port.shape == () else row for port, row in zip(self.inputs, values, strict=True)]
        outputs: list[list[Any]] = [[None] * port.size for port in self.outputs]
        guards = self._compiled[mode](*context, literals, *arguments, *outputs)
        return {port.name: row for port, row in zip(self.outputs, outputs, strict=True)}, guards

    def _compile(self, mode: str) -> Callable[..., Any]:
        ports = [f"v_{port.name}" for port in self.inputs + self.outputs]
        arguments = [*(f"f_{operation}" for operation in _OPERATIONS), "inverse", "p", "literals", *ports]
        return compiled(self.name, arguments, self.statements, self.guards, mode == "mod", len(self.literals))


class FunctionReader:
    """Reads one body; used once."""

    def __init__(
        self,
        place: str,
        program: Program,
        constants: Mapping[str, Fraction],
        precision: str,
        trigonometry: str,
        status: bool,
    ) -> None:
        self.place = place
        self.program = program
        self.constants = constants
        self.precision = precision
        self.status = status
        self.arrays = {port.name: port.size for port in program.inputs if port.shape != ()}
        self.known = {port.name for port in program.inputs if port.shape == ()}
        self.sizes = {port.name: port.size for port in program.outputs}
        self.written: set[tuple[str, int]] = set()
        self.declared: list[str] = []
        self.group: list[str] = []
        self.angles: list[str] = []
        self.padded = 0
        self.turned: set[int] = set()
        self.literals: dict[Fraction, str] = {}
        self.used: set[str] = set()
        self.statements: list[tuple[str, str]] = []
        self.atoms: dict[str, str] = {}
        """What names, entries and literals that were read before are in Python."""
        self.pair = trigonometry == "polynomial"
        f = "f" if precision == "float" else ""
        trigonometric = {"sine": "sin", "cosine": "cos"} if self.pair else {f"sin{f}": "sin", f"cos{f}": "cos"}
        entire = {name: name for name in ("cos_sqrt", "sinc_sqrt", "sinc3_sqrt")}
        self.functions = {f"sqrt{f}": "sqrt", **trigonometric, **entire}

    def refuse(self, what: str) -> CertificateError:
        return CertificateError(f"{self.place}: {what}")

    def read(self, body: str) -> ReadFunction:
        """The function of this body (the text between its braces, without comments)."""
        body += "\n"
        code, guards = self.take_tail(body)
        code = self.take_cleared(code)
        pieces = code.split(";")
        if pieces.pop().strip():
            raise self.refuse("a statement does not end in ;")
        for piece in pieces:
            self.statement(piece.strip())
        if self.declared:
            raise self.refuse(f"{self.declared[0]} is declared and never set")
        if len(self.turned) != len(self.angles):
            raise self.refuse("an angle whose sine and cosine are never read")
        missing = sum(self.sizes.values()) - len(self.written)
        if missing:
            raise self.refuse(f"{missing} output entries are never assigned")
        return ReadFunction(
            self.program.name,
            self.program.inputs,
            self.program.outputs,
            tuple(self.literals),
            frozenset(self.used),
            tuple(self.statements),
            tuple(self.expression(text) for text in guards),
            count_operations(code, self.constants),
        )

    def take_cleared(self, body: str) -> str:
        """Take out the loops that set runs of output entries to zero."""

        def take(match: re.Match[str]) -> str:
            start, end = int(match[1]), int(match[2])
            for entry in range(start, end):
                self.store(match[3], entry)
            self.statements.append(zeros(match[3], start, end))
            return match[0][0]

        return _CLEAR_LOOP.sub(take, body)

    def take_tail(self, body: str) -> tuple[str, list[str]]:
        """Split off the status and the guards with their NaN loops."""
        if self.status:
            if not body.endswith("    return 0;\n"):
                raise self.refuse("does not end in return 0")
            body = body.removesuffix("    return 0;\n")
        if not self.program.guards:
            return body, []
        start = body.find("    if (")
        match = _GUARD.fullmatch(body, start) if start >= 0 else None
        if match is None:
            raise self.refuse("the guards do not have their form")
        nan = "NAN" if self.precision == "float" else "(double)NAN"
        loops = [(name, int(size)) for size, name, value in _NAN_LOOP.findall(match[2]) if value == nan]
        if loops != list(self.sizes.items()) or match[2].count("for") != len(loops):
            raise self.refuse("the guards do not set every output to NaN")
        if bool(match[3]) != self.status:
            raise self.refuse("a failed guard does not return its status")
        zero = " > 0.0f" if self.precision == "float" else " > 0.0"
        terms = match[1].split(" && ")
        if not all(term.endswith(zero) for term in terms):
            raise self.refuse("a guard is not a comparison with zero")
        return body[:start], [term.removesuffix(zero) for term in terms]

    def statement(self, text: str) -> None:
        if match := _DEFINITION.fullmatch(text):
            self.check_type(match[1])
            value = self.expression(match[3])
            self.define(match[2])
            self.statements.append((f"v_{match[2]}", value))
        elif match := _STORE.fullmatch(text):
            self.store(match[1], int(match[2]))
            self.statements.append((f"v_{match[1]}[{int(match[2])}]", self.expression(match[3])))
        elif match := _DECLARE_PAIR.fullmatch(text):
            self.check_type(match[1])
            if self.declared:
                raise self.refuse(f"{self.declared[0]} is declared and not set at once")
            self.declared = [match[2], match[3]]
        elif (match := _CALL_PAIR.fullmatch(text)) and self.pair:
            self.read_pair(match[1], match[2], match[3])
        elif (match := _ANGLES.fullmatch(text)) and self.pair:
            self.read_angles(match[1], int(match[2]), match[3])
        elif (match := _TABLES.fullmatch(text)) and self.group == ["angles"]:
            self.check_type(match[1])
            self.group.append(match[2] if match[2] == match[3] else "")
        elif (match := _CALL_ALL.fullmatch(text)) and self.group == ["angles", match[1]]:
            if int(match[1]) != self.padded:
                raise self.refuse("sines and cosines of other angles than there are")
            self.group.append("called")
        elif (match := _VOID.fullmatch(text)) and (match[1] in self.arrays or match[1] in self.known):
            pass
        else:
            raise self.refuse(f"not a statement of emitted C: {text[:80]!r}")

    def read_angles(self, c_type: str, size: int, text: str) -> None:
        """The table of angles whose sines and cosines are taken together; zeros fill it up to a multiple of four."""
        self.check_type(c_type)
        items = [" ".join(item.split()) for item in text.split(",")]
        zero = "0.0f" if self.precision == "float" else "0.0"
        while items and items[-1] == zero:
            items.pop()
        if self.group or size != len(items) + -len(items) % 4 or text.count(",") + 1 != size:
            raise self.refuse("not a table of angles")
        self.group, self.padded = ["angles"], size
        self.angles = [self.expression(item) for item in items]

    def read_pair(self, text: str, sine: str, cosine: str) -> None:
        if self.declared != [sine, cosine]:
            raise self.refuse(f"{sine} and {cosine} are not declared just before they are set")
        self.declared = []
        argument = self.expression(text)
        for name in (sine, cosine):
            self.define(name)
        self.statements.append((f"v_{sine}", f"f_sin({argument})"))
        self.statements.append((f"v_{cosine}", f"f_cos({argument})"))

    def check_type(self, c_type: str) -> None:
        if c_type != self.precision:
            raise self.refuse(f"a {c_type} in a function of {self.precision} precision")

    def define(self, name: str) -> None:
        if name in self.known or name in self.arrays or name in self.sizes or name in self.constants:
            raise self.refuse(f"{name} is defined twice")
        if name in self.functions or name in ("sine_cosine", "sines_cosines", "angles", "sines", "cosines"):
            raise self.refuse(f"{name} hides a function")
        self.known.add(name)

    def store(self, name: str, entry: int) -> None:
        if not entry < self.sizes.get(name, 0):
            raise self.refuse(f"{name}[{entry}] is not an entry of an output")
        if (name, entry) in self.written:
            raise self.refuse(f"{name}[{entry}] is assigned twice")
        self.written.add((name, entry))

    def expression(self, text: str) -> str:
        """A C expression as a Python expression; refuses what is not arithmetic on known values."""
        foreign = _FOREIGN.search(text) or _MISREAD.search(text)
        if foreign:
            raise self.refuse(f"not plain arithmetic: {text[:80]!r}")
        return " ".join(_ATOM.sub(self.known_atom, text).split())

    def known_atom(self, match: re.Match[str]) -> str:
        """`atom`, asked once for each: what may be read once may be read from then on, and means the same."""
        text = match[0]
        found = self.atoms.get(text)
        if found is None:
            found = self.atoms[text] = self.atom(match)
        return found

    def atom(self, match: re.Match[str]) -> str:
        name, index, call, number = match["name"], match["index"], match["call"], match["number"]
        if number is not None:
            return self.literal(literal_value(number, self.precision))
        if name is None:
            raise self.refuse(f"{match[0]!r} out of place")
        if call is not None:
            if name not in self.functions:
                raise self.refuse(f"calls {name}")
            return f"f_{self.functions[name]}("
        if name in ("sines", "cosines") and index is not None and len(self.group) == 3:
            if not index.isdigit() or not int(index) < len(self.angles):
                raise self.refuse(f"{name}[{index}] is not of one of the angles")
            self.turned.add(int(index))
            return f"f_{'sin' if name == 'sines' else 'cos'}({self.angles[int(index)]})"
        if index is not None:
            if not index.isdigit() or not int(index) < self.arrays.get(name, 0):
                raise self.refuse(f"{name}[{index}] is not an entry of an input")
            return f"v_{name}[{int(index)}]"
        if name in self.known:
            return f"v_{name}"
        if name in self.constants:
            self.used.add(name)
            return self.literal(self.constants[name])
        raise self.refuse(f"reads {name}, which is not set")

    def literal(self, value: Fraction) -> str:
        return self.literals.setdefault(value, f"l{len(self.literals)}")
