"""``symgen show SCENE --base-parameters``, and these rows as outputs of a scene."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import symgen
from symgen.cli import run

SCENE = """
name: arm
bodies:
  - {name: upper, mass: 2, com: [0, 0, -0.5], inertia: [0.17, 0.17, 0.002, 0, 0, 0]}
  - {name: lower, mass: 1, com: [0, 0, -0.4], inertia: [0.06, 0.06, 0.001, 0, 0, 0]}
joints:
  - {name: shoulder, type: revolute, parent: ground, child: upper, axis: [0, 1, 0]}
  - {name: elbow, type: revolute, parent: upper, child: lower, axis: [0, 1, 0], origin: {xyz: [0, 0, -1]}}
frames: [{name: tip, body: lower, origin: {xyz: [0, 0, -0.6]}}, {name: mid, body: lower, origin: {xyz: [0, 0, -0.2]}}]
parameters: [upper.mass, lower.mass]
outputs:
  - center_of_mass
  - base_parameters
  - {name: tips, of: ["frame_jacobian:tip", "frame_jacobian:mid", "frame_velocity:tip"]}
"""

PRINTED = """arm: 6 base parameters of 20 inertial parameters

beta_0 = upper.mcx
beta_1 = upper.mcz - lower.m
beta_2 = upper.Iyy + lower.m
beta_3 = lower.mcx
beta_4 = lower.mcz
beta_5 = lower.Iyy

felt by no joint: """


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "arm.scene.yaml"
    path.write_text(SCENE)
    return path


def test_base_parameters_are_printed(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["show", str(scene), "--base-parameters"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith(PRINTED) and "lower.Ixx" in printed[len(PRINTED) :]


def test_and_as_json(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["show", str(scene), "--base-parameters", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["base_parameters"][1] == {"column": 3, "combination": {"upper.mcz": "1", "lower.m": "-1"}}
    assert len(printed["parameters"]) == 20 and "upper.m" in printed["unfelt"]


def test_two_questions_at_once_are_wrong_usage(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["show", str(scene), "--base-parameters", "--equations", "M"]) == 2
    assert "--base-parameters" in capsys.readouterr().err


def test_closed_loops_have_none_yet(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["show", "examples/four_bar.scene.yaml", "--base-parameters"]) == 2
    assert "closed loops" in capsys.readouterr().err


def test_rows_in_functions_of_a_scene(scene: Path, tmp_path: Path) -> None:
    f = symgen.generate(scene, tmp_path / "out").load(cache=tmp_path / "cache")
    p, q, v = np.array([2.0, 1.0]), np.array([0.3, -0.7]), np.array([1.1, 0.4])
    jacobian, other, twist = f.tips(q, v, p=p)
    assert jacobian.shape == other.shape == (6, 2)
    assert np.allclose(jacobian @ v, twist) and not np.allclose(jacobian, other)
    assert np.allclose(f.base_parameters(p=p), [0, -2 * 0.5 - 1, 0.17 + 2 * 0.25 + 1, 0, -0.4, 0.06 + 0.16])
    centre = f.center_of_mass(q, p=p)
    arms = [-0.5 * np.array([np.sin(0.3), 0, np.cos(0.3)]), None]
    arms[1] = -1.0 * np.array([np.sin(0.3), 0, np.cos(0.3)]) - 0.4 * np.array([np.sin(-0.4), 0, np.cos(-0.4)])
    assert np.allclose(centre, (2 * arms[0] + arms[1]) / 3)


def test_without_mass_at_run_time_there_is_no_answer(scene: Path, tmp_path: Path) -> None:
    f = symgen.generate(scene, tmp_path / "out").load(cache=tmp_path / "cache")
    assert np.all(np.isnan(f.center_of_mass(np.zeros(2), p=np.array([1.0, -1.0]))))
    assert np.all(np.isfinite(f.center_of_mass(np.zeros(2), p=np.array([1.0, 0.0]))))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("A", "A = "),
        ("frame_jacobian:tip", "J_tip = "),
        ("W", "W[1,1] = "),
        ("base_parameters", "β = "),
        ("com", "c = "),
    ],
)
def test_they_are_printed_as_equations(name: str, expected: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["show", "examples/double_pendulum.scene.yaml", "--equations", name]) == 0
    assert expected in capsys.readouterr().out


def test_what_has_no_form_for_reading_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["show", "examples/pendulum.scene.yaml", "--equations", "inverse_dynamics_derivatives"]) == 2
    assert "no form for reading" in capsys.readouterr().err
