"""From a scene to certified files: derive, emit, read back, certify, write."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from symgen.algebra.field import FieldNumbers
from symgen.artifact import (
    Artifact,
    FunctionRecord,
    build_manifest,
    check_target,
    manifest_text,
    write_artifact,
)
from symgen.certificate import Candidate, Certificate, Certifier
from symgen.errors import CertificateError, ToolError
from symgen.integrators.certify import certify_step
from symgen.loops.choose import Code
from symgen.loops.read import ReadLoops
from symgen.program.composed import ComposedProgram
from symgen.program.evaluate import Residues, evaluate_in_field, remembered_residues
from symgen.program.instructions import Program
from symgen.program.memory import uncollected
from symgen.scene.load import load
from symgen.scene.model import Output, Scene
from symgen.system import System, derive
from symgen.targets.c import Info, JointRow, ReadFunction, emit_c, read_back
from symgen.targets.c.read_back import Read
from symgen.targets.c.sincos import enclosure
from symgen.targets.cuda import emit_cuda, read_cuda
from symgen.version import VERSION

if TYPE_CHECKING:
    import casadi

SCALAR, VECTORS, THREADS = "C", "C on vectors", "CUDA"
"""What a certificate calls what was emitted."""

Progress = Callable[[int, int, str], None]
"""``progress(done, total, what)``."""


@dataclass(frozen=True)
class Generated:
    """Everything that will be written, certified."""

    files: Mapping[str, str | bytes]
    certificates: Mapping[str, Certificate]
    """By function name."""


def generate(
    scene: Scene | str | Path, out_dir: str | Path, progress: Progress | None = None, system: System | None = None
) -> Artifact:
    """Generate what ``scene`` asks for into the folder ``out_dir`` (see interface: C, CasADi, manifest).

    ``system``: the derived system of the scene, if there is one already. Raises SceneError for a bad scene or folder,
    NotSupportedError for what cannot be generated, CertificateError when a function is not the literal one; nothing is
    written then.
    """
    scene = load(scene) if isinstance(scene, str | Path) else scene
    check_target(out_dir)
    system = system or derive(scene)
    generated = generate_files(system, progress or (lambda done, total, what: None))
    write_artifact(out_dir, generated.files)
    return Artifact(Path(out_dir))


@uncollected()
def generate_files(system: System, progress: Progress) -> Generated:
    """Derive, emit, read back and certify every output of a system."""
    outputs, targets = system.outputs, system.scene.options.targets
    total = 2 * len(outputs) + 1
    codes: list[Code] = []
    for output in outputs:
        system.require(output)
    for done, output in enumerate(outputs):
        progress(done, total, output.name)
        codes.append(system.code(output.name))
    programs = [code.program for code in codes]
    straight = [code.straight for code in codes if code.straight is not None]
    straight_of = {code.program.name: code.straight for code in codes}
    progress(len(outputs), total, "emit")
    info = replace(target_info(system), notes=tuple(code.note for code in codes if code.note))
    emitted = emit_c(system.scene.name, programs, info) if "c" in targets else None
    read = read_back(emitted) if emitted else None
    if read:
        read.check_literals()
    cuda = emit_cuda(system.scene.name, straight, info) if "cuda" in targets else None
    forms = {SCALAR: read.functions, VECTORS: read.vectors} if read else {}
    forms |= {THREADS: read_cuda(cuda)} if cuda else {}
    stored = _casadi_functions(system, codes) if "casadi" in targets else {}
    files: dict[str, str | bytes] = dict(emitted.files) if emitted else {}
    files.update(cuda.files if cuda else {})
    files.update({row.path: row.content for row in stored.values()})
    certifier = Certifier(system, "".join(repr(content) for content in files.values()))
    records: list[FunctionRecord] = []
    certificates: dict[str, Certificate] = {}
    for done, (output, code) in enumerate(zip(outputs, codes, strict=True)):
        program = code.program
        progress(len(outputs) + 1 + done, total, f"certify {output.name}")
        texts = {form: found[program.name] for form, found in forms.items() if program.name in found}
        function = stored.get(program.name)
        if not texts and function is None:
            continue  # all its outputs are empty: left out, as the header says
        in_casadi = function.read_back if function else None
        if isinstance(program, ComposedProgram):
            whole = read.functions if read else {}
            certificate = certify_step(certifier, output, program, whole, straight_of, in_casadi)
        else:
            certificate = _certify(certifier, output, code, texts, in_casadi)
        certificates[program.name] = certificate
        records.append(FunctionRecord(program, certificate.to_json(), function.path if function else None))
    progress(total, total, "write")
    files["manifest.json"] = manifest_text(build_manifest(system.scene.name, info, records, emitted, cuda))
    return Generated(files, certificates)


def target_info(system: System) -> Info:
    """What targets must know of a scene beside its programs."""
    joints = tuple(
        JointRow(
            body.joint.name,
            body.joint.type,
            (body.q, body.nq),
            (body.v, body.nv),
            body.joint.limits,
            body.joint.mimic,
        )
        for body in system.tree.bodies
    )
    scene = system.scene
    return Info(
        nq=system.tree.nq,
        nv=system.tree.nv,
        joints=joints,
        parameters=scene.parameters,
        options=scene.options,
        scene_sha256=scene.sha256,
        version=VERSION,
    )


@dataclass(frozen=True)
class _Stored:
    """A casadi.Function as its file will hold it."""

    path: str
    content: bytes
    read_back: casadi.Function
    """What ``casadi.Function.load`` makes of the content."""


def _casadi_functions(system: System, codes: Sequence[Code]) -> dict[str, _Stored]:
    """By program name; none for functions whose outputs are all empty, or that would be too long."""
    import casadi

    found: dict[str, _Stored] = {}
    programs = {code.program.name: code.straight for code in codes}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "f.casadi"
        for code in codes:
            program = code.program
            made = _casadi_function(code, programs) if any(port.size for port in program.outputs) else None
            if made is not None:
                path = f"{system.scene.name}.casadi/{program.name}.casadi"
                try:
                    made.save(str(file))
                    found[program.name] = _Stored(path, file.read_bytes(), casadi.Function.load(str(file)))
                except RuntimeError as error:  # what CasADi does not say where it writes, it says where it reads
                    reason = str(error).strip().rpartition("\n")[2]
                    raise ToolError(
                        f"CasADi cannot save {program.name} in {folder} : {reason} (no space left?)"
                    ) from None
    return found


def _casadi_function(code: Code, programs: Mapping[str, Program | None]) -> casadi.Function | None:
    """None where it, or what it calls, has no straight-line form."""
    from symgen.integrators.casadi import casadi_step
    from symgen.targets.casadi import casadi_function

    if not isinstance(code.program, ComposedProgram):
        return casadi_function(code.straight) if code.straight is not None else None
    callees = {row: program for row in code.program.callees if (program := programs[row]) is not None}
    return casadi_step(code.program, callees) if len(callees) == len(code.program.callees) else None


def _certify(
    certifier: Certifier,
    output: Output,
    code: Code,
    texts: Mapping[str, Read],
    function: casadi.Function | None,
) -> Certificate:
    """Certify everything that was emitted for one function. ``texts``: form → its statements, read back."""
    values = remembered_residues(code.straight) if code.straight is not None else None
    candidates = _c_candidates(texts, code, values)
    remarks = _remarks(next(iter(texts.values())), certifier.system) if texts else ""
    if function is not None and code.straight is not None:
        candidates.append(_casadi_candidate(function, code.straight, values))
    if code.straight is not None:
        candidates += [_program_candidate(other) for other in certifier.system.others(output.name)]
    certificate = certifier.certify(output, code.program, candidates, code.straight)
    return Certificate(
        certificate.method + remarks,
        certificate.checked_against,
        certificate.points,
        certificate.failure_probability,
    )


def _c_candidates(texts: Mapping[str, Read], code: Code, values: Residues | None) -> list[Candidate]:
    """One candidate for all forms that are, once read, word for word the same."""
    groups: list[tuple[Read, list[str]]] = []
    for form, text in texts.items():
        same = next((forms for other, forms in groups if other == text), None)
        if same is None:
            groups.append((text, [form]))
        else:
            same.append(form)
    return [_candidate(text, code, ", ".join(forms), values) for text, forms in groups]


def _candidate(text: Read, code: Code, what: str, values: Residues | None) -> Candidate:
    if isinstance(text, ReadLoops):
        return Candidate(
            f"{what} in loops", lambda numbers, inputs: text.evaluate_mod(numbers.p, inputs, numbers.apply)
        )
    assert code.straight is not None and isinstance(text, ReadFunction)
    return _c_candidate(text, code.straight, what, values)


def _c_candidate(text: ReadFunction, program: Program, what: str, known: Residues | None = None) -> Candidate:
    values = known or remembered_residues(program)

    def evaluate(numbers: FieldNumbers, inputs: Mapping[str, Sequence[int]]) -> Mapping[str, Sequence[int]]:
        outputs, guards = text.outputs_and_guards_mod(numbers.p, inputs, numbers.apply)
        if program.guards:
            expected = values(numbers, inputs)
            if guards != [expected[i] for i in program.guards]:
                raise CertificateError(f"{program.name}: the emitted C does not guard the pivots")
        return outputs

    return Candidate(what, evaluate)


def _casadi_candidate(function: casadi.Function, program: Program, known: Residues | None = None) -> Candidate:
    from symgen.targets.casadi import evaluate_mod, listing

    instructions, values = listing(function), known or remembered_residues(program)

    def evaluate(numbers: FieldNumbers, inputs: Mapping[str, Sequence[int]]) -> Mapping[str, Sequence[int]]:
        return evaluate_mod(function, program, numbers, inputs, instructions, values(numbers, inputs))

    return Candidate("CasADi", evaluate)


def _program_candidate(program: Program) -> Candidate:
    """A program as it stands: another derivation of the same function."""
    return Candidate(f"its {program.plan} plan", partial(evaluate_in_field, program), emitted=False)


def _remarks(text: Read, system: System) -> str:
    """What of the C is proven otherwise: its constants, and its sine and cosine."""
    remarks = "; C constants proven correctly rounded"
    options = system.scene.options
    if text.operations.sincos and options.trigonometry == "polynomial":
        bounds = enclosure(options.precision)
        error = float(max(bounds.sine, bounds.cosine))
        remarks += f"; sine and cosine by enclosure, relative error of the polynomials at most {error:.1e}"
    elif text.operations.sincos:
        remarks += "; sine and cosine are the C library's"
    return remarks


__all__ = ["Generated", "Progress", "generate", "generate_files", "target_info"]
