"""Measure every function of a scene beside its peers: generate, compile, check that all agree, then run in turn."""

from __future__ import annotations

import platform
import statistics
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from symgen.artifact.compiler import cache_folder
from symgen.bench import floor
from symgen.bench.driver import COUNTED_STATES, Driver, build_driver
from symgen.bench.errors import Errors, Truth, errors_of, unpacked
from symgen.bench.multiprecision import exact_outputs
from symgen.bench.peers import forms, ours, registry
from symgen.bench.result import BenchResult, FunctionFacts, Row
from symgen.bench.variant import OURS, STRIPPED, Array, Found, Left, Problem, State, Unit, Variant
from symgen.bench.workshop import LIMIT_S, NATIVE, Compiled, CompileError, Workshop, compiler_version, open_workshop
from symgen.catalogue import STATE_INPUTS, input_ports
from symgen.errors import SceneError
from symgen.integrators.plan import without_steps
from symgen.program.instructions import Program, count
from symgen.scene.canonical import with_hash
from symgen.scene.model import Scene
from symgen.system import System, derive
from symgen.targets.c import emit_c
from symgen.validation.mechanism import build_mechanism, random_state

STATES = 256
ROUNDS = 101
SAMPLE_NS = 100_000.0
"""A sample takes at least so long, so that reading the clock does not matter."""
TOLERANCE = 1e-10
"""A peer agrees when it differs by less, relative to the largest entry of the output …"""
CONDITION = 1e-14
"""… plus so much for every unit of the mass matrix' condition number, where it is inverted."""
FLOAT_TOLERANCE = 1e-3
"""The same for what is computed in float."""
CONDITIONED = 5
"""States at which that condition number is computed."""
NOTHING = 1e-4
"""Outputs smaller than this are compared absolutely, as if they were of this size."""
INVERTED = ("forward_dynamics", "mass_matrix_inverse", "forward_dynamics_derivatives")

Say = Callable[[str], None]


@dataclass(frozen=True)
class Settings:
    """How to measure."""

    peers: tuple[str, ...] | None = None
    """None: all that are installed."""
    states: int = STATES
    rounds: int = ROUNDS
    batches: bool = True
    variants: str = "none"
    """Our functions in other forms: ``none``, ``standard`` (the main functions) or ``all`` (see
    `symgen.bench.peers.forms`)."""
    counting: bool = True
    """Whether instructions are counted, where there is valgrind."""
    folder: Path | None = None
    """Where generated and compiled files are kept; None: compiled ones in the user's cache, the rest nowhere."""
    limit_s: float = LIMIT_S


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
    started = time.process_time()
    system = derive(scene)
    for output in system.outputs:
        program = system.program(output.name)
        now = time.process_time()
        programs[output.name], milliseconds[output.name] = program, (now - started) * 1e3
        started = now
    return system, programs, milliseconds


def comparable(scene: Scene) -> tuple[Scene, list[str]]:
    """The scene as peers can have it: without springs and dampers, which they lack or keep elsewhere, and a floating
    base's velocity in its own axes, as most have it. What was changed is said."""
    notes = []
    if scene.forces or any(joint.damping for joint in scene.joints):
        scene = replace(scene, forces=(), joints=tuple(replace(joint, damping=Fraction(0)) for joint in scene.joints))
        notes.append(STRIPPED)
    floating = any(joint.type == "floating" for joint in scene.joints)
    if floating and scene.options.base_velocity != "body":
        scene = replace(scene, options=replace(scene.options, base_velocity="body"))
        notes.append("measured with base_velocity: body, which is the peers' convention")
    return (with_hash(scene) if notes else scene), notes


def bench(scene: Scene, settings: Settings = Settings(), say: Say = lambda what: None) -> BenchResult:
    """Measure every function the scene asks for, ours and the peers'; see `BenchResult` for the figures.

    Raises ToolError without a C compiler, SceneError for peers or variants of an unknown name. What a peer cannot do is
    said in the result.
    """
    peers, missing = registry.chosen(settings.peers)
    if settings.variants not in forms.CHOICES:
        raise SceneError(f"no variants {settings.variants!r}; there are: {', '.join(forms.CHOICES)}", "--variants")
    notes: list[str] = []
    alone = without_steps(scene.outputs)
    if alone != scene.outputs:
        scene = with_hash(replace(scene, outputs=alone))
        notes.append(
            "steps are left out, and what they call is measured: see python -m symgen.validation.work_precision"
        )
    if any(peer.physics for peer in peers):
        scene, changed = comparable(scene)
        notes += changed
    with ExitStack() as stack:
        scratch = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder = (settings.folder or scratch).resolve() / scene.name
        folder.mkdir(parents=True, exist_ok=True)
        kept = settings.folder / "compiled" if settings.folder else cache_folder() / "bench"
        workshop = open_workshop(kept, settings.limit_s, say)
        problem, milliseconds = pose(scene, settings, folder)
        found = collect(problem, workshop, peers, settings, say)
        found.left[:0] = missing
        return run(problem, workshop, found, settings, milliseconds, notes, scratch, say)


