"""Work–precision diagrams: CPU time against global error, steps or tolerances swept, everything in one run.

Per scene one motion from one generic start. Error: largest difference of link positions (m) and entries of rotation
matrices at its end from the reference, DOP853 at its finest; how far Pinocchio's own reference is from that is printed.
Time: CPU time of the integration alone, least of `REPEATS`, without deriving, compiling, building models and energies.
Exudyn and the generated steps loop inside C++ and C; SciPy calls the right-hand side, ours or Pinocchio's, from Python.

    python -m tools.work_precision [-o out/work_precision] [SCENE …]
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from symgen.errors import SymgenError
from symgen.scene.canonical import with_hash
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.simulate.model import Model
from symgen.simulate.run import integrators, simulate
from symgen.validation import exudyn_bodies, exudyn_tree
from symgen.validation.exudyn_model import settings
from symgen.validation.mechanism import Array, Mechanism, build_mechanism, link_poses, position_rate
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio
from symgen.validation.trajectories import flat, start_state

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SCENES = ("double_pendulum", "spinning_top", "fig1", "fig2", "panda")
REPEATS = 3
STEPS = tuple(2**k for k in range(4, 15))
TOLERANCES = tuple(10.0**-k for k in range(2, 14))
FINEST: dict[str, Any] = {"rtol": 1e-13, "atol": 1e-15}
USELESS = 0.1
"""Errors from here on are listed as failed: not a digit is right."""
LONGEST = 20.0
"""Seconds of CPU time from which on finer points of a method are left out."""
SEED = 7
PLAIN = ("revolute", "prismatic", "spherical", "floating")


@dataclass(frozen=True)
class Point:
    """One run."""

    scene: str
    program: str
    integrator: str
    knob: str
    setting: float
    error: float
    cpu_seconds: float
    failed: str = ""


@dataclass(frozen=True)
class Setting:
    """A scene, its start, and the poses that are right."""

    scene: Scene
    mechanism: Mechanism
    q: Array
    v: Array
    end: float
    model: Model
    right: Array


Run = Callable[[Setting, float], tuple[Array, float]]
"""(setting, steps or tolerance) → poses at the end, CPU seconds."""


def poses(mechanism: Mechanism, q: Array) -> Array:
    return flat([link_poses(mechanism, q)])


# --- programs --------------------------------------------------------------------------------------------------------


def ours(method: str) -> Run:
    def run(at: Setting, knob: float) -> tuple[Array, float]:
        stepped = method in at.model.steps
        how: dict[str, Any] = {"dt": at.end / knob} if stepped else {"rtol": knob, "atol": knob * 1e-2}
        motion = simulate(at.model, list(at.q), list(at.v), at.end, method=method, samples=2, **how)
        return poses(at.mechanism, motion.q[-1]), motion.cpu_seconds

    return run


def pinocchio(method: str) -> Run:
    def run(at: Setting, knob: float) -> tuple[Array, float]:
        rate, nq = pinocchio_rate(at, build_pinocchio(at.scene)), at.mechanism.nq
        began = time.process_time()
        y = np.concatenate([at.q, at.v])
        solver = getattr(integrators(), method)(rate, 0.0, y, at.end, rtol=knob, atol=knob * 1e-2)
        while solver.status == "running":
            solver.step()
            solver.dense_output()
        spent = time.process_time() - began
        q = np.array(solver.y[:nq])
        return poses(at.mechanism, normalised(at.mechanism, q)), spent

    return run


def pinocchio_rate(at: Setting, theirs: Pinocchio) -> Callable[[float, Array], Array]:
    """dy/dt by ABA. Where Pinocchio's coordinates are ours and nothing is added, without our adapter between."""
    nq, zero = at.mechanism.nq, np.zeros(at.mechanism.nv)
    links = at.mechanism.links
    plain = all(link.joint.type in PLAIN and link.coupling is None for link in links)
    if plain and not at.scene.forces and theirs.model.nq == nq and same_velocities(at, theirs):
        aba, model, data = theirs.pin.aba, theirs.model, theirs.data
        damping = np.zeros(at.mechanism.nv)
        for link in links:
            damping[link.v] = float(link.joint.damping)
        turning = [link for link in links if link.joint.type in ("spherical", "floating")]
        if not turning:
            return lambda _t, y: np.concatenate([y[nq:], aba(model, data, y[:nq], y[nq:], -damping * y[nq:])])
        places = [(link.q.start, link.v.start, link.joint.type == "floating") for link in turning]
        vectors = [(link.q, link.v) for link in links if link not in turning]

        def lean(_t: float, y: Array) -> Array:
            found, q, v = np.empty(y.size), y[:nq], y[nq:]
            for to, of in vectors:
                found[to] = v[of]
            for place, first, floating in places:
                quaternion_rate(q, v, found, place, first, floating)
            found[nq:] = aba(model, data, q, v, -damping * v)
            return found

        return lean

    def rate(_t: float, y: Array) -> Array:
        q, v = y[:nq], y[nq:]
        return np.concatenate([position_rate(at.mechanism, q, v), theirs.forward_dynamics(q, v, zero)])

    return rate


