"""How generation, compilation and run time grow with the number of links, beside Pinocchio and MuJoCo.

    python -m tools.scaling [N …] [--kinds chain,tree] [-o FOLDER] [--rounds R]

For revolute chains and random trees of N links and for every function: CPU seconds to generate (derive, emit, read
back, certify) and to compile, kilobytes of object code, and nanoseconds a call of straight-line code, of loops, of
Pinocchio's C++ and of MuJoCo, all in turn in one process over the same states, after their results have been compared.
Everything is compiled with the same flags; straight-line code only as far as compilers come with it. Writes
scaling.json, scaling.csv, scaling.md and figures as PNG and SVG into the folder.
"""

from __future__ import annotations

import argparse
import csv
import ctypes
import json
import random
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import symgen
from symgen.loops.choose import about, too_long
from symgen.scene.builder import SceneBuilder
from symgen.scene.model import Scene
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request

SIZES = (2, 5, 10, 20, 50, 100, 200, 500, 1000)
FUNCTIONS = {
    "inverse_dynamics": ("q", "v", "a"),
    "bias_force": ("q", "v"),
    "mass_matrix": ("q",),
    "forward_dynamics": ("q", "v", "a"),
}
FLAGS = ("-O3", "-march=native")
STRAIGHT_LIMIT = 45000
"""Operations of the longest straight-line function that is compiled here."""
STATES = 8
SLICE = 0.004
"""Seconds that one measurement takes."""
AGREE = 1e-9
Array = NDArray[np.float64]

TIMER = r"""
#include <time.h>
typedef void (*f1)(void *); typedef void (*f2)(void *, void *); typedef void (*f3)(void *, void *, void *);
typedef void (*f4)(void *, void *, void *, void *);
double run(void *f, int count, char **arrays, const long *strides, int states, long calls)
{
    struct timespec a, b;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &a);
    for (long k = 0; k < calls; ++k) {
        const long s = k % states;
        void *x[4];
        for (int i = 0; i < count; ++i) x[i] = arrays[i] + s * strides[i];
        switch (count) {
        case 1: ((f1)f)(x[0]); break;
        case 2: ((f2)f)(x[0], x[1]); break;
        case 3: ((f3)f)(x[0], x[1], x[2]); break;
        default: ((f4)f)(x[0], x[1], x[2], x[3]); break;
        }
    }
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &b);
    return (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec);
}
"""


@dataclass
class Row:
    """One function of one scene."""

    kind: str
    n: int
    function: str
    chosen: str = ""
    operations: int = 0
    generate_s: float | None = None
    compile_s: dict[str, float] = field(default_factory=dict)
    object_kb: dict[str, float] = field(default_factory=dict)
    ns: dict[str, float] = field(default_factory=dict)
    median_ns: dict[str, float] = field(default_factory=dict)
    difference: dict[str, float] = field(default_factory=dict)


def chain(n: int) -> Scene:
    """Revolute joints about x, y and z in turn; the bodies differ."""
    builder = SceneBuilder(f"chain_{n}")
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    for k in range(n):
        inertia = [f"0.01{k % 3 + 1}", "0.012", "0.013", "0.0001", "0.0002", "0.0003"]
        com = ["0.02", "0.01", f"-0.1{k % 5}"]
        builder.body(f"b{k}", mass=f"1.{k % 7 + 1}", com=com, inertia=inertia)
        parent = f"b{k - 1}" if k else "ground"
        builder.joint(f"j{k}", "revolute", parent, f"b{k}", xyz=["0.03", 0, "0.2"], axis=axes[k % 3])
    return builder.build()


def tree(n: int) -> Scene:
    """A branching tree of revolute and, one in six, prismatic joints, about any axes and turned any way."""
    rng = random.Random(n)
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1), ("0.6", 0, "0.8"), (0, "0.8", "-0.6"), (1, 2, 2))
    builder = SceneBuilder(f"tree_{n}")
    names = ["ground"]
    for k in range(n):
        com = [f"{rng.uniform(-0.3, 0.3):.3f}" for _ in range(3)]
        inertia = [f"{rng.uniform(0.02, 0.03):.4f}" for _ in range(3)] + [f"{rng.uniform(-4, 4):.3f}e-3" for _ in "123"]
        builder.body(f"b{k}", mass=f"{rng.uniform(0.5, 3):.2f}", com=com, inertia=inertia)
        parent = names[-1] if k == 0 or rng.randrange(4) else rng.choice(names[1:])
        xyz = [f"{rng.uniform(-0.5, 0.5):.2f}" for _ in range(3)]
        rpy = [0, 0, 0] if rng.randrange(2) else [f"{rng.uniform(-3, 3):.3f}" for _ in range(3)]
        kind = rng.choices(("revolute", "prismatic"), (5, 1))[0]
        builder.joint(f"j{k}", kind, parent, f"b{k}", xyz=xyz, rpy=rpy, axis=rng.choice(axes))
        names.append(f"b{k}")
    return builder.build()


