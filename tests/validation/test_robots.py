"""tools/robots.py: a table of what works, and of what does not and why."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

from tools.robots import main

ROOT = Path(__file__).resolve().parents[2]
ROBOT = """<robot name="two">
  <link name="base"/>
  <link name="a"><inertial><mass value="1"/><origin xyz="0 0 -0.5"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""


def run(*arguments: str) -> tuple[int, str]:
    command = [sys.executable, "-m", "tools.robots", *arguments]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return ran.returncode, ran.stdout + ran.stderr


def test_table_of_one_robot_and_one_failure(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    (tmp_path / "two.urdf").write_text(ROBOT)
    (tmp_path / "bad.urdf").write_text(ROBOT.replace('child link="a"', 'child link="b"'))
    files = [str(tmp_path / name) for name in ("two.urdf", "bad.urdf")]
    status, said = run(*files, "--outputs=mass_matrix,mass_matrix_inverse,integrate", f"--out={tmp_path}/out")
    assert status == 1
    assert "two" in said
    good, bad = json.loads((tmp_path / "out" / "robots.json").read_text())
    assert {f["output"] for f in good["functions"]} == {"mass_matrix", "mass_matrix_inverse", "integrate"}
    assert [f["difference"] < 1e-14 for f in good["functions"] if "difference" in f] == [True, True]
    assert bad["functions"] == []
    assert "bad.urdf" in bad["error"]
    rows = list(csv.DictReader((tmp_path / "out" / "robots.csv").open(newline="")))
    assert len(rows) == 4
    assert "| two |" in (tmp_path / "out" / "robots.md").read_text()


def test_unknown_robot_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["robots", "no_such_robot", f"--out={tmp_path}/out"])
    assert main() == 2
    assert "double_pendulum" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
