"""CUDA read back: what is emitted passes, every mutation is refused."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from symgen.algebra.field import NotInField, Residue
from symgen.errors import CertificateError
from symgen.generate import generate_files
from symgen.program.evaluate import evaluate_all
from symgen.program.instructions import Program
from symgen.scene.load import load
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request
from symgen.system import derive
from symgen.targets.c import emit_c, read_back
from symgen.targets.cuda import EmittedCuda, emit_cuda, read_cuda
from tests.targets.batches import wide
from tests.targets.programs import all_programs, arm, info, solver
from tests.targets.test_read_back import expected, point

PENDULUM = Path(__file__).parents[2] / "examples/double_pendulum.scene.yaml"
GOLDEN = Path(__file__).parent / "golden"


def certify(emitted: EmittedCuda) -> None:
    """What a certificate does with the functions of one state; raises CertificateError."""
    read = read_cuda(emitted)
    for function in emitted.functions:
        program, text = function.program, read[function.program.name]
        numbers, inputs = point(program)
        try:
            found = text.evaluate_mod(numbers.p, inputs, numbers.apply)
            guards = text.guards_mod(numbers.p, inputs, numbers.apply)
        except NotInField:
            raise CertificateError("no value") from None
        every = evaluate_all(program, numbers, {k: [Residue(x, numbers.p) for x in row] for k, row in inputs.items()})
        if found != expected(program, numbers, inputs) or guards != [every[i].x for i in program.guards]:
            raise CertificateError(f"{program.name} differs")


OPTIONS = [{}, {"precision": "float", "status": True}, {"trigonometry": "libm"}]


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_what_is_emitted_passes(options: dict[str, Any]) -> None:
    programs: list[Program] = [*all_programs(), wide()]
    emitted = emit_cuda("demo", programs, info(**options))
    certify(emitted)
    scalar, read = read_back(emit_c("demo", programs, info(**options))).functions, read_cuda(emitted)
    assert set(scalar) == set(read)
    assert all(read[name].operations == scalar[name].operations for name in read)


CHANGES: dict[str, Sequence[str]] = {
    r"(?<![\w.])\d+\.\d+(?:e-?\d+)?": ("7.25", "7"),
    r"(?<= )\+(?= )": ("-", "*"),
    r"(?<= )-(?= )": ("+", "/", "--"),
    r"(?<= )\*(?= )": ("/", "+", "%"),
    r"\bq\[\d": ("q[9", "p[1", "q[i", "*q"),
    r"\bk1\b": ("k2", "k999"),
    r"&(\w+), &(\w+)": ("&sin_q0, &sin_q0", "0, 0"),
    r"(?<=\n)    M\[0\]": ("    M[1]", "    if (q[0] > 0.0) M[0]", "    threadIdx", "    return; M[0]"),
    r"if \(!\(": ("if ((", "if (!(1.0 + "),
    r"NAN": ("0", "INFINITY"),
    r"const double": ("double", "static const double", "const float"),
    r";(?=\n)": (",", "; ;", " #x;", "; // x"),
}
WORD = re.compile(r"\w+|[-+*/<>=&|!~?,;(){}\[\]#\"]")


def mutants(text: str) -> Iterator[str]:
    comments = [match.span() for match in re.finditer(r"/\*.*?\*/", text, re.DOTALL)]
    start = text.index("/* Constants that no short decimal")
    for pattern, news in CHANGES.items():
        found = 0
        for match in re.finditer(pattern, text):
            if match.start() < start or any(a <= match.start() < b for a, b in comments):
                continue
            for new in news:
                if new != match[0]:
                    found += 1
                    yield text[: match.start()] + new + text[match.end() :]
        assert found, pattern


def refused(emitted: EmittedCuda, file: str, text: str) -> None:
    try:
        certify(replace(emitted, files={**emitted.files, file: text}))
    except CertificateError:
        return
    old = emitted.files[file]
    where = next((k for k, (a, b) in enumerate(zip(old, text, strict=False)) if a != b), len(old))
    raise AssertionError(f"not caught: {text[max(0, where - 80) : where + 80]!r}")


@pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.slow)])
def test_mutated_statements_are_refused(every: int) -> None:
    emitted = emit_cuda("demo", [arm(), solver(), wide()], info())
    for mutant in list(mutants(emitted.files["demo.cuh"]))[::every]:
        refused(emitted, "demo.cuh", mutant)


@pytest.mark.parametrize("file", ["demo.cu", "demo.cuh"])
def test_mutated_frames_are_refused(file: str) -> None:
    """Any number, name or operator outside the statements, comments too."""
    emitted = emit_cuda("demo", [arm(), solver()], info(status=True))
    text = emitted.files[file]
    end = text.index("\n    double ") if file == "demo.cuh" else len(text)
    words = [match for match in WORD.finditer(text) if match.end() < end]
    for match in words[::13]:
        refused(emitted, file, text[: match.start()] + ("x" if match[0] != "x" else "y") + text[match.end() :])
    for mutant in (text + "int x;\n", f"int x;\n{text}", ""):
        refused(emitted, file, mutant)


def test_generation_refuses_wrong_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """One sign in the statements of a thread, the C as it should be."""
    scene = request(load(PENDULUM), parse_outputs("mass_matrix"), targets=("c", "cuda"))
    generated = generate_files(derive(scene), lambda done, total, what: None)
    assert "(C, CUDA)" in generated.certificates["mass_matrix"].method

    def tampered(*arguments: Any) -> EmittedCuda:
        emitted = emit_cuda(*arguments)
        text = emitted.files["double_pendulum.cuh"]
        line = next(line for line in text.splitlines() if line.startswith("    M[0] = "))
        assert " + " in line
        return replace(
            emitted,
            files={**emitted.files, "double_pendulum.cuh": text.replace(line, line.replace(" + ", " - "))},
        )

    monkeypatch.setattr(sys.modules["symgen.generate"], "emit_cuda", tampered)  # symgen.generate is the function
    with pytest.raises(CertificateError, match="the emitted CUDA is not mass_matrix"):
        generate_files(derive(scene), lambda done, total, what: None)


@pytest.mark.parametrize("file", ["double_pendulum.cu", "double_pendulum.cuh"])
def test_golden(file: str, golden: Callable[[Path, str], None]) -> None:
    scene = request(load(PENDULUM), parse_outputs("mass_matrix,forward_dynamics"), targets=("cuda",))
    generated = generate_files(derive(scene), lambda done, total, what: None)
    text = generated.files[file]
    assert isinstance(text, str)
    golden(GOLDEN / f"{file}.txt", text)
