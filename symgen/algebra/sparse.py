"""Sparse symmetric systems over any number type: an order of elimination with little fill, and LDLᵀ in that order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import add, is_zero, mul, sub

Scalar = Any
Symmetric = Sequence[Mapping[int, Scalar]]
"""Rows of a symmetric matrix, both halves, structural zeros left out; every diagonal entry is there."""


def gram(rows: Sequence[Sequence[Scalar]]) -> list[dict[int, Scalar]]:
    """A Aᵀ of a matrix whose structural zeros are the int 0."""
    sparse = [{k: x for k, x in enumerate(row) if not is_zero(x)} for row in rows]
    columns: dict[int, list[int]] = {}
    for i, row in enumerate(sparse):
        for k in row:
            columns.setdefault(k, []).append(i)
    found: list[dict[int, Scalar]] = [{} for _ in rows]
    for i, row in enumerate(sparse):
        for j in sorted({j for k in row for j in columns[k] if j >= i}):
            value: Scalar = 0
            for k, x in row.items():
                if k in sparse[j]:
                    value = add(value, mul(x, sparse[j][k]))
            if not is_zero(value):
                found[i][j] = found[j][i] = value
    return found


def elimination_order(matrix: Symmetric) -> list[int]:
    """Minimum degree: always the unknown with the fewest neighbours left, the last of these."""
    near = [set(row) - {i} for i, row in enumerate(matrix)]
    left, order = set(range(len(matrix))), list[int]()
    while left:
        pick = min(left, key=lambda i: (len(near[i]), -i))
        left.remove(pick)
        order.append(pick)
        for i in near[pick]:
            near[i] |= near[pick]
            near[i] -= {i, pick}
    return order


def solve_symmetric(matrix: Symmetric, b: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
    """x with A x = b by LDLᵀ, and the pivots, which are all positive exactly when A is positive definite.

    Raises ZeroDivisionError, or what the number type raises, where a pivot is zero.
    """
    h = [dict(row) for row in matrix]
    x, order = list(b), elimination_order(matrix)
    pivots, inverses, factors = list[Scalar](), list[Scalar](), list[dict[int, Scalar]]()
    for k in order:
        pivots.append(h[k].pop(k, 0))
        inverses.append(Fraction(1, pivots[-1]) if type(pivots[-1]) is int else 1 / pivots[-1])
        row = h[k]
        factors.append({i: mul(value, inverses[-1]) for i, value in row.items()})
        for i, ratio in factors[-1].items():
            del h[i][k]
            for j, value in row.items():
                if j >= i:
                    h[i][j] = h[j][i] = sub(h[i].get(j, 0), mul(ratio, value))
            x[i] = sub(x[i], mul(ratio, x[k]))
    for k, inverse, factor in reversed(list(zip(order, inverses, factors, strict=True))):
        x[k] = mul(x[k], inverse)
        for i, ratio in factor.items():
            x[k] = sub(x[k], mul(ratio, x[i]))
    return x, pivots
