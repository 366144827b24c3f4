"""Programs → C99 files: prepared rows go into templates, nothing else happens there.

emitted = emit_c("rrpr", programs, info)
emitted.files["rrpr.c"]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symgen.errors import NotSupportedError, SceneError
from symgen.integrators.text import write_composed
from symgen.loops.model import LoopProgram, straight_programs
from symgen.loops.text import LoopBody, write_loops
from symgen.program.composed import ComposedProgram
from symgen.program.instructions import Counts, Port, Program, count
from symgen.scene.names import sanitise
from symgen.targets.c.batch import BatchFile, batch_files
from symgen.targets.c.comments import comment_lines, comment_text
from symgen.targets.c.example import example_file
from symgen.targets.c.info import Info
from symgen.targets.c.literals import (
    PRECISIONS,
    Constant,
    ConstantTable,
    Precision,
    constant_table,
    inline_literal,
    rounded_literal,
)
from symgen.targets.c.names import HELPERS, Names
from symgen.targets.c.signatures import Symbols, batch_prototypes, prototype, returns_status, scalar_arguments, symbols
from symgen.targets.c.sincos import helper_functions
from symgen.targets.c.split import split
from symgen.targets.c.statements import Body, Functions, write_body
from symgen.targets.c.templates import render

LICENCE = "0BSD"
_SYMMETRIC = frozenset({"M", "Minv"})
"""Outputs that are symmetric matrices: each value below the diagonal is written twice, in places far apart."""
FOUR_SINES = "sines_cosines"
"""Sines of four are compiled without pairs of scalars, and gcc inlines only what is compiled with the same options."""
LINES_PER_FILE = 20000
"""Sources longer than this are split between functions: gcc's memory and time grow with the length of a file."""

_HEADERS = """assert
complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdarg stdbool stddef
stdint stdio stdlib string tgmath time wchar wctype stdalign stdatomic stdnoreturn threads uchar"""
_LIBRARY_HEADERS = frozenset(_HEADERS.split())
_TARGETS = "all clean help install test package edit_cache rebuild_cache depend m none c"
_CMAKE_TARGETS = frozenset(_TARGETS.split())


@dataclass(frozen=True)
class EmittedFunction:
    """What became of one program."""

    program: Program
    """As emitted: without empty outputs."""
    symbols: Symbols
    source: str
    """File it stands in."""
    counts: Counts
    """What the C performs, counted in its text."""


@dataclass(frozen=True)
class Emitted:
    """Files by name, and what a reader of them must know."""

    name: str
    info: Info
    files: Mapping[str, str]
    sources: tuple[str, ...]
    headers: tuple[str, ...]
    functions: tuple[EmittedFunction, ...]
    constants: Mapping[str, Fraction]
    """Every named constant of the sources and the rational it stands for."""
    notes: tuple[str, ...]
    """What was left out, and why."""
    batches: tuple[BatchFile, ...] = ()


def emit_c(name: str, programs: Sequence[Program], info: Info) -> Emitted:
    """The C files of a scene: NAME.h, NAME.c (NAME_1.c, … when long), NAME_batch.c where asked for, CMakeLists.txt
    and main.c.

    ``name`` is the scene's, a C identifier. Raises SceneError where names cannot be told apart in C and
    NotSupportedError where a constant does not fit the precision.
    """
    if name.lower() in _LIBRARY_HEADERS:
        raise SceneError(f"a scene named {name} would make {name}.h hide the C library's; choose another name", "name")
    precision = PRECISIONS[info.options.precision]
    kept, notes = without_empty_outputs(programs)
    info = replace(info, notes=(*info.notes, *notes))
    names = symbols(name, kept, precision, info.options.batch)
    taken = Names([*HELPERS, *(s for row in names for s in row.all)])
    table = constant_table([part for program in kept for part in straight_programs(program)], precision, taken)
    functions = c_functions(info.options.trigonometry, precision)
    bodies = _bodies(kept, names, table, functions, taken.taken, info.options.status)
    groups = _split([len(body.lines) for body in bodies])
    banner = banner_lines(name, info)
    files: dict[str, str] = {}
    emitted: list[EmittedFunction] = []
    files[f"{name}.h"] = _header(name, kept, names, bodies, info, precision, banner)
    for number, group in enumerate(groups):
        source = f"{name}.c" if number == 0 else f"{name}_{number}.c"
        chosen = [(kept[i], names[i], bodies[i]) for i in group]
        constants = [constant for constant in table if _mentions(constant.name, [body for _, _, body in chosen])]
        files[source] = _source(name, chosen, constants, info, precision, banner)
        emitted += [EmittedFunction(program, row, source, body.counts) for program, row, body in chosen]
    sources = tuple(file for file in files if file.endswith(".c"))
    batches = batch_files(name, kept, names, table, taken.taken, info.options, banner)
    files.update((batch.file, batch.text(table)) for batch in batches)
    sources += tuple(batch.file for batch in batches)
    files["main.c"] = example_file(name, kept, names, info, precision, banner)
    files["CMakeLists.txt"] = _cmake(name, sources, banner)
    constants_by_name = {constant.name: constant.value for constant in table}
    return Emitted(
        name, info, files, sources, (f"{name}.h",), tuple(emitted), constants_by_name, tuple(notes), tuple(batches)
    )


