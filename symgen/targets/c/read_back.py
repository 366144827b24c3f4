"""Emitted C read back: the proof that a certificate is about the text, not about what was meant.

The strict straight-line subset that `emit_c` writes is recognised, everything else is refused. Arithmetic with
+ − * / and parentheses means the same in C and in Python, so a function body becomes Python source (each name
prefixed, each literal an exact rational) that runs over any number type, and modulo a prime at full speed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symgen.errors import CertificateError
from symgen.integrators.read import ComposedReader, ReadComposed
from symgen.loops.model import LoopProgram
from symgen.loops.read import LoopReader, ReadLoops
from symgen.program.composed import ComposedProgram
from symgen.program.instructions import Port
from symgen.targets.c.batch import BatchFile
from symgen.targets.c.batch_text import read_batch
from symgen.targets.c.emit import Emitted, EmittedFunction
from symgen.targets.c.function_text import FunctionReader, ReadFunction
from symgen.targets.c.literals import PRECISIONS
from symgen.targets.c.rounding import check_literal, literal_value
from symgen.targets.c.signatures import batch_prototypes
from symgen.targets.c.sincos import helper_functions
from symgen.targets.c.split import PART, joined

_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_INCLUDES = re.compile(r'\s*#include "(\w+)\.h"\n((?:#include <(?:math|stdint)\.h>\n)*)')
_CONSTANT = re.compile(r"\s*static const (double|float) (\w+) = ([\w.+-]+);", re.ASCII)
_FUNCTION = re.compile(
    r"\s*(?P<unpaired>SYMGEN_UNPAIRED\n)?(?P<kind>void|int) (?P<name>\w+)\((?P<ports>[^()]*)\)\n\{\n(?P<body>.*?)\n\}\n"
    r"(?(unpaired)SYMGEN_PAIRED\n)",
    re.ASCII | re.DOTALL,
)
_CALL = re.compile(r"\b([A-Za-z_]\w*)\(", re.ASCII)
_FUNCTIONS = "sqrt sqrtf sin sinf cos cosf sines_cosines sine_cosine sine cosine cos_sqrt sinc_sqrt sinc3_sqrt"
_MATH = frozenset(_FUNCTIONS.split())
_MACROS = {"SYMGEN_PART": "parts", "SYMGEN_STEP": "steps"}


Read = ReadFunction | ReadLoops | ReadComposed
"""A function as its text says it is."""


@dataclass(frozen=True)
class NamedLiteral:
    """A line of a constant table: the file says ``name = text``, the emitter says it stands for ``value``."""

    file: str
    name: str
    text: str
    value: Fraction


@dataclass(frozen=True)
class ReadBack:
    """What the C sources of one artifact say."""

    functions: Mapping[str, Read]
    """By program name."""
    vectors: Mapping[str, ReadFunction]
    """What its batch file does with every lane; by program name."""
    literals: tuple[NamedLiteral, ...]
    precision: str

    def check_literals(self) -> int:
        """Prove every named constant correctly rounded; how many there are. Raises CertificateError."""
        for row in self.literals:
            try:
                check_literal(row.text, row.value, self.precision)
            except CertificateError as error:
                raise CertificateError(f"{row.file}: {row.name}: {error}") from None
        return len(self.literals)


def read_back(emitted: Emitted) -> ReadBack:
    """Parse the sources of ``emitted`` and check them against its programs' ports.

    Raises CertificateError for anything that is not the form `emit_c` writes: unknown statements, wrong signatures,
    entries of an output assigned twice or never, names read before they are assigned, indices out of bounds, constants
    that are not in the table. Values are for the caller to check (`ReadFunction.evaluate_mod`).
    """
    functions: dict[str, Read] = {}
    literals: list[NamedLiteral] = []
    by_file: dict[str, list[EmittedFunction]] = {}
    for function in emitted.functions:
        by_file.setdefault(function.source, []).append(function)
    for file, expected in by_file.items():
        read, found = _read_source(file, emitted, expected)
        functions.update(read)
        literals.extend(found)
    _check_header(emitted)
    vectors: dict[str, ReadFunction] = {}
    for batch in emitted.batches:
        of_vectors, found = _read_batch(batch, emitted)
        vectors.update(of_vectors)
        literals.extend(found)
    return ReadBack(functions, vectors, tuple(literals), emitted.info.options.precision)


def strip_comments(text: str) -> str:
    """Comments become blanks; lines stay."""
    return _COMMENT.sub(lambda match: "\n" * match[0].count("\n") or " ", text)


def _code(file: str, text: str) -> str:
    """The code of a file without comments; refuses what could make a compiler read it differently."""
    code = strip_comments(text)
    for mark in ("//", "??", "\\", "/*", '"""'):
        if mark in code:
            raise CertificateError(f"{file}: {mark} is not part of emitted C")
    if not code.isascii():
        raise CertificateError(f"{file}: code outside comments is not ASCII")
    return re.sub(r"[ \t]+\n", "\n", code)


