"""What a file is does not depend on what it is called."""

from __future__ import annotations

from pathlib import Path

import pytest

from symgen.scene.load import load
from tools.seeds import SEEDS

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
MESHED = """\
<mujoco model="meshed">
  <include file="sub/part.xml"/>
  <worldbody><body name="b"><joint type="hinge" axis="0 0 1"/><geom type="mesh" mesh="t"/></body></worldbody>
</mujoco>
"""


@pytest.mark.parametrize("suffix", [".xml", ".mjcf", ".model", ""])
def test_mujoco_models(suffix: str, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "part.xml").write_text('<mujoco><asset><mesh name="t" file="t.obj"/></asset></mujoco>')
    for folder in (tmp_path, tmp_path / "sub"):
        (folder / "t.obj").write_text(TETRAHEDRON)
    path = tmp_path / f"model{suffix}"
    path.write_text(MESHED)
    assert float(load(path).body("b").mass) == pytest.approx(1000 / 6)
    path.write_text(SEEDS["good.xml"])
    assert len(load(path).joints) > 3


@pytest.mark.parametrize("name", ["good.urdf", "good.scene.yaml"])
def test_other_names(name: str, tmp_path: Path) -> None:
    found = []
    for other in (name, "model.txt", "model"):
        (tmp_path / other).write_text(SEEDS[name])
        found.append(load(tmp_path / other))
    assert found[0].sha256 == found[1].sha256 == found[2].sha256
