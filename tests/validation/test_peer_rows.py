"""Pinocchio's derivatives, frames and momenta in our coordinates: each against differences of plainer ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction as F
from typing import Any

import numpy as np
import pytest

from symgen.scene.model import Options, Scene, Spring
from symgen.validation.compare import norm
from symgen.validation.compare_rows import compare_rows, states_of
from symgen.validation.differences import derivative
from symgen.validation.functions import bind
from symgen.validation.mechanism import Array
from symgen.validation.passive import passive_force
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio
from symgen.validation.pinocchio_rows import (
    PEER_ROWS,
    State,
    forward_dynamics_derivatives,
    frame_bias_acceleration,
    frame_jacobian,
    frame_velocity,
    inertial_force,
    inverse_dynamics_gradient,
    joint_wrenches,
    mass_matrix_inverse,
    momentum,
    momentum_matrix,
    move,
)
from tests.validation.changed import Changed
from tests.validation.peer_functions import ROWS, PeerFunctions
from tests.validation.scenes import chain, coupled, every_joint, floating_tree, sprung, vec

pytest.importorskip("pinocchio")


def sprung_base() -> Scene:
    springs = (
        Spring(("b1", "b3"), (vec(0, "1/10", 0), vec("1/10", 0, 0)), F(15), F(1, 5), F(3, 10)),
        Spring(("b5", "ground"), (vec(0, "1/10", 0), vec("1/10", 0, 0)), F(15), F(1, 5), F(3, 10)),
    )
    return replace(floating_tree("world"), name="sprung_base", forces=springs)


def every(kind: str) -> Scene:
    return replace(every_joint(), options=Options(base_velocity=kind))


SCENES = (
    floating_tree("mixed"), floating_tree("body"), every("world"), sprung(), sprung_base(), coupled(), coupled(1),
)  # fmt: skip


def label(scene: Scene) -> str:
    return f"{scene.name}-{scene.options.base_velocity}"


def differenced(peer: Pinocchio, f: Callable[[State], Array], s: State, name: str) -> Array:
    """∂f/∂name, the directions last."""

    def along(unit: Array) -> Callable[[float], Array]:
        if name == "q":
            return lambda t: f(s._replace(q=move(peer, s.q, unit, t)))
        return lambda t: f(s._replace(**{name: getattr(s, name) + t * unit}))

    return np.stack([derivative(along(unit)) for unit in np.eye(peer.mechanism.nv)], axis=-1)


@pytest.mark.parametrize("scene", SCENES, ids=label)
def test_derivatives_are_derivatives(scene: Scene) -> None:
    peer = build_pinocchio(scene)
    (s,) = states_of(peer, 1, 3)
    inverse = inverse_dynamics_gradient(peer, s)
    for found, name in zip(inverse, ("q", "v", "a"), strict=True):
        expected = differenced(peer, lambda x: peer.inverse_dynamics(x.q, x.v, x.a), s, name)
        assert norm(found - expected) < 1e-11 * max(1.0, norm(expected))
    for found, name in zip(forward_dynamics_derivatives(peer, s), ("q", "v", "tau"), strict=True):
        expected = differenced(peer, lambda x: peer.forward_dynamics(x.q, x.v, x.tau), s, name)
        assert norm(found - expected) < 1e-10 * max(1.0, norm(expected))
    (inverse_matrix,) = mass_matrix_inverse(peer, s)
    assert norm(inverse_matrix @ peer.mass_matrix(s.q) - np.eye(len(s.v))) < 1e-11


@pytest.mark.parametrize("scene", SCENES, ids=label)
def test_frames_and_momenta(scene: Scene) -> None:
    peer = build_pinocchio(scene)
    (s,) = states_of(peer, 1, 4)
    for frame in (scene.bodies[0].name, scene.bodies[-1].name):
        (J,) = frame_jacobian(peer, s, frame)
        assert norm(J @ s.v - frame_velocity(peer, s, frame)[0]) < 1e-13

        def velocity(t: float, frame: str = frame) -> Array:
            return np.asarray(frame_jacobian(peer, s._replace(q=move(peer, s.q, s.v, t)), frame)[0] @ s.v)

        assert norm(frame_bias_acceleration(peer, s, frame)[0] - derivative(velocity)) < 1e-11
        position = derivative(lambda t, f=frame: peer.body_pose(move(peer, s.q, s.v, t), f).position)  # type: ignore[misc]
        assert norm((J @ s.v)[:3] - position) < 1e-11
    assert norm(momentum_matrix(peer, s)[0] @ s.v - momentum(peer, s)[0]) < 1e-12
    assert norm(passive_force(peer.mechanism, s.q, s.v).real - peer.passive_force(s.q, s.v)) < 1e-12


def test_joint_wrenches_carry_what_hangs_on_them() -> None:
    """Along its own freedom a joint transmits its load, less its passive force; springs between points load it."""
    scene = chain("arm", ("revolute", "prismatic", "revolute"), forces=sprung().forces[1:2])
    peer = build_pinocchio(scene)
    (s,) = states_of(peer, 1, 5)
    (W,) = joint_wrenches(peer, s)
    tau = peer.inverse_dynamics(s.q, s.v, s.a)
    for k, link in enumerate(peer.mechanism.links):
        along = W[k][:3] if link.joint.type == "prismatic" else W[k][3:]
        assert along @ link.axis == pytest.approx(tau[k], abs=1e-12)
    bare = replace(scene, forces=())
    assert norm(joint_wrenches(build_pinocchio(bare), s)[0] - W) > 1e-3


def test_regressor_times_parameters() -> None:
    scene = every("body")
    peer = build_pinocchio(scene)
    (s,) = states_of(peer, 1, 6)
    assert norm(inertial_force(peer, s) - peer.inverse_dynamics(s.q, s.v, s.a)) < 1e-11


def bump(relative: float) -> Callable[..., Any]:
    """Spoils one entry of the last output."""

    def change(result: Any, *_arguments: Any) -> Any:
        ports = list(result) if isinstance(result, tuple) else [result]
        spoilt = np.array(ports[-1])
        spoilt.flat[0] += relative * np.abs(spoilt).max()
        ports[-1] = spoilt
        return tuple(ports) if isinstance(result, tuple) else spoilt

    return change


@pytest.mark.parametrize("row", ROWS)
def test_every_row_is_compared_and_can_fail(row: str) -> None:
    scene = chain("arm", ("spherical", "prismatic"))
    good = PeerFunctions(scene)
    name = f"{row}_b2" if row.startswith("frame_") else row
    for relative, passes in ((1e-13 if "derivatives" not in row else 1e-11, True), (1e-8, False)):
        functions = Changed(good, name, bump(relative))
        rows = {line.quantity: line for line in compare_rows(scene, bind(functions, scene), 1, 1)}
        assert set(rows) == set(ROWS) == set(PEER_ROWS) - set(PLAIN)
        assert rows[row].passed is passes
        assert all(line.passed for quantity, line in rows.items() if quantity != row)


PLAIN = {*PeerFunctions.NAMES, "kinetic_energy", "frame_pose"}
