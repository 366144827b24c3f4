"""One robot (or one random tree): derive, emit, certify, compile and compare every function; a JSON line for each.

The worker of tools/robots.py: it runs in a process of its own, so that a robot that fails, hangs or needs too much
memory stops nothing but itself.
"""

from __future__ import annotations

import argparse
import json
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType
from typing import Any

from symgen import Artifact, Scene, SceneBuilder, derive
from symgen.artifact.write import write_artifact
from symgen.errors import SymgenError, ToolError
from symgen.generate import generate_files
from symgen.program.instructions import count
from symgen.scene.model import Output
from symgen.scene.outputs import AVAILABLE, OF_A_FRAME, check_row, function_name
from symgen.system import System
from tools.robot_list import Robot, find_robot

MEMORY = 9 << 30
PRODUCTS = ("jvp:inverse_dynamics", "vjp:inverse_dynamics", "jvp:forward_dynamics", "vjp:forward_dynamics")
LATE = ("inverse_dynamics_second_derivatives",)
"""The largest functions come last."""
TOGETHER = {"base_regressor": ("base_parameters",)}
"""What a row needs beside it to be compared."""


class OutOfTimeError(Exception):
    pass


@contextmanager
def limit(seconds: float) -> Iterator[None]:
    def stop(_number: int, _frame: FrameType | None) -> None:
        raise OutOfTimeError(f"more than {seconds:g} CPU seconds")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def say(**record: Any) -> None:
    print(json.dumps(record), flush=True)


def rows_of(scene: Scene, frame: str, wanted: list[str]) -> list[str]:
    """Every row that exists, frame rows for one frame."""
    available = sorted(AVAILABLE - {"step"})  # steps are calls of the others
    names = [f"{name}:{frame}" if name in OF_A_FRAME else name for name in available]
    names += [name for name in PRODUCTS if product_exists(name)]
    if wanted:
        names = [name for name in names if name.split(":")[0] in wanted or name in wanted]
    return sorted(names, key=lambda name: name in LATE)


def product_exists(name: str) -> bool:
    try:
        check_row(name, (), "")
    except SymgenError:
        return False
    return True


def load_robot(robot: Robot) -> tuple[Scene, str]:
    """The scene, and what is worth saying of it."""
    path = find_robot(robot)
    if path.suffix == ".sdf":
        from tools.sdf_tree import load_sdf_tree

        scene, cut = load_sdf_tree(path, robot.name, robot.base)
        return scene, f"spanning tree; {len(cut)} joints that close loops are left out"
    scene = SceneBuilder(robot.name).model(str(path), base=robot.base).build()
    return scene, "floating base" if robot.base == "floating" else ""


@dataclass(frozen=True)
class Limits:
    function: float
    compile: float
    states: int
    optimise: bool
    """Time -O3 too."""


def measure(scene: Scene, rows: list[str], limits: Limits, system: System) -> None:
    """A line per function; an error becomes part of its line."""
    for row in rows:
        record: dict[str, Any] = {"output": row}
        with tempfile.TemporaryDirectory(prefix="symgen-robots-") as folder:
            try:
                with limit(limits.function):
                    record |= generate_one(system, row, Path(folder))
                record |= compile_and_compare(scene, row, Path(folder), limits)
            except Exception as error:
                record["error"] = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        say(**record)


def generate_one(system: System, row: str, folder: Path) -> dict[str, Any]:
    """Seconds to derive (plans weighed), to emit and read back, to certify; operations; files written."""
    options = replace(system.scene.options, targets=("c",))
    output = Output(function_name(row), (row,))
    outputs = (output, *(Output(name, (name,)) for name in TOGETHER.get(row, ())))
    own = replace(system, scene=replace(system.scene, outputs=outputs, options=options), _chosen={})
    marks: dict[str, float] = {}

    def progress(done: int, total: int, what: str) -> None:
        marks.setdefault(what.split(" ", maxsplit=1)[0] if done else "start", time.process_time())

    begun = time.process_time()
    files = generate_files(own, progress)
    ended = time.process_time()
    write_artifact(folder / "out", files.files)
    certificate = next(iter(files.certificates.values()), None)
    operations = count(own.program(output.name))
    return {
        "flops": operations.flops,
        "sincos": operations.sincos,
        "derive_s": marks["emit"] - begun,
        "emit_s": marks["certify"] - marks["emit"],
        "certify_s": ended - marks["certify"],
        "failure_probability": certificate.failure_probability if certificate else None,
    }


def compile_and_compare(scene: Scene, row: str, folder: Path, limits: Limits) -> dict[str, Any]:
    artifact = Artifact(folder / "out")
    if not artifact.manifest["functions"]:
        return {"note": "no entries"}
    record: dict[str, Any] = {}
    functions = None
    for level in ("-O2", "-O0"):
        begun = compiler_time()
        try:
            seconds = limits.compile * (1 if level == "-O2" else 10)
            functions = artifact.load(cc=limited(seconds), flags=[level], cache=folder)
        except ToolError:
            record["note"] = f"gcc {level}: more than {seconds:g} s"
            continue
        record[f"compile_{level[1:]}_s"] = compiler_time() - begun
        break
    if "compile_O2_s" in record and limits.optimise:
        record["compile_O3_s"] = time_compiler(artifact, limits.compile)
    if functions is not None:
        with limit(limits.function):
            record |= compare(scene, row, functions, limits.states)
    return record


