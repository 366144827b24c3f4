"""Every plan is the literal definition: random trees of every joint type, exactly, in GF(p)."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F
from functools import partial
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.algebra.field import MERSENNE_61, FieldNumbers, Residue
from symgen.algebra.linear import dot
from symgen.algebra.numbers import State
from symgen.certificate import Candidate, Certifier
from symgen.plans import composite, coriolis, factor, recursive
from symgen.plans.build import PLANNED, build, flatten
from symgen.plans.families import DERIVATIVES, OF_MASS, Family, families_of, output_merges
from symgen.plans.lagging import lagging
from symgen.program.evaluate import evaluate_in_field
from symgen.program.instructions import count
from symgen.scene.model import JointSpring, Mimic, Options, Output, Parameter, Scene, Spring
from symgen.system import System, derive
from tests.natural.trees import random_scene

seeds = st.integers(0, 2**32)
few = settings(max_examples=25, deadline=None)


def scene_of(seed: int) -> Scene:
    """A random tree with armature, damping and springs; the base velocity convention varies."""
    rng = random.Random(seed)
    scene = random_scene(rng, rng.randint(1, 6))
    rooted = tuple(
        replace(joint, type="spherical") if joint.type == "floating" and joint.parent != "ground" else joint
        for joint in scene.joints
    )
    joints = tuple(
        replace(joint, armature=F(rng.randint(0, 2), 7), damping=F(rng.randint(0, 2), 5))
        if joint.type != "fixed"
        else joint
        for joint in rooted
    )
    forces: list[Spring | JointSpring] = []
    body = rng.choice(scene.bodies).name
    forces.append(Spring((body, "ground"), ((F(1), F(0), F(1, 3)), (F(0), F(2), F(5))), F(3), F(1, 2), name="s"))
    turning = [joint.name for joint in joints if joint.type in ("revolute", "planar", "cylindrical")]
    if turning:
        forces.append(JointSpring(turning[0], F(2), F(1, 4), F(1, 3), name="t"))
    convention = rng.choice(("world", "body", "mixed"))
    return replace(scene, joints=joints, forces=tuple(forces), options=Options(base_velocity=convention))


def state_of(system: System, numbers: FieldNumbers, rng: random.Random) -> State:
    def draw(n: int) -> tuple[Residue, ...]:
        return tuple(Residue(rng.randrange(1, numbers.p), numbers.p) for _ in range(n))

    size = system.sizes
    return State(draw(size.nq), draw(size.nv), draw(size.nv), draw(size.nv), draw(1)[0], draw(size.np))


def equal(a: Any, b: Any) -> bool:
    left, right = flatten(a), flatten(b)
    return len(left) == len(right) and all(Residue(0, MERSENNE_61) + x == y for x, y in zip(left, right, strict=True))


def with_armature(m: list[list[Any]], armature: Any) -> list[list[Any]]:
    return [[x + armature[i] if i == j else x for j, x in enumerate(row)] for i, row in enumerate(m)]


@given(seeds)
@few
def test_plans_run_in_the_field_itself(seed: int) -> None:
    scene = scene_of(seed)
    system, numbers, rng = derive(scene), FieldNumbers(MERSENNE_61, seed), random.Random(seed)
    if not system.tree.bodies:
        return
    state = state_of(system, numbers, rng)
    literal = system.literal(numbers, state)
    x = state.a
    for regrouped in (True, False):
        links = system.lowered.at(literal.values, state.q, regrouped)
        gravity = literal.values.gravity()
        m = with_armature(composite.mass_matrix(links), literal.armature)
        assert equal([dot(row, x) for row in m], literal.mass_matrix_times(x))
        bias = recursive.inverse_dynamics(links, state.v, [0] * system.tree.nv, gravity)
        assert equal([a + b for a, b in zip(literal.coriolis_force(), literal.gravity_force(), strict=True)], bias)
        c = coriolis.coriolis_matrix(links, state.v)
        assert equal([dot(row, x) for row in c], literal.coriolis_times(x))
        assert equal(coriolis.gravity_force(links, gravity), literal.gravity_force())
        motors = [extra * rate * rate for extra, rate in zip(literal.armature, state.v, strict=True)]
        twice = sum(motors, coriolis.twice_kinetic_energy(links, state.v))
        assert equal(twice, 2 * literal.kinetic_energy())
        energy = coriolis.gravity_energy(links, gravity) + literal.spring_energy()
        assert equal(energy, literal.potential_energy())


@given(seeds)
@few
def test_solvers_solve(seed: int) -> None:
    """Both solvers give x with M x = b, and the product of their pivots is det M."""
    scene = scene_of(seed)
    scene = replace(scene, joints=tuple(replace(j, armature=j.armature + F(1, 9)) for j in scene.joints))
    system, numbers, rng = derive(scene), FieldNumbers(MERSENNE_61, seed), random.Random(seed)
    state = state_of(system, numbers, rng)
    literal = system.literal(numbers, state)
    links = system.lowered.at(literal.values, state.q)
    m = with_armature(composite.mass_matrix(links), literal.armature)
    factored, products = factor.factor(links, m), []
    for x, pivots in (
        (factored.solve(state.tau), factored.pivots),
        factor.solve_articulated(links, literal.armature, state.tau),
    ):
        assert equal(literal.mass_matrix_times(x), state.tau)
        product = numbers.const(1)
        for pivot in pivots:
            product = product * pivot
        products.append(product)
    assert products[0] == products[1] == determinant([list(row) for row in m], numbers)


def determinant(m: list[list[Any]], numbers: FieldNumbers) -> Any:
    result = numbers.const(1)
    for k in range(len(m)):
        result = result * m[k][k]
        for i in range(k + 1, len(m)):
            ratio = m[i][k] / m[k][k]
            m[i] = [x - ratio * y for x, y in zip(m[i], m[k], strict=True)]
    return result


@given(seeds)
@few
def test_velocity_identities(seed: int) -> None:
    """Ψ_q R = 0, Ṙθ̇ without Ṙ equals Ṙ times θ̇, and C θ̇ is the Coriolis force."""
    system, rng = derive(scene_of(seed)), random.Random(seed)
    numbers = FieldNumbers(MERSENNE_61, seed)
    state = state_of(system, numbers, rng)
    literal = system.literal(numbers, state)
    r = literal.velocity_transformation()
    for row in literal.constraint_jacobian():
        assert equal([dot(row, column) for column in zip(*r, strict=True)], [0] * system.tree.nv)
    assert equal(literal.constraints(), [0] * system.natural.nc)
    rate = literal.velocity_transformation_rate()
    assert equal([dot(row, state.v) for row in rate], literal.natural_bias_acceleration())
    assert equal(literal.coriolis_times(state.v), literal.coriolis_force())


SINGLE = ("revolute", "continuous", "prismatic")


def coupled(scene: Scene, rng: random.Random) -> Scene:
    """Some of the one-dof joints made followers of others, chains included."""
    single = [joint.name for joint in scene.joints if joint.type in SINGLE]
    rng.shuffle(single)
    masters = {name: single[k - 1] for k, name in enumerate(single) if k and rng.randrange(2)}
    return replace(
        scene,
        joints=tuple(
            replace(joint, mimic=Mimic(masters[joint.name], F(rng.choice((-1, 1, 3)), 2), F(rng.randint(0, 2), 3)))
            if joint.name in masters
            else joint
            for joint in scene.joints
        ),
    )


def with_parameters(scene: Scene, rng: random.Random) -> Scene:
    """Inertial parameters, gravity, a spring and the geometry of two joints at run time."""
    body, names = scene.bodies[-1], list[tuple[str, tuple[F, ...]]]()
    names += [(f"{body.name}.mass", (body.mass,)), (f"{body.name}.com", body.com)]
    names += [(f"{body.name}.inertia", body.inertia), ("gravity", scene.gravity), ("s.stiffness", (F(3),))]
    names += [("s.point1", (F(1), F(0), F(1, 3)))]
    for joint in rng.sample(scene.joints, min(2, len(scene.joints))):
        if joint.type != "floating":
            names.append((f"{joint.name}.xyz", joint.origin.translation))
        if joint.type != "floating" and rng.randrange(2):
            names.append((f"{joint.name}.rpy", (F(0), F(0), F(0))))
        if joint.type in SINGLE:
            names.append((f"{joint.name}.offset", (F(0),)))
    found, start = [], 0
    for name, default in names:
        found.append(Parameter(name, default, "", start))
        start += len(default)
    return replace(scene, parameters=tuple(found))


@given(seeds, st.booleans(), st.booleans())
@settings(max_examples=8, deadline=None)
def test_programs_of_every_family(seed: int, runtime: bool, couplings: bool) -> None:
    """The optimised program of each family is certified, with parameters at run time and with coupled joints."""
    rng = random.Random(seed)
    scene = scene_of(seed)
    scene = replace(scene, joints=tuple(replace(j, armature=F(1, 9)) for j in scene.joints))
    scene = coupled(scene, rng) if couplings else scene
    system = derive(with_parameters(scene, rng) if runtime else scene)
    certifier = Certifier(system, str(seed))
    massless = not any(part.mass for body in system.tree.bodies for part, _ in body.parts)
    for row in sorted(PLANNED.keys() - DERIVATIVES - (OF_MASS if massless else set())):
        output = Output(row, (row,))
        for family in every_family(output, system):
            program = build(system.lowered, system.natural, output, family)
            certifier.certify(output, program, [Candidate(f"{row} by {family}", partial(evaluate_in_field, program))])


def every_family(output: Output, system: System) -> list[Family]:
    """Families of a function, those that merge parallel axes included."""
    families = families_of(output, system.tree)
    merged = [replace(family, merged=True) for family in families if not family.literal]
    return [*families, *(merged if output_merges(output) and lagging(system.lowered.links) else ())]


def test_families_have_different_names() -> None:
    tree = derive(scene_of(11)).tree
    for row in ("forward_dynamics", "inverse_dynamics_derivatives", "vjp:forward_dynamics", "mass_matrix"):
        output = Output(row, (row,))
        families = families_of(output, tree)
        assert len({family.plan(output) for family in families}) == len(families) > 1


def test_combined_function_shares_work() -> None:
    """One function for M, bias and forward dynamics costs less than the three apart."""
    scene = replace(scene_of(11), outputs=(Output("dynamics", ("mass_matrix", "bias_force", "forward_dynamics")),))
    system = derive(scene)
    together = count(system.program("dynamics")).flops
    apart = sum(count(system.program(row)).flops for row in ("mass_matrix", "bias_force", "forward_dynamics"))
    assert together < apart
