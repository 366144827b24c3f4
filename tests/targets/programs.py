"""Small programs made by hand and at random, and what the tests do with them: emit, compile, call."""

from __future__ import annotations

import ctypes
import random
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from shutil import which
from typing import Any

import pytest

from symgen.program.graph import Graph, extract
from symgen.program.instructions import Instruction, Port, Program
from symgen.scene.model import Options, Parameter
from symgen.targets.c import Emitted, Info, JointRow, emit_c

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-Wshadow", "-Wdouble-promotion"]
COMPILERS = [
    pytest.param(cc, marks=pytest.mark.skipif(which(cc) is None, reason=f"no {cc}")) for cc in ("gcc", "clang")
]

PARAMETERS = (
    Parameter("link.mass", (Fraction(6, 5),), "kg", 0),
    Parameter("link.com", (Fraction(1, 10), Fraction(0), Fraction(1, 3)), "m", 1),
)


def info(**options: Any) -> Info:
    """Facts of a two-joint scene with four parameters."""
    return Info(
        nq=2,
        nv=2,
        joints=(JointRow("j1", "revolute", (0, 1), (0, 1)), JointRow("j2", "revolute", (1, 1), (1, 1))),
        parameters=PARAMETERS,
        options=Options(**options),
        scene_sha256="0" * 64,
        version="0.1.0",
    )


Q, V, TAU, DT, P = (
    Port("q", (2,), "rad"),
    Port("v", (2,), "rad/s"),
    Port("tau", (2,), "N·m"),
    Port("dt", (), "s"),
    Port("p", (4,)),
)


def arm() -> Program:
    """Mass matrix of a planar two-link arm: pairs, shared entries, long constants, parameters."""
    g = Graph()
    q, p = g.inputs("q", 2), g.inputs("p", 4)
    with g.phase("angles"):
        c1, s1 = g.cos(q[0]), g.sin(q[0])
        c2, s2 = g.cos(q[0] + q[1]), g.sin(q[0] + q[1])
        g.name_scalar("cos_elbow", c2)
    with g.phase("mass matrix"):
        coupling = p[0] * (c1 * c2 + s1 * s2) * Fraction(1, 3) - p[1] * Fraction(2, 7)
        diagonal = (coupling + Fraction(5, 4)) * (coupling - p[2]) + p[3] * p[3] * Fraction(1, 3)
        rows = [diagonal, coupling, coupling, g.const(Fraction(-1, 3))]
    return extract(g, "mass_matrix", (Q, P), (Port("M", (2, 2), "kg·m²"),), [rows], plan="literal", summary="RᵀMR")


def solver() -> Program:
    """Forward dynamics of two masses: division, guards, a square root, negations."""
    g = Graph()
    q, v, tau, p = g.inputs("q", 2), g.inputs("v", 2), g.inputs("tau", 2), g.inputs("p", 4)
    pivot = p[0] * p[0] - q[0] * q[1] * Fraction(1, 7)
    distance = g.sqrt(q[0] * q[0] + q[1] * q[1] + Fraction(1, 100))
    g.name_scalar("distance", distance)
    force = -(distance - p[1]) * Fraction(10) - v[0] * Fraction(1, 30)
    a0 = (tau[0] + force / distance) / pivot
    a1 = (tau[1] - a0 * q[1] - (v[0] - v[1])) / (pivot + 1)
    return extract(
        g, "forward_dynamics", (Q, V, TAU, P), (Port("a", (2,), "rad/s²"), Port("f", ())), [[a0, a1], [-force]], [pivot]
    )


def rotation() -> Program:
    """A step of a rotation vector: entire functions, a scalar input by value, one cosine alone."""
    g = Graph()
    q, v, dt = g.inputs("q", 2), g.inputs("v", 2), g.input("dt", 0)
    x = (v[0] * v[0] + v[1] * v[1]) * dt * dt
    results = [q[0] + g.cos_sqrt(x) * v[0], g.sinc_sqrt(x) * dt - q[1], g.sinc3_sqrt(x), g.cos(q[1]) * g.sin(v[0])]
    return extract(g, "integrate", (Q, V, DT, P), (Port("q_next", (4,)),), [results])


def alone() -> Program:
    """One angle alone: both functions of it in one function, only one in another."""
    g = Graph()
    q = g.inputs("q", 2)
    return extract(g, "gravity_force", (Q, P), (Port("g", (2,)),), [[g.sin(q[0]) * q[1], g.cos(q[0]) - q[1]]])


