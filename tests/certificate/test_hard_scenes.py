"""Right scenes that are hard to certify: equal pivots, constants that share a double, roots, high degrees."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F

import pytest

from symgen.algebra.numbers import FloatNumbers, State
from symgen.errors import CertificateError, SceneError
from symgen.generate import Generated, generate_files
from symgen.program.evaluate import evaluate
from symgen.scene.model import Body, Joint, Output, Parameter, Scene, Spring, Transform, Vector
from symgen.system import derive
from tests.plans.chains import chain

X, Z = (F(1), F(0), F(0)), (F(0), F(0), F(1))
SOLID = (F(1, 10), F(1, 5), F(1, 4), F(0), F(0), F(0))


def made(scene: Scene, *rows: str) -> Generated:
    outputs = tuple(Output(row, (row,)) for row in rows)
    return generate_files(derive(replace(scene, outputs=outputs)), lambda done, total, what: None)


def door(*forces: Spring, com: Vector = X) -> Scene:
    """One body that turns about z."""
    return Scene(
        "door", (Body("b", F(2), com, SOLID),), (Joint("j", "revolute", "ground", "b", axis=Z),), forces=forces
    )


def test_pivots_that_are_one_value_are_guarded_once() -> None:
    """The three translations of a free body whose mass is a parameter, and the three turns of a motor ball."""
    free = Scene("free", (Body("b", F(2), inertia=SOLID),), (Joint("j", "floating", "ground", "b"),))
    ball = Scene("ball", (Body("b"),), (Joint("j", "spherical", "ground", "b", armature=F(1)),))
    for scene, name, unit in ((free, "b.mass", "kg"), (ball, "j.armature", "kg.m^2")):
        varied = replace(scene, parameters=(Parameter(name, (F(2),), unit, 0),))
        assert made(varied, "forward_dynamics").certificates


def test_constants_that_share_a_double() -> None:
    """Two masses that are one double: CasADi merges them, in outputs and in products."""
    masses = (F(1, 10), F(1, 10) + F(1, 10**23))
    bodies = tuple(Body(f"b{k}", mass) for k, mass in enumerate(masses))
    joints = tuple(Joint(f"j{k}", "prismatic", "ground", f"b{k}", axis=X) for k in range(2))
    assert made(Scene("twins", bodies, joints), "natural_mass_matrix", "mass_matrix", "kinetic_energy").certificates


def test_many_springs_with_lengths() -> None:
    """Each squared length is a square at half of the points only."""
    scene = chain(10)
    springs = tuple(
        Spring((body.name, "ground"), ((F(0), F(1, 7), F(k)), (F(k), F(0), F(2))), F(3), F(1), F(1, 2))
        for k, body in enumerate(scene.bodies)
    )
    assert made(replace(scene, forces=springs), "passive_force", "potential_energy").certificates


@pytest.mark.parametrize("place", [(F(0), F(0), F(0)), (F(0), F(0), F(1)), (F(-2), F(-4), F(0))])
def test_springs_of_constant_length(place: Vector) -> None:
    """Points of the axis stay where they are: 5 and the root of 26 are constants, in CasADi folded ones."""
    spring = Spring(("ground", "b"), ((F(3), F(4), F(0)), place), F(1), F(1), F(2))
    scene = door(spring)
    assert made(scene, "passive_force", "potential_energy").certificates
    system = derive(scene)
    program, state = system.program("potential_energy"), State(q=(0.3,))
    (energy,) = evaluate(program, FloatNumbers(), {"q": (0.3,)})["V"]
    assert energy == pytest.approx(system.evaluate("potential_energy", FloatNumbers(), state)["V"])


def test_springs_without_a_direction_are_refused() -> None:
    spring = Spring(("ground", "b"), ((F(0), F(0), F(2)), (F(0), F(0), F(2))), F(1), F(0), F(1), name="s")
    for row in ("passive_force", "potential_energy", "forward_dynamics"):
        with pytest.raises(SceneError, match="the spring 's' has both ends at one place in every configuration"):
            derive(door(spring)).program(row)
    assert made(door(replace(spring, length=F(0))), "passive_force", "potential_energy").certificates


def test_springs_inside_one_rigid_body_do_nothing() -> None:
    scene = door(Spring(("b", "c"), ((F(0), F(0), F(0)), (F(1), F(0), F(0))), F(1), F(1), F(3)))
    weld = Joint("w", "fixed", "b", "c", Transform(translation=(F(-1), F(0), F(0))))
    scene = replace(scene, bodies=(*scene.bodies, Body("c", F(1))), joints=(*scene.joints, weld))
    generated = made(scene, "passive_force", "potential_energy", "bias_force")
    assert "sqrt" not in str(generated.files["door.c"])


def test_long_chains_have_small_failure_probabilities() -> None:
    """Formal degrees double with every pivot; a certificate says what it assumes and never that it may fail surely."""
    certificates = made(chain(40), "forward_dynamics", "mass_matrix").certificates
    assert all(certificate.failure_probability < 1e-25 for certificate in certificates.values())
    assert "random residues" in certificates["forward_dynamics"].method
    assert "random residues" not in certificates["mass_matrix"].method


def test_massless_scenes_are_refused_by_name() -> None:
    with pytest.raises((SceneError, CertificateError), match=r"mass matrix is singular.*joint 'j'"):
        made(Scene("light", (Body("b"),), (Joint("j", "revolute", "ground", "b", axis=Z),)), "forward_dynamics")