SCENES: dict[str, Callable[[int], Scene]] = {"chain": chain, "tree": tree}


def children_seconds() -> float:
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def compiled(sources: Sequence[Path], library: Path, extra: Sequence[str] = ()) -> float:
    """Make a shared library; CPU seconds it took."""
    before = children_seconds()
    compiler = "g++" if any(source.suffix == ".cpp" for source in sources) else "gcc"
    command = [compiler, *FLAGS, "-fPIC", "-shared", *map(str, sources), "-o", str(library), *extra]
    subprocess.run([*command, "-lm"], check=True, timeout=900)
    return children_seconds() - before


def asked(scene: Scene, function: str, code: str | None) -> Scene:
    wanted = request(scene, parse_outputs(function))
    return request(replace(wanted, options=replace(wanted.options, code=code, targets=("c",))))


@dataclass
class Peers:
    """Pinocchio and MuJoCo, compiled once."""

    folder: Path

    def __post_init__(self) -> None:
        from symgen.bench.peers import mujoco, pinocchio
        from symgen.bench.text import template

        self.pinocchio, self.mujoco = pinocchio, mujoco
        for name in ("pinocchio.cpp", "pinocchio_model.hpp", "mujoco.c"):
            (self.folder / name).write_text(template(name))
        includes = [option for path in pinocchio.include_folders() for option in ("-isystem", str(path))]
        pin = self.folder / "pinocchio.so"
        if not pin.exists():
            print("compiling Pinocchio …", file=sys.stderr)
            compiled(
                [self.folder / "pinocchio.cpp"], pin, ["-std=c++17", "-w", "-DNDEBUG", *pinocchio.DEFINES, *includes]
            )
        home = mujoco.home()
        assert home is not None
        muj, shared = self.folder / "mujoco.so", mujoco.library(home)
        compiled([self.folder / "mujoco.c"], muj, ["-I", str(home / "include"), str(shared), f"-Wl,-rpath,{home}"])
        self.libraries = {"pinocchio": ctypes.CDLL(str(pin)), "mujoco": ctypes.CDLL(str(muj))}

    def open(self, scene: Scene) -> None:
        """Both peers on this scene."""
        from symgen.validation.mujoco_model import build_mujoco
        from symgen.validation.pinocchio_model import build_pinocchio

        model = self.folder / "pinocchio.model"
        model.write_text(self.pinocchio.model_text(build_pinocchio(scene)))
        assert self.libraries["pinocchio"].pinocchio_open(str(model).encode()) == 0
        adapter = build_mujoco(scene)
        file = self.folder / "mujoco.mjb"
        adapter.mujoco.mj_saveModel(adapter.model, str(file), None)
        assert self.libraries["mujoco"].bench_mujoco_open(str(file).encode()) == 0

    def calls(self, function: str) -> Iterator[tuple[str, Any, Callable[[Array], None]]]:
        for name, prefix in (("pinocchio", "pinocchio"), ("mujoco", "bench_mujoco")):
            library = self.libraries[name]
            fetch = getattr(library, f"{prefix}_fetch")

            def get(out: Array, fetch: Any = fetch) -> None:
                fetch(function.encode(), out.ctypes.data_as(ctypes.c_void_p))

            yield name, getattr(library, f"{prefix}_{function}"), get


