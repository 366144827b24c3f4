"""Scenes of this room: textbook arms, and random trees with frames, couplings and parameters."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F

from symgen.scene.model import GROUND, Body, Frame, Joint, Scene, Spring, Transform, Vector
from tests.natural.trees import random_planar_scene
from tests.plans.test_against_literal import coupled, scene_of, with_parameters

X, Y, Z = (F(1), F(0), F(0)), (F(0), F(1), F(0)), (F(0), F(0), F(1))
DOWN = (F(0), F(0), F(-10))
ROWS = (
    "center_of_mass", "momentum", "momentum_matrix", "regressor", "base_regressor", "base_parameters", "joint_wrenches",
    "constraint_forces",
)  # fmt: skip
OF_FRAMES = ("frame_jacobian:tool", "frame_velocity:tool", "frame_bias_acceleration:tool")


def arm(name: str, axes: tuple[Vector, ...], steps: tuple[Vector, ...], gravity: Vector = DOWN) -> Scene:
    """A chain of revolute joints whose frames are all parallel at zero."""
    inertia = (F(3, 10), F(4, 10), F(5, 10), F(1, 50), F(1, 70), F(-1, 30))
    bodies = tuple(Body(f"l{k + 1}", F(k + 2, 3), (F(1, 10), F(-1, 5), F(3, 10)), inertia) for k in range(len(axes)))
    joints = tuple(
        Joint(f"j{k + 1}", "revolute", f"l{k}" if k else GROUND, f"l{k + 1}", Transform(translation=step), axis)
        for k, (axis, step) in enumerate(zip(axes, steps, strict=True))
    )
    return Scene(name, bodies, joints, gravity=gravity)


def planar_arm(gravity: Vector) -> Scene:
    """Two parallel joints about z."""
    return arm("planar", (Z, Z), ((F(0), F(0), F(0)), (F(1), F(0), F(0))), gravity)


def puma() -> Scene:
    """The axes of a PUMA 560: z, then two parallel ones with offsets, then a spherical wrist."""
    zero = F(0)
    steps = (
        (zero, zero, F(67, 100)), (zero, F(24, 100), zero), (F(43, 100), F(-9, 100), zero),
        (F(2, 100), zero, F(43, 100)), (zero, zero, zero), (zero, zero, zero),
    )  # fmt: skip
    return arm("puma", (Z, Y, Y, Z, Y, Z), steps)


def in_a_plane(rng: random.Random) -> Scene:
    """A planar tree with a spring between two of its bodies."""
    scene = random_planar_scene(rng, rng.randint(2, 5))
    ends = (scene.bodies[0].name, scene.bodies[-1].name)
    spring = Spring(ends, ((F(1), F(0), F(1, 3)), (F(0), F(2), F(5))), F(3), F(1, 2), name="s")
    return replace(scene, forces=(spring,), gravity=(F(1), F(-7, 3), F(2)))


def kinematic_scene(seed: int, couplings: bool = False, runtime: bool = False, planar: bool = False) -> Scene:
    """A random tree with a tool frame on its last body, mass on some body that moves."""
    rng = random.Random(seed)
    scene = in_a_plane(rng) if planar else scene_of(seed)
    first = next((joint for joint in scene.joints if joint.type != "fixed"), None)
    if first is None:
        scene = replace(scene, joints=(replace(scene.joints[0], type="spherical", axis=None), *scene.joints[1:]))
        first = scene.joints[0]
    bodies = tuple(replace(b, mass=b.mass + 1) if b.name == first.child else b for b in scene.bodies)
    frame = Frame("tool", bodies[-1].name, Transform(translation=(F(1, 3), F(-1, 2), F(2, 5))))
    scene = replace(scene, bodies=bodies, frames=(frame,))
    scene = coupled(scene, rng) if couplings else scene
    return with_parameters(scene, rng) if runtime else scene
