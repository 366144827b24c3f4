"""MJCF models against MuJoCo: every one is loaded and derived, and compared with MuJoCo at random states.

``python tools/mjcf_models.py [PATH | PACKAGE …]``: MJCF files, folders, or installed packages that ship some
(``dm_control``, ``gymnasium``, …). Prints one row per model: nq, nv, the worst relative difference of the mass matrix
and of the bias force (springs and dampers included; ‖x − x̂‖∞/‖x̂‖∞ over states), seconds, and what was left out or why
it failed (``no``: MuJoCo alone does not load it either). Models that say the same are shown once. ``--json FILE``
writes the rows.

Every model is read in a process of its own with a time limit. Both sides leave out what symgen does not model: MuJoCo's
tendon springs, gravity compensation, fluids and nonlinear joint forces are switched off in the comparison.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from symgen.algebra.numbers import FloatNumbers
from symgen.conventions import to_mujoco
from symgen.errors import SymgenError
from symgen.program.evaluate import evaluate
from symgen.scene.assemble import assemble
from symgen.scene.document import Document
from symgen.scene.model import Scene
from symgen.system import System, derive
from symgen.validation.mujoco_model import full_mass_matrix

CRITERION = 1e-12
STATES = 5
SNAP = Fraction(1, 10**13)
"""rad: only rounding is snapped, so that the file's own numbers are compared."""

PARTS = ("no joint can move", "is a part that an MJCF model includes")
"""What symgen says of furniture, and of parts to be included."""


def models(arguments: list[str]) -> Iterator[Path]:
    """Files whose text starts an MJCF model."""
    for argument in arguments:
        path = Path(argument)
        if not path.exists():
            found = importlib.util.find_spec(argument)
            if found is None or not found.submodule_search_locations:
                sys.exit(f"{argument}: neither a path nor an installed package")
            path = Path(found.submodule_search_locations[0])
        files = [path] if path.is_file() else sorted((*path.rglob("*.xml"), *path.rglob("*.mjcf")))
        yield from (file for file in files if b"<mujoco" in file.read_bytes()[:5000])


# -- one model, in a process of its own --------------------------------------------------------------------------------


class ArrayNumbers(FloatNumbers):
    """A program's scalars are arrays with one number per state."""

    def cos(self, x: Any) -> Any:
        return np.cos(x)

    def sin(self, x: Any) -> Any:
        return np.sin(x)


def scene_of(path: Path) -> Scene:
    data = {
        "name": "model",
        "model": path.name,
        "outputs": ["mass_matrix", "bias_force"],
        "options": {"base_velocity": "mixed", "snap": SNAP},
    }
    return assemble(Document(data, path.name), path.parent)


def mujoco_model(path: Path) -> Any:
    """MuJoCo's model of the file as it is; without its meshes where they are missing."""
    import mujoco

    from symgen.scene import mjcf_child

    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        return mjcf_child.compiled(str(path))[1]


def switch_off(model: Any) -> list[str]:
    """Set to zero what symgen does not model; what it was."""
    import mujoco

    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    names = (
        "tendon_stiffness", "tendon_damping", "tendon_armature", "tendon_stiffnesspoly", "tendon_dampingpoly",
        "body_gravcomp", "jnt_stiffnesspoly", "dof_dampingpoly", "jnt_springyield", "flex_edgestiffness",
        "flex_edgedamping", "flex_stiffness", "flex_bending", "flex_damping",
    )  # fmt: skip
    off = [name for name in names if np.any(getattr(model, name, 0))]
    for name in off:
        getattr(model, name)[:] = 0
    for name in ("density", "viscosity"):
        if getattr(model.opt, name):
            setattr(model.opt, name, 0.0)
            off.append(name)
    for i in range(model.njnt):
        if model.jnt_type[i] < 2 and model.jnt_stiffness[i]:  # free, ball
            model.jnt_stiffness[i] = 0
            off.append("ball stiffness")
    for k in range(model.nu):  # what tendons reflect
        if model.actuator_trntype[k] == mujoco.mjtTrn.mjTRN_TENDON and hasattr(model, "actuator_armature"):
            model.actuator_armature[k] = model.actuator_damping[k] = 0
    return list(dict.fromkeys(off))


def values(system: System, name: str, q: Any, v: Any) -> Any:
    """A row at many states, by its program in doubles."""
    program = system.program(name)
    (found,) = evaluate(program, ArrayNumbers(), {"q": q.T, "v": v.T}).values()
    columns = [np.broadcast_to(np.asarray(x, dtype=float), len(q)) for x in found]
    return np.stack(columns, -1)