def pose(scene: Scene, settings: Settings, folder: Path) -> tuple[Problem, dict[str, float]]:
    system, programs, milliseconds = derive_programs(scene)
    states = sample_states(scene, system, settings.states)
    return Problem(scene, system, programs, {}, states, build_mechanism(scene), folder), milliseconds


def collect(
    problem: Problem, workshop: Workshop, peers: Sequence[registry.Peer], settings: Settings, say: Say
) -> Found:
    """Every variant whose files compile."""
    say("generating")
    found = ours.build(problem, settings.batches)
    if settings.variants != "none":
        say("generating other forms")
        more = forms.build(problem, found, settings.variants)
        found = Found(found.variants + more.variants, found.left + more.left)
    for peer in peers:
        say(peer.name)
        more = registry.build(peer, problem, workshop)
        found.variants += more.variants
        found.left += more.left
    return compiled_only(found, workshop)


def compiled_only(found: Found, workshop: Workshop) -> Found:
    """What compiles; the rest is said."""
    usable = []
    for variant in found.variants:
        try:
            for unit in variant.units:
                workshop.compile(unit, NATIVE)
                workshop.compile(unit, workshop.counted_flags())
            usable.append(variant)
        except CompileError as error:
            found.left.append(Left(variant.peer, variant.function, str(error)))
    return Found(usable, found.left)


def run(
    problem: Problem, workshop: Workshop, found: Found, settings: Settings, milliseconds: Mapping[str, float],
    notes: list[str], scratch: Path, say: Say,
) -> BenchResult:  # fmt: skip
    """Compare, time and count what was built."""
    probes = probe_variants(problem) if settings.counting else {}
    variants = [*found.variants, *probes.values()]
    driver = build_driver(workshop, variants, settings.states, problem.folder / "driver")
    say("comparing")
    truth = Truth(problem)
    judged = judge(problem, driver, driver.values(scratch), truth)
    agreeing = [index for index, _ in enumerate(found.variants) if judged[index].why is None]
    say("timing")
    times = driver.times(agreeing, settings.rounds, SAMPLE_NS)
    counts: dict[int, float] = {}
    if settings.counting:
        say("counting instructions")
        counts = driver.instructions([*agreeing, *range(len(found.variants), len(variants))], scratch)
    rows, left = [], list(found.left)
    for index, variant in enumerate(found.variants):
        why = judged[index].why
        if why is not None:
            left.append(Left(variant.peer, variant.function, why))
        else:
            rows.append(row_of(variant, workshop, judged[index].errors, times[index], counts.get(index)))
    facts = facts_of(problem, found.variants, milliseconds, floors_of(problem, driver, counts, probes))
    return BenchResult(
        problem.scene.name, problem.system.tree.nq, problem.nv, processor(), compiler_version(workshop.cc),
        " ".join(NATIVE), " ".join(workshop.counted_flags()), settings.states, settings.rounds, truth.states,
        truth.method, facts, tuple(rows), tuple(left), (*notes, *standing_notes(bool(counts), truth)),
        registry.versions({row.peer for row in rows}),
    )  # fmt: skip


def facts_of(
    problem: Problem, variants: Sequence[Variant], milliseconds: Mapping[str, float], floors: Mapping[str, float]
) -> tuple[FunctionFacts, ...]:
    """What is known of our functions; the floor is for straight-line code only."""
    own = {variant.function: variant for variant in variants if variant.peer == OURS}
    found = []
    for name, program in problem.programs.items():
        made = own.get(name)
        straight = made is None or made.plan == program.plan
        flops = count(program).flops if made is None or made.operations is None else made.operations
        plan = made.plan if made else program.plan
        floor_of_it = floors.get(name) if straight else None
        found.append(FunctionFacts(name, plan, flops, count(program).sincos, milliseconds[name], floor_of_it))
    return tuple(found)


@dataclass(frozen=True)
class Judged:
    """A variant's errors, and why it is not measured, if it is not."""

    errors: Errors
    why: str | None


def judge(problem: Problem, driver: Driver, values: Sequence[Array], truth: Truth) -> list[Judged]:
    """Every variant against the exact results; in double against ours too, at every state."""
    condition = condition_number(problem, problem.states[:CONDITIONED])
    own: dict[str, list[list[Array]]] = {}
    judged = []
    for variant, flat in zip(driver.variants, values, strict=True):
        if variant.function not in problem.programs:
            judged.append(Judged(Errors(0.0, 0.0, None), None))
            continue
        outputs = unpacked(variant, flat, problem)
        found = errors_of(outputs, truth.of(variant.function, variant.real), variant.real)
        bound = TOLERANCE + (CONDITION * condition if variant.function in INVERTED else 0.0)
        if variant.real == "float":
            apart, bound = found.largest, max(bound, FLOAT_TOLERANCE)
        else:
            first = own.setdefault(variant.function, outputs)
            apart = max(_apart(got, expected) for got, expected in zip(outputs, first, strict=True))
        from_what = "the exact result" if variant.real == "float" else "ours"
        why = None if apart <= bound else f"disagrees: {apart:.1e} apart from {from_what}, more than {bound:.0e}"
        judged.append(Judged(found, why))
    return judged


