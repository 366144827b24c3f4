"""Scenes, and measurements that take no time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.site.fakes import Put

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LINK = "{mass: 1, com: [0, 0, -0.5], inertia: [0.1, 0.1, 0.01, 0, 0, 0]"
SMALL = f"""name: NAME
bodies: [{LINK}, name: rod}}]
joints: [{{name: swing, type: revolute, parent: ground, child: rod, axis: [0, 1, 0]}}]
outputs: [mass_matrix, forward_dynamics]
options: {{targets: [c]}}
"""


def example(name: str) -> Path:
    return EXAMPLES / f"{name}.scene.yaml"


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """A scene of that name that costs little."""
    folder = tmp_path_factory.mktemp("scenes")

    def write(name: str) -> Path:
        path = folder / f"{name}.scene.yaml"
        path.write_text(SMALL.replace("NAME", name), encoding="utf-8")
        return path

    return write


@pytest.fixture
def put(monkeypatch: pytest.MonkeyPatch) -> Put:
    monkeypatch.delenv("SYMGEN_DEBUG", raising=False)
    return Put(monkeypatch)
