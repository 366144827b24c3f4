"""The validators' own reading of a scene: order, poses, velocities."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.model import GROUND, Mimic, Scene
from symgen.topology.tree import build_tree
from symgen.validation.functions import vary_parameters, with_parameter
from symgen.validation.mechanism import (
    build_mechanism,
    link_accelerations,
    link_motions,
    link_poses,
    order_matches,
    position_rate,
    quaternion_of,
    random_state,
    rotation_about,
    rotation_of,
    skew,
)
from tests.validation.scenes import body, chain, coupled, every_joint, floating_tree, joint, sprung

SCENES = [every_joint(), sprung(), coupled(), *(floating_tree(kind) for kind in ("world", "body", "mixed"))]
RNG = np.random.default_rng


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: f"{scene.name}-{scene.options.base_velocity}")
def test_depth_first_order_is_the_topology_rooms(scene: Scene) -> None:
    bodies = build_tree(scene).bodies
    mechanism = build_mechanism(scene)
    assert order_matches(mechanism, [x.name for x in bodies], [(x.q, x.v) for x in bodies])
    assert not order_matches(mechanism, [x.name for x in bodies], [(x.q, x.v + 1) for x in bodies])
    assert [x.parent for x in bodies] == [x.parent for x in mechanism.links]


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: f"{scene.name}-{scene.options.base_velocity}")
def test_velocities_and_accelerations_are_derivatives(scene: Scene) -> None:
    mechanism = build_mechanism(scene)
    rng, h = RNG(1), 1e-5
    q, v = random_state(mechanism, rng)
    a = rng.normal(size=mechanism.nv)
    here, rate = link_motions(mechanism, q, v, link_poses(mechanism, q)), position_rate(mechanism, q, v)
    before, after = (link_poses(mechanism, q + s * h * rate) for s in (-1, 1))
    for x, y, motion, pose in zip(before, after, here, link_poses(mechanism, q), strict=True):
        np.testing.assert_allclose((y.position - x.position) / (2 * h), motion.linear, atol=1e-7)
        np.testing.assert_allclose((y.rotation - x.rotation) / (2 * h), skew(motion.angular) @ pose.rotation, atol=1e-7)
    slow, fast = (
        link_motions(mechanism, q + s * h * rate, v + s * h * a, link_poses(mechanism, q + s * h * rate))
        for s in (-1, 1)
    )
    for x, y, found in zip(slow, fast, link_accelerations(mechanism, q, v, a), strict=True):
        np.testing.assert_allclose((y.linear - x.linear) / (2 * h), found.linear, atol=1e-6)
        np.testing.assert_allclose((y.angular - x.angular) / (2 * h), found.angular, atol=1e-6)


def test_quaternion_of_every_branch() -> None:
    for axis in (*np.eye(3), np.array([0.6, 0, 0.8])):
        for angle in (0.0, 0.1, 2.0, np.pi, -3.0):
            rotation = rotation_about(axis, angle)
            np.testing.assert_allclose(rotation_of(quaternion_of(rotation)), rotation, atol=1e-15)


def test_random_states_are_in_range_and_repeatable() -> None:
    mechanism = build_mechanism(every_joint())
    q, v = random_state(mechanism, RNG(3))
    again = random_state(mechanism, RNG(3))
    assert np.array_equal(q, again[0])
    assert np.array_equal(v, again[1])
    assert np.abs(v).max() <= 2
    assert np.linalg.norm(q[3:7]) == pytest.approx(1.0)
    assert np.abs(q).max() <= np.pi


def test_closed_loop_is_refused() -> None:
    scene = Scene(
        "loop",
        (body("b1"), body("b2")),
        (
            joint("a", "revolute", GROUND, "b1"),
            joint("b", "revolute", "b1", "b2"),
            joint("c", "revolute", GROUND, "b2"),
        ),
    )
    with pytest.raises(NotSupportedError, match="joint c closes a loop"):
        build_mechanism(scene)


def test_loose_body_is_refused() -> None:
    with pytest.raises(SceneError, match="b2"):
        build_mechanism(Scene("loose", (body("b1"), body("b2")), (joint("a", "revolute", GROUND, "b1"),)))


def test_parameters_reach_the_scene() -> None:
    scene = sprung()
    assert with_parameter(scene, "gravity", (F(1), F(2), F(3))).gravity == (1, 2, 3)
    assert with_parameter(scene, "b2.mass", (F(7),)).body("b2").mass == 7
    assert with_parameter(scene, "b2.com", (F(1), F(2), F(3))).body("b2").com == (1, 2, 3)
    assert with_parameter(scene, "j1.damping", (F(9),)).joint("j1").damping == 9
    named = replace(scene, forces=(replace(scene.forces[0], name="coil"), *scene.forces[1:]))
    changed = with_parameter(named, "coil.length", (F(4),))
    assert changed.forces[0].length == 4  # type: ignore[union-attr]
    assert vary_parameters(scene, RNG(0))[1].size == 0


def test_mimics_of_mimics_are_composed() -> None:
    """q1 = −2 q2 + 1/3 with q2 = 3 q3 − 1: all of it in the place of q3, the last in depth-first order."""
    scene = chain("gear", ("revolute",) * 3)
    one, two, three = scene.joints
    joints = (
        replace(one, mimic=Mimic("j2", F(-2), F(1, 3))), replace(two, mimic=Mimic("j3", F(3), F(-1))), three,
    )  # fmt: skip
    mechanism = build_mechanism(replace(scene, joints=joints))
    assert (mechanism.nq, mechanism.nv) == (1, 1)
    q, v = np.array([0.5]), np.array([2.0])
    np.testing.assert_allclose(
        [x.position(q)[0] for x in mechanism.links], [-2 * 0.5 + 1 / 3, 3 * 0.5 - 1, 0.5], atol=1e-15
    )
    np.testing.assert_allclose([x.rate(v)[0] for x in mechanism.links], [-12.0, 6.0, 2.0], atol=1e-15)