def _apart(got: Sequence[Array], expected: Sequence[Array]) -> float:
    """‖x − y‖∞ / ‖y‖∞, the largest over the outputs; absolute where y is next to nothing (constraints are zero)."""
    worst = 0.0
    for x, y in zip(got, expected, strict=True):
        if not np.all(np.isfinite(x)):
            return float("inf")
        scale = max(float(np.max(np.abs(y), initial=0.0)), NOTHING)
        worst = max(worst, float(np.max(np.abs(x - y), initial=0.0)) / scale)
    return worst


def _exact(program: Program, state: State) -> dict[str, Any]:
    return exact_outputs(program, {port.name: np.ravel(state[port.name]).tolist() for port in program.inputs})


def condition_number(problem: Problem, states: Sequence[State]) -> float:
    """The largest of the mass matrix over the states; 0 where no function inverts it."""
    if not any(name in INVERTED for name in problem.programs):
        return 0.0
    program = problem.system.program("mass_matrix")
    matrices = [np.array(_exact(program, state)["M"], dtype=float).reshape(problem.nv, problem.nv) for state in states]
    return float(max(np.linalg.cond(M) for M in matrices))


def row_of(
    variant: Variant, workshop: Workshop, errors: Errors, times: Sequence[float], instructions: float | None
) -> Row:
    """One row of the result. Size and compile time are left out where the compiled file serves more than this."""
    compiled: list[Compiled] = []
    if variant.sized:
        compiled = [workshop.compile(unit, NATIVE) for unit in variant.units]
    sizes = [made.text_bytes for made in compiled]
    return Row(
        variant.peer, variant.function, min(times), statistics.median(times), instructions, variant.operations,
        sum(size or 0 for size in sizes) if sizes and None not in sizes else None,
        sum(made.seconds for made in compiled) if compiled else None, variant.generate_s, errors.largest,
        errors.median, errors.units, variant.real, variant.plan, variant.own, variant.batch,
    )  # fmt: skip


def probe_variants(problem: Problem) -> dict[floor.Angles, Variant]:
    """Functions of nothing but the sines and cosines that the programs take, counted for the floor."""
    from symgen.generate import target_info

    info, rng = target_info(problem.system), np.random.default_rng(2)
    found: dict[floor.Angles, Variant] = {}
    for angles in dict.fromkeys(floor.angles_of(program) for program in problem.programs.values()):
        program, name = floor.probe(angles), floor.probe_name(angles)
        emitted = emit_c("probe", [program], info)
        headers = tuple((file, text) for file, text in emitted.files.items() if file.endswith(".h"))
        units = tuple(Unit(name, emitted.files[file], headers=headers) for file in emitted.sources)
        sizes = [port.size for port in program.outputs]
        outs = [f"{{out}} + {start}" for start in np.cumsum([0, *sizes])[:-1]]
        pointers = ", ".join(["const double *", *["double *"] * len(sizes)])
        q = rng.uniform(-3, 3, (len(problem.states), program.inputs[0].size))
        found[angles] = Variant(
            "probe", name, f"void probe_{name}({pointers});", f"probe_{name}({', '.join(['{q}', *outs])});", {"q": q},
            sum(sizes), lambda flat, state: [flat], units,
        )  # fmt: skip
    return found


def floors_of(
    problem: Problem, driver: Driver, counts: Mapping[int, float], probes: Mapping[floor.Angles, Variant]
) -> dict[str, float]:
    """The floor of every function whose probe was counted."""
    costs = {
        angles: floor.cost_of_angles(counts[driver.variants.index(variant)], angles)
        for angles, variant in probes.items()
        if driver.variants.index(variant) in counts
    }
    return {
        name: floor.floor(program, costs[floor.angles_of(program)])
        for name, program in problem.programs.items()
        if floor.angles_of(program) in costs
    }


def standing_notes(counted: bool, truth: Truth) -> list[str]:
    notes = [
        "times: CPU nanoseconds of a call, all variants in turn in every round of one process; results of Pinocchio's "
        "C++ and of MuJoCo stay in their own structures, those generated from Pinocchio have the upper triangle of "
        "symmetric matrices only",
        f"error: ‖x − x̂‖∞/‖x̂‖∞ against the exact program by {truth.method}, {truth.states} states; float at states "
        "that a float holds"
        + ("; units: the largest over u · max(1, κ), κ the condition of the problem" if truth.balls else ""),
    ]
    if not counted:
        return [*notes, "instructions were not counted: that needs valgrind"]
    return [
        *notes,
        f"instructions: callgrind, mean of {COUNTED_STATES} states (batches: of all, per state)",
        "floor: inputs read once, outputs written once, a fused multiply-add wherever one could be, and what the sines "
        "and cosines alone were counted to take, in scalar code",
    ]


def processor() -> str:
    """What the machine says it computes with."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()


__all__ = ["OURS", "Settings", "bench", "sample_states"]