class Timer:
    """Calls functions over states, and says how long a call takes."""

    def __init__(self, folder: Path) -> None:
        source = folder / "timer.c"
        source.write_text(TIMER)
        compiled([source], folder / "timer.so")
        self.run = ctypes.CDLL(str(folder / "timer.so")).run
        self.run.restype = ctypes.c_double

    def seconds(self, function: Any, arrays: Sequence[Array], calls: int) -> float:
        pointers = (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
        strides = (ctypes.c_long * len(arrays))(*(array.strides[0] if array.ndim > 1 else 0 for array in arrays))
        address = ctypes.cast(function, ctypes.c_void_p)
        return float(self.run(address, len(arrays), pointers, strides, STATES, ctypes.c_long(calls)))


def measure(timer: Timer, variants: dict[str, tuple[Any, list[Array]]], rounds: int) -> dict[str, list[float]]:
    """Nanoseconds a call of every variant, in turn, round by round."""
    calls: dict[str, int] = {}
    for name, (function, arrays) in variants.items():
        count, taken = 1, timer.seconds(function, arrays, STATES) / STATES
        count = max(1, int(SLICE / max(taken, 1e-9)))
        calls[name] = count
    found: dict[str, list[float]] = {name: [] for name in variants}
    for _ in range(rounds):
        for name, (function, arrays) in variants.items():
            found[name].append(1e9 * timer.seconds(function, arrays, calls[name]) / calls[name])
    return found


def one(
    kind: str, n: int, function: str, peers: Peers | None, timer: Timer, rounds: int, limit: int, folder: Path
) -> Row:
    """Everything of one function of one scene."""
    row = Row(kind, n, function)
    scene = SCENES[kind](n)
    inputs = FUNCTIONS[function]
    rng = np.random.default_rng(n)
    states = {name: rng.normal(size=(STATES, n)) for name in ("q", "v", "a")}
    size = n * n if function == "mass_matrix" else n
    variants: dict[str, tuple[Any, list[Array]]] = {}
    results: dict[str, Array] = {}
    operations = about(symgen.derive(asked(scene, function, None)).tree, parse_outputs(function)[0])
    for code in ("loops", "straight"):
        if code == "straight" and operations > limit:
            continue
        place = folder / f"{kind}_{n}_{function}_{code}"
        started = time.process_time()
        symgen.generate(asked(scene, function, code), place)
        taken = time.process_time() - started
        manifest = json.loads((place / "manifest.json").read_text())
        sources = [place / name for name in manifest["sources"]]
        library = place / "library.so"
        row.compile_s[code] = compiled(sources, library)
        row.object_kb[code] = library.stat().st_size / 1024
        if code == "loops":
            row.operations = operations
            row.generate_s = taken
        out = np.zeros(size)
        call = getattr(ctypes.CDLL(str(library)), f"{scene.name}_{function}")
        variants[code] = (call, [*(states[name] for name in inputs), out])
        call(
            *(x[0].ctypes.data_as(ctypes.c_void_p) for x in variants[code][1][:-1]), out.ctypes.data_as(ctypes.c_void_p)
        )
        results[code] = out.copy()
    row.chosen = "loops" if in_loops(scene, function) else "straight"
    if peers:
        peers.open(scene)
    for name, call, fetch in peers.calls(function) if peers else ():
        arrays = [states[key] for key in inputs]
        call(*(x[0].ctypes.data_as(ctypes.c_void_p) for x in arrays))
        results[name] = np.zeros(size)
        fetch(results[name])
        variants[name] = (call, arrays)
    right = results["pinocchio" if peers else "loops"]
    for name, value in results.items():
        row.difference[name] = float(np.abs(value - right).max() / np.abs(right).max())
    for name, taken_ns in measure(timer, variants, rounds).items():
        row.ns[name], row.median_ns[name] = min(taken_ns), statistics.median(taken_ns)
    return row


def in_loops(scene: Scene, function: str) -> bool:
    """Whether symgen chooses loops by itself."""
    system = symgen.derive(asked(scene, function, None))
    return too_long(about(system.tree, parse_outputs(function)[0]))


def best(row: Row) -> float:
    return min(row.ns[code] for code in ("loops", "straight") if code in row.ns)


HEADER = (
    "| scene | n | function | generate s | compile s, loops | straight | chosen | ns, loops | straight | Pinocchio "
    "| MuJoCo | chosen / best | Pinocchio / chosen |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)


def table(rows: Sequence[Row]) -> str:
    lines = [HEADER]
    for row in rows:
        chosen = row.ns.get(row.chosen) or row.ns["loops"]
        straight = f"{row.compile_s['straight']:.1f}" if "straight" in row.compile_s else "–"
        times = [
            f"{row.ns[name]:,.0f}" if name in row.ns else "–" for name in ("loops", "straight", "pinocchio", "mujoco")
        ]
        peer = f"{row.ns['pinocchio'] / chosen:.1f}" if "pinocchio" in row.ns else "–"
        lines.append(
            f"| {row.kind} | {row.n} | {row.function} | {row.generate_s:.2f} | {row.compile_s['loops']:.1f} "
            f"| {straight} | {row.chosen} | {' | '.join(times)} | {chosen / best(row):.2f} | {peer} |"
        )
    return "\n".join(lines) + "\n"


STYLES = {
    "straight": ("symgen, straight-line", "#d95f02", "o"),
    "loops": ("symgen, loops", "#1b9e77", "s"),
    "pinocchio": ("Pinocchio", "#7570b3", "^"),
    "mujoco": ("MuJoCo", "#888888", "v"),
}


def figure(rows: Sequence[Row], folder: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    kinds = list(dict.fromkeys(row.kind for row in rows))
    names = [name for name in FUNCTIONS if any(row.function == name for row in rows)]
    figure, axes = pyplot.subplots(len(kinds), len(names), figsize=(4 * len(names), 3.6 * len(kinds)), squeeze=False)
    for line, kind in zip(axes, kinds, strict=True):
        for place, name in zip(line, names, strict=True):
            mine = [row for row in rows if row.kind == kind and row.function == name]
            for variant, (label, colour, marker) in STYLES.items():
                points = [(row.n, row.ns[variant] / 1000) for row in mine if variant in row.ns]
                if points:
                    place.loglog(*zip(*points, strict=True), color=colour, marker=marker, ms=4, lw=1.4, label=label)
            place.set_title(f"{name}, {kind}", fontsize=10)
            place.set_xlim(1.5, 1500)
            place.grid(True, which="major", alpha=0.3)
            place.set_xlabel("links")
    for line in axes:
        line[0].set_ylabel("µs a call")
    axes[0][0].legend(fontsize=8, frameon=False)
    figure.tight_layout()
    for suffix in ("png", "svg"):
        figure.savefig(folder / f"scaling.{suffix}", dpi=130, metadata={"Date": None} if suffix == "svg" else None)
    pyplot.close(figure)


def costs(rows: Sequence[Row], folder: Path) -> None:
    """CPU seconds of generation and compilation against n."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(9, 3.6))
    for name in FUNCTIONS:
        mine = [row for row in rows if row.function == name and row.kind == "chain"]
        if not mine:
            continue
        axes[0].loglog([row.n for row in mine], [row.generate_s for row in mine], marker="o", ms=4, label=name)
        axes[1].loglog([row.n for row in mine], [row.compile_s["loops"] for row in mine], marker="o", ms=4, label=name)
        straight = [(row.n, row.compile_s["straight"]) for row in mine if "straight" in row.compile_s]
        if straight:
            axes[1].loglog(*zip(*straight, strict=True), ls=":", marker="x", ms=4, label=f"{name}, straight-line")
    for place, title in zip(axes, ("generate and certify, chains", "gcc -O3, chains"), strict=True):
        place.set_title(title, fontsize=10)
        place.set_xlabel("links")
        place.set_ylabel("CPU s")
        place.grid(True, alpha=0.3)
        if place.lines:
            place.legend(fontsize=7, frameon=False)
    figure.tight_layout()
    for suffix in ("png", "svg"):
        figure.savefig(
            folder / f"scaling_costs.{suffix}", dpi=130, metadata={"Date": None} if suffix == "svg" else None
        )
    pyplot.close(figure)


def write(rows: Sequence[Row], folder: Path) -> None:
    (folder / "scaling.json").write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    (folder / "scaling.md").write_text(table(rows))
    with (folder / "scaling.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        variants = list(STYLES)
        writer.writerow(
            ["scene", "n", "function", "chosen", "generate_s", "compile_loops_s", "compile_straight_s", *variants]
        )
        for row in rows:
            compile_s = [row.compile_s.get(code, "") for code in ("loops", "straight")]
            times = [row.ns.get(name, "") for name in variants]
            writer.writerow([row.kind, row.n, row.function, row.chosen, row.generate_s, *compile_s, *times])
    figure(rows, folder)
    costs(rows, folder)


def main() -> None:
    sys.setrecursionlimit(20000)  # peers walk deep trees recursively
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=list(SIZES))
    parser.add_argument("--kinds", default="chain,tree")
    parser.add_argument("--functions", default=",".join(FUNCTIONS))
    parser.add_argument("-o", "--out", type=Path, default=Path("out/scaling"))
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument(
        "--straight", type=int, default=STRAIGHT_LIMIT, help="operations that are compiled straight-line"
    )
    parser.add_argument("--alone", action="store_true", help="without peers")
    parser.add_argument("--plot", action="store_true", help="only draw what is in the folder again")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    if arguments.plot:
        stored = json.loads((arguments.out / "scaling.json").read_text())
        write([Row(**row) for row in stored], arguments.out)
        return
    peers, timer = None if arguments.alone else Peers(arguments.out), Timer(arguments.out)
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as scratch:
        for kind in arguments.kinds.split(","):
            for n in arguments.sizes or SIZES:
                for function in arguments.functions.split(","):
                    row = one(kind, n, function, peers, timer, arguments.rounds, arguments.straight, Path(scratch))
                    rows.append(row)
                    print(table([row]).splitlines()[-1], flush=True)
                    loose = [name for name, x in row.difference.items() if x > AGREE * n]
                    if loose:
                        print(f"  differs: {', '.join(loose)} {row.difference}", flush=True)
                write(rows, arguments.out)


if __name__ == "__main__":
    main()