def same_velocities(at: Setting, theirs: Pinocchio) -> bool:
    """Whether Pinocchio's v is ours, at two configurations."""
    maps = [theirs.velocity_map(q, at.v).S for q in (at.q, np.roll(at.q, 1))]
    return all(np.array_equal(found, np.eye(at.mechanism.nv)) for found in maps)


def quaternion_rate(q: Array, v: Array, found: Array, place: int, first: int, floating: bool) -> None:
    """dq/dt of a spherical joint, or of a floating one with velocities in its own axes; in plain floats, which are
    faster than arrays of three."""
    if floating:
        a, b, c = v[first : first + 3].tolist()
        x, y, z, w = q[place + 3 : place + 7].tolist()
        s = 2.0 / (x * x + y * y + z * z + w * w)
        k, m, n = s * (y * c - z * b), s * (z * a - x * c), s * (x * b - y * a)
        found[place] = a + w * k + y * n - z * m
        found[place + 1] = b + w * m + z * k - x * n
        found[place + 2] = c + w * n + x * m - y * k
        place, first = place + 3, first + 3
    a, b, c = v[first : first + 3].tolist()
    x, y, z, w = q[place : place + 4].tolist()
    found[place] = 0.5 * (w * a + y * c - z * b)
    found[place + 1] = 0.5 * (w * b + z * a - x * c)
    found[place + 2] = 0.5 * (w * c + x * b - y * a)
    found[place + 3] = -0.5 * (x * a + y * b + z * c)


def normalised(mechanism: Mechanism, q: Array) -> Array:
    for link in mechanism.links:
        if link.joint.type in ("spherical", "floating"):
            part = q[link.q]
            part[-4:] /= np.linalg.norm(part[-4:])
            q[link.q] = part
    return q


def exudyn(formulation: str, solver: str) -> Run:
    def run(at: Setting, knob: float) -> tuple[Array, float]:
        if formulation == "tree":
            model = exudyn_tree.build_exudyn_tree(at.scene, at.q, at.v).model
        else:
            model = exudyn_bodies.build_exudyn_bodies(at.scene, at.q, at.v)
        if solver == "DOPRI5":
            return adaptive(model, at.end, knob)
        began = time.process_time()
        found = model.simulate(round(knob), at.end, 1, solver)
        return flat(found), time.process_time() - began

    return run


def adaptive(model: Any, end: float, tolerance: float) -> tuple[Array, float]:
    """Exudyn's DOPRI5; sensors are read at its last step, which is the end."""
    options = settings(model.exu, 10, end)
    options.solutionSettings.sensorsWritePeriod = end
    options.timeIntegration.automaticStepSize = True
    options.timeIntegration.adaptiveStep = True
    options.timeIntegration.relativeTolerance = tolerance
    options.timeIntegration.absoluteTolerance = tolerance * 1e-2
    began = time.process_time()
    model.mbs.SolveDynamic(options, solverType=model.exu.DynamicSolverType.DOPRI5)
    spent = time.process_time() - began
    found = []
    for (place, turn), local in zip(model.sensors, model.local, strict=True):
        position, rotation = (np.array(model.mbs.GetSensorStoredData(sensor))[-1] for sensor in (place, turn))
        if abs(position[0] - end) > 1e-9 * end:
            raise RuntimeError(f"stopped at t = {position[0]:g} s")
        found.append(type(local)(rotation[1:].reshape(3, 3), position[1:]) @ local)
    return flat([found]), spent