def _read_source(
    file: str, emitted: Emitted, expected: Sequence[EmittedFunction]
) -> tuple[dict[str, Read], list[NamedLiteral]]:
    options = emitted.info.options
    code = _code(file, emitted.files[file])
    symbol = re.escape(expected[0].symbols.scalar)
    first = re.search(
        rf"\n(?:SYMGEN_PART void {symbol}_part0|SYMGEN_STEP void {symbol}_\w+"
        rf"|(?:SYMGEN_UNPAIRED\n)?(?:void|int) {symbol})\(",
        code,
    )
    if first is None:
        raise CertificateError(f"{file}: {expected[0].symbols.scalar} is not there")
    prefix, rest = code[: first.start() + 1], code[first.start() + 1 :]
    called = set(_CALL.findall(rest)) | {name for mark, name in _MACROS.items() if mark in rest}
    helpers = _code(file, helper_functions(options.precision, options.trigonometry, called))
    guarded = any(function.program.guards for function in expected)
    prefix = _after_includes(file, prefix, emitted.name, bool(called & _MATH) or guarded, "uint64_t" in helpers)
    if not prefix.lstrip().startswith(helpers.strip()):
        raise CertificateError(f"{file}: the built-in functions are not the certified ones")
    literals = _constants(file, prefix.lstrip()[len(helpers.strip()) :], emitted)
    values = {row.name: row.value for row in literals}
    functions: dict[str, Read] = {}
    position = 0
    for function in expected:
        if isinstance(function.program, LoopProgram):
            read, position = _read_loops(file, rest, position, function, values, emitted)
            functions[function.program.name] = read
            literals += [NamedLiteral(file, row.name, row.text, row.value) for row in read.literals]
            continue
        if isinstance(function.program, ComposedProgram):
            functions[function.program.name], position = _read_composed(file, rest, position, function, values, emitted)
            continue
        parts = []
        while match := PART.match(rest, position):
            parts.append((match[1], match[2], match[3]))
            position = match.end()
        place, status = f"{file}: {function.symbols.scalar}", options.status and bool(function.program.guards)
        match = _definition(rest, position, place, function, options.precision, status)
        position = match.end()
        reader = FunctionReader(place, function.program, values, options.precision, options.trigonometry, status)
        body = match["body"]
        if parts:
            body = joined(place, function.symbols.scalar, options.precision, match["ports"], parts, body)
        functions[function.program.name] = reader.read(body)
    if rest[position:].strip():
        raise CertificateError(f"{file}: text after the last function")
    _check_all_used(file, [row for row in literals if row.name in values], functions)
    return functions, literals


def _definition(
    text: str, position: int, place: str, function: EmittedFunction, precision: str, status: bool
) -> re.Match[str]:
    """The definition of a function that must stand at ``position``, its signature checked."""
    match = _FUNCTION.match(text, position)
    if match is None or match["name"] != function.symbols.scalar:
        raise CertificateError(f"{place}: expected here, found something else")
    _check_signature(place, match["kind"], match["ports"], function, precision, status)
    return match


def _read_loops(
    file: str, text: str, position: int, function: EmittedFunction, constants: Mapping[str, Fraction], emitted: Emitted
) -> tuple[ReadLoops, int]:
    """A function in loops, its steps and tables before it."""
    options, symbol = emitted.info.options, function.symbols.scalar
    assert isinstance(function.program, LoopProgram)
    status, place = options.status and bool(function.program.guards), f"{file}: {symbol}"
    reader = LoopReader(place, function.program, symbol, constants, options.precision, options.trigonometry, status)
    steps, position = reader.before(text, position)
    match = _definition(text, position, place, function, options.precision, status)
    return reader.read(steps, match["body"]), match.end()


def _read_composed(
    file: str, text: str, position: int, function: EmittedFunction, constants: Mapping[str, Fraction], emitted: Emitted
) -> tuple[ReadComposed, int]:
    """A function that calls others, its updates before it."""
    options, symbol, program = emitted.info.options, function.symbols.scalar, function.program
    assert isinstance(program, ComposedProgram)
    status, place = options.status and bool(program.guards), f"{file}: {symbol}"
    symbols = {row.program.name: row.symbols.scalar for row in emitted.functions}
    precision, trigonometry = options.precision, options.trigonometry
    reader = ComposedReader(place, program, symbol, symbols, constants, precision, trigonometry, options.status)
    updates, position = reader.before(text, position)
    match = _definition(text, position, place, function, precision, status)
    return reader.read(updates, match["body"], function.counts), match.end()


def _after_includes(file: str, prefix: str, name: str, math: bool, stdint: bool) -> str:
    match = _INCLUDES.match(prefix)
    wanted = ["#include <math.h>\n"] * math + ["#include <stdint.h>\n"] * stdint
    if match is None or match[1] != name or match[2] != "".join(wanted):
        raise CertificateError(f"{file}: must begin with its includes")
    return prefix[match.end() :]


