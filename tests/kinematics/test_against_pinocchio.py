"""Frames, momenta, regressor and joint wrenches of real robots, compiled, against Pinocchio."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symgen
from symgen.artifact.load import Loaded
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.validation.compare import sample_states
from symgen.validation.pinocchio_model import build_pinocchio
from tests.scene.robots import PANDA, robot

pytest.importorskip("pinocchio")
from symgen.validation.pinocchio_rows import PEER_ROWS, State, inertial_parameters

HYQ = "hyq_description/robots/hyq_no_sensors.urdf"
FLOATING = "base: floating\noptions: {{base_velocity: {}, targets: [c]}}\n"
PLAIN = ("center_of_mass", "momentum", "momentum_matrix", "regressor", "joint_wrenches")
OF_A_FRAME = ("frame_jacobian", "frame_velocity", "frame_bias_acceleration")
INPUTS = {
    "center_of_mass": "q", "momentum": "qv", "momentum_matrix": "q", "regressor": "qva", "joint_wrenches": "qva",
    "frame_jacobian": "q", "frame_velocity": "qv", "frame_bias_acceleration": "qv", "base_regressor": "qva",
    "base_parameters": "",
}  # fmt: skip


def made(folder: Path, file: str, frame: str, options: str) -> tuple[Scene, Loaded]:
    rows = [*PLAIN, "base_regressor", "base_parameters", *(f"'{row}:{frame}'" for row in OF_A_FRAME)]
    path = folder / "r.scene.yaml"
    path.write_text(f"name: r\nmodel: {robot(file)}\n{options}outputs: [{', '.join(rows)}]\n")
    return load(path), symgen.generate(path, folder / "out").load(flags=("-O1",), cache=folder / "cache")


@pytest.mark.parametrize(
    ("file", "frame", "options"),
    [
        (PANDA, "panda_hand_tcp", "options: {targets: [c]}\n"),
        pytest.param(HYQ, "rh_foot", FLOATING.format("world"), marks=pytest.mark.slow),
        pytest.param(HYQ, "lf_foot", FLOATING.format("mixed"), marks=pytest.mark.slow),
        pytest.param(HYQ, "lf_foot", FLOATING.format("body"), marks=pytest.mark.slow),
    ],
    ids=("panda", "hyq, world", "hyq, mixed", "hyq, body"),
)
def test_rows_are_pinocchios(tmp_path: Path, file: str, frame: str, options: str) -> None:
    scene, functions = made(tmp_path, file, frame, options)
    peer = build_pinocchio(scene)
    states = [State(*row) for row in zip(*sample_states(peer.mechanism, 20, 7), strict=True)]
    pi = inertial_parameters(peer)
    beta = functions.base_parameters()
    for s in states:
        for row in (*PLAIN, *OF_A_FRAME):
            name = f"{row}_{frame}" if row in OF_A_FRAME else row
            ours = getattr(functions, name)(*(getattr(s, x) for x in INPUTS[row]))
            (theirs,) = PEER_ROWS[row](peer, s, frame)
            assert ours.shape == theirs.shape, row
            assert np.abs(ours - theirs).max() <= 1e-12 * np.abs(theirs).max(), row
        force = PEER_ROWS["regressor"](peer, s, "")[0] @ pi
        reduced = functions.base_regressor(s.q, s.v, s.a) @ beta
        assert np.abs(reduced - force).max() <= 1e-11 * np.abs(force).max()
