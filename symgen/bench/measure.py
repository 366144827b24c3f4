"""Measure every function of a scene: derive, generate, compile, run, compare."""

from __future__ import annotations

import platform
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symgen.artifact import RELEASE_FLAGS, find_compiler
from symgen.bench import callgrind
from symgen.bench.multiprecision import exact_outputs, relative_error
from symgen.bench.peers import OVERHEAD_NOTE, pinocchio_calls
from symgen.bench.result import EMPTY_CALL, BenchResult, FunctionRow, PeerRow
from symgen.catalogue import STATE_INPUTS, input_ports
from symgen.errors import ToolError
from symgen.program.instructions import Program, count
from symgen.scene.model import Scene
from symgen.system import System, derive
from symgen.validation.mechanism import build_mechanism, random_state

if TYPE_CHECKING:
    from numpy.typing import NDArray

REPEATS = 9
ERROR_STATES = 5
CALLGRIND_STATES = 4
INSTRUCTIONS_NOTE = (
    f"instructions: callgrind, compiled with {' '.join(callgrind.FLAGS)} alone, mean of {CALLGRIND_STATES} states"
)

Times = dict[str, list[float]]
"""Name → nanoseconds per state, one entry per repeat."""


def sample_states(scene: Scene, system: System, n: int, seed: int = 1) -> list[dict[str, Any]]:
    """n random states: joint positions and velocities as in validation, a and tau within ±5, dt 1 ms, default p."""
    rng = np.random.default_rng(seed)
    mechanism = build_mechanism(scene)
    p = np.array([float(x) for parameter in scene.parameters for x in parameter.default])
    states = []
    for _ in range(n):
        q, v = random_state(mechanism, rng)
        a, tau = rng.uniform(-5, 5, (2, system.tree.nv))
        further = {name: rng.uniform(-1, 1, shape) for name, shape in further_inputs(system).items()}
        states.append({"q": q, "v": v, "a": a, "tau": tau, "dt": 1e-3, "p": p, **further})
    return states


def further_inputs(system: System) -> dict[str, tuple[int, ...]]:
    """Directions and weights that products among the outputs take, with their shapes."""
    ports = [port for output in system.outputs for port in input_ports(output.of, system.sizes)]
    return {port.name: port.shape for port in ports if port.name not in (*STATE_INPUTS, "p")}


def derive_programs(scene: Scene) -> tuple[System, dict[str, Program], dict[str, float]]:
    """A fresh derivation, and the milliseconds each function took (the first carries what all share)."""
    programs: dict[str, Program] = {}
    milliseconds: dict[str, float] = {}
    started = time.perf_counter()
    system = derive(scene)
    for output in system.outputs:
        program = system.program(output.name)
        now = time.perf_counter()
        programs[program.name], milliseconds[program.name] = program, (now - started) * 1e3
        started = now
    return system, programs, milliseconds


def batch_calls(
    loaded: Any, programs: Mapping[str, Program], states: Sequence[Mapping[str, Any]]
) -> dict[str, Callable[[], Any]]:
    """Function → a call over all states at once; functions without a state input have none."""
    columns: dict[str, NDArray[np.float64] | float] = {
        key: np.ascontiguousarray([state[key] for state in states]) for key in states[0] if key not in ("dt", "p")
    }
    columns |= {"dt": states[0]["dt"], "p": states[0]["p"]}
    calls: dict[str, Callable[[], Any]] = {}
    for name, program in programs.items():
        wanted = [port.name for port in program.inputs]
        if {"q", "v"} & set(wanted):
            calls[name] = partial(getattr(loaded, name), *(columns[key] for key in wanted))
    return calls


def interleaved(calls: Mapping[str, Callable[[], Any]], states: int, repeats: int, tick: Callable[[], None]) -> Times:
    """Time every call in turn, ``repeats`` rounds, so that a slow spell of the machine hits all alike."""
    times: Times = {name: [] for name in calls}
    for call in calls.values():
        call()
    for _ in range(repeats):
        for name, call in calls.items():
            started = time.perf_counter_ns()
            call()
            times[name].append((time.perf_counter_ns() - started) / states)
        tick()
    return times


