"""A derived system as the interface shows it: every form of every function, and clear refusals."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F

import pytest

from symgen.algebra.field import FieldNumbers, Residue
from symgen.algebra.numbers import FloatNumbers, State
from symgen.errors import NotSupportedError, SceneError, SymgenError
from symgen.scene.load import load
from symgen.scene.model import Body, Joint, Parameter, Scene
from symgen.system import derive

Z = (F(0), F(0), F(1))


def lifts(*masses: F) -> Scene:
    bodies = tuple(Body(f"b{k}", mass) for k, mass in enumerate(masses))
    joints = tuple(Joint(f"j{k}", "prismatic", "ground", body.name, axis=Z) for k, body in enumerate(bodies))
    return Scene("lifts", bodies, joints)


def test_forward_dynamics_stays_exact_where_the_mass_matrix_is_whole_numbers() -> None:
    numbers = FieldNumbers()
    x = tuple(Residue(k, numbers.p) for k in (2, 3))
    state = State(q=x, v=x, tau=x)
    found = derive(lifts(F(1), F(1))).evaluate("forward_dynamics", numbers, state)["a"]
    assert list(found) == [Residue(2, numbers.p) - F(981, 100), Residue(3, numbers.p) - F(981, 100)]


def test_a_singular_mass_matrix_is_an_error_in_numbers_too() -> None:
    with pytest.raises(SceneError, match="lifts: the mass matrix is singular: no inertia moves with velocity 1"):
        derive(lifts(F(1), F(0))).evaluate(
            "forward_dynamics", FloatNumbers(), State(q=(0.1, 0.2), v=(0.1, 0.2), tau=(0.1, 0.2))
        )
    with pytest.raises(SceneError, match="lifts: the mass matrix is singular"):
        derive(lifts(F(1), F(0))).sympy("forward_dynamics")


@pytest.mark.parametrize(
    "row", ["constraints", "jvp:constraints", "vjp:constraint_jacobian", "parameter_jacobian:constraints"]
)
def test_constraints_are_refused_where_origins_are_arguments_however_they_are_wrapped(row: str) -> None:
    scene = load("examples/double_pendulum.scene.yaml")
    system = derive(replace(scene, parameters=(Parameter("elbow.xyz", (F(0), F(0), F(-1)), "m", 0),)))
    with pytest.raises(NotSupportedError, match=f"{row} needs constant joint origins"):
        system.program(row)


@pytest.mark.parametrize("form", ["program", "plans", "sympy", "casadi", "evaluate"])
def test_closed_loops_are_shown_and_refused(form: str) -> None:
    system = derive(load("examples/four_bar.scene.yaml"))
    assert system.path_matrix.shape == system.secondary_path_matrix.shape == (3, 3)
    extra = (FloatNumbers(), State()) if form == "evaluate" else ()
    with pytest.raises(NotSupportedError, match=r"closed loops are not there yet.*cut at 'c'"):
        getattr(system, form)("mass_matrix", *extra)


@pytest.mark.parametrize(
    "name",
    [
        "nonsense",
        "frame_pose",
        "frame_pose:nowhere",
        "mass_matrix:b0",
        "closure",
        "jvp",
        "jvp:nonsense",
        "vjp:integrate",
        "parameter_jacobian:mass_matrix",
        "jvp:jvp:mass_matrix",
    ],
)
def test_functions_that_are_not_there(name: str) -> None:
    with pytest.raises(SymgenError, match=name.replace(":", "|")):
        derive(lifts(F(1))).program(name)