def programs(at: Setting) -> Iterator[tuple[str, str, str, Sequence[float], Run]]:
    """(program, integrator, knob, settings, run)."""
    for method in at.model.steps:
        yield "symgen (C)", f"step:{method}", "steps", STEPS, ours(method)
    for method in ("DOP853", "RK45", "LSODA", "Radau"):
        yield "symgen (SciPy)", method, "rtol", TOLERANCES, ours(method)
    for method in ("DOP853", "RK45"):
        yield "Pinocchio ABA (SciPy)", method, "rtol", TOLERANCES, pinocchio(method)
    if not exudyn_tree.refusal(at.scene):
        for method in ("RK44", "RK67"):
            yield "Exudyn KinematicTree", method, "steps", STEPS, exudyn("tree", method)
        yield "Exudyn KinematicTree", "DOPRI5", "rtol", TOLERANCES, exudyn("tree", "DOPRI5")
    if not exudyn_bodies.refusal(at.scene):
        yield "Exudyn redundant", "GeneralizedAlpha", "steps", STEPS, exudyn("bodies", "GeneralizedAlpha")


# --- runs ------------------------------------------------------------------------------------------------------------


def prepare(path: Path, end: float) -> tuple[Setting, float]:
    """The setting, and how far Pinocchio's reference is from ours."""
    scene = load(path)
    scene = with_hash(replace(scene, options=replace(scene.options, base_velocity="body")))  # Pinocchio's
    mechanism = build_mechanism(scene)
    steps = ["semi_implicit_euler", "rk4", "implicit_midpoint"]
    if any(link.joint.type in ("spherical", "floating") for link in mechanism.links):
        steps.insert(2, "lie")
    model = Model(scene, steps)
    q, v = start_state(mechanism, SEED)
    motion = simulate(model, list(q), list(v), end, samples=2, **FINEST)
    at = Setting(scene, mechanism, q, v, end, model, poses(mechanism, motion.q[-1]))
    theirs, _ = pinocchio("DOP853")(at, FINEST["rtol"])
    return at, float(np.abs(theirs - at.right).max())


def point(at: Setting, blank: Point, run: Run) -> Point:
    """One point of a diagram, or why there is none."""
    try:
        found = [run(at, blank.setting) for _ in range(REPEATS)]
    except Exception as error:  # whatever a solver says when it gives up
        return replace(blank, failed=" ".join(str(error).split())[:100] or type(error).__name__)
    error = float(np.abs(found[0][0] - at.right).max())
    spent = min(spent for _, spent in found)
    useless = "" if math.isfinite(error) and error < USELESS else f"error {error:.1e}"
    return replace(blank, error=error, cpu_seconds=spent, failed=useless)


def sweep(at: Setting, floor: float) -> Iterator[Point]:
    """Every program, from coarse to fine; a method ends where it no longer gains, or takes too long."""
    for program, integrator, knob, values, run in programs(at):
        gone: list[float] = []
        for value in values:
            blank = Point(at.scene.name, program, integrator, knob, value, math.nan, math.nan)
            found = point(at, blank, run)
            yield found
            if found.failed:
                continue
            gone.append(found.error)
            if found.cpu_seconds > LONGEST / REPEATS or (len(gone) > 2 and gone[-1] < 10 * floor > gone[-2] > 0):
                break


# --- what is left -----------------------------------------------------------------------------------------------------