def measure(path: Path) -> dict[str, Any]:
    """The row of one model."""
    import mujoco

    begun = time.perf_counter()
    scene = scene_of(path)
    loaded = time.perf_counter()
    system = derive(scene)
    nq, nv = system.tree.nq, system.tree.nv
    rng = np.random.default_rng(1)
    q, v = rng.uniform(-2.0, 2.0, (STATES, nq)), rng.uniform(-2.0, 2.0, (STATES, nv))
    for body in system.tree.bodies:
        if body.nq > body.nv:
            part = q[:, body.q + body.nq - 4 : body.q + body.nq]
            part /= np.linalg.norm(part, axis=1, keepdims=True)
    ours = {name: values(system, name, q, v) for name in ("mass_matrix", "bias_force")}
    derived = time.perf_counter()
    model = mujoco_model(path)
    off = switch_off(model)
    data, carry = mujoco.MjData(model), to_mujoco(system, model)
    full = np.zeros((model.nv, model.nv))
    worst = {"mass_matrix": 0.0, "bias_force": 0.0}
    for k, (position, velocity) in enumerate(zip(carry.q(q), carry.v(q, v), strict=True)):
        data.qpos[:], data.qvel[:] = position, velocity
        mujoco.mj_forward(model, data)
        full_mass_matrix(mujoco, model, data, full)
        theirs = {"mass_matrix": full.reshape(-1), "bias_force": data.qfrc_bias - data.qfrc_passive}
        for name, value in theirs.items():
            # A force may cancel: it is measured against a thousandth of its terms, too.
            size = float(np.abs(value).max())
            if name == "bias_force":
                size = max(size, 1e-3 * float(np.abs(full).max() * np.abs(velocity).max() ** 2))
            worst[name] = max(worst[name], float(np.abs(ours[name][k] - value).max()) / (size or 1.0))
    return {
        "nq": nq, "nv": nv, "bodies": len(scene.bodies), **worst, "load": loaded - begun, "derive": derived - loaded,
        "notes": list(scene.notes), "switched_off": off, "sha256": scene.sha256,
    }  # fmt: skip


def one(path: Path) -> dict[str, Any]:
    try:
        return measure(path)
    except SymgenError as error:
        return {"error": str(error), "mujoco": refusal(path)}


def refusal(path: Path) -> str:
    """Why MuJoCo alone does not load the file; empty when it does."""
    import mujoco

    try:
        mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        return " ".join(str(error).split())
    return ""


# -- many --------------------------------------------------------------------------------------------------------------


def apart(path: Path, seconds: int) -> dict[str, Any]:
    """`one` in another process; an error when it is not done in time."""
    command = [sys.executable, str(Path(__file__).absolute()), "--one", str(path.absolute())]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(part for part in sys.path if part)}
    try:
        with tempfile.TemporaryDirectory() as folder:  # MuJoCo writes its log where it runs
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=seconds, check=False, cwd=folder, env=environment
            )
    except subprocess.TimeoutExpired:
        return {"error": f"not done after {seconds} s"}
    lines = done.stdout.splitlines()
    try:
        row = json.loads(lines[-1])
    except (IndexError, ValueError):
        row = {"error": (done.stderr.splitlines() or ["ended without a word"])[-1]}
    return dict(row)


def verdict(row: dict[str, Any]) -> str:
    if "error" in row:
        if any(words in row["error"] for words in PARTS):
            return "part"
        return "no" if row.get("mujoco") else "FAIL"
    return "ok" if max(row["mass_matrix"], row["bias_force"]) <= CRITERION else "DIFF"


def line(path: Path, row: dict[str, Any], width: int) -> str:
    state, name = verdict(row), f"{path.parent.name}/{path.name}"
    if "error" in row:
        return f"{state:5}{name:{width}}{'':44}{row['error']}"
    numbers = f"{row['nq']:4}{row['nv']:4}{row['mass_matrix']:9.1e}{row['bias_force']:9.1e}"
    numbers += f"{row['load']:9.1f}{row['derive']:9.1f}"
    off = f"; switched off: {', '.join(row['switched_off'])}" if row["switched_off"] else ""
    return f"{state:5}{name:{width}}{numbers}  {'; '.join(row['notes'])}{off}"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("paths", nargs="+", help="MJCF files, folders or installed packages")
    parser.add_argument("--json", metavar="FILE", help="write the rows")
    parser.add_argument("--seconds", type=int, default=300, help="time limit of one model")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(one(Path(arguments.paths[0]))))
        return
    found = list(dict.fromkeys(models(arguments.paths)))
    width = max((len(f"{path.parent.name}/{path.name}") for path in found), default=0) + 2
    print(f"{'':5}{'model':{width}}{'nq':>4}{'nv':>4}{'M':>9}{'bias':>9}{'load s':>9}{'derive s':>9}  notes")
    rows: list[dict[str, Any]] = []
    seen: set[str] = set()
    tally: Counter[str] = Counter()
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for path, row in zip(found, pool.map(lambda p: apart(p, arguments.seconds), found), strict=True):
            state = verdict(row)
            state = "same" if row.get("sha256") in seen else state
            seen.add(row.get("sha256", ""))
            seen.discard("")
            tally[state] += 1
            rows.append({"model": str(path), "verdict": state, **row})
            if state not in ("same", "part"):
                print(line(path, row, width), flush=True)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=1) + "\n")
    said = {
        "ok": "agree", "DIFF": "differ", "FAIL": "fail", "no": "refused by MuJoCo too",
        "same": "say the same as another", "part": "are parts or cannot move",
    }  # fmt: skip
    print(", ".join(f"{count} {said[state]}" for state, count in tally.items()))
    worst = [max(row["mass_matrix"], row["bias_force"]) for row in rows if row["verdict"] == "ok"]
    print(f"worst difference of those that agree: {max(worst, default=math.nan):.1e}")
    sys.exit(1 if tally["DIFF"] or tally["FAIL"] else 0)


if __name__ == "__main__":
    main()
