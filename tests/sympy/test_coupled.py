"""SymPy forms of mechanisms in which joints follow another one: equal to the literal rows."""

from __future__ import annotations

import pytest

from symgen.scene.builder import SceneBuilder
from symgen.system import System, derive
from symgen.targets.sympy import sympy_matrix, system_symbols
from tests.sympy.evaluate import bindings, literal, random_state, value_of
from tests.sympy.test_matrices import agree


def folding(multiplier: str, offset: str) -> System:
    """Three links in a row; the first follows the last, and a slide beside them does too."""
    made = SceneBuilder("folding")
    for k, name in enumerate("abcd"):
        made.body(name, mass=1 + k, com=("0.1", 0, "-0.5"), inertia=(1, 1, "0.1", 0, 0, 0))
    follows = {"joint": "last", "multiplier": multiplier, "offset": offset}
    made.joint("first", "revolute", "ground", "a", axis=(0, 1, 0), mimic=follows)
    made.joint("middle", "revolute", "a", "b", axis=(0, 1, 0), xyz=(0, 0, -1))
    made.joint("last", "revolute", "b", "c", axis=(0, 1, 0), xyz=(0, 0, -1), armature="0.2")
    made.joint("slide", "prismatic", "a", "d", axis=(1, 0, 0), mimic={"joint": "last", "multiplier": 2})
    made.outputs("mass_matrix")
    return derive(made.build())


@pytest.mark.parametrize(("multiplier", "offset"), [("1", "0"), ("-2", "0.3")])
@pytest.mark.parametrize("row", ["mass_matrix", "bias_force", "kinetic_energy", "velocity_transformation"])
def test_followers(row: str, multiplier: str, offset: str) -> None:
    system = folding(multiplier, offset)
    state = random_state(system, 3)
    symbols = system_symbols(system.scene, system.tree)
    assert [str(symbol) for symbol in symbols.q] == ["theta_middle", "theta_last"]
    agree(value_of(sympy_matrix(system, row), bindings(system, state)), literal(system, row, state))
