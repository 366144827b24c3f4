"""Long functions in parts: read back as the one body they are, refused where a part or its traffic is changed."""

from __future__ import annotations

import ctypes
import random
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symgen.errors import CertificateError
from symgen.targets.c import Emitted, emit_c, read_back, split
from tests.targets.programs import COMPILERS, compile_library, info, pointer, random_program, solver
from tests.targets.test_read_back import certify, changed

OPERATIONS = ("add", "sub", "mul", "cos", "sin")


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(split, "LONGEST", 12)
    monkeypatch.setattr(split, "PART_LENGTH", 8)


def emitted(**options: object) -> Emitted:
    return emit_c("demo", [random_program(3, 150, OPERATIONS, "f"), solver()], info(**options))


OPTIONS: list[dict[str, object]] = [{}, {"status": True}, {"precision": "float"}, {"trigonometry": "libm"}]


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_guards_of_parts(short: None, options: dict[str, object]) -> None:
    program = random_program(4, 150, ("add", "sub", "mul", "div"), "g")
    guards = tuple(i for i, step in enumerate(program.instructions) if step.op == "div")
    found = emit_c("demo", [replace(program, guards=guards)], info(**options))
    assert "_part1(" in found.files["demo.c"] and "if (!(" in found.files["demo.c"]
    certify(found)
    assert read_back(found).functions["g"].guards


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_parts_are_one_body(short: None, options: dict[str, object]) -> None:
    found = emitted(**options)
    assert found.files["demo.c"].count("SYMGEN_PART void demo_f") >= 4
    certify(found)
    read = read_back(found)
    for function in found.functions:
        assert read.functions[function.program.name].operations == function.counts


def test_changed_traffic_is_refused(short: None) -> None:
    found = emitted()
    text = found.files["demo.c"]
    start = text.index("SYMGEN_PART void")
    changes = []
    for match in re.finditer(r"w\[(\d+)\](?: = \w+;|;)", text[start:]):
        place = start + match.start()
        changes.append(text[:place] + text[place:].replace(f"w[{match[1]}]", f"w[{int(match[1]) + 1}]", 1))
    for match in re.finditer(
        r"\n    (?:w\[\d+\] = \w+|const double \w+ = w\[\d+\]|demo_\w*part\d\([^)]*\));", text[start:]
    ):
        place = start + match.start()
        changes.append(text[:place] + text[place + len(match[0]) :])
        changes.append(text[:place] + match[0] + text[place:])
    for old, new in (
        (", w);", ", v);"),
        ("_part1(", "_part0("),
        ("double *w", "double *v"),
        ("const double x[4]", "double x[4]"),
    ):
        changes += [text[:start] + text[start:].replace(old, new, 1)]
    refused = 0
    for wrong in random.Random(1).sample(changes, min(120, len(changes))):
        if wrong != text:
            with pytest.raises(CertificateError):
                certify(changed(found, wrong))
            refused += 1
    assert refused > 40


@pytest.mark.parametrize("cc", COMPILERS)
def test_parts_compute_the_same(cc: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = []
    for name, longest in (("whole", 10**6), ("parts", 12)):
        monkeypatch.setattr(split, "LONGEST", longest)
        monkeypatch.setattr(split, "PART_LENGTH", 8)
        folder = tmp_path / name
        folder.mkdir()
        found = emitted()
        for file in ("demo.c", "demo.h"):
            (folder / file).write_text(str(found.files[file]))
        library = compile_library(folder, ["demo.c"], cc, ["-O1"])
        x, y = np.array([0.3, -0.2, 0.7, 1.1]), np.zeros(5)
        program = found.functions[0].program
        library.demo_f.restype = None
        arguments = [pointer(x) if port.name == "x" else ctypes.c_double(0.25) for port in program.inputs]
        library.demo_f(*arguments, pointer(y))
        values.append(y)
    assert np.array_equal(*values) and np.isfinite(values[0]).all() and values[0].any()