def cosine() -> Program:
    g = Graph()
    q = g.inputs("q", 2)
    return extract(g, "potential_energy", (Q, P), (Port("V", ()),), [[g.cos(q[1]) * Fraction(5, 2)]])


def inverse() -> Program:
    """An output with the name of another function's input; an input of this name too."""
    g = Graph()
    q, a = g.inputs("q", 2), g.inputs("a", 2)
    return extract(g, "inverse_dynamics", (Q, Port("a", (2,)), P), (Port("tau", (2,)),), [[q[0] * a[0], a[1] + a[0]]])


def constant() -> Program:
    """No state among its inputs."""
    g = Graph()
    values = [g.const(Fraction(k, 3)) for k in range(16)]
    return extract(g, "natural_mass_matrix", (), (Port("Mn", (4, 4), "kg"),), [values])


def empty() -> Program:
    g = Graph()
    return extract(g, "constraints", (Q,), (Port("Psi", (0,)),), [[]])


def all_programs() -> list[Program]:
    return [arm(), solver(), rotation(), alone(), cosine(), inverse(), constant(), empty()]


def random_program(seed: int, size: int, operations: Sequence[str], name: str = "f", more: int = 0) -> Program:
    """Arithmetic at random over five inputs and awkward constants; no dead code. ``more`` outputs beyond five."""
    rng = random.Random(seed)
    code = [Instruction("input", value=("x", k)) for k in range(4)] + [Instruction("input", value=("dt", 0))]
    constants = (Fraction(1, 3), Fraction(-1, 3), Fraction(-5, 2), Fraction(7), Fraction(1, 10), Fraction(10**12, 7))
    code += [Instruction("const", value=value) for value in constants]
    for _ in range(size):
        op = rng.choice(operations)
        count = 1 if op not in ("add", "sub", "mul", "div") else 2
        recent = [rng.randrange(max(0, len(code) - 6), len(code)) if rng.random() < 0.7 else rng.randrange(len(code))]
        args = (*recent, rng.randrange(len(code)))[:count]
        label = rng.choice(["", "", "", "w_x", "t1", "x", "double", "k1"])
        phase = rng.choice(["one", "two */ \\"]) if rng.random() < 0.2 else ""
        code.append(Instruction(op, args, label=label, phase=phase))
    results = [len(code) - 1, len(code) - 2, len(code) - 2, rng.randrange(len(code)), rng.randrange(len(code))]
    results += [rng.randrange(len(code)) for _ in range(more)]
    return compact(
        Program(name, (Port("x", (4,)), Port("dt", ())), (Port("y", (len(results),)),), tuple(code), (tuple(results),))
    )


def compact(program: Program) -> Program:
    """Without dead code."""
    live: set[int] = set()
    stack = [index for row in program.results for index in row] + list(program.guards)
    while stack:
        index = stack.pop()
        if index not in live:
            live.add(index)
            stack.extend(program.instructions[index].args)
    place = {index: k for k, index in enumerate(sorted(live))}
    old = program.instructions
    kept = tuple(
        Instruction(old[i].op, tuple(place[a] for a in old[i].args), old[i].value, old[i].label, old[i].phase)
        for i in sorted(live)
    )
    results = tuple(tuple(place[i] for i in row) for row in program.results)
    return replace(program, instructions=kept, results=results, guards=tuple(place[i] for i in program.guards))


def write_files(emitted: Emitted, folder: Path) -> None:
    for name, text in emitted.files.items():
        (folder / name).write_text(text, encoding="utf-8")


def compile_library(
    folder: Path, sources: Sequence[str], cc: str = "gcc", flags: Sequence[str] = ("-O1",)
) -> ctypes.CDLL:
    """Compiled without a warning, loaded."""
    library = folder / f"lib_{cc}.so"
    command = [cc, *STRICT, "-ffp-contract=off", *flags, "-fPIC", "-shared", "-o", str(library), *sources, "-lm"]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert ran.returncode == 0 and not ran.stderr, ran.stderr
    return ctypes.CDLL(str(library))


def emitted_library(
    programs: Sequence[Program], folder: Path, cc: str = "gcc", **options: Any
) -> tuple[Emitted, ctypes.CDLL]:
    emitted = emit_c("demo", programs, info(**options))
    write_files(emitted, folder)
    return emitted, compile_library(folder, emitted.sources, cc)


def pointer(array: Any) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
