"""Plans of frames, momenta, regressors, wrenches and multipliers are their literal definitions, exactly, in GF(p)."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F
from functools import partial
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.algebra.field import MERSENNE_61, FieldNumbers, Residue
from symgen.algebra.linear import cross, dot, matvec, vadd, vsub
from symgen.algebra.numbers import FloatNumbers, State
from symgen.certificate import Candidate, Certifier
from symgen.literal import frames, reactions, regressor
from symgen.literal.equations import Literal
from symgen.plans.build import build
from symgen.plans.families import families_of
from symgen.program.evaluate import evaluate_in_field
from symgen.scene.model import JointSpring, Output
from symgen.system import System, derive
from symgen.velocity.kinematics import point_velocity
from tests.kinematics.scenes import OF_FRAMES, ROWS, kinematic_scene
from tests.plans.test_against_literal import equal, state_of

seeds = st.integers(0, 2**32)
few = settings(max_examples=12, deadline=None)


def at_random(seed: int, couplings: bool = False, planar: bool = False) -> tuple[System, Literal]:
    system = derive(kinematic_scene(seed, couplings, planar=planar))
    numbers = FieldNumbers(MERSENNE_61, seed)
    return system, system.literal(numbers, state_of(system, numbers, random.Random(seed)))


@given(seeds, st.sampled_from(("couplings", "runtime", "planar", "plain")))
@settings(max_examples=5, deadline=None)
def test_programs_of_every_family_are_certified(seed: int, kind: str) -> None:
    system = derive(kinematic_scene(seed, kind == "couplings", kind == "runtime", kind == "planar"))
    certifier = Certifier(system, str(seed))
    for row in (*ROWS, *OF_FRAMES):
        output = Output(row, (row,))
        for family in families_of(output, system.tree):
            program = build(system.lowered, system.natural, output, family)
            certifier.certify(output, program, [Candidate(f"{row} by {family}", partial(evaluate_in_field, program))])


@given(seeds, st.booleans())
@few
def test_matrices_times_velocities(seed: int, couplings: bool) -> None:
    """J v is the twist, A v the momentum, and R's columns of the frame's origin are those of J."""
    system, literal = at_random(seed, couplings)
    v = literal.state.v
    assert equal([dot(row, v) for row in frames.momentum_matrix(literal)], frames.momentum(literal))
    for frame in system.tree.frames:
        twist = frames.frame_velocity(literal, frame)
        assert equal([dot(row, v) for row in frames.frame_jacobian(literal, frame)], twist)
        home, origin = frames.place(literal, frame)
        assert equal(twist[:3], point_velocity(literal.at, literal.twists, home, origin))


@given(seeds, st.booleans())
@few
def test_linear_momentum_and_first_moment(seed: int, couplings: bool) -> None:
    """Momentum is Σ m v_c over all bodies, the centre of mass Σ m c / Σ m, from their own centres."""
    system, literal = at_random(seed, couplings)
    momentum: Any = (0, 0, 0)
    first: Any = (0, 0, 0)
    mass: Any = 0
    for body in system.tree.bodies:
        for part, pose in body.parts:
            turn, shift = literal.values.transform(pose)
            centre = literal.at.poses[body.index].point(vadd(shift, matvec(turn, literal.values.com(part))))
            m = literal.values.mass(part)
            velocity = point_velocity(literal.at, literal.twists, body.index, centre)
            momentum = vadd(momentum, tuple(m * x for x in velocity))
            first, mass = vadd(first, tuple(m * x for x in centre)), mass + m
    assert equal(frames.momentum(literal)[:3], momentum)
    assert equal([mass * x for x in frames.center_of_mass(literal)], first)


@given(seeds, st.booleans())
@few
def test_the_regressor_is_inverse_dynamics(seed: int, couplings: bool) -> None:
    """Y π with the scene's own π is mass_matrix a + C v + gravity without armature, and Y is linear in π."""
    _, literal = at_random(seed, couplings)
    y, pi = regressor.regressor(literal), regressor.inertial_parameters(literal)
    armature = [extra * x for extra, x in zip(literal.armature, literal.state.a, strict=True)]
    force = vadd(literal.coriolis_force(), literal.gravity_force())
    inertia = vsub(tuple(literal.mass_matrix_times(literal.state.a)), tuple(armature))
    assert equal([dot(row, pi) for row in y], vadd(inertia, force))
    rng = random.Random(seed)
    other = [Residue(rng.randrange(MERSENNE_61), MERSENNE_61) for _ in pi]
    assert equal([dot(row, other) for row in y], regressor.regressor_times(literal, other))


