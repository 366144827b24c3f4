"""SymPy matrices: the numbers of the literal definition, shapes, names, and what stays of structure."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

from symgen.errors import SceneError
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.load import load
from symgen.scene.model import GROUND, Options, Output, Parameter, Scene, Spring, Transform
from symgen.system import System, derive
from symgen.targets.sympy import row_equation, sympy_matrix, system_symbols
from tests.natural.trees import random_planar_scene, random_scene
from tests.sympy.evaluate import bindings, literal, random_state, value_by_definitions, value_of
from tests.validation.scenes import SINGLES, chain, single, sprung, vec

EXAMPLES = Path(__file__).parents[2] / "examples"
SMALL = (
    "pendulum", "double_pendulum", "cart_pole", "furuta", "spherical_pendulum", "screw_drive", "slope_body",
    "spinning_top", "universal_shaft", "free_body",
)  # fmt: skip
CHEAP = ("velocity_transformation", "mass_matrix", "bias_force")


def example(name: str) -> System:
    return derive(load(EXAMPLES / f"{name}.scene.yaml"))


def rows(system: System) -> list[str]:
    return [row for output in system.outputs for row in output.of]


def agree(found: Any, wanted: Any) -> None:
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max(initial=0.0) <= 1e-11 * max(1.0, np.abs(wanted).max(initial=0.0))


@pytest.mark.parametrize("name", SMALL)
def test_every_row_of_an_example_is_the_literal_one(name: str) -> None:
    system = example(name)
    state = random_state(system, 1)
    known = bindings(system, state)
    for row in rows(system):
        if row == "forward_dynamics" and system.tree.nv > 3:
            continue  # nested and large: by definitions below
        agree(value_of(sympy_matrix(system, row), known), literal(system, row, state))


@pytest.mark.parametrize("name", ["free_body", "fig1", "fig2", "ur5"])
def test_definitions_are_the_literal_rows(name: str) -> None:
    system = example(name)
    state = random_state(system, 2)
    known = bindings(system, state)
    for row in ("mass_matrix", "forward_dynamics"):
        equation = row_equation(system, row, longest=5)
        agree(value_by_definitions(equation, known), literal(system, row, state))
        assert equation.definitions


@pytest.mark.parametrize("base_velocity", ["world", "body", "mixed"])
def test_floating_conventions(base_velocity: str) -> None:
    scene = chain("f", ("floating",), options=Options(base_velocity=base_velocity))
    system = derive(scene)
    state = random_state(system, 3)
    for row in (*CHEAP, "integrate"):
        found = value_of(sympy_matrix(system, row), bindings(system, state))
        agree(found, literal(system, row, state))
    names = [symbol.name for symbol in system_symbols(scene, system.tree).v]
    wanted = ["v_j1_x", "v_j1_y", "v_j1_z"] if base_velocity == "body" else ["xdot_j1", "ydot_j1", "zdot_j1"]
    assert names[:3] == wanted


@pytest.mark.parametrize("kind", [kind for kind in SINGLES if kind != "floating"])
def test_every_joint_type(kind: str) -> None:
    system = derive(single(kind))
    state = random_state(system, 4)
    for row in (*CHEAP, "kinetic_energy", "integrate"):
        agree(value_of(sympy_matrix(system, row), bindings(system, state)), literal(system, row, state))


@pytest.mark.parametrize("seed", range(6))
def test_random_trees(seed: int) -> None:
    rng = random.Random(seed)
    scene = random_planar_scene(rng, 4) if seed % 2 else random_scene(rng, 3, ("revolute", "prismatic", "helical"))
    system = derive(scene)
    state = random_state(system, seed)
    for row in CHEAP:
        agree(value_of(sympy_matrix(system, row), bindings(system, state)), literal(system, row, state))


def test_springs_with_roots() -> None:
    system = derive(sprung())
    state = random_state(system, 5)
    found = row_equation(system, "passive_force")
    agree(value_by_definitions(found, bindings(system, state)), literal(system, "passive_force", state))


def test_a_spring_in_closed_form() -> None:
    scene = load(EXAMPLES / "pendulum.scene.yaml")
    spring = Spring(("rod", GROUND), (vec(0, 0, -1), vec(1, 0, 0)), F(20), F(1, 2), F(1, 3))
    system = derive(replace(scene, forces=(spring,)))
    state = random_state(system, 5)
    for row in ("passive_force", "potential_energy"):
        found = sympy_matrix(system, row)
        agree(value_of(found, bindings(system, state)), literal(system, row, state))
        assert any(power.exp in (sympy.S.Half, -sympy.S.Half) for power in found.atoms(sympy.Pow))
        assert len(str(found)) < 400


def test_parameters_are_symbols() -> None:
    scene = load(EXAMPLES / "double_pendulum.scene.yaml")
    parameters = (
        Parameter("lower.mass", (F(3, 4),), "kg", 0),
        Parameter("lower.com", (F(0), F(0), F(-2, 5)), "m", 1),
        Parameter("gravity", (F(0), F(0), F(-981, 100)), "m/s²", 4),
    )
    system = derive(replace(scene, parameters=parameters))
    state = random_state(system, 6)
    for row in (*CHEAP, "inverse_dynamics", "forward_dynamics"):
        agree(value_of(sympy_matrix(system, row), bindings(system, state)), literal(system, row, state))
    names = {symbol.name for symbol in sympy_matrix(system, "gravity_force").free_symbols}
    assert {"m_lower", "c_lower_z", "g_z", "theta_elbow"} <= names


def test_shapes_and_types() -> None:
    system = example("double_pendulum")
    assert sympy_matrix(system, "mass_matrix").shape == (2, 2)
    assert sympy_matrix(system, "bias_force").shape == (2, 1)
    assert isinstance(sympy_matrix(system, "kinetic_energy"), sympy.Expr)
    assert sympy_matrix(system, "frame_pose:tip").shape == (4, 4)
    assert system.sympy("mass_matrix") == sympy_matrix(system, "mass_matrix")


def test_several_outputs_come_by_name() -> None:
    scene = load(EXAMPLES / "pendulum.scene.yaml")
    outputs = (Output("dynamics", ("mass_matrix", "bias_force")),)
    found = derive(replace(scene, outputs=outputs)).sympy("dynamics")
    assert list(found) == ["M", "h"] and found["M"].shape == (1, 1)


def test_unknown_names_are_refused() -> None:
    with pytest.raises(SceneError, match="mass_matrx"):
        example("pendulum").sympy("mass_matrx")


def test_numbers_stay_exact() -> None:
    found = sympy_matrix(example("double_pendulum"), "mass_matrix")
    assert not found.atoms(sympy.Float)
    assert found[1, 1] == sympy.Rational(4, 25)


def test_parallel_axes_share_summed_angles() -> None:
    """A planar chain: linear in cosines of sums, not expanded into 2ⁿ products."""
    names = ("revolute",) * 8
    scene = chain("planar", names)
    x, z = vec(1, 0, 0), vec(0, 0, 1)
    joints = tuple(replace(joint, origin=Transform(translation=x), axis=z) for joint in scene.joints)
    system = derive(Scene("planar", scene.bodies, joints))
    found = sympy_matrix(system, "mass_matrix")
    assert all(isinstance(node.args[0], sympy.Symbol | sympy.Add) for node in found.atoms(sympy.cos))
    assert len(found[7, 0].atoms(sympy.cos, sympy.sin)) <= 14 and not found.has(sympy.Pow)
    state = random_state(system, 7)
    agree(value_of(found, bindings(system, state)), literal(system, "mass_matrix", state))


def test_quaternions_cancel() -> None:
    """In child axes a spherical joint's mass matrix does not depend on the quaternion, of any norm."""
    assert not sympy_matrix(example("spinning_top"), "mass_matrix").free_symbols


