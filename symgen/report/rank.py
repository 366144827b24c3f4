"""The number of degrees of freedom, from the constraints: exact rank in a prime field."""

from __future__ import annotations

import random
from typing import Any

from symgen.algebra.field import MERSENNE_61, FieldNumbers, NotInField, Residue, inverse
from symgen.algebra.numbers import State
from symgen.system import System


def constraint_rank(system: System, seed: int = 1) -> int:
    """Rank of Ψ_q at a random configuration of the tree, taken in GF(2⁶¹ − 1): it is exact but for a chance of 1e-16.

    Loops that are cut are open here.
    """
    p = MERSENNE_61
    for attempt in range(100):
        rng = random.Random(f"{system.scene.sha256}:{seed}:{attempt}")
        numbers = FieldNumbers(p, rng.getrandbits(64))

        def draw(n: int, rng: random.Random = rng) -> tuple[Residue, ...]:
            return tuple(Residue(rng.randrange(1, p), p) for _ in range(n))

        state = State(q=draw(system.tree.nq), v=draw(system.tree.nv), p=draw(system.sizes.np))
        try:
            return rank(system.literal(numbers, state).constraint_jacobian(), p)
        except NotInField:
            continue
    raise ArithmeticError("no configuration found at which the constraints can be evaluated")


def rank(matrix: Any, p: int) -> int:
    """Rank of a matrix over GF(p) by elimination."""
    rows = [[_residue(x, p) for x in row] for row in matrix]
    found = 0
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((k for k in range(found, len(rows)) if rows[k][column]), None)
        if pivot is None:
            continue
        rows[found], rows[pivot] = rows[pivot], rows[found]
        scale = inverse(rows[found][column], p)
        for k in range(found + 1, len(rows)):
            factor = rows[k][column] * scale % p
            if factor:
                rows[k] = [(x - factor * y) % p for x, y in zip(rows[k], rows[found], strict=True)]
        found += 1
    return found


def _residue(x: Any, p: int) -> int:
    return x.x if isinstance(x, Residue) else (Residue(0, p) + x).x
