"""Many right-hand sides at once: M X = B and M⁻¹ from M = LᵀDL, by L or by L⁻¹, whichever takes fewer operations.

With L⁻¹ what acts on one branch moves another by the velocities of their common ancestors alone, where L goes through
the whole branch; but L⁻¹ fills in where L is zero along a path.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from symgen.algebra.linear import add, dot, known_value, mul, sub
from symgen.plans.factor import Factored

Scalar = Any
Column = Sequence[Scalar]
Rows = Sequence[dict[int, Scalar]]
Solved = tuple[list[list[Scalar]], list[list[Scalar]]]
"""The solutions, one list for each right-hand side, and M⁻¹ (full symmetric)."""


def solved(factored: Factored, columns: Sequence[Column]) -> Solved:
    """x with M x = b for every b in ``columns``, and M⁻¹."""
    ways: tuple[Callable[[Factored, Sequence[Column]], Solved], ...] = (_by_factor, _by_inverse_factor)
    return min(ways, key=lambda way: _operations(way, factored, columns))(factored, columns)


class _Tally:
    """A number that is nothing but a count of the operations made with it."""

    def __init__(self) -> None:
        self.count = 0

    def _operation(self, other: object) -> _Tally:
        self.count += 1
        return self

    __add__ = __radd__ = __sub__ = __mul__ = __rmul__ = _operation

    def __neg__(self) -> _Tally:
        return self


def _operations(
    way: Callable[[Factored, Sequence[Column]], Solved], factored: Factored, columns: Sequence[Column]
) -> int:
    """Operations of a way to solve, from the zeros alone."""
    tally = _Tally()

    def seen(x: Scalar) -> Scalar:
        return 0 if known_value(x) == 0 else tally

    rows = tuple({i: seen(x) for i, x in row.items()} for row in factored.rows)
    pattern = Factored((tally,) * len(rows), (tally,) * len(rows), rows)
    way(pattern, [[seen(x) for x in column] for column in columns])
    return tally.count


def _by_factor(factored: Factored, columns: Sequence[Column]) -> Solved:
    return [factored.solve(b) for b in columns], factored.inverse_matrix()


def _by_inverse_factor(factored: Factored, columns: Sequence[Column]) -> Solved:
    shares = _shares(factored.rows)
    found = [_solve_by_shares(factored.inverse, shares, b) for b in columns]
    return found, _inverse_by_shares(factored.inverse, shares)


def _shares(rows: Rows) -> Rows:
    """A = 1 − L⁻¹ below its diagonal, from L − 1: A = (L − 1)(1 − A)."""
    found: list[dict[int, Scalar]] = []
    for row in rows:
        shares = dict(row)
        for i, ratio in row.items():
            for j, share in found[i].items():
                shares[j] = sub(shares.get(j, 0), mul(ratio, share))
        found.append(shares)
    return found


def _solve_by_shares(inverse: Sequence[Scalar], shares: Rows, b: Column) -> list[Scalar]:
    felt = list(b)
    for k, row in enumerate(shares):
        for i, share in row.items():
            felt[i] = sub(felt[i], mul(share, b[k]))
    own = [mul(over, value) for over, value in zip(inverse, felt, strict=True)]
    return [sub(own[k], dot(list(row.values()), [own[i] for i in row])) for k, row in enumerate(shares)]


def _inverse_by_shares(inverse: Sequence[Scalar], shares: Rows) -> list[list[Scalar]]:
    """L⁻¹ D⁻¹ L⁻ᵀ entry by entry, over the common ancestors of two velocities."""
    n = len(inverse)
    scaled = [{k: mul(inverse[k], share) for k, share in row.items()} for row in shares]
    found: list[list[Scalar]] = [[0] * n for _ in range(n)]
    for i, row in enumerate(shares):
        for j in range(i + 1):
            common = [k for k in scaled[j] if k in row]
            entry = dot([row[k] for k in common], [scaled[j][k] for k in common])
            if i == j:
                entry = add(inverse[i], entry)
            elif j in row:
                entry = sub(entry, scaled[i][j])
            found[i][j] = found[j][i] = entry
    return found
