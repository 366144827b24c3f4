"""Where the URDF files of real robots are, if they are installed."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest

UR5 = "ur_description/urdf/ur5_robot.urdf"
PANDA = "panda_description/urdf/panda.urdf"


@cache
def robots() -> dict[str, Path]:
    """``panda_description/urdf/panda.urdf`` → its file, of every URDF in example-robot-data; empty without it."""
    try:
        installed = distribution("example-robot-data").files or []
    except PackageNotFoundError:
        return {}
    files = [Path(str(file.locate())) for file in installed if file.suffix == ".urdf"]
    return {"/".join(file.parts[-3:]): file for file in sorted(files)}


def robot(path: str) -> Path:
    """The file, or skip the test: ``pip install 'symgen[robots]'`` brings it."""
    if not robots():
        pytest.skip("example-robot-data is not installed")
    if path not in robots():
        pytest.skip(f"example-robot-data has no {path}")
    return robots()[path]
