"""The adapters against each other: neither simulator knows of the other, nor of the derivation."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path

import numpy as np
import pytest

from symgen.errors import NotSupportedError, ToolError
from symgen.scene.model import GROUND, Joint, JointSpring, Scene, Transform
from symgen.validation import exudyn_bodies, exudyn_tree
from symgen.validation.compare import adapters_agree, norm, sample_states
from symgen.validation.exudyn_bodies import build_exudyn_bodies
from symgen.validation.exudyn_tree import build_exudyn_tree
from symgen.validation.invariants import energy
from symgen.validation.mechanism import build_mechanism, link_accelerations
from symgen.validation.pinocchio_model import build_pinocchio
from tests.validation.scenes import SINGLES, body, every_joint, floating_tree, single, sprung, sprung_pendulum, vec

pytest.importorskip("pinocchio")


def damped(scene: Scene) -> Scene:
    """The scene with damping on every joint."""
    joints = tuple(joint if joint.type == "fixed" else replace(joint, damping=F(3, 10)) for joint in scene.joints)
    return replace(scene, name=f"{scene.name}_damped", joints=joints)


def cardan() -> Scene:
    """A universal joint on axes at right angles, which Exudyn builds differently from an oblique one."""
    joints = (
        Joint("j1", "revolute", GROUND, "b1", Transform(), vec(0, 0, 1), armature=F(1, 10)),
        Joint("j2", "universal", "b1", "b2", Transform(translation=vec(0, 0, 1)), vec(1, 0, 0), vec(0, 1, 0)),
    )
    return Scene("cardan", (body("b1"), body("b2", 1)), joints)


def screw() -> Scene:
    """A geared, sprung screw on ground that carries a revolute."""
    scene = single("helical")
    first = replace(scene.joints[0], armature=F(1, 10), damping=F(1, 5))
    return replace(scene, joints=(first, scene.joints[1]), forces=(JointSpring("j1", F(3), F(1, 10), F(1, 2)),))


KINDS = ("world", "body", "mixed")
ALL = [
    *(single(kind) for kind in SINGLES),
    *(single("floating", kind) for kind in KINDS[1:]),
    *(floating_tree(kind) for kind in KINDS),
    every_joint(),
    sprung(),
    sprung_pendulum(),
    cardan(),
    screw(),
]
SCENES = [*ALL, *(damped(scene) for scene in ALL)]


def label(scene: Scene) -> str:
    return f"{scene.name}-{scene.options.base_velocity}"


@pytest.mark.parametrize("scene", ALL, ids=label)
def test_pinocchio_agrees_with_itself(scene: Scene) -> None:
    """CRBA, RNEA and ABA share little code; the kinetic energy is this package's own."""
    peer = build_pinocchio(scene)
    assert adapters_agree(scene, 1) < 1e-13
    for q, v, a, _tau in zip(*sample_states(peer.mechanism, 3, 1), strict=True):
        M = peer.mass_matrix(q)
        assert norm(M - peer.mass_matrix_by_columns(q)) < 1e-13 * norm(M)
        tau = peer.inverse_dynamics(q, v, a)
        assert norm(M @ a + peer.bias_force(q, v) - tau) < 1e-13 * max(1.0, norm(tau))
        assert norm(peer.forward_dynamics(q, v, tau) - a) < 1e-10
        assert energy(peer.mechanism, q, v)[0] == pytest.approx(0.5 * v @ M @ v, rel=1e-13)


@pytest.mark.parametrize("scene", SCENES, ids=label)
def test_kinematic_tree_is_pinocchio(scene: Scene) -> None:
    pytest.importorskip("exudyn")
    peer = build_pinocchio(scene)
    for q, v, _a, tau in zip(*sample_states(peer.mechanism, 2, 2), strict=True):
        tree = build_exudyn_tree(scene, q, v, tau)
        M, a = peer.mass_matrix(q), peer.forward_dynamics(q, v, tau)
        assert norm(tree.mass_matrix() - M) < 1e-13 * norm(M)
        assert norm(tree.accelerations() - a) < 1e-12 * norm(a)


