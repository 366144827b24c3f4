"""Scenes for loops, and what the tests do with them: emit, read back, certify, compile."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from symgen.certificate import Candidate, Certifier
from symgen.generate import target_info
from symgen.loops.read import ReadLoops
from symgen.scene.builder import SceneBuilder
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request
from symgen.system import System, derive
from symgen.targets.c import Emitted, emit_c, read_back

EXAMPLES = Path(__file__).parents[2] / "examples"
ROWS = "inverse_dynamics,bias_force,gravity_force,mass_matrix,forward_dynamics"
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-Wshadow", "-Wdouble-promotion"]


def chain(n: int, name: str = "chain") -> Scene:
    """Revolute joints about x, y and z in turn."""
    builder = SceneBuilder(name)
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    for k in range(n):
        builder.body(
            f"b{k}", mass=f"1.{k % 7 + 1}", com=["0.02", "0.01", f"-0.1{k % 5}"],
            inertia=[f"0.01{k % 3 + 1}", "0.012", "0.013", "0.0001", "0.0002", "0.0003"],
        )  # fmt: skip
        parent = f"b{k - 1}" if k else "ground"
        builder.joint(f"j{k}", "revolute", parent, f"b{k}", xyz=["0.03", 0, "0.2"], axis=axes[k % 3])
    return builder.build()


def zoo(velocity: str = "world") -> Scene:
    """A floating base that branches, with every kind of elementary joint, turned any way, armature and damping."""
    builder = SceneBuilder("zoo").options(base_velocity=velocity)
    kinds: list[tuple[str, str, dict[str, Any]]] = [
        ("ground", "floating", {}),
        ("b0", "revolute", {"axis": [0, 0, 1], "armature": "0.3", "damping": "0.2"}),
        ("b1", "spherical", {"damping": "0.1"}),
        ("b2", "revolute", {"axis": [1, 2, 2], "rpy": ["0.3", "-0.7", "1.1"]}),
        ("b0", "prismatic", {"axis": ["0.6", 0, "0.8"], "armature": 2}),
        ("b4", "helical", {"axis": [0, 1, 0], "pitch": "0.05"}),
        ("b4", "universal", {"axis": [1, 0, 0], "axis2": [0, 1, 0]}),
        ("b6", "cylindrical", {"axis": [0, 0, 1], "damping": "0.4"}),
        ("b0", "planar", {}),
        ("b8", "revolute", {"axis": [0, 0, 1]}),
    ]
    for k, (parent, kind, facts) in enumerate(kinds):
        builder.body(
            f"b{k}", mass=f"{k + 1}.5", com=[f"0.{k + 1}", "-0.2", "0.05"],
            inertia=[f"1.{k}", "1.2", "1.3", "0.1", "-0.05", "0.02"],
        )  # fmt: skip
        place = {} if kind == "floating" else {"xyz": ["0.1", f"-0.{k + 1}", "0.3"]}
        builder.joint(f"j{k}", kind, parent, f"b{k}", **place, **facts)
    return builder.build()


def asked(scene: Scene | str, rows: str = ROWS, **options: Any) -> System:
    """A system with these functions and options; in loops unless said otherwise."""
    scene = load(EXAMPLES / f"{scene}.scene.yaml") if isinstance(scene, str) else scene
    chosen = {"code": "loops", "targets": ("c",)} | options
    wanted = request(scene, parse_outputs(rows))
    return derive(request(replace(wanted, options=replace(wanted.options, **chosen))))


def emitted(system: System) -> Emitted:
    programs = [system.code(output.name).program for output in system.outputs]
    return emit_c(system.scene.name, programs, target_info(system))


def certify(system: System, text: Emitted, names: Sequence[str] = ()) -> dict[str, Any]:
    """Read back and certify as `symgen.generate` does; raises CertificateError."""
    read = read_back(text)
    read.check_literals()
    certifier = Certifier(system, "".join(text.files.values()))
    found = {}
    for output in system.outputs:
        if names and output.name not in names:
            continue
        function = read.functions[output.name]
        assert isinstance(function, ReadLoops)
        candidate = Candidate("C", lambda numbers, inputs, f=function: f.evaluate_mod(numbers.p, inputs, numbers.apply))
        found[output.name] = certifier.certify(output, system.code(output.name).program, [candidate])
    return found


def library(text: Emitted, folder: Path, compiler: str = "gcc", flags: Sequence[str] = ("-O0",)) -> ctypes.CDLL:
    """The emitted C as a shared library."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in text.files.items():
        (folder / name).write_text(content)
    target = folder / "library.so"
    sources = [str(folder / name) for name in text.sources]
    subprocess.run([compiler, *STRICT, *flags, "-fPIC", "-shared", *sources, "-o", str(target), "-lm"], check=True)
    return ctypes.CDLL(str(target))


def call(function: Any, inputs: Sequence[np.ndarray], size: int, kind: type = np.float64) -> tuple[int, np.ndarray]:
    """(what it returns, its output)."""
    out = np.zeros(size, kind)
    arrays = [np.ascontiguousarray(x, kind) for x in inputs]
    status = function(*(x.ctypes.data_as(ctypes.c_void_p) for x in (*arrays, out)))
    return status, out
