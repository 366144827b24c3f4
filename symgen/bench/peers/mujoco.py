"""MuJoCo through its C interface, on the model that the validation builds of the scene.

MuJoCo's velocities of a floating base are `base_velocity: mixed`: states are given in its coordinates, and what it
returns is turned into ours before it is compared.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path

import numpy as np

from symgen.bench.text import template
from symgen.bench.variant import INPUTS, Array, Found, Problem, State, Unit, Variant
from symgen.bench.workshop import CompileError, Workshop
from symgen.errors import NotSupportedError
from symgen.validation.mujoco_model import MuJoCo, build_mujoco

NAME = "mujoco"
HAS = ("mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics")


def home() -> Path | None:
    spec = importlib.util.find_spec("mujoco")
    folder = Path(spec.origin).parent if spec is not None and spec.origin else None
    return folder if folder and (folder / "include" / "mujoco" / "mujoco.h").exists() else None


def has_mujoco() -> bool:
    return home() is not None


def library(folder: Path) -> Path:
    """The shared library in MuJoCo's wheel."""
    found = sorted(folder.glob("libmujoco.so*")) or sorted(folder.glob("libmujoco*.dylib"))
    if not found:
        raise CompileError("MuJoCo's library is missing")
    return found[0]


def build(problem: Problem, workshop: Workshop) -> Found:
    """Kinematics and the algorithm by the functions that mj_forward itself calls."""
    folder = home()
    if folder is None:
        raise CompileError("MuJoCo's headers are missing")
    adapter = build_mujoco(problem.scene)
    if adapter.model.nv != problem.nv or np.any(adapter.loose_armature):
        raise NotSupportedError("coupled joints and the armature of a floating base are different in MuJoCo")
    path = problem.folder / "mujoco.mjb"
    adapter.mujoco.mj_saveModel(adapter.model, str(path), None)
    unit = Unit("bench_mujoco", template("mujoco.c"), includes=(folder / "include",), limited=False)
    shared = library(folder)
    arrays = columns(adapter, problem)
    found = Found()
    for name in (row for row in HAS if row in problem.wanted):
        pointers = ", ".join(["const double *"] * len(INPUTS[name]))
        found.variants.append(
            Variant(
                NAME, name,
                "int bench_mujoco_open(const char *);\nvoid bench_mujoco_fetch(const char *, double *);\n"
                f"void bench_mujoco_{name}({pointers});",
                f"bench_mujoco_{name}({', '.join(f'{{{key}}}' for key in INPUTS[name])});",
                {key: arrays[key] for key in INPUTS[name]}, sum(problem.shapes(name)),
                unpacking(adapter, problem, name), (unit,), (str(shared), f"-Wl,-rpath,{folder}"),
                fetch=f'bench_mujoco_fetch("{name}", {{out}});',
                setup=f'if (bench_mujoco_open("{path}")) return 1;', sized=False,
            )
        )  # fmt: skip
    return found


def columns(adapter: MuJoCo, problem: Problem) -> dict[str, Array]:
    """The states in MuJoCo's coordinates."""
    rows: dict[str, list[Array]] = {"q": [], "v": [], "a": [], "tau": []}
    for state in problem.states:
        S, rate = adapter.maps(state["q"], state["v"])
        rows["q"].append(adapter.expand(state["q"]))
        rows["v"].append(S @ state["v"])
        rows["a"].append(S @ state["a"] + rate)
        rows["tau"].append(S @ state["tau"])
    return {name: np.array(values) for name, values in rows.items()}


def unpacking(adapter: MuJoCo, problem: Problem, name: str) -> Callable[[Array, State], list[Array]]:
    """MuJoCo's results in symgen's coordinates; S is orthogonal."""
    n = problem.nv

    def unpack(flat: Array, state: State) -> list[Array]:
        S, rate = adapter.maps(state["q"], state["v"])
        if name == "mass_matrix":
            return [np.ravel(S.T @ flat.reshape(n, n) @ S)]
        if name == "forward_dynamics":
            return [S.T @ (flat - rate)]
        if name == "bias_force" and np.any(rate):  # at its own zero acceleration, which is not ours
            return [S.T @ flat + adapter.mass_matrix(state["q"]) @ (S.T @ rate)]
        return [S.T @ flat]

    return unpack