def limited(seconds: float) -> str:
    """gcc with a limit of CPU time."""
    return f"prlimit --cpu={seconds:.0f} gcc"


def compiler_time() -> float:
    """CPU seconds of all children that ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def time_compiler(artifact: Artifact, seconds: float) -> float | None:
    """gcc with the release flags less -march; None where it takes longer than allowed."""
    flags = ["-std=c99", "-O3", "-ffp-contract=fast", "-fno-math-errno", "-c", "-o", "O3.o"]
    begun = compiler_time()
    for source in artifact.manifest["sources"]:
        command = [*limited(seconds).split(), *flags, source]
        if subprocess.run(command, cwd=artifact.directory, check=False, capture_output=True).returncode:
            return None
    return compiler_time() - begun


def compare(scene: Scene, row: str, functions: Any, states: int) -> dict[str, Any]:
    """Worst difference to Pinocchio, with the criterion at that state."""
    from symgen.validation.compare import CRITERION
    from symgen.validation.compare_products import KINDS, compare_products
    from symgen.validation.compare_rows import STATES, base_rows, row_difference, states_of
    from symgen.validation.functions import bind
    from symgen.validation.pinocchio_model import build_pinocchio
    from symgen.validation.pinocchio_rows import PEER_ROWS

    name, _, frame = row.partition(":")
    if name in KINDS:
        asked = replace(scene, outputs=(Output(function_name(row), (row,)),))
        lines, _skipped = compare_products(asked, bind(functions, scene), 20240)
        return {"difference": lines[0].value, "criterion": lines[0].criterion, "remark": lines[0].note, "states": 3}
    peer = build_pinocchio(scene)
    if name == "base_regressor":
        (line,) = base_rows(peer, bind(functions, scene), states_of(peer, states, 20240), "", CRITERION, "")
        return {"difference": line.value, "criterion": line.criterion, "remark": line.note, "states": states}
    if name not in PEER_ROWS:
        return {}
    drawn = states_of(peer, min(states, STATES.get(name, states)), 20240)
    found = row_difference(peer, bind(functions, scene), name, frame, drawn)
    return {"difference": found.value, "criterion": found.criterion, "remark": found.note, "states": len(drawn)}


def random_tree(bodies: int, seed: int) -> Scene:
    """A branching tree: three joints of four revolute, the rest prismatic, now and then a spherical one."""
    rng = random.Random(seed)
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1), ("0.6", 0, "0.8"), (0, "0.8", "-0.6"), (1, 2, 2))
    builder = SceneBuilder(f"tree_{bodies}")
    names = ["ground"]
    for k in range(bodies):
        kind = rng.choices(("revolute", "prismatic", "spherical"), (15, 4, 1))[0]
        name, parent = f"b{k}", names[-1] if rng.randrange(4) else rng.choice(names)
        com = [f"{rng.uniform(-0.3, 0.3):.3f}" for _ in range(3)]
        inertia = [f"{rng.uniform(0.02, 0.03):.4f}" for _ in range(3)] + [f"{rng.uniform(-4, 4):.3f}e-3" for _ in "123"]
        builder.body(name, mass=f"{rng.uniform(0.5, 3):.2f}", com=com, inertia=inertia)
        facts: dict[str, Any] = {} if kind == "spherical" else {"axis": rng.choice(axes)}
        xyz = [f"{rng.uniform(-0.5, 0.5):.2f}" for _ in range(3)]
        rpy = [0, 0, 0] if rng.randrange(2) else [f"{rng.uniform(-3, 3):.3f}" for _ in range(3)]
        builder.joint(f"j{k}", kind, parent, name, xyz=xyz, rpy=rpy, **facts)
        names.append(name)
    return builder.build()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot", type=json.loads, help="a Robot as JSON; a number as its file is a random tree")
    parser.add_argument("--outputs", default="")
    parser.add_argument("--function-limit", type=float, default=120)
    parser.add_argument("--compile-limit", type=float, default=120)
    parser.add_argument("--states", type=int, default=10)
    parser.add_argument("--only-O2", action="store_true")
    arguments = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for tool in ("gcc", "prlimit"):
        if shutil.which(tool) is None:
            sys.exit(f"{tool} is not on the PATH")
    wanted = [name for name in arguments.outputs.split(",") if name]
    begun = time.process_time()
    robot = Robot(**arguments.robot)
    if robot.file.isdigit():
        scene, note = random_tree(int(robot.file), int(robot.file)), ""
    else:
        scene, note = load_robot(robot)
    loaded = time.process_time()
    system = derive(scene)
    ended = time.process_time()
    nq, nv = system.tree.nq, system.tree.nv
    frame = system.tree.bodies[-1].name
    say(nq=nq, nv=nv, bodies=len(system.tree.bodies), note=note, load_s=loaded - begun, tree_s=ended - loaded)
    limits = Limits(arguments.function_limit, arguments.compile_limit, arguments.states, not arguments.only_O2)
    measure(scene, rows_of(scene, frame, wanted), limits, system)


if __name__ == "__main__":
    main()
