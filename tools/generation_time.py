"""How long generating takes: derive, emit with read-back, CasADi, certify; per scene and for chains of revolutes.

``python tools/generation_time.py [--outputs ROWS] [--compile] [SCENE … | N …]``: scene files, or numbers of links of a
chain. ROWS are named as for ``symgen generate``; ``all`` is the whole catalogue (frames: the last body). CPU seconds,
the minimum of a few runs where that is short; everything is done as `symgen.generate` does it, except that nothing is
written. ``--compile``: also CPU seconds of ``gcc -O3`` and the size of what it makes.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from symgen import Scene, SceneBuilder, derive, load
from symgen.catalogue import CATALOGUE
from symgen.generate import generate_files
from symgen.program.instructions import Program
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request

EXAMPLES = Path(__file__).parent.parent / "examples"
DEFAULT = [*(str(EXAMPLES / f"{name}.scene.yaml") for name in ("fig1", "fig2", "ur5", "panda")), "10", "50", "100"]
AXES = ((0, 0, 1), (0, 1, 0))
SHORT = 3.0
"""Seconds; what takes less is run again."""
COMPILER = ("gcc", "-std=c99", "-O3")


def chain(links: int) -> Scene:
    """A chain of revolutes about z and y in turn, with generic centres of mass and inertias."""
    builder = SceneBuilder(f"chain_{links}")
    parent = "ground"
    for k in range(links):
        name = f"link{k}"
        builder.body(
            name,
            mass="1.2",
            com=("0.1", "0.05", "0.14"),
            inertia=("0.03", "0.04", "0.05", "0.002", "0.0015", "-0.003"),
        )
        builder.joint(f"j{k}", "revolute", parent, name, axis=AXES[k % 2], xyz=("0.2", "0.1", "0.3"))
        parent = name
    return builder.outputs("mass_matrix", "bias_force", "forward_dynamics").build()


def catalogue(scene: Scene) -> str:
    """Every row that needs no choice but of a frame."""
    frame = scene.bodies[-1].name
    return ",".join(f"{row}:{frame}" if row.startswith("frame_") else row for row in CATALOGUE if row != "step")


@dataclass(frozen=True)
class Times:
    """CPU seconds, and how much was made."""

    derive: float
    emit: float
    certify: float
    functions: int
    instructions: int
    files: Mapping[str, str | bytes]

    @property
    def total(self) -> float:
        return self.derive + self.emit + self.certify


def measure(scene: Scene) -> Times:
    marks: dict[str, float] = {}

    def progress(done: int, total: int, what: str) -> None:
        marks.setdefault(what.split(" ", maxsplit=1)[0] if done else "start", time.process_time())

    begun = time.process_time()
    system = derive(scene)
    files = generate_files(system, progress).files
    ended = time.process_time()
    programs = [system.code(output.name).program for output in system.outputs]
    instructions = sum(len(program.instructions) for program in programs if isinstance(program, Program))
    times = marks["emit"] - begun, marks["certify"] - marks["emit"], ended - marks["certify"]
    return Times(*times, len(programs), instructions, files)


def compiled(files: Mapping[str, str | bytes]) -> tuple[float, int]:
    """(CPU seconds of the compiler, bytes of code and constants) of the scalar functions."""
    size = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, content in files.items():
            if isinstance(content, str) and "/" not in file:
                (folder / file).write_text(content)
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        sources = [file for file in files if file.endswith(".c") and file != "main.c" and "_batch" not in file]
        for source in sources:
            subprocess.run([*COMPILER, "-c", source], cwd=folder, check=True)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        for source in sources:
            answer = subprocess.run(
                ["size", f"{source[:-2]}.o"], cwd=folder, check=True, capture_output=True, text=True
            )
            size += int(answer.stdout.splitlines()[1].split()[0])
    return seconds, size


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scenes", nargs="*", default=DEFAULT)
    parser.add_argument("--outputs", default="", help="rows of the catalogue, or all")
    parser.add_argument("--compile", action="store_true", help="time gcc as well")
    options = parser.parse_args()
    measure(load(EXAMPLES / "pendulum.scene.yaml"))  # imports
    extra = f"{'gcc':>9}{'kB':>7}" if options.compile else ""
    head = f"{'scene':24}{'functions':>10}{'operations':>11}{'derive':>9}{'emit':>9}{'certify':>9}{'all':>9}"
    print(f"{head}  us/operation{extra}")
    for argument in options.scenes:
        scene = chain(int(argument)) if argument.isdigit() else load(argument)
        if options.outputs:
            rows = catalogue(scene) if options.outputs == "all" else options.outputs
            scene = request(scene, outputs=parse_outputs(rows))
        times = measure(scene)
        if times.total < SHORT:
            times = min((times, measure(scene), measure(scene)), key=lambda found: found.total)
        columns = "".join(f"{x:9.2f}" for x in (times.derive, times.emit, times.certify, times.total))
        each = 1e6 * times.total / max(1, times.instructions)
        row = f"{scene.name:24}{times.functions:10}{times.instructions:11}{columns}{each:14.0f}"
        if options.compile:
            seconds, size = compiled(times.files)
            row += f"{seconds:9.2f}{size / 1024:7.0f}"
        print(row, flush=True)


if __name__ == "__main__":
    main()
