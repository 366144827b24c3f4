"""A scene compiled for motions: dy/dt of y = (q, v), steps in a loop of C, and energies."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.artifact.compiler import RELEASE_FLAGS, cache_folder, find_compiler, shared_library
from symgen.artifact.load import Loaded
from symgen.errors import NotSupportedError, SceneError
from symgen.generate import Progress, generate
from symgen.scene.load import load
from symgen.scene.model import Output, Scene
from symgen.scene.outputs import STEPS
from symgen.scene.request import request
from symgen.targets.c.templates import render

Array = NDArray[np.float64]
DRIVER = "motion-driver.c"
ROWS = ("forward_dynamics", "configuration_rate", "kinetic_energy", "potential_energy")


def numbers(given: object, size: int, what: str, place: str) -> Array:
    """So many finite numbers. Raises SceneError that says how many there are, or which is none."""
    values = np.asarray(given, dtype=np.float64)
    if values.shape != (size,):
        found = str(values.size) if values.ndim == 1 else f"an array {values.shape}"
        needed = f"one finite {what} is" if size == 1 else f"{size} finite {what}s are"
        raise SceneError(f"{needed} needed, not {found}", place)
    for k in np.flatnonzero(~np.isfinite(values)):
        raise SceneError(f"{what}s must be finite, and the one at {k} is {values[k]}", place)
    return values


class Model:
    """The compiled functions of a scene that motions need. ``steps``: methods whose steps are wanted.

    Raises SymgenError for scenes without such functions, ToolError without a C compiler.
    """

    def __init__(
        self,
        scene: Scene | str | Path,
        steps: Sequence[str] = (),
        p: Sequence[float] | None = None,
        progress: Progress | None = None,
    ) -> None:
        scene = load(scene) if isinstance(scene, str | Path) else scene
        unknown = next((name for name in steps if name not in STEPS), None)
        if unknown is not None:
            raise SceneError(f"no step method {unknown!r}; there are {', '.join(STEPS)}", "method")
        rows = (*ROWS, *(f"step:{name}" for name in steps))
        self.scene = request(scene, tuple(Output(row, (row,)) for row in rows), "double", ("c",))
        self.steps = tuple(steps)
        with tempfile.TemporaryDirectory() as folder:
            artifact = generate(self.scene, Path(folder, "code"), progress)
            manifest = artifact.manifest
            self.functions: Loaded = artifact.load()
            names = [*manifest["sources"], *manifest["headers"]]
            texts = {name: (artifact.directory / name).read_text(encoding="utf-8") for name in names}
        self.nq, self.nv = int(manifest["nq"]), int(manifest["nv"])
        self.joints: list[dict[str, Any]] = manifest["joints"]
        self.p = self._parameters(manifest, p)
        self._library = self._compiled(manifest, texts)

    def _parameters(self, manifest: dict[str, Any], given: Sequence[float] | None) -> Array:
        defaults = [value for row in manifest["parameters"] for value in row["default"]]
        p = np.ascontiguousarray(defaults if given is None else given, dtype=np.float64)
        if p.shape != (len(defaults),):
            raise SceneError(f"{len(defaults)} parameters are needed, {p.size} are given", "p")
        return p

    def _compiled(self, manifest: dict[str, Any], texts: dict[str, str]) -> ctypes.CDLL:
        name = str(manifest["name"])
        texts[DRIVER] = render(
            "c/motion.c.j2",
            header=f"{name}.h",
            name=name,
            nq=self.nq,
            ny=self.nq + self.nv,
            methods=self.steps,
            p=", p" if manifest["parameters"] else "",
        )
        sources = [*manifest["sources"], DRIVER]
        library = shared_library(name, texts, sources, find_compiler(), RELEASE_FLAGS, cache_folder())
        handle = ctypes.CDLL(str(library))
        handle.motion_rate.restype = None
        for method in self.steps:
            entry = getattr(handle, f"motion_{method}")
            entry.argtypes = [ctypes.c_size_t] * 2 + [ctypes.c_void_p, ctypes.c_double] + [ctypes.c_void_p] * 3
            entry.restype = None
        return handle

    @property
    def quaternions(self) -> tuple[int, ...]:
        """Where the quaternions start in q."""
        kinds = ("spherical", "floating")
        return tuple(row["q"][0] + row["q"][1] - 4 for row in self.joints if row["type"] in kinds)

    @property
    def names(self) -> tuple[list[str], list[str]]:
        """A name for every entry of q and of v."""
        q, v = [""] * self.nq, [""] * self.nv
        for row in self.joints:
            if "mimic" in row:
                continue
            for names, (start, size) in ((q, row["q"]), (v, row["v"])):
                for k in range(size):
                    names[start + k] = row["name"] if size == 1 else f"{row['name']}.{k}"
        return q, v

    def start(self, q0: Sequence[float] | None, v0: Sequence[float] | None) -> Array:
        """The state (q, v): zeros where nothing is given, quaternions at no rotation; given ones are normalised.

        Raises SceneError for wrong sizes, values that are no numbers, and a quaternion of zeros."""
        q, v = np.zeros(self.nq), np.zeros(self.nv)
        for place in self.quaternions:
            q[place + 3] = 1.0
        for name, array, given in (("q0", q, q0), ("v0", v, v0)):
            if given is not None:
                array[:] = numbers(given, array.size, "number", name)
        for place in self.quaternions:
            norm = np.linalg.norm(q[place : place + 4])
            if norm == 0.0:
                raise SceneError(f"the quaternion at q[{place}] is zero", "q0")
            q[place : place + 4] /= norm
        return np.concatenate([q, v])

    def rate(self) -> Callable[[Array, Array], Array]:
        """dy/dt as a function of y and tau. It has arrays of its own, whose addresses are asked for once: that would
        cost more than the call."""
        state, load, found = np.zeros(self.nq + self.nv), np.zeros(self.nv), np.zeros(self.nq + self.nv)
        entry = self._library.motion_rate
        places = [ctypes.c_void_p(array.ctypes.data) for array in (state, load, self.p, found)]

        def rate(y: Array, tau: Array) -> Array:
            state[:] = y
            load[:] = tau
            entry(*places)
            return found.copy()

        return rate

    def step(self, method: str, steps: int, every: int, tau: Array, dt: float, y: Array) -> Array:
        """``steps`` steps from y, which is left at the end; the states after every ``every`` of them, a row each."""
        if method not in self.steps:
            raise NotSupportedError(f"this model was made without step:{method}")
        kept = np.empty((steps // every, y.size))
        entry = getattr(self._library, f"motion_{method}")
        entry(steps, every, tau.ctypes.data, dt, self.p.ctypes.data, y.ctypes.data, kept.ctypes.data)
        return kept

    def energies(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Kinetic and potential energy of every row, J."""
        f = self.functions
        p = {"p": self.p} if self.p.size else {}
        kinetic = np.asarray(f.kinetic_energy(q, v, **p)).ravel()
        return kinetic, np.asarray(f.potential_energy(q, **p)).ravel()
