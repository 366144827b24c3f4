"""A scene read from MJCF against MuJoCo's own model of the same file, at the same states."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symgen.conventions import from_mujoco, to_mujoco
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.system import derive
from symgen.validation.mujoco_model import full_mass_matrix
from tests.states import ours, random_states


def mixed(scene: Scene) -> Scene:
    return replace(scene, options=replace(scene.options, base_velocity="mixed"))


def peer(path: Path) -> Any:
    """MuJoCo's model of the file, without what symgen does not model."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


def differences(scene: Scene, model: Any, states: int = 3) -> dict[str, float]:
    """Worst relative difference of the mass matrix and of inverse dynamics (springs, dampers, gravity inside)."""
    mujoco = pytest.importorskip("mujoco")
    system = derive(scene)
    data, full = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    to, back = to_mujoco(system, model), from_mujoco(system, model)
    worst = {"mass_matrix": 0.0, "inverse_dynamics": 0.0}
    for q, v, a in zip(*random_states(system, states), strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:] = to.q(q), to.v(q, v), to.a(q, v, a)
        mujoco.mj_inverse(model, data)
        full_mass_matrix(mujoco, model, data, full)
        S = np.stack([to.v(q, e) for e in np.eye(len(v))], -1)
        theirs = {
            "mass_matrix": S.T @ full @ S,
            "inverse_dynamics": back.tau(to.q(q), np.array(data.qfrc_inverse)),
        }
        found = {
            "mass_matrix": ours(system, "mass_matrix", q=q),
            "inverse_dynamics": ours(system, "inverse_dynamics", q=q, v=v, a=a),
        }
        for name, value in theirs.items():
            worst[name] = max(worst[name], float(np.abs(found[name] - value).max() / np.abs(value).max()))
    return worst


def check(path: Path, scene: Scene | None = None) -> Scene:
    """The scene of an MJCF file agrees with MuJoCo to rounding."""
    scene = scene or load(path)
    for name, value in differences(scene, peer(path)).items():
        assert value < 1e-12, name
    return scene