@given(seeds, st.booleans())
@few
def test_joints_feel_their_wrenches(seed: int, planar: bool) -> None:
    """A joint's columns against the wrench it transmits: inverse dynamics without armature, dampers, joint springs."""
    system, literal = at_random(seed, planar=planar)
    found: list[Any] = [0] * system.tree.nv
    for body, row in zip(system.tree.bodies, reactions.joint_wrenches(literal), strict=True):
        pose, motion = literal.at.poses[body.index], literal.at.motions[body.index]
        force, moment = pose.vector(row[:3]), pose.vector(row[3:])
        for k, column in enumerate(motion.columns):
            velocity = vadd(column.v, cross(column.w, vsub(pose.origin, motion.reference)))
            found[body.v + k] = dot(velocity, force) + dot(column.w, moment)
            found[body.v + k] += literal.values.armature(body.joint) * literal.state.a[body.v + k]
            found[body.v + k] += literal.values.damping(body.joint) * literal.state.v[body.v + k]
    for spring in literal.values.scene.forces:
        if isinstance(spring, JointSpring):
            for j, value in literal._joint_spring_force(spring).items():
                found[j] = found[j] + value
    assert equal(found, literal.inverse_dynamics())


@given(seeds, st.booleans())
@few
def test_multipliers_leave_what_joints_can_do(seed: int, planar: bool) -> None:
    """Mẍ − Q − Ψᵀλ has no part along the constraints, and Rᵀ of it is the inverse dynamics of everything but armature,
    dampers and joint springs."""
    system, literal = at_random(seed, planar=planar)
    multipliers = reactions.constraint_forces(literal)
    for left, right in reactions.normal_equations(literal, multipliers):
        assert Residue(0, MERSENNE_61) + left == right
    load = reactions.unconstrained_loads(literal, reactions.natural_accelerations(literal))
    columns = zip(*literal.velocity_transformation(), strict=True)
    jacobian = literal.constraint_jacobian()
    rest = [
        x - sum((row[k] * m for row, m in zip(jacobian, multipliers, strict=True)), Residue(0, MERSENNE_61))
        for k, x in enumerate(load)
    ]
    wrenches = [dot(column, rest) for column in columns]
    armature = [extra * x for extra, x in zip(literal.armature, literal.state.a, strict=True)]
    assert len(jacobian) == system.natural.nn - system.tree.nv
    joints = [a - b for a, b in zip(literal.passive_force(), _between_points(literal), strict=True)]
    total = [w + a + j for w, a, j in zip(wrenches, armature, joints, strict=True)]
    assert equal(total, literal.inverse_dynamics())


@given(seeds, st.booleans())
@settings(max_examples=6, deadline=None)
def test_multipliers_are_the_least_squares_solution(seed: int, planar: bool) -> None:
    """Without outer forces, λ is what NumPy's least squares makes of Ψᵀλ = Mẍ in floats."""
    scene = replace(kinematic_scene(seed, planar=planar), gravity=(F(0), F(0), F(0)), forces=())
    system, rng = derive(scene), random.Random(seed)
    size = system.sizes
    q, v, a = ([rng.uniform(-1, 1) for _ in range(n)] for n in (size.nq, size.nv, size.nv))
    literal = system.literal(FloatNumbers(), State(q=q, v=v, a=a))
    psi = np.array(literal.constraint_jacobian(), dtype=float).reshape(size.nc, size.nn)
    motion = np.array(literal.velocity_transformation(), dtype=float) @ a
    load = np.array(literal.natural_mass_matrix(), dtype=float) @ (motion + literal.natural_bias_acceleration())
    expected = np.linalg.lstsq(psi.T, load, rcond=None)[0]
    found = np.array(reactions.constraint_forces(literal), dtype=float)
    assert np.allclose(found, expected, rtol=1e-6, atol=1e-6 * (1 + np.abs(expected).max(initial=0)))


def _between_points(literal: Literal) -> list[Any]:
    found: list[Any] = [0] * literal.tree.nv
    for spring in literal.values.scene.forces:
        if not isinstance(spring, JointSpring):
            for j, value in literal._spring_force(spring).items():
                found[j] = found[j] + value
    return found
