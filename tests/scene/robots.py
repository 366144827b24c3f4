"""Where the URDF files of real robots are, if they are installed."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest

UR5 = "ur_description/urdf/ur5_robot.urdf"
PANDA = "panda_description/urdf/panda.urdf"


def robot(path: str) -> Path:
    """The file, or skip the test: ``pip install 'symgen[robots]'`` brings it."""
    try:
        installed = distribution("example-robot-data").files or []
    except PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    for file in installed:
        if str(file).endswith(path):
            return Path(str(file.locate()))
    pytest.skip(f"example-robot-data has no {path}")