def figure(name: str, points: Sequence[Point], floor: float, folder: Path) -> None:
    """NAME.png and NAME.svg: one line a method; failed points and the reference itself are not drawn."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams["svg.hashsalt"] = "symgen"
    colours = {"symgen (C)": "C0", "symgen (SciPy)": "C2", "Pinocchio ABA (SciPy)": "C1"}
    colours |= {"Exudyn KinematicTree": "C3", "Exudyn redundant": "C5"}
    marks = "osD^vP*"
    axes_figure, axes = plt.subplots(figsize=(9.0, 5.6), layout="constrained")
    methods = dict.fromkeys((p.program, p.integrator) for p in points)
    counts: dict[str, int] = {}
    for program, integrator in methods:
        mine = [p for p in points if (p.program, p.integrator) == (program, integrator) and not p.failed and p.error]
        k = counts[program] = counts.get(program, -1) + 1
        if mine:
            x, y = [max(p.error, 1e-16) for p in mine], [p.cpu_seconds for p in mine]
            style = ("-", "--", "-.", ":")[k % 4]
            label = f"{program}: {integrator}"
            axes.plot(x, y, style, marker=marks[k % 7], ms=4, lw=1.2, color=colours[program], label=label)
    axes.axvspan(1e-17, max(floor, 1e-16), color="0.5", alpha=0.15, lw=0)
    axes.set(
        xscale="log", yscale="log", xlabel="global error of positions and rotation matrices (grey: references differ)"
    )
    axes.set(ylabel="CPU time, s", title=name)
    axes.set_xlim(1e-16, 1.0)
    axes.invert_xaxis()
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    for suffix in ("png", "svg"):
        metadata = {"Date": None} if suffix == "svg" else None
        axes_figure.savefig(folder / f"{name}.{suffix}", dpi=130, metadata=metadata)
    plt.close(axes_figure)


def summary(points: Sequence[Point]) -> Iterator[str]:
    """Per method the least CPU time with an error up to 1e-4, 1e-7 and 1e-10, and what failed."""
    bars = (1e-4, 1e-7, 1e-10)
    yield f"  {'program':24}{'integrator':26}" + "".join(f"{f'ms to {bar:.0e}':>14}" for bar in bars) + "  failed"
    for program, integrator in dict.fromkeys((p.program, p.integrator) for p in points):
        mine = [p for p in points if (p.program, p.integrator) == (program, integrator)]
        cells = []
        for bar in bars:
            good = [p.cpu_seconds for p in mine if not p.failed and p.error <= bar]
            cells.append(f"{1e3 * min(good):14.3f}" if good else f"{'–':>14}")
        lost = [p for p in mine if p.failed]
        last = f"{len(lost)} ({lost[0].knob} {lost[0].setting:g} …: {lost[0].failed})" if lost else ""
        yield f"  {program:24}{integrator:26}{''.join(cells)}  {last}"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("-o", "--output", default="out/work_precision", type=Path)
    parser.add_argument("--time", default=1.0, type=float, help="seconds of motion")
    parser.add_argument("scenes", nargs="*", default=list(SCENES))
    options = parser.parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    for name in options.scenes:
        path = Path(name) if "." in name else EXAMPLES / f"{name}.scene.yaml"
        try:
            at, floor = prepare(path, options.time)
        except SymgenError as error:
            print(f"{name}: {error}", file=sys.stderr)
            return error.exit_status
        print(f"{at.scene.name}: {at.end:g} s; the references differ by {floor:.1e}", flush=True)
        points = list(sweep(at, floor))
        with (options.output / f"{at.scene.name}.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, [*asdict(points[0])], lineterminator="\n")
            writer.writeheader()
            writer.writerows(asdict(p) for p in points)
        rows = [
            {k: None if isinstance(x, float) and not math.isfinite(x) else x for k, x in asdict(p).items()}
            for p in points
        ]
        document = {"scene": at.scene.name, "seconds": at.end, "references_differ": floor, "points": rows}
        (options.output / f"{at.scene.name}.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
        figure(at.scene.name, points, floor, options.output)
        print("\n".join(summary(points)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