def test_symbols_of_all_joint_types_are_distinct() -> None:
    system = derive(chain("all", tuple(kind for kind in JOINT_TYPES if kind not in ("fixed",))))
    symbols = system_symbols(system.scene, system.tree)
    every = [*symbols.q, *symbols.v, *symbols.a, *symbols.tau, symbols.dt]
    assert len({symbol.name for symbol in every}) == len(every)
    assert all(symbol.name.isidentifier() for symbol in every)


def test_symbols_that_would_clash_are_kept_apart() -> None:
    scene = chain("clash", ("universal", "revolute", "revolute"))
    names = ("a", "a_1", "j1")
    joints = tuple(replace(j, name=name) for j, name in zip(scene.joints, names, strict=True))
    system = derive(Scene("clash", scene.bodies, joints))
    symbols = system_symbols(system.scene, system.tree)
    assert [symbol.name for symbol in symbols.q] == ["theta_a_1", "theta_a_2", "theta_a_1_2", "theta_j1"]


def test_a_wrong_mass_is_seen() -> None:
    """The comparison above can fail: the matrix of one scene against the literal form of another."""
    scene = load(EXAMPLES / "double_pendulum.scene.yaml")
    body = scene.bodies[1]
    heavier = replace(body, mass=body.mass + F(1, 1000))
    other = derive(replace(scene, bodies=(scene.bodies[0], heavier)))
    state = random_state(other, 1)
    with pytest.raises(AssertionError):
        found = value_of(sympy_matrix(derive(scene), "mass_matrix"), bindings(other, state))
        agree(found, literal(other, "mass_matrix", state))
