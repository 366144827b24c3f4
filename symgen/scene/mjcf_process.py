"""Runs MuJoCo's reader on an MJCF file in a process of its own, and takes what it found as exact numbers."""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from symgen.errors import SceneError, ToolError
from symgen.scene.document import clean
from symgen.scene.exact import check_range

SECONDS = 30
"""CPU time that MuJoCo's reader may take for one file."""

GRACE = 15
"""More seconds on the clock, when others work too."""

INSTALL = "pip install 'symgen[mjcf]'"
MAX_BODIES = 2000

CHILD = Path(__file__).with_name("mjcf_child.py")

Numbers = tuple[Fraction, ...]


@dataclass(frozen=True)
class CompiledBody:
    """A body of MuJoCo's compiled model; ``parent`` is an index, 0 the world."""

    name: str
    parent: int
    position: Numbers
    quaternion: Numbers
    """(w, x, y, z), of unit length but for rounding."""
    mass: Fraction
    com: Numbers
    axes: Numbers
    """Quaternion of the principal axes of inertia."""
    moments: Numbers
    full: Numbers
    """The file's own ixx, iyy, izz, ixy, ixz, iyz; empty when it gives none."""


@dataclass(frozen=True)
class CompiledJoint:
    """A joint of the compiled model: ``type`` is free, ball, slide or hinge; anchor and axis in the body's frame."""

    name: str
    type: str
    body: int
    anchor: Numbers
    axis: Numbers
    reference: Fraction
    """MuJoCo's coordinate where the body is as the file draws it."""
    spring_reference: Fraction
    stiffness: Fraction
    damping: Fraction
    armature: Fraction
    range: Numbers
    force_range: Numbers


@dataclass(frozen=True)
class CompiledSite:
    name: str
    body: int
    position: Numbers
    quaternion: Numbers


@dataclass(frozen=True)
class Compiled:
    """What MuJoCo made of an MJCF file. ``held`` counts what the file has beyond bodies, joints and sites."""

    name: str
    gravity: Numbers
    bodies: tuple[CompiledBody, ...]
    joints: tuple[CompiledJoint, ...]
    sites: tuple[CompiledSite, ...]
    held: dict[str, int]


def compile_mjcf(path: Path, file: str, seconds: int = SECONDS) -> Compiled:
    """Read and compile ``path``; ``file`` is its name in messages.

    Raises ToolError when MuJoCo is not installed, SceneError with MuJoCo's message when it refuses the file, fails on
    it, or is not done in time.
    """
    if importlib.util.find_spec("mujoco") is None:
        raise ToolError(f"{file}: MJCF files are read with MuJoCo, which is not installed: {INSTALL}")
    with tempfile.TemporaryDirectory(prefix="symgen-mjcf-") as folder:
        result = Path(folder) / "result.json"
        # -P: this folder holds modules that are called like the standard library's.
        python = [sys.executable or "python3", "-P", "-W", "ignore"]
        command = [*python, str(CHILD), str(path.absolute()), str(result), str(seconds), str(MAX_BODIES)]
        # MuJoCo writes its log where it runs: in the folder that goes away.
        said = _run(command, folder, file, seconds)
        if not result.exists():
            raise SceneError(f"MuJoCo's reader failed: {_last_line(said)}", file)
        data = json.loads(result.read_text(encoding="utf-8"), parse_float=Fraction, parse_int=int)
    if "refusal" in data:
        raise SceneError(clean(data["refusal"], 300), file)
    if "error" in data:
        raise SceneError(f"MuJoCo: {_one_line(data['error'], path)}", file)
    return _compiled(data, file)


def _run(command: list[str], folder: str, file: str, seconds: int) -> str:
    """What the process says on stderr. SceneError when it is not done in time, or dies."""
    path = os.pathsep.join(part for part in sys.path if part)  # wherever this process found its packages
    environment = {**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=seconds + GRACE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise SceneError(f"MuJoCo's reader is not done with it after {seconds} s", file) from None
    except OSError as error:
        raise ToolError(f"{file}: MuJoCo's reader cannot be started: {error.strerror or error}") from None
    if done.returncode < 0:
        if -done.returncode == getattr(signal, "SIGXCPU", None):
            raise SceneError(f"MuJoCo's reader is not done with it after {seconds} s", file)
        raise SceneError(f"MuJoCo's reader broke down on it ({_signal(-done.returncode)})", file)
    return done.stderr.decode("utf-8", "replace")


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return clean(lines[-1], 200) if lines else "it ended without a word"


def _one_line(message: str, path: Path) -> str:
    """MuJoCo's message without line breaks and without the folder."""
    flat = " ".join(message.split()).replace(f"{path.absolute().parent}{os.sep}", "")
    return clean(flat.removeprefix("XML Error: ").removeprefix("Error: "), 300)


# -- JSON → dataclasses ------------------------------------------------------------------------------------------------


def _compiled(data: dict[str, Any], file: str) -> Compiled:
    try:
        return Compiled(
            data["name"],
            _numbers(data["gravity"]),
            tuple(CompiledBody(**_exact(item)) for item in data["bodies"]),
            tuple(CompiledJoint(**_exact(item)) for item in data["joints"]),
            tuple(CompiledSite(**_exact(item)) for item in data["sites"]),
            {what: int(count) for what, count in data["held"].items() if count},
        )
    except ValueError as error:
        raise SceneError(str(error), file) from None


def _exact(item: dict[str, Any]) -> dict[str, Any]:
    """Numbers as rationals: those of the decimals that Python prints for MuJoCo's doubles."""
    return {
        key: _numbers(value) if isinstance(value, list) else _number(value) if isinstance(value, Fraction) else value
        for key, value in item.items()
    }


def _numbers(values: list[Any]) -> Numbers:
    return tuple(_number(Fraction(value)) for value in values)


def _number(value: Fraction) -> Fraction:
    return check_range(value, f"{float(value):g}") if abs(value) > 1 else value if abs(value) > TINY else Fraction(0)


TINY = Fraction(1, 10**300)
