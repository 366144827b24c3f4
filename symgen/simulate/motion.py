"""What a simulation leaves: states along time, energies, monitors, and a way to look between."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symgen.errors import SceneError
from symgen.scene.document import clean

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Monitors:
    """What should not change, and how far it did."""

    energy_drift: float
    """max |E − E₀| / max(|E₀|, largest kinetic energy); says something where nothing drives or damps."""
    quaternion_drift: float
    """max | |quaternion| − 1 | before quaternions were normalised; what the motion depends on is their direction."""


@dataclass(frozen=True)
class Motion:
    """A motion: ``t`` (N), ``q`` (N, nq), ``v`` (N, nv), ``kinetic``, ``potential`` (N), SI units."""

    t: Array
    q: Array
    v: Array
    kinetic: Array
    potential: Array
    monitors: Monitors
    method: str
    steps: int
    evaluations: int
    """Of dy/dt, where the solver counts them, else 0."""
    cpu_seconds: float
    names: tuple[tuple[str, ...], tuple[str, ...]] = ((), ())
    """Of the entries of q and v."""
    between: Callable[[Array], Array] = field(default=lambda t: np.empty((0, 0)), repr=False, compare=False)
    """Times (M) → states (M, nq + nv)."""

    @property
    def energy(self) -> Array:
        """Kinetic plus potential."""
        return self.kinetic + self.potential

    def at(self, t: float | Array) -> tuple[Array, Array]:
        """q and v at any times of the motion, by the solver's own interpolation, or by cubic ones between steps.

        Raises ValueError outside the motion."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        if np.any(times < self.t[0]) or np.any(times > self.t[-1]):
            raise ValueError(f"the motion is from t = {self.t[0]:g} to {self.t[-1]:g}")
        y = self.between(times)
        nq = self.q.shape[1]
        found = (y[:, :nq], y[:, nq:])
        return found if np.ndim(t) else (found[0][0], found[1][0])

    def header(self) -> list[str]:
        q, v = self.names
        return ["t", *(f"q.{name}" for name in q), *(f"v.{name}" for name in v), "kinetic", "potential"]

    def table(self) -> Array:
        """One row a time: t, q, v, kinetic, potential."""
        return np.column_stack([self.t, self.q, self.v, self.kinetic, self.potential])

    def to_csv(self, path: str | Path | None = None) -> str:
        """The table as CSV, numbers with all their digits; written to ``path`` where given."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.header())
        writer.writerows([[repr(float(x)) for x in row] for row in self.table()])
        if path is not None:
            Path(path).write_text(text.getvalue(), encoding="utf-8")
        return text.getvalue()

    def to_json(self) -> dict[str, object]:
        """As JSON values; ``columns`` names the entries of ``rows``."""
        return {
            "method": self.method,
            "steps": self.steps,
            "evaluations": self.evaluations,
            "cpu_seconds": self.cpu_seconds,
            "monitors": {
                "energy_drift": self.monitors.energy_drift,
                "quaternion_drift": self.monitors.quaternion_drift,
            },
            "columns": self.header(),
            "rows": self.table().tolist(),
        }

    def to_text(self) -> str:
        """A few lines for people."""
        first = f"{self.method}: {self.t[-1]:g} s in {self.steps} steps, {self.cpu_seconds:.3g} s of CPU time"
        second = f"energy {self.energy[0]:.10g} J, drift {self.monitors.energy_drift:.1e}"
        if self.monitors.quaternion_drift:
            second += f"; quaternions off by {self.monitors.quaternion_drift:.1e} before they were normalised"
        return f"{first}\n{second}"

    def write(self, path: str | Path) -> None:
        """A file by its ending, .csv or .json, and the folders that it needs; a device gets CSV. Raises SceneError for
        another ending."""
        check_ending(path)
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix.lower() == ".json":
            path.write_text(json.dumps(self.to_json(), allow_nan=False) + "\n", encoding="utf-8")
        else:
            self.to_csv(path)


def check_ending(path: str | Path) -> None:
    """Raise SceneError for a file whose ending says neither .csv nor .json; known before anything is computed."""
    path = Path(path)
    device = path.exists() and not path.is_file() and not path.is_dir()
    if not device and path.suffix.lower() not in (".csv", ".json"):
        raise SceneError("is neither .csv nor .json, which are what a motion is written as", clean(str(path), 300))
