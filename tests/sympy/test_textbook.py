"""Closed forms of textbooks, symbolically: masses, lengths and gravity as letters."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path

import sympy

from symgen.scene.load import load
from symgen.scene.model import Parameter
from symgen.scene.parameters import available_parameters
from symgen.system import System, derive
from symgen.targets.sympy import sympy_matrix, system_symbols

EXAMPLES = Path(__file__).parents[2] / "examples"
g, length, m, inertia = sympy.symbols("g l m I", positive=True)


def with_parameters(name: str, *wanted: str) -> System:
    """An example with some of its numbers as run-time parameters."""
    scene = load(EXAMPLES / f"{name}.scene.yaml")
    known = available_parameters(scene)
    parameters, start = [], 0
    for parameter in wanted:
        values, unit = known[parameter]
        parameters.append(Parameter(parameter, values, unit, start))
        start += len(values)
    return derive(replace(scene, parameters=tuple(parameters)))


def same(found: sympy.Expr, wanted: sympy.Expr) -> bool:
    return bool(sympy.simplify(sympy.expand_trig(sympy.expand(found - wanted))) == 0)


def test_pendulum() -> None:
    """(m l² + I) θ̈ + m g l sin θ = τ"""
    system = with_parameters("pendulum", "rod.mass", "rod.com", "rod.inertia", "gravity")
    given = {
        "rod.mass": (m,), "rod.com": (0, 0, -length), "rod.inertia": (inertia, inertia, 0, 0, 0, 0),
        "gravity": (0, 0, -g),
    }  # fmt: skip
    symbols = system_symbols(system.scene, system.tree)
    (theta,), (rate,), (acceleration,), (tau,) = symbols.q, symbols.v, symbols.a, symbols.tau
    assert sympy_matrix(system, "mass_matrix", given)[0] == m * length**2 + inertia
    assert sympy_matrix(system, "gravity_force", given)[0] == m * g * length * sympy.sin(theta)
    assert sympy_matrix(system, "kinetic_energy", given) == rate**2 / 2 * (m * length**2 + inertia)
    assert sympy_matrix(system, "potential_energy", given) == -m * g * length * sympy.cos(theta)
    found = sympy_matrix(system, "inverse_dynamics", given)[0]
    assert found == acceleration * (m * length**2 + inertia) + m * g * length * sympy.sin(theta)
    found = sympy_matrix(system, "forward_dynamics", given)[0]
    assert found == (tau - m * g * length * sympy.sin(theta)) / (m * length**2 + inertia)
    assert str(sympy_matrix(system, "gravity_force", given)) == "Matrix([[g*l*m*sin(theta_hinge)]])"


def test_double_pendulum() -> None:
    """Two uniform links, relative angles: only cos θ₂ in the mass matrix, only sin θ₂ beside the gravity terms."""
    l1, m1, m2, c1, c2, i1, i2 = sympy.symbols("l1 m1 m2 c1 c2 I1 I2", positive=True)
    wanted = ("upper.mass", "upper.com", "upper.inertia", "lower.mass", "lower.com", "lower.inertia", "gravity")
    system = with_parameters("double_pendulum", *wanted)
    given = {
        "upper.mass": (m1,), "upper.com": (0, 0, -c1), "upper.inertia": (0, i1, 0, 0, 0, 0),
        "lower.mass": (m2,), "lower.com": (0, 0, -c2), "lower.inertia": (0, i2, 0, 0, 0, 0), "gravity": (0, 0, -g),
    }  # fmt: skip
    l1 = sympy.Integer(1)  # the distance of the joints is a number in this scene
    symbols = system_symbols(system.scene, system.tree)
    (q1, q2), (v1, v2) = symbols.q, symbols.v
    mass = sympy_matrix(system, "mass_matrix", given)
    m12 = i2 + m2 * (c2**2 + l1 * c2 * sympy.cos(q2))
    m11 = i1 + m1 * c1**2 + i2 + m2 * (l1**2 + c2**2 + 2 * l1 * c2 * sympy.cos(q2))
    for found, textbook in zip(mass, (m11, m12, m12, i2 + m2 * c2**2), strict=True):
        assert sympy.expand(found - textbook) == 0
    assert mass.atoms(sympy.cos, sympy.sin) == {sympy.cos(q2)}
    bias = sympy_matrix(system, "bias_force", given)
    spin = m2 * l1 * c2 * sympy.sin(q2)
    weight = m2 * g * c2 * sympy.sin(q1 + q2)
    assert sympy.expand(bias[0] + spin * (2 * v1 * v2 + v2**2) - (m1 * c1 + m2 * l1) * g * sympy.sin(q1) - weight) == 0
    assert sympy.expand(bias[1] - spin * v1**2 - weight) == 0
    assert bias.atoms(sympy.cos, sympy.sin) == {sympy.sin(q1), sympy.sin(q2), sympy.sin(q1 + q2)}


def test_cart_pole() -> None:
    """(M + m) ẍ + m l θ̈ cos θ − m l θ̇² sin θ = F,  m l ẍ cos θ + (I + m l²) θ̈ − m g l sin θ = τ (θ from upright)"""
    cart = sympy.Symbol("M", positive=True)
    system = with_parameters("cart_pole", "cart.mass", "pole.mass", "pole.com", "pole.inertia", "gravity")
    given = {
        "cart.mass": (cart,), "pole.mass": (m,), "pole.com": (0, 0, length), "pole.inertia": (0, inertia, 0, 0, 0, 0),
        "gravity": (0, 0, -g),
    }  # fmt: skip
    symbols = system_symbols(system.scene, system.tree)
    (_, theta), (_, rate), (force, tau) = symbols.q, symbols.v, symbols.tau
    cos, sin = sympy.cos(theta), sympy.sin(theta)
    mass = sympy.Matrix([[cart + m, m * length * cos], [m * length * cos, inertia + m * length**2]])
    bias = sympy.Matrix([-m * length * rate**2 * sin, -m * g * length * sin])
    assert sympy_matrix(system, "mass_matrix", given) == mass
    assert sympy_matrix(system, "bias_force", given) == bias
    found = sympy_matrix(system, "forward_dynamics", given)
    textbook = mass.inv() * (sympy.Matrix([force, tau]) - bias)
    assert all(same(x, y) for x, y in zip(found, textbook, strict=True))


def test_screw() -> None:
    """(I + m h²) θ̈ + m g h = τ, by hand for the example's numbers."""
    system = derive(load(EXAMPLES / "screw_drive.scene.yaml"))
    (acceleration,) = system_symbols(system.scene, system.tree).a
    found = sympy_matrix(system, "inverse_dynamics")[0]
    assert found == acceleration * sympy.Rational(25, 10000) + sympy.Rational(4905, 10000)


def test_spinning_top() -> None:
    """Euler's equations about the tip: A ω̇₁ − (A − C) ω₂ ω₃ and so on."""
    system = derive(load(EXAMPLES / "spinning_top.scene.yaml"))
    mass, bias = sympy_matrix(system, "mass_matrix"), sympy_matrix(system, "bias_force")
    gravity = sympy_matrix(system, "gravity_force")
    x, y, z = system_symbols(system.scene, system.tree).v
    a, c = mass[0, 0], mass[2, 2]
    assert mass == sympy.diag(a, a, c)
    euler = sympy.Matrix([-(a - c) * y * z, (a - c) * x * z, 0])
    assert sympy.expand(bias - gravity - euler) == sympy.zeros(3, 1)


def test_cylinder_on_a_slope_has_constant_mass() -> None:
    system = derive(load(EXAMPLES / "slope_body.scene.yaml"))
    (part, _) = system.tree.bodies[0].parts[0]
    mass = sympy_matrix(system, "mass_matrix")
    assert mass[0, 0] == mass[1, 1] == sympy.Rational(part.mass.numerator, part.mass.denominator)
    assert F(int(mass[0, 0].p), int(mass[0, 0].q)) == part.mass
