"""R x and Rᵀ y of large trees: the walks give what R, assembled block by block, gives."""

from __future__ import annotations

from pathlib import Path

import pytest

from symgen import derive
from symgen.algebra.field import MERSENNE_61, FieldNumbers, Residue
from symgen.algebra.numbers import State
from symgen.literal import walks

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENES = (
    "cart_pole",
    "fig1",
    "fig2",
    "gripper",
    "panda",
    "screw_drive",
    "universal_shaft",
    "spinning_top",
    "free_body",
)


@pytest.mark.parametrize("name", SCENES)
def test_walks_are_products_with_r(name: str) -> None:
    system = derive(EXAMPLES / f"{name}.scene.yaml")
    p, size = MERSENNE_61, system.sizes
    lengths = {"q": size.nq, "v": size.nv, "a": size.nv, "tau": size.nv, "p": size.np}
    drawn = iter(range(3, 10000, 7))
    fields = {key: tuple(Residue(next(drawn), p) for _ in range(n)) for key, n in lengths.items()}
    literal = system.literal(FieldNumbers(p, 1), State(**fields, dt=Residue(2, p)))
    x = [Residue(next(drawn) ** 5, p) for _ in range(size.nv)]
    blocks = literal.apply(literal.r_columns, x)
    walked = walks.velocities(literal.at, literal.natural, literal.values, literal.places, x)
    assert [list(row) for row in walked] == [list(row) for row in blocks]
    forces = walks.forces(literal.at, literal.natural, literal.values, literal.places, blocks)
    assert forces == literal.apply_transposed(blocks)
    assert any(value != 0 for value in forces)