def _bodies(
    programs: Sequence[Program],
    names: Sequence[Symbols],
    table: ConstantTable,
    functions: Functions,
    taken: frozenset[str],
    status: bool,
) -> list[Body]:
    """The inside of every function; of those that call others last, with the others' counts."""
    symbol_of = {program.name: row.scalar for program, row in zip(programs, names, strict=True)}
    found: dict[str, Body] = {}
    for program in sorted(programs, key=lambda program: isinstance(program, ComposedProgram)):
        symbol = symbol_of[program.name]
        if isinstance(program, ComposedProgram):
            counts = {name: body.counts for name, body in found.items()}
            body: Body = write_composed(program, symbol, symbol_of, counts, table, functions, taken, status)
        elif isinstance(program, LoopProgram):
            body = write_loops(program, symbol, table, functions, taken, status)
        else:
            body = write_body(program, table, functions, taken, grouped=True)
        found[program.name] = body
    return [found[program.name] for program in programs]


def without_empty_outputs(programs: Sequence[Program]) -> tuple[list[Program], list[str]]:
    """C has no arrays of length zero: such outputs are left out, and functions that have no other."""
    kept: list[Program] = []
    notes: list[str] = []
    for program in programs:
        full = [k for k, port in enumerate(program.outputs) if port.size]
        for port in program.outputs:
            if not port.size:
                notes.append(f"left out, because it is empty: output {port.name} of {program.name}")
        if full:
            inputs = tuple(port for port in program.inputs if port.size)
            outputs = tuple(program.outputs[k] for k in full)
            results = tuple(program.results[k] for k in full)
            kept.append(replace(program, inputs=inputs, outputs=outputs, results=results))
        else:
            notes.append(f"left out, because it has no output: function {program.name}")
    return kept, notes


def c_functions(trigonometry: str, precision: Precision) -> Functions:
    """How the statements of a file call its functions."""
    f = precision.literal_suffix
    entire = {name: name for name in ("cos_sqrt", "sinc_sqrt", "sinc3_sqrt")}
    if trigonometry == "polynomial":
        return Functions({"sqrt": f"sqrt{f}", "cos": "cosine", "sin": "sine", **entire}, pair="sine_cosine")
    if trigonometry == "libm":
        return Functions({"sqrt": f"sqrt{f}", "cos": f"cos{f}", "sin": f"sin{f}", **entire})
    raise NotSupportedError(f"trigonometry is polynomial or libm, not {trigonometry}")


def _split(lengths: Sequence[int]) -> list[list[int]]:
    """Functions, in order, over files of at most LINES_PER_FILE lines (a longer one has a file of its own)."""
    groups: list[list[int]] = [[]]
    lines = 0
    for index, length in enumerate(lengths):
        if groups[-1] and lines + length > LINES_PER_FILE:
            groups.append([])
            lines = 0
        groups[-1].append(index)
        lines += length
    return groups


def _mentions(name: str, bodies: Sequence[Body]) -> bool:
    return any(name in body.words for body in bodies)


def banner_lines(name: str, info: Info) -> list[str]:
    """The comment at the head of every file."""
    options = info.options
    stated = [
        f"precision {options.precision}",
        f"trigonometry {options.trigonometry}",
        f"base_velocity {options.base_velocity}",
        f"snap {_plain(options.snap)} rad",
        f"status {'on' if options.status else 'off'}",
        f"batch {'on' if options.batch else 'off'}",
    ]
    lines = [
        f"SPDX-License-Identifier: {LICENCE}",
        "",
        f"{name}: generated by symgen {info.version} from the scene with sha256",
        info.scene_sha256 or "(none)",
        f"Options: {', '.join(stated)}.",
    ]
    return comment_lines([*lines, *(f"Note: {note}." for note in info.notes)])


def _plain(value: Fraction) -> str:
    return repr(float(value))


def _port(port: Port) -> str:
    shape = " x ".join(map(str, port.shape)) or "scalar"
    unit = f", {port.unit}" if port.unit else ""
    return f"{port.name} ({shape}{unit})"


def describe(program: Program, body: Body) -> list[str]:
    """The comment above a function."""
    counts = body.counts
    work = [
        (counts.add, "add"),
        (counts.mul, "mul"),
        (counts.div, "div"),
        (counts.sqrt, "sqrt"),
        (counts.sincos, "sincos"),
    ]
    performed = ", ".join(f"{n} {what}" for n, what in work if n) or "none"
    inputs = ", ".join(_port(port) for port in program.inputs) or "nothing"
    lines = [
        f"{program.name}: {program.summary}" if program.summary else program.name,
        f"From {inputs} to {', '.join(_port(port) for port in program.outputs)}.",
        f"Plan: {program.plan}. Operations: {performed}." if program.plan else f"Operations: {performed}.",
    ]
    if isinstance(body, LoopBody):
        lines.append(f"Needs {body.stack} KB of stack.")
    if program.guards:
        lines.append("Where there is no answer (a pivot that is not positive), every output is NaN.")
    return comment_lines(lines)