def _constants(file: str, text: str, emitted: Emitted) -> list[NamedLiteral]:
    rows: list[NamedLiteral] = []
    position = 0
    while match := _CONSTANT.match(text, position):
        c_type, name, literal = match.groups()
        position = match.end()
        if (
            c_type != emitted.info.options.precision
            or name not in emitted.constants
            or name in {r.name for r in rows[-1:]}
        ):
            raise CertificateError(f"{file}: constant {name} is not one of the table")
        literal_value(literal, c_type)
        rows.append(NamedLiteral(file, name, literal, emitted.constants[name]))
    if text[position:].strip():
        raise CertificateError(f"{file}: unexpected text before the first function: {text[position:].strip()[:60]!r}")
    if len({row.name for row in rows}) != len(rows):
        raise CertificateError(f"{file}: a constant is defined twice")
    return rows


def _check_all_used(file: str, literals: Sequence[NamedLiteral], functions: Mapping[str, Read]) -> None:
    used = {name for function in functions.values() for name in function.constants}
    for row in literals:
        if row.name not in used:
            raise CertificateError(f"{file}: constant {row.name} is never used")


def _arguments(function: EmittedFunction, precision: str) -> list[str]:
    def spelled(port: Port, qualifier: str) -> str:
        scalar = port.shape == () and qualifier
        return f"{precision} {port.name}" if scalar else f"{qualifier}{precision} {port.name}[{port.size}]"

    program = function.program
    return [spelled(port, "const ") for port in program.inputs] + [spelled(port, "") for port in program.outputs]


def _check_signature(
    place: str, result: str, arguments: str, function: EmittedFunction, precision: str, status: bool
) -> None:
    found = [" ".join(argument.split()) for argument in arguments.split(",")]
    if result != ("int" if status else "void"):
        raise CertificateError(f"{place}: returns {result}")
    if found != _arguments(function, precision):
        raise CertificateError(f"{place}: arguments are ({', '.join(found)})")


def _check_header(emitted: Emitted) -> None:
    """Every function is declared once, as it is defined, and no macro changes what a source says."""
    file = emitted.headers[0]
    _check_macros(file, strip_comments(emitted.files[file]), emitted)
    code = " ".join(strip_comments(emitted.files[file]).split())
    options = emitted.info.options
    for function in emitted.functions:
        result = "int" if options.status and function.program.guards else "void"
        arguments = ", ".join(_arguments(function, options.precision))
        symbol = function.symbols.scalar
        forms = batch_prototypes(function.program, function.symbols, PRECISIONS[options.precision], options.status)
        texts = {symbol: f"{result} {symbol}({arguments})", **forms}
        for name, prototype in texts.items():
            text = f"{' '.join(prototype.split())};".replace("( ", "(")
            if code.replace("( ", "(").count(text) != 1 or len(re.findall(rf"\b{name}\(", code)) != 1:
                raise CertificateError(f"{file}: {name} is not declared as it is defined")


def _check_macros(file: str, code: str, emitted: Emitted) -> None:
    """Sizes and the places of parameters as they are; besides them only the guard, the defaults and C++'s linkage."""
    info, prefix = emitted.info, f"{emitted.name.upper()}_"
    sizes = {"NQ": info.nq, "NV": info.nv} | ({"NP": info.parameter_count} if info.parameters else {})
    wanted = [f"#define {prefix}{name} {size}" for name, size in sizes.items()]
    plain = re.compile(
        rf"#(ifndef|define) SYMGEN_{prefix}(F32_)?H|#define {prefix}P_\w+ (\d+|\\)"
        r"|#include <stddef\.h>|#ifdef __cplusplus|#endif"
    )
    lines = [" ".join(line.split()) for line in code.splitlines() if line.lstrip().startswith(("#", "%:", "??="))]
    others = [line for line in lines if line not in wanted]
    starts = [int(line.split()[2]) for line in others if re.fullmatch(rf"#define {prefix}P_\w+ \d+", line)]
    if (
        [line for line in lines if line in wanted] != wanted
        or starts != [parameter.start for parameter in info.parameters]
        or not all(plain.fullmatch(line) for line in others)
    ):
        raise CertificateError(f"{file}: its macros are not those of the scene")


def _read_batch(batch: BatchFile, emitted: Emitted) -> tuple[dict[str, ReadFunction], list[NamedLiteral]]:
    """The functions of a batch file that are on vectors, read as scalar ones."""
    options = emitted.info.options
    read = read_batch(batch, _code(batch.file, emitted.files[batch.file]), lambda text: _code(batch.file, text))
    literals = _constants(batch.file, read.constants, emitted)
    values = {row.name: row.value for row in literals}
    found: dict[str, ReadFunction] = {}
    for program, place, body in read.bodies:
        status = options.status and bool(program.guards)
        reader = FunctionReader(place, program, values, options.precision, options.trigonometry, status)
        found[program.name] = reader.read(body.removesuffix("\n"))
    _check_all_used(batch.file, literals, found)
    return found, literals
