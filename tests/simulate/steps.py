"""Scenes with steps, compiled, and what a test asks of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.artifact import Artifact
from symgen.generate import generate
from symgen.scene.builder import SceneBuilder
from symgen.scene.canonical import with_hash
from symgen.scene.load import load
from symgen.scene.model import Output, Scene
from symgen.scene.outputs import STEPS
from symgen.scene.request import request

Array = NDArray[np.float64]
ORDERS = {"semi_implicit_euler": 1, "rk4": 4, "lie": 4, "implicit_midpoint": 2, "variational": 2}


def asked(scene: Scene | str, *rows: str, **options: Any) -> Scene:
    """A scene (or an example's name) that asks for these functions alone."""
    loaded = load(f"examples/{scene}.scene.yaml") if isinstance(scene, str) else scene
    loaded = request(loaded, tuple(Output(row, (row,)) for row in rows))
    return with_hash(replace(loaded, options=replace(loaded.options, **options)))


def stepping(scene: Scene | str, folder: Path, *methods: str, **options: Any) -> Artifact:
    return generate(asked(scene, *(f"step:{name}" for name in methods or STEPS), **options), folder)


def ball(base_velocity: str = "world") -> Scene:
    """A lopsided floating body that carries another one on a ball joint: quaternions of both kinds."""
    scene = SceneBuilder("ball").body("hull", mass=2, com=(0.1, 0, 0.2), inertia=(0.3, 0.2, 0.25, 0.01, 0, 0.02))
    scene.body("arm", mass=1, com=(0, 0.3, -0.1), inertia=(0.05, 0.02, 0.06, 0, 0, 0))
    scene.joint("base", "floating", "ground", "hull", rpy=(0.3, 0.2, -0.1))
    scene.joint("wrist", "spherical", "hull", "arm", xyz=(0, 0.2, 0.1))
    return scene.options(base_velocity=base_velocity).build()


def state(manifest: dict[str, Any], seed: int = 3) -> tuple[Array, Array, Array]:
    """A generic q, v, tau; quaternions of norm one."""
    rng = np.random.default_rng(seed)
    q, v = 0.4 * rng.normal(size=manifest["nq"]), rng.normal(size=manifest["nv"])
    for joint in manifest["joints"]:
        if joint["type"] in ("spherical", "floating"):
            part = slice(joint["q"][0] + joint["q"][1] - 4, joint["q"][0] + joint["q"][1])
            turn = rng.normal(size=4)
            q[part] = turn / np.linalg.norm(turn)
    return q, v, 0.2 * rng.normal(size=manifest["nv"])


def motion(function: Any, start: tuple[Array, Array, Array], end: float, steps: int) -> Array:
    q, v, tau = start
    for _ in range(steps):
        q, v = function(q, v, tau, end / steps)
    return np.concatenate([q, v])