def _header(
    name: str,
    programs: Sequence[Program],
    names: Sequence[Symbols],
    bodies: Sequence[Body],
    info: Info,
    precision: Precision,
    banner: Sequence[str],
) -> str:
    macro = name.upper()
    rows = []
    for program, row, body in zip(programs, names, bodies, strict=True):
        prototypes = [prototype(program, row, precision, info.options.status)]
        prototypes += batch_prototypes(program, row, precision, info.options.status).values()
        rows.append({"comment": describe(program, body), "prototypes": prototypes})
    macros = sanitise([parameter.name for parameter in info.parameters])
    parameters = [
        {
            "macro": f"{macro}_P_{macros[p.name].upper()}",
            "start": p.start,
            "comment": comment_text(f"{p.name}, {p.size} value{'s' if p.size > 1 else ''}, {p.unit or '1'}"),
        }
        for p in info.parameters
    ]
    return render(
        "c/header.h.j2",
        banner=[*banner, "", *_CONVENTIONS, *(_STATUS if info.options.status else ())],
        guard=f"SYMGEN_{macro}{precision.symbol_suffix.upper()}_H",
        include_stddef=any(row.batch for row in names),
        macro=macro,
        nq=info.nq,
        nv=info.nv,
        np=info.parameter_count,
        real=precision.c_type,
        parameters=parameters,
        defaults=[literal(value, precision) for p in info.parameters for value in p.default],
        defaults_macro=f"{macro}_P_DEFAULTS{precision.symbol_suffix.upper()}",
        functions=rows,
    )


_CONVENTIONS = (
    "SI units, radians. Matrices are row-major (CasADi and Eigen are column-major).",
    "Inputs and outputs may not overlap. Every function is re-entrant.",
)
_STATUS = ("Functions that may have no answer return 0, or 1 where there is none (batches: where any state has none).",)


def literal(value: Fraction, precision: Precision) -> str:
    """Any rational as a literal: exact where it can be, correctly rounded where not."""
    magnitude = abs(value)
    text = inline_literal(magnitude, precision) or rounded_literal(magnitude, precision)
    return f"-{text}" if value < 0 else text


def _computes_symmetric(program: Program) -> bool:
    """Whether a symmetric matrix is computed; a constant one is stored faster in pairs."""
    symmetric = any(port.name in _SYMMETRIC for port in program.outputs)
    return symmetric and not (isinstance(program, Program) and count(program).flops == 0)


def _source(
    name: str,
    chosen: Sequence[tuple[Program, Symbols, Body]],
    constants: Sequence[Constant],
    info: Info,
    precision: Precision,
    banner: Sequence[str],
) -> str:
    whole = [
        ((), body)
        if isinstance(body, LoopBody)
        else split(body, precision.c_type, row.scalar, scalar_arguments(program, precision))
        for program, row, body in chosen
    ]
    called = {function for _, _, body in chosen for function in body.called}
    functions = called | ({"parts"} if any(parts for parts, _ in whole) else set())
    functions |= {"steps"} if any(isinstance(body, LoopBody) for _, _, body in chosen) else set()
    helpers = helper_functions(precision.name, info.options.trigonometry, functions)
    guarded = any(program.guards for program, _, _ in chosen)
    zero, nan = f"0.0{precision.literal_suffix}", "NAN" if precision.name == "float" else "(double)NAN"
    rows = [
        {
            "comment": describe(program, body),
            "prototype": prototype(program, row, precision, info.options.status),
            "unpaired": FOUR_SINES in body.called or _computes_symmetric(program),
            "loops": isinstance(body, LoopBody)
            and body.text(describe(program, body), prototype(program, row, precision, info.options.status)),
            "parts": parts,
            "body": rest,
            "guard": " && ".join(f"{text} > {zero}" for text in body.guards),
            "outputs": [(port.name, port.size) for port in program.outputs],
            "status": returns_status(program, info.options.status),
        }
        for (program, row, body), (parts, rest) in zip(chosen, whole, strict=True)
    ]
    return render(
        "c/source.c.j2",
        banner=banner,
        header=f"{name}.h",
        includes=[
            *(["math.h"] if called or guarded else []),
            *(["stdint.h"] if "uint64_t" in helpers else []),
        ],
        helpers=helpers,
        constants=constants,
        real=precision.c_type,
        functions=rows,
        nan=nan,
    )


def _cmake(name: str, sources: Sequence[str], banner: Sequence[str]) -> str:
    target = f"{name}_symgen" if name.lower() in _CMAKE_TARGETS else name
    return render("c/CMakeLists.txt.j2", banner=banner, target=target, sources=sources)
