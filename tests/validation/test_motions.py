"""Closed forms, first integrals and trajectories: right motions pass, slightly wrong ones do not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction as F
from typing import Any

import numpy as np
import pytest

from symgen.scene.model import GROUND, Body, Joint, Scene, Transform
from symgen.validation.closed_forms import EulerTop, closed_form_rows
from symgen.validation.functions import bind
from symgen.validation.invariants import energy_row, momentum_rows
from symgen.validation.mechanism import build_mechanism
from symgen.validation.reference import MotionError, integrate_motion
from symgen.validation.result import Row
from symgen.validation.trajectories import (
    acceleration_rows,
    choose_motion,
    extrapolate,
    observed_order,
    start_state,
    trajectory_rows,
)
from tests.validation.changed import Changed
from tests.validation.peer_functions import PeerFunctions
from tests.validation.scenes import TURNS, floating_tree, single, sprung, vec

pytest.importorskip("pinocchio")
pytest.importorskip("scipy")


def one(kind: str, body: Body, **more: Any) -> Scene:
    """One body on a joint with a turned frame."""
    gravity = more.pop("gravity", vec(0, 0, "-9.81"))
    joint = Joint("j1", kind, GROUND, body.name, Transform(TURNS[0], vec(1, 2, 3)), **more)
    return Scene(f"one_{kind}", (body,), (joint,), gravity=gravity)


ROD = Body("rod", F(6, 5), vec("1/10", "1/5", "-1/2"), (F(1, 10), F(1, 10), F(1, 50), F(0), F(0), F(0)))
TOP = Body("top", F(1, 2), vec(0, 0, "1/10"), (F(6, 10000), F(6, 10000), F(1, 1000), F(0), F(0), F(0)))
NUT = Body("nut", F(2), vec("1/10", 0, "-1/5"), (F(1), F(2), F(3), F(1, 10), F(0), F(-1, 5)))
AXIS = vec("9/25", "12/25", "4/5")

FORMS: tuple[tuple[Scene, int], ...] = (
    (one("revolute", ROD, axis=AXIS, armature=F(1, 20)), 1),
    (one("helical", ROD, axis=AXIS, pitch=F(1, 20)), 1),
    (one("planar", ROD), 1),
    (one("spherical", TOP), 2),
    (one("spherical", replace(TOP, com=vec(0, 0, -1))), 2),
    (one("floating", NUT), 2),
)


@pytest.mark.parametrize(("scene", "count"), FORMS, ids=[f"{s.name}-{k}" for k, (s, _) in enumerate(FORMS)])
def test_closed_forms_hold_and_can_fail(scene: Scene, count: int) -> None:
    mechanism = build_mechanism(scene)
    rows = closed_form_rows(mechanism, bind(PeerFunctions(scene), scene), 1)
    assert len(rows) == count
    assert [row for row in rows if not row.passed] == []
    heavier = replace(
        scene.bodies[0],
        inertia=tuple(x * F(1000001, 1000000) for x in scene.bodies[0].inertia[:3]) + scene.bodies[0].inertia[3:],
    )
    other = replace(scene, bodies=(replace(heavier, com=(heavier.com[0] + F(1, 10**6), *heavier.com[1:])),))
    spoilt = closed_form_rows(mechanism, bind(PeerFunctions(other), scene), 1)
    assert any(not row.passed for row in spoilt)


def test_dzhanibekov_period() -> None:
    top = EulerTop(np.array([1.0, 2.0, 3.0]), np.array([1e-3, 1.0, 1e-3]))
    assert top.period == pytest.approx(55.061681107466372, rel=1e-14)


@pytest.mark.parametrize("start", [(0.6, 0.0, 1.0), (1.0, 0.0, 0.2)])
def test_euler_top_solves_eulers_equations(start: tuple[float, float, float]) -> None:
    moments = np.array([1.0, 2.0, 3.0])
    top = EulerTop(moments, np.array(start))
    h = 1e-5
    for t in (0.3, 2.0):
        w = top.omega(t)
        rate = (top.omega(t + h) - top.omega(t - h)) / (2 * h)
        np.testing.assert_allclose(moments * rate, np.cross(moments * w, w), atol=1e-9)
    np.testing.assert_allclose(np.abs(top.omega(0.0)), np.abs(start), atol=1e-12)


def momenta(scene: Scene, functions: Any) -> list[Row]:
    mechanism = build_mechanism(scene)
    bound = bind(functions, scene)
    _end, motion = choose_motion(mechanism, bound, *start_state(mechanism, 3))
    return [energy_row(mechanism, motion), *momentum_rows(mechanism, motion)]


UPRIGHT = vec(0, 0, 1)


@pytest.mark.parametrize(
    ("scene", "count"),
    [
        (floating_tree("world"), 7),
        (single("spherical"), 2),
        (single("planar"), 4),
        (single("prismatic"), 2),
        (replace(single("revolute"), gravity=vec(0, 0, 0)), 2),
        (replace(single("cylindrical"), gravity=vec(0, 0, 0)), 3),
        (replace(single("helical"), gravity=vec(0, 0, 0)), 2),
        (replace(single("universal"), gravity=vec(0, 0, 0)), 2),
        (replace(single("spherical"), gravity=vec(0, 0, 0)), 4),
        (sprung(), 1),
    ],
    ids=lambda x: x.name if isinstance(x, Scene) else str(x),
)
def test_first_integrals(scene: Scene, count: int) -> None:
    rows = momenta(scene, PeerFunctions(scene))
    assert len(rows) == count
    assert [row for row in rows if not row.passed] == []


def drift(index: int, amount: float) -> Callable[..., Any]:
    def change(a: Any, *_arguments: Any) -> Any:
        spoilt = np.array(a)
        spoilt[..., index] += amount
        return spoilt

    return change


def test_wrong_acceleration_breaks_first_integrals() -> None:
    scene = floating_tree("world")
    failed = {
        row.quantity
        for row in momenta(scene, Changed(PeerFunctions(scene), "forward_dynamics", drift(0, 1e-6)))
        if not row.passed
    }
    assert "momentum x, less its weight's impulse" in failed
    assert "momentum y, less its weight's impulse" not in failed


def test_nan_stops_a_motion() -> None:
    scene = single("revolute")
    spoilt = bind(Changed(PeerFunctions(scene), "forward_dynamics", drift(0, np.nan)), scene)
    with pytest.raises(MotionError, match="t = 0"):
        integrate_motion(build_mechanism(scene), spoilt, np.zeros(2), np.zeros(2), 1.0, 4)


def test_orders_and_extrapolation_of_known_sequences() -> None:
    steps = [0.1 * 0.5**k for k in range(4)]
    even = [np.array([1.0 + 3 * h**2 - 2 * h**4]) for h in steps]
    rk = [np.array([1.0 + 3 * h**4 - 2 * h**5]) for h in steps]
    assert observed_order(even) == pytest.approx(2.0, abs=0.02)
    assert observed_order(rk) == pytest.approx(4.0, abs=0.1)
    assert extrapolate(even, 2)[0] == pytest.approx(1.0, abs=1e-13)
    assert extrapolate(rk, 4)[0] == pytest.approx(1.0, abs=1e-13)
    assert np.isnan(observed_order([np.zeros(1)] * 3))


@pytest.mark.parametrize("kind", ["universal", "helical", "floating"])
def test_trajectories_against_exudyn(kind: str) -> None:
    pytest.importorskip("exudyn")
    scene = single(kind)
    functions = bind(PeerFunctions(scene), scene)
    rows, skipped, trajectory = trajectory_rows(scene, functions, 3)
    assert [row for row in rows if not row.passed] == []
    assert len(trajectory.refinements) == 2
    assert skipped == []
    assert len(trajectory.times) == len(trajectory.q) == 101
    assert len(trajectory.coordinates) == len(trajectory.q[0])
    assert all(row.passed for row in acceleration_rows(scene, functions, 4)[0])


def test_a_slightly_wrong_motion_is_seen_by_exudyn() -> None:
    pytest.importorskip("exudyn")
    scene = single("universal")
    functions = bind(Changed(PeerFunctions(scene), "forward_dynamics", drift(1, 1e-8)), scene)
    rows, _skipped, trajectory = trajectory_rows(scene, functions, 3)
    failed = [row.quantity for row in rows if not row.passed]
    assert [name.split(":")[1] for name in failed] == [" extrapolated error"] * 2
    assert all(refinement.extrapolated > 1e-9 for refinement in trajectory.refinements)
    assert not all(row.passed for row in acceleration_rows(scene, functions, 4)[0])
