"""The batch files: every function over many states, on vectors of every width that a processor may have.

One text of a function serves all widths: NAME_batch.c includes itself once for each (`templates/c/batch*.j2`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symgen.loops.model import LoopProgram
from symgen.program.composed import ComposedProgram
from symgen.program.instructions import Port, Program
from symgen.scene.model import Options
from symgen.targets.c.literals import PRECISIONS, Constant, ConstantTable, Precision
from symgen.targets.c.signatures import Symbols, batch_prototypes, returns_status
from symgen.targets.c.sincos import helper_functions, vector_numbers
from symgen.targets.c.statements import ENTIRE
from symgen.targets.c.templates import render
from symgen.targets.c.vector import GROUPS, VectorBody, is_shared, spelling, vector_body

TILE_LIMIT = 1 << 18
"""Bytes of stack for the inputs and outputs of the widest vectors; a function that needs more runs state by state."""
WIDEST = 64
LONGEST = 8000
"""Lines of a function over vectors; a longer one runs state by state: gcc takes minutes for it, once a width."""
LINES_PER_FILE = 8000
"""Longer batch files are split between functions: every width compiles all of it."""

_SURE_512 = "defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__)"
WIDTHS: tuple[Mapping[str, Any], ...] = (
    {
        "name": "avx512",
        "bytes": 64,
        "features": ("avx512f", "avx512dq", "avx512vl", "avx2", "fma"),
        "macros": f"{_SURE_512} && defined(__FMA__)",
    },
    {"name": "avx2", "bytes": 32, "features": ("avx2", "fma"), "macros": "defined(__AVX2__) && defined(__FMA__)"},
)


@dataclass(frozen=True)
class BatchFunction:
    """What a batch file holds of one program."""

    program: Program
    symbols: Symbols
    vector: VectorBody | None
    """None: state by state."""


@dataclass(frozen=True)
class BatchFile:
    """One batch file."""

    file: str
    header: str
    functions: tuple[BatchFunction, ...]
    constants: frozenset[str]
    """Named constants in it."""
    options: Options
    banner: tuple[str, ...]

    def text(self, constants: Iterable[Constant]) -> str:
        """The file; ``constants``: all there are."""
        return self.render([constant for constant in constants if constant.name in self.constants])

    def render(self, constants: Sequence[Constant]) -> str:
        """The file with these constants."""
        precision, trigonometry = PRECISIONS[self.options.precision], self.options.trigonometry
        called = {macro for row in self.functions if row.vector for macro in row.vector.called}
        own = trigonometry == "polynomial"
        single = {macro: name for macro, name in spelling(trigonometry, precision.name).items() if macro in called}
        groups = {count for count, macro in GROUPS.items() if macro in called}
        groups |= {1} if own and called & {"SIN", "COS"} else set()
        by_lane = [name for name in single.values() if name not in ("sine", "cosine")]
        entire = {name for name in by_lane if name in ENTIRE}
        size = 8 if precision.name == "double" else 4
        return render(
            "c/batch.c.j2",
            banner=self.banner,
            file=self.file,
            header=self.header,
            real=precision.c_type,
            word=f"uint{8 * size}_t",
            size=size,
            zero=f"0.0{precision.literal_suffix}",
            math=bool(by_lane),
            helpers=helper_functions(precision.name, trigonometry, entire),
            constants=constants,
            functions=[_row(function, precision, self.options.status) for function in self.functions],
            calls=list(single.items()),
            groups=sorted(groups),
            trigonometry=bool(groups),
            single_angles=own and bool(called & {"SIN", "COS"}),
            lane_functions=[
                {"name": name, "wide": _SQUARE_ROOTS[precision.name] if name[:4] == "sqrt" else ()} for name in by_lane
            ],
            widths=[{**width, "asked": _asked(width["features"])} for width in WIDTHS],
            **vector_numbers(precision.name),
        )


def batch_files(
    name: str,
    programs: Sequence[Program],
    names: Sequence[Symbols],
    table: ConstantTable,
    taken: Iterable[str],
    options: Options,
    banner: Sequence[str],
) -> list[BatchFile]:
    """NAME_batch.c, and NAME_batch_1.c, … when long; none where no function has a batch form."""
    pairs = options.trigonometry == "polynomial"
    taken = [*taken]
    groups: list[list[BatchFunction]] = []
    lines = 0
    for program, row in zip(programs, names, strict=True):
        if not row.batch:
            continue
        vector = vector_body(program, table, pairs, taken) if fits(program) else None
        if vector and len(vector.lines) > LONGEST:
            vector = None
        length = len(vector.lines) if vector else 0
        if not groups or lines + length > LINES_PER_FILE:
            groups.append([])
            lines = 0
        groups[-1].append(BatchFunction(program, row, vector))
        lines += length
    files = []
    for number, group in enumerate(groups):
        file = f"{name}_batch_{number}.c" if number else f"{name}_batch.c"
        words = {word for row in group if row.vector for word in row.vector.words}
        constants = frozenset(constant.name for constant in table if constant.name in words)
        files.append(BatchFile(file, f"{name}.h", tuple(group), constants, options, tuple(banner)))
    return files


def fits(program: Program) -> bool:
    """Whether a function can run over a block of states, whose inputs and outputs must fit on the stack; loops and
    steps run state by state."""
    if isinstance(program, LoopProgram | ComposedProgram):
        return False
    return WIDEST * sum(port.size for port in program.inputs + program.outputs) <= TILE_LIMIT


_SQUARE_ROOTS = {
    "double": ("_mm512_sqrt_pd", "__m512d", "_mm256_sqrt_pd", "__m256d"),
    "float": ("_mm512_sqrt_ps", "__m512", "_mm256_sqrt_ps", "__m256"),
}


def _asked(features: Sequence[str]) -> str:
    return " && ".join(f'__builtin_cpu_supports("{feature}")' for feature in features)


def _row(function: BatchFunction, precision: Precision, status: bool) -> dict[str, Any]:
    """Everything the templates say of one function."""
    program, symbols, real = function.program, function.symbols, precision.c_type
    inputs = [_port(port) for port in program.inputs]
    outputs = [{**_port(port), "array": True, "shared": False} for port in program.outputs]
    shared = {port["name"] for port in inputs if port["shared"]}
    own = next((port.size for port in program.inputs if port.name == "p"), 0)
    ports = [*inputs, *outputs]
    names = [port["name"] for port in ports]
    arrays = [f"const {real} *{port['name']}" if port["array"] else f"{real} {port['name']}" for port in inputs]
    arrays += [f"{real} *{port['name']}" for port in outputs]
    with_own = _after_p(names, arrays, "int own_p")
    passed = _after_p(names, names, "own_p")
    answers = returns_status(program, status)
    forms = [
        {
            "name": "batch",
            "arguments": ["size_t n", *with_own],
            "passed": ["n", *passed],
            "call": _state_call(symbols.scalar, ports),
        },
        {
            "name": "soa",
            "arguments": ["size_t n", "size_t stride", *with_own],
            "passed": ["n", "stride", *passed],
            "call": f"{symbols.scalar}_column({', '.join(['i', 'stride', *passed])})",
        },
    ]
    return {
        "name": symbols.scalar,
        "symbol": symbols.scalar,
        "vector": function.vector,
        "result": "int" if answers else "void",
        "status": answers,
        "inputs": inputs,
        "outputs": outputs,
        "ports": ports,
        "own": own,
        "pointers": [
            *(f"const {real} *restrict {port['name']}" for port in inputs),
            *(f"{real} *restrict {port['name']}" for port in outputs),
        ],
        "part_arguments": forms[0]["arguments"],
        "soa_arguments": forms[1]["arguments"],
        "tiles": [f"tile_{name}" for name in names],
        "columns": [f"tile_{name}" if name in shared else f"{name} + first" for name in names],
        "column_call": ["i", "stride", *passed],
        "states": [_one_state(name, name in shared) for name in names],
        "call": forms[0]["call"],
        "forms": forms,
        "entries": _entries(function, precision, status, ports),
    }


def _one_state(name: str, shared: bool) -> str:
    """The argument of the scalar function for one state of a structure of arrays."""
    if name == "p":
        return "own_p ? state_p : p"
    return name if shared else f"state_{name}"


def _after_p(names: Sequence[str], items: Sequence[str], extra: str) -> list[str]:
    result: list[str] = []
    for name, item in zip(names, items, strict=True):
        result.append(item)
        if name == "p":
            result.append(extra)
    return result


def _port(port: Port) -> dict[str, Any]:
    return {
        "name": port.name,
        "size": port.size,
        "array": port.shape != (),
        "shared": is_shared(port.name, port.shape),
        "address": port.name if port.shape != () else f"&{port.name}",
    }


def _state_call(symbol: str, ports: Sequence[Mapping[str, Any]]) -> str:
    """The scalar call for state i of states that lie one after the other."""
    arguments = []
    for port in ports:
        here = f"{port['name']} + {port['size']} * i"
        if port["name"] == "p":
            arguments.append(f"own_p ? {here} : p")
        else:
            arguments.append(port["name"] if port["shared"] else here)
    return f"{symbol}({', '.join(arguments)})"


def _entries(
    function: BatchFunction, precision: Precision, status: bool, ports: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """The functions of the header."""
    program, symbols = function.program, function.symbols
    rows = []
    prototypes = batch_prototypes(program, symbols, precision, status)
    for symbol, own in ((symbols.batch, False), (symbols.batch_p, True)):
        if symbol:
            passed = ["count"]
            for port in ports:
                name, size = port["name"], port["size"]
                per_state = not port["shared"] or (name == "p" and own)
                passed.append(f"{name} + {size} * part" if per_state else name)
                passed += [str(int(own))] if name == "p" else []
            rows.append({"prototype": prototypes[symbol], "form": "batch", "passed": passed})
    for symbol, own in ((symbols.soa, False), (symbols.soa_p, True)):
        if symbol:
            passed = ["count", "stride"]
            for port in ports:
                name = port["name"]
                per_state = not port["shared"] or (name == "p" and own)
                passed.append(f"{name} + part" if per_state else name)
                passed += [str(int(own))] if name == "p" else []
            rows.append({"prototype": prototypes[symbol], "form": "soa", "passed": passed})
    return rows