def largest_error(program: Program, loaded: Any, states: Sequence[Mapping[str, Any]]) -> float:
    """Over the states and outputs, compiled code against the exact program."""
    worst = 0.0
    for state in states:
        arguments = [state[port.name] for port in program.inputs]
        computed = getattr(loaded, program.name)(*arguments)
        outputs = computed if isinstance(computed, tuple) else (computed,)
        exact = exact_outputs(program, {p.name: np.ravel(state[p.name]).tolist() for p in program.inputs})
        for port, array in zip(program.outputs, outputs, strict=True):
            worst = max(worst, relative_error(np.ravel(array).tolist(), exact[port.name]))
    return worst


def processor() -> str:
    """What the machine says it computes with."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()


def compiler_version(cc: str) -> str:
    ran = subprocess.run([cc, "--version"], capture_output=True, text=True, check=False)
    return ran.stdout.splitlines()[0] if ran.stdout else cc


@dataclass
class Steps:
    """Tells a progress callback that one more of ``total`` steps is done."""

    progress: Callable[[int, int, str], None] | None
    total: int
    done: int = 0

    def tick(self, what: str) -> None:
        self.done += 1
        if self.progress is not None:
            self.progress(self.done, self.total, what)


@dataclass(frozen=True)
class Built:
    """The generated code and what it took."""

    artifact: Any
    loaded: Any
    generate_s: float
    compile_s: float


def build(scene: Scene, directory: Path) -> Built:
    """Generate and compile into ``directory``; nothing comes from the compile cache."""
    from symgen.generate import generate

    started = time.perf_counter()
    artifact = generate(scene, directory)
    generated = time.perf_counter()
    loaded = artifact.load(cache=directory / "cache")
    return Built(artifact, loaded, generated - started, time.perf_counter() - generated)


def instruction_counts(
    built: Built, samples: Sequence[Mapping[str, Any]], cc: str
) -> tuple[dict[str, float], list[str]]:
    """Instructions per call by function, or a note why there are none."""
    if not callgrind.available():
        return {}, ["no instruction counts: valgrind is not installed"]
    try:
        return callgrind.count_instructions(built.artifact.directory, built.artifact.manifest, samples, cc), [
            INSTRUCTIONS_NOTE
        ]
    except ToolError as error:
        return {}, [f"no instruction counts: {error}"]


def bench(
    scene: Scene, states: int = 5000, repeats: int = REPEATS, progress: Callable[[int, int, str], None] | None = None
) -> BenchResult:
    """Measure every function the scene asks for; see `BenchResult` for the figures.

    Raises ToolError without a C compiler. Peers that are not installed are left out.
    """
    steps = Steps(progress, repeats + 4)
    cc = find_compiler()
    system, programs, milliseconds = derive_programs(scene)
    steps.tick("derived")
    samples = sample_states(scene, system, states)
    with tempfile.TemporaryDirectory() as scratch:
        built = build(scene, Path(scratch, "c"))
        steps.tick("compiled")
        peers = {f"pinocchio {name}": call for name, call in pinocchio_calls(scene, samples).items()}
        calls = {**batch_calls(built.loaded, programs, samples), **peers}
        times = interleaved(calls, states, repeats, lambda: steps.tick("timing"))
        errors = {name: largest_error(row, built.loaded, samples[:ERROR_STATES]) for name, row in programs.items()}
        steps.tick("compared")
        counts, notes = instruction_counts(built, samples[:CALLGRIND_STATES], cc)
        steps.tick("counted")
    rows = tuple(
        FunctionRow(
            name, program.plan, count(program).flops, count(program).sincos, milliseconds[name],
            min(times[name]) if name in times else None, statistics.median(times[name]) if name in times else None,
            counts.get(name), errors[name],
        )
        for name, program in programs.items()
    )  # fmt: skip
    notes.append(OVERHEAD_NOTE if peers else "no peer is installed: pip install 'symgen[validation]'")
    return BenchResult(
        scene.name, processor(), compiler_version(cc), " ".join(RELEASE_FLAGS), states, repeats,
        built.generate_s, built.compile_s, rows, peer_rows(times, set(programs)), tuple(notes),
    )  # fmt: skip


def peer_rows(times: Times, functions: set[str]) -> tuple[PeerRow, ...]:
    """The peers' times for the functions we made too, and of the empty call."""
    rows = []
    for name, series in times.items():
        peer, _, function = name.partition(" ")
        if peer == "pinocchio" and (function in functions or function == EMPTY_CALL):
            rows.append(PeerRow(peer, function, min(series), statistics.median(series)))
    return tuple(rows)
