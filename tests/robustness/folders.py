"""Hand-made artifacts whose every file says which version it is of, and what a folder of them holds."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

from symgen.artifact import Artifact

SOURCES = 12


def version(k: int) -> dict[str, str | bytes]:
    """Version ``k`` of an artifact; odd ones have files that even ones have not."""
    sources = [f"demo_{i}.c" for i in range(SOURCES + k % 2)]
    casadi = "demo.casadi/f.casadi" if k % 2 else None
    manifest = {
        "format": 1, "name": f"v{k}", "sources": sources, "headers": ["demo.h"], "parameters": [],
        "functions": [{"name": "f", "symbol": None, "casadi_file": casadi}],
    }  # fmt: skip
    files: dict[str, str | bytes] = dict.fromkeys([*sources, "demo.h", "main.c", "CMakeLists.txt"], f"v{k}")
    if casadi:
        files[casadi] = f"v{k}".encode()
    return {**files, "manifest.json": json.dumps(manifest)}


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below ``folder``."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if not path.is_dir()}


def version_in(folder: Path) -> int:
    """Which version a folder holds, once whoever reads an artifact has read it; it must be whole, and nothing else."""
    k = int(Artifact(folder).manifest["name"].removeprefix("v"))
    wanted = {name: text.encode() if isinstance(text, str) else text for name, text in version(k).items()}
    assert contents(folder) == wanted
    return k


def in_child(work: Callable[[], object]) -> int:
    """Run ``work`` in a forked process; its wait status (0: it returned)."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            work()
            status = 0
        finally:
            os._exit(status)
    return os.waitpid(child, 0)[1]
