"""Programs that measurements are made with where they are installed, and their versions, without importing them."""

from __future__ import annotations

import importlib.metadata
import importlib.util
from collections.abc import Sequence

ABSENT = "absent"
MODULES = {
    "pin": "pinocchio", "exudyn": "exudyn", "mujoco": "mujoco", "casadi": "casadi", "cmeel-cppadcodegen": "",
    "adam-robotics": "adam", "sympy": "sympy", "scipy": "scipy", "python-flint": "flint",
}  # fmt: skip
"""Package → the module that it is imported by; empty where it has none."""


def installed(packages: Sequence[str]) -> dict[str, str]:
    """Package → its version, ``of no version`` where only the module is found, or ``absent``."""
    return {package: _version(package) for package in packages}


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        module = MODULES[package]
        return "of no version" if module and importlib.util.find_spec(module) is not None else ABSENT
