"""Programs → CUDA: NAME.cuh with functions of one state for any kernel, NAME.cu with kernels over many states.

The statements are those of the C functions, and are read back as they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from symgen.errors import SceneError
from symgen.program.instructions import Counts, Port, Program
from symgen.targets.c.comments import comment_lines
from symgen.targets.c.emit import banner_lines, c_functions, without_empty_outputs
from symgen.targets.c.info import Info
from symgen.targets.c.literals import PRECISIONS, Constant, ConstantTable, Precision, constant_table
from symgen.targets.c.names import HELPERS, Names
from symgen.targets.c.signatures import SHARED, declaration, returns_status
from symgen.targets.c.statements import Body, write_body
from symgen.targets.c.templates import render
from symgen.targets.cuda.helpers import device_functions

CONSTANT_BYTES = 3840
"""Parameters that all states share are an argument of kernels, which may have 4 KB; longer ones come per state only."""


@dataclass(frozen=True)
class CudaFunction:
    """What became of one program."""

    program: Program
    """As emitted: without empty outputs."""
    name: str
    """Of the function of one state."""
    launches: Mapping[str, str]
    """Form (cuda, cuda_p, cuda_soa, cuda_soa_p) → host function; empty where there is no state to run over."""
    body: Body
    counts: Counts


@dataclass(frozen=True)
class EmittedCuda:
    """Files by name, and what a reader of them must know."""

    name: str
    info: Info
    files: Mapping[str, str]
    sources: tuple[str, ...]
    headers: tuple[str, ...]
    functions: tuple[CudaFunction, ...]
    table: ConstantTable
    notes: tuple[str, ...]

    @property
    def space(self) -> str:
        """The namespace of the functions of one state."""
        return f"{self.name}_device{PRECISIONS[self.info.options.precision].symbol_suffix}"

    @property
    def constants(self) -> Mapping[str, Fraction]:
        """Every named constant and the rational it stands for."""
        return {constant.name: constant.value for constant in self.used_constants()}

    def used_constants(self) -> list[Constant]:
        words = {word for function in self.functions for word in function.body.words}
        return [constant for constant in self.table if constant.name in words]


def emit_cuda(name: str, programs: Sequence[Program], info: Info) -> EmittedCuda:
    """NAME.cuh and NAME.cu. Raises SceneError where two functions would have one name, NotSupportedError where a
    constant does not fit the precision."""
    precision = PRECISIONS[info.options.precision]
    kept, notes = without_empty_outputs(programs)
    long = info.parameter_count * (8 if precision.name == "double" else 4) > CONSTANT_BYTES
    if long:
        notes.append("left out, because kernels take at most 4 KB: forms with one p for all states")
    info = replace(info, notes=(*info.notes, *notes))
    launches = _launches(name, kept, precision, shared_p=not long)
    taken = Names([*HELPERS, *_WORDS, *(program.name for program in kept)])
    for program in kept:
        taken.take(f"{name}_{program.name}")
    table = constant_table(kept, precision, taken)
    functions = c_functions(info.options.trigonometry, precision)
    rows = []
    for program, forms in zip(kept, launches, strict=True):
        body = write_body(program, table, functions, taken.taken)
        rows.append(CudaFunction(program, f"{name}_{program.name}", forms, body, body.counts))
    emitted = EmittedCuda(name, info, {}, (f"{name}.cu",), (f"{name}.cuh",), tuple(rows), table, tuple(notes))
    bodies = [body_text(emitted, row) for row in rows]
    files = {
        f"{name}.cuh": device_text(emitted, bodies, constants_text(emitted)),
        f"{name}.cu": kernels_text(emitted),
    }
    return replace(emitted, files=files)


_WORDS = ("input", "output", "parameters", "copied", "too_many", "blocks", "step", "stride", "failed", "stream")


def _launches(name: str, programs: Sequence[Program], precision: Precision, shared_p: bool) -> list[dict[str, str]]:
    """Per program: form → symbol of the function that launches it."""
    rows: list[dict[str, str]] = []
    owner: dict[str, str] = {}
    for program in programs:
        stem, suffix = f"{name}_{program.name}", precision.symbol_suffix
        found: dict[str, str] = {}
        if any(port.name not in SHARED for port in program.inputs):
            with_p = any(port.name == "p" for port in program.inputs)
            forms = ["cuda", "cuda_soa"] if shared_p or not with_p else []
            forms += ["cuda_p", "cuda_soa_p"] if with_p else []
            found = {form: f"{stem}_{form}{suffix}" for form in forms}
        for symbol in found.values():
            if symbol in owner:
                raise SceneError(f"{program.name} and {owner[symbol]} both need the function {symbol}", "outputs")
            owner[symbol] = program.name
        rows.append(found)
    return rows


def body_text(emitted: EmittedCuda, function: CudaFunction) -> str:
    """What stands between the braces of a function of one state: the text of the C function."""
    precision, options = PRECISIONS[emitted.info.options.precision], emitted.info.options
    zero, nan = f"0.0{precision.literal_suffix}", "NAN" if precision.name == "float" else "(double)NAN"
    return render(
        "cuda/body.j2",
        body=function.body,
        guard=" && ".join(f"{text} > {zero}" for text in function.body.guards),
        outputs=[(port.name, port.size) for port in function.program.outputs],
        nan=nan,
        status=returns_status(function.program, options.status),
    )


def constants_text(emitted: EmittedCuda) -> str:
    """The table of named constants."""
    real = PRECISIONS[emitted.info.options.precision].c_type
    return render("cuda/constants.j2", real=real, constants=emitted.used_constants())


def device_text(emitted: EmittedCuda, bodies: Sequence[str], constants: str) -> str:
    """NAME.cuh with these bodies and this table of constants."""
    info, precision = emitted.info, PRECISIONS[emitted.info.options.precision]
    called = {function for row in emitted.functions for function in row.body.called}
    helpers = device_functions(precision.name, info.options.trigonometry, called)
    macro = emitted.name.upper()
    rows = []
    for function, body in zip(emitted.functions, bodies, strict=True):
        arguments = [
            f"{precision.c_type} {port.name}" if port.shape == () else f"const Symgen{k} &{port.name}"
            for k, port in enumerate(function.program.inputs)
        ]
        count = len(arguments)
        arguments += [f"const Symgen{count + k} &{port.name}" for k, port in enumerate(function.program.outputs)]
        rows.append(
            {
                "comment": _described(function),
                "name": function.name,
                "types": [f"class Symgen{k}" for k, text in enumerate(arguments) if "&" in text],
                "arguments": arguments,
                "result": "int" if returns_status(function.program, info.options.status) else "void",
                "body": body,
                "prototypes": [_prototype(emitted, function, form) for form in function.launches],
            }
        )
    return render(
        "cuda/device.cuh.j2",
        banner=[*banner_lines(emitted.name, info), "", *_HELD],
        guard=f"SYMGEN_{macro}{precision.symbol_suffix.upper()}_CUH",
        macro=macro,
        nq=info.nq,
        nv=info.nv,
        np=info.parameter_count,
        math=bool(called) or any(row.program.guards for row in emitted.functions),
        stdint="uint64_t" in helpers,
        space=emitted.space,
        helpers=helpers,
        constants=constants.rstrip("\n"),
        functions=rows,
    )


def _described(function: CudaFunction) -> list[str]:
    """The comment above a function."""
    program, counts = function.program, function.counts
    work = {name: getattr(counts, name) for name in ("add", "mul", "div", "sqrt", "sincos")}
    performed = ", ".join(f"{n} {what}" for what, n in work.items() if n) or "none"
    lines = [
        f"{program.name}: {program.summary}" if program.summary else program.name,
        f"Plan: {program.plan}. Operations: {performed}." if program.plan else f"Operations: {performed}.",
    ]
    if program.guards:
        lines.append("Where there is no answer (a pivot that is not positive), every output is NaN.")
    return comment_lines(lines)


_HELD = (
    "SI units, radians. Matrices are row-major.",
    "Functions that launch: n states, one thread each; arrays lie in the memory of the device and may not overlap.",
    "cuda: states one after the other; cuda_soa: entry k of state i at [k * stride + i], which is faster; _p: p per",
    "state too. A p for all states, and dt, are read on the host before the launch returns. The result is a",
    "cudaError_t, 0 for none; nothing is waited for.",
)


def _prototype(emitted: EmittedCuda, function: CudaFunction, form: str) -> str:
    """Of the host function that launches one form."""
    real = PRECISIONS[emitted.info.options.precision].c_type
    arguments = ["size_t n", *(["size_t stride"] if "soa" in form else [])]
    for port in function.program.inputs:
        if port.shape == ():
            arguments.append(f"{real} {port.name}")
        else:
            shared = port.name == "p" and not form.endswith("_p")
            arguments.append(f"const {real} {port.name}[{port.size}]" if shared else f"const {real} *{port.name}")
    arguments += [f"{real} *{port.name}" for port in function.program.outputs]
    arguments += ["int *failed"] if returns_status(function.program, emitted.info.options.status) else []
    return declaration("int", function.launches[form], [*arguments, "struct CUstream_st *stream"])


def kernels_text(emitted: EmittedCuda) -> str:
    """NAME.cu."""
    info, precision = emitted.info, PRECISIONS[emitted.info.options.precision]
    kernels, entries = [], []
    for function in emitted.functions:
        for own in (False, True):
            forms = [form for form in function.launches if form.endswith("_p") == own]
            if forms:
                kernels.append(_kernel(emitted, function, own))
                entries += [_entry(emitted, function, form) for form in forms]
    shared = any(kernel["shared_p"] for kernel in kernels)
    return render(
        "cuda/kernels.cu.j2",
        banner=banner_lines(emitted.name, info),
        header=emitted.headers[0],
        real=precision.c_type,
        shared=info.parameter_count if shared else 0,
        space=emitted.space,
        kernels=kernels,
        entries=entries,
    )


def _kernel(emitted: EmittedCuda, function: CudaFunction, own: bool) -> dict[str, Any]:
    program = function.program
    real = PRECISIONS[emitted.info.options.precision].c_type
    status = returns_status(program, emitted.info.options.status)
    arguments, passed, ports = ["size_t n", "size_t step"], [], []

    def per_state(port: Port, kind: str) -> None:
        ports.append({"name": port.name, "size": port.size, "kind": kind})
        passed.append(f"{port.name}_i")

    for port in program.inputs:
        if port.shape == ():
            arguments.append(f"{real} {port.name}")
            passed.append(port.name)
        elif port.name == "p" and not own:
            arguments.append("const parameters p")
            passed.append("p")
        else:
            arguments.append(f"const {real} *__restrict__ {port.name}")
            per_state(port, "input")
    for port in program.outputs:
        arguments.append(f"{real} *__restrict__ {port.name}")
        per_state(port, "output")
    return {
        "name": f"{function.name}_each{'_p' if own else ''}",
        "function": function.name,
        "arguments": [*arguments, *(["int *failed"] if status else [])],
        "passed": passed,
        "ports": ports,
        "status": status,
        "shared_p": "p" in passed,
    }


def _entry(emitted: EmittedCuda, function: CudaFunction, form: str) -> dict[str, Any]:
    own = form.endswith("_p")
    passed = ["n", "stride" if "soa" in form else "(size_t)0"]
    for port in function.program.inputs:
        passed.append("copied(p)" if port.name == "p" and not own else port.name)
    passed += [port.name for port in function.program.outputs]
    passed += ["failed"] if returns_status(function.program, emitted.info.options.status) else []
    return {
        "prototype": _prototype(emitted, function, form),
        "kernel": f"{function.name}_each{'_p' if own else ''}",
        "passed": passed,
    }