@pytest.mark.parametrize("scene", SCENES, ids=label)
def test_redundant_bodies_are_pinocchio(scene: Scene) -> None:
    pytest.importorskip("exudyn")
    reason = exudyn_bodies.refusal(scene)
    if reason:
        kinds = {joint.type for joint in scene.joints}
        assert "helical" in kinds or "armature" in reason or "planar" in reason
        pytest.skip(reason)
    peer = build_pinocchio(scene)
    for q, v, _a, tau in zip(*sample_states(peer.mechanism, 2, 3), strict=True):
        links = link_accelerations(peer.mechanism, q, v, peer.forward_dynamics(q, v, 0 * tau))
        expected = np.concatenate([np.concatenate([x.linear, x.angular]) for x in links])
        model = build_exudyn_bodies(scene, q, v)
        found = model.link_acceleration(model.terms().accelerations())
        assert norm(found - expected) < 1e-11 * norm(expected)


def test_a_wrong_mass_shows_in_every_adapter() -> None:
    pytest.importorskip("exudyn")
    scene = floating_tree()
    heavier = replace(scene, bodies=(*scene.bodies[:-1], replace(scene.bodies[-1], mass=F(3))))
    mechanism = build_mechanism(scene)
    q, v, _a, tau = (x[0] for x in sample_states(mechanism, 1, 4))
    a = build_pinocchio(scene).forward_dynamics(q, v, tau)
    assert norm(build_exudyn_tree(heavier, q, v, tau).accelerations() - a) > 1e-3
    assert norm(build_pinocchio(heavier).forward_dynamics(q, v, tau) - a) > 1e-3


def test_refusals_give_reasons() -> None:
    scene = single("spherical")
    geared = replace(scene, joints=tuple(replace(joint, armature=F(1)) for joint in scene.joints))
    assert "armature" in exudyn_tree.refusal(geared)
    assert "armature" in exudyn_bodies.refusal(geared)
    assert "helical" in exudyn_bodies.refusal(every_joint())
    assert "planar" in exudyn_bodies.refusal(damped(single("planar")))
    pytest.importorskip("exudyn")
    with pytest.raises(NotSupportedError, match="helical"):
        build_exudyn_bodies(every_joint(), np.zeros(22), np.zeros(20))


def test_floating_armature_stays_on_symgens_diagonal() -> None:
    scene = floating_tree("world")
    geared = replace(scene, joints=(replace(scene.joints[0], armature=F(2)), *scene.joints[1:]))
    plain, loaded = build_pinocchio(scene), build_pinocchio(geared)
    q, v, a, tau = (x[0] for x in sample_states(plain.mechanism, 1, 5))
    extra = np.diag([2.0] * 6 + [0.0] * 4)
    np.testing.assert_allclose(loaded.mass_matrix(q) - plain.mass_matrix(q), extra, atol=1e-12)
    np.testing.assert_allclose(loaded.bias_force(q, v), plain.bias_force(q, v), atol=1e-12)
    a = loaded.forward_dynamics(q, v, tau)
    np.testing.assert_allclose(loaded.inverse_dynamics(q, v, a), tau, atol=1e-10)


def test_exudyn_is_silent_and_leaves_no_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: object) -> None:
    pytest.importorskip("exudyn")
    monkeypatch.chdir(tmp_path)
    model = build_exudyn_tree(sprung(), np.zeros(4), np.ones(4)).model
    model.terms()
    assert len(model.simulate(8, 0.1, 4, "RK44")) == 4
    assert os.listdir(tmp_path) == []
    out, err = capfd.readouterr()  # type: ignore[attr-defined]
    assert out == ""
    assert err == ""


@pytest.mark.parametrize("module", ["pinocchio", "exudyn"])
def test_missing_simulator_names_the_extra(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ToolError, match=r"pip install 'symgen\[validation\]'"):
        if module == "pinocchio":
            build_pinocchio(sprung())
        else:
            build_exudyn_tree(sprung(), np.zeros(4), np.zeros(4))
