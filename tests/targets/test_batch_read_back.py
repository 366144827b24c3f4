"""Batches read back: what is emitted passes, every mutation is refused."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from symgen.errors import CertificateError
from symgen.generate import generate_files
from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port
from symgen.scene.load import load
from symgen.system import derive
from symgen.targets.c import Emitted, emit_c, read_back
from tests.targets.batches import certify, programs, wide
from tests.targets.programs import all_programs, arm, info, solver
from tests.targets.test_read_back import changed

OPTIONS = [{}, {"precision": "float", "status": True}, {"trigonometry": "libm"}]


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_what_is_emitted_passes(options: dict[str, Any]) -> None:
    emitted = emit_c("demo", [*all_programs(), wide()], info(batch=True, **options))
    certify(emitted)
    read = read_back(emitted)
    for function in emitted.functions:
        if function.symbols.batch:
            assert read.vectors[function.program.name].operations == function.counts


def body_mutants(text: str) -> Iterator[str]:
    """Every single change, of many kinds, to the statements over vectors."""
    changes: dict[str, Sequence[str]] = {
        r"(?<![\w.])\d+\.\d+(?:e-?\d+)?": ("7.25", "7"),
        r"(?<= )\+(?= )": ("-", "*", "=="),
        r"(?<= )-(?= )": ("+", "/", "--"),
        r"(?<= )\*(?= )": ("/", "+", "&", "%"),
        r"(?<== )-": ("", "~"),
        r"\b(?:IN|TILE)\((?=[a-z])": ("OUT(", "", "SPLAT(", "("),
        r"\bIN\(": ("TILE(",),
        r"\bTILE\(": ("IN(",),
        r"\bOUT\(": ("IN(", "TILE("),
        r"\bSPLAT\(": ("IN(", "COS("),
        r"(?<=, )\d+(?=\))": ("99", "i", "-1"),
        r"(?<=\()q(?=, )": ("p", "v", "M"),
        r"\bk1\b": ("k2", "k999", "1.0"),
        r"\bt1\b": ("t2", "slow_lanes", "q"),
        r"\bCOS\(": ("SIN(", "cos(", "cosine("),
        r"\bSQRT\(": ("COS(", "sqrt("),
        r"SINES_COSINES_\d\(": ("sine_cosine(", "COS(", "SINES_COSINES_1(", "SINES_COSINES_2(", "SINES_COSINES_6("),
        r"(?<=reals )(\w+), (\w+)": ("sin_q0, sin_q0", "a, b", "a", r"sin_q0, cos_q0, x"),
        r"&(\w+), &(\w+)": ("&sin_q0, &sin_q0", "0, 0", "&cos_q0, &sin_q0"),
        r"(?<=\w, )IN\(q, 1\), &": ("IN(q, 2), &", "&"),
        r"REQUIRE\(": ("SQRT(", "(void)("),
        r"\n    REQUIRE[^;]*;": ("", "\n    REQUIRE(1.0);"),
        r"\n    const reals \w+ = [^;]*;": ("",),
        r"\n    OUT[^;]*;": ("", "\n    slow_lanes = 1;", "\n    return 0;", "\n    if (n) return 0;"),
        r"const reals": ("reals", "const words", "const double", "static const reals"),
        r";(?=\n)": (",", "; ;", " #x;"),
    }
    bodies = [m.span(1) for m in re.finditer(r"\(void\)lane_step;\n(.*?)    SYMGEN_IN_MEMORY", text, re.DOTALL)]
    assert len(bodies) == 3
    comments = [match.span() for match in re.finditer(r"/\*.*?\*/", text, re.DOTALL)]
    for pattern, news in changes.items():
        found = 0
        for match in re.finditer(pattern, text):
            inside = any(a - 1 <= match.start() and match.end() <= b for a, b in bodies)
            if not inside or any(a <= match.start() < b for a, b in comments):
                continue
            for new in news:
                if new != match[0]:
                    found += 1
                    yield text[: match.start()] + new + text[match.end() :]
        assert found, pattern


@pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.slow)])
def test_mutated_statements_are_refused(every: int) -> None:
    emitted = emit_c("demo", [arm(), solver(), wide()], info(batch=True))
    text = emitted.files["demo_batch.c"]
    for mutant in list(body_mutants(text))[::every]:
        try:
            certify(changed(emitted, mutant, "demo_batch.c"))
        except CertificateError:
            continue
        where = next(k for k, (a, b) in enumerate(zip(text, mutant, strict=False)) if a != b)
        raise AssertionError(f"not caught: {mutant[max(0, where - 80) : where + 80]!r}")


@pytest.mark.parametrize("status", [False, True])
def test_mutated_frames_are_refused(status: bool) -> None:
    """Any number, name or operator outside the statements: it is compared with what it must be."""
    emitted = emit_c("demo", [arm(), solver()], info(batch=True, status=status))
    text = emitted.files["demo_batch.c"]
    start = text.index("#ifdef SYMGEN_LANES")
    comments = [match.span() for match in re.finditer(r"/\*.*?\*/", text, re.DOTALL)]
    bodies = [m.span(1) for m in re.finditer(r"\(void\)lane_step;\n(.*?)    SYMGEN_IN_MEMORY", text, re.DOTALL)]
    words = list(re.finditer(r"\w+|[-+*/<>=&|!~?,;(){}\[\]#\"]", text))
    checked = 0
    for match in words[status::29]:
        if match.start() < start or any(a <= match.start() < b for a, b in [*comments, *bodies]):
            continue
        mutant = text[: match.start()] + ("x" if match[0] != "x" else "y") + text[match.end() :]
        with pytest.raises(CertificateError):
            read_back(changed(emitted, mutant, "demo_batch.c")).check_literals()
        checked += 1
    assert checked > 80
    for mutant in (text + "int x;\n", text.replace('"demo.h"', '"other.h"'), f"int x;\n{text}"):
        with pytest.raises(CertificateError):
            read_back(changed(emitted, mutant, "demo_batch.c"))


def test_header_of_batches_is_checked() -> None:
    emitted = emit_c("demo", [arm(), solver()], info(batch=True))
    header = emitted.files["demo.h"]
    for old, new in (
        ("demo_mass_matrix_batch(size_t n, ", "demo_mass_matrix_batch(int n, "),
        ("_soa(size_t n, size_t stride", "_soa(size_t stride, size_t n"),
        ("_batch_p(", "_batch_q("),
    ):
        assert old in header
        with pytest.raises(CertificateError):
            read_back(changed(emitted, header.replace(old, new, 1), "demo.h"))


def test_files_of_a_long_batch_may_not_change_places(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symgen.targets.c.batch.LINES_PER_FILE", 5)
    emitted = emit_c("demo", programs(), info(batch=True))
    moved = replace(emitted, files={**emitted.files, "demo_batch_1.c": emitted.files["demo_batch_2.c"]})
    with pytest.raises(CertificateError):
        read_back(moved)


def test_generation_refuses_wrong_vectors(monkeypatch: pytest.MonkeyPatch) -> None:
    """One sign in the statements over vectors, the scalar file as it should be."""
    scene = load(Path(__file__).parents[2] / "examples/double_pendulum.scene.yaml")
    scene = replace(scene, options=replace(scene.options, batch=True, targets=("c",)))

    def tampered(*arguments: Any) -> Emitted:
        emitted = emit_c(*arguments)
        text = emitted.files["double_pendulum_batch.c"]
        line = next(line for line in text.splitlines() if line.startswith("    OUT(M, 0) = "))
        assert " + " in line
        return changed(emitted, text.replace(line, line.replace(" + ", " - ")), "double_pendulum_batch.c")

    generated = generate_files(derive(scene), lambda done, total, what: None)
    assert "(C, C on vectors)" in generated.certificates["mass_matrix"].method
    monkeypatch.setattr(sys.modules["symgen.generate"], "emit_c", tampered)  # symgen.generate is the function
    with pytest.raises(CertificateError, match="the emitted C on vectors is not mass_matrix"):
        generate_files(derive(scene), lambda done, total, what: None)


def test_a_guard_may_be_an_argument_itself() -> None:
    """As where the mass of the last, sliding body is a run-time parameter."""
    graph = Graph()
    tau, p = graph.inputs("tau", 2), graph.inputs("p", 4)
    ports = (Port("tau", (2,)), Port("p", (4,))), (Port("a", (1,)),)
    program = extract(graph, "forward_dynamics", *ports, [[tau[0] / p[3]]], [p[3]])
    emitted = emit_c("demo", [program], info(batch=True))
    read_back(emitted)
    assert "REQUIRE(TILE(p, 3))" in emitted.files["demo_batch.c"]
