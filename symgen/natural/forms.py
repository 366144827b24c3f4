"""Vectors written as combinations of natural coordinates, and the polynomials their products are.

A coefficient is a pair (p, q) that stands for p + iq: in planar scenes a complex number that turns and scales the
plane's vectors, in space always real.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from symgen.natural.carriers import complex_product
from symgen.natural.entities import Vector
from symgen.natural.layout import Complex, NaturalCoordinates, Term
from symgen.natural.plane import in_plane, product

Polynomial = dict[tuple[int, ...], Fraction]
"""Offsets in x (ascending) → coefficient; () is the constant."""

NONE = Fraction(0)


class Form:
    """Σ coefficient · (moving entity) + constant, a vector of 3 (planar: 2) components."""

    __slots__ = ("constant", "moving")

    def __init__(self, size: int) -> None:
        self.moving: dict[int, Complex] = {}
        """Start of an entity in x → its coefficient."""
        self.constant: list[Fraction] = [NONE] * size

    def __sub__(self, other: Form) -> Form:
        result = Form(len(self.constant))
        result.moving = dict(self.moving)
        for start, (p, q) in other.moving.items():
            a, b = self.moving.get(start, (NONE, NONE))
            result.moving[start] = (a - p, b - q)
        result.constant = [a - b for a, b in zip(self.constant, other.constant, strict=True)]
        return result


def entity_form(natural: NaturalCoordinates, index: int) -> Form:
    """The entity itself. Its coefficient is the pair of ints (1, 0): quicker than rationals."""
    form = Form(3 if natural.plane is None else 2)
    entity = natural.entities[index]
    if entity.start is not None:
        form.moving[entity.start] = (1, 0)  # type: ignore[assignment]
    else:
        form.constant = list(ground_position(natural, index))
    return form


def ground_position(natural: NaturalCoordinates, index: int) -> tuple[Fraction, ...]:
    """The constant coordinates of an entity fixed in ground."""
    local = natural.entities[index].local[-1]
    return local if natural.plane is None else in_plane(natural.plane, local)


def combination(natural: NaturalCoordinates, parts: Iterable[tuple[int, Complex]]) -> Form:
    """Σ coefficient · entity, the entities fixed in ground put in as constants."""
    form = Form(3 if natural.plane is None else 2)
    for index, (p, q) in parts:
        entity = natural.entities[index]
        if not p and not q:
            continue
        if entity.start is not None:
            form.moving[entity.start] = (p, q)
            continue
        fixed = ground_position(natural, index)
        if natural.plane is None:
            values: Iterable[Fraction] = (p * value for value in fixed)
        else:
            values = complex_product((p, q), (fixed[0], fixed[1]))
        form.constant = [a + b for a, b in zip(form.constant, values, strict=True)]
    return form


def carried(natural: NaturalCoordinates, body: int, kind: str, local: Vector) -> list[tuple[int, Complex]]:
    """A point or direction of a body as a combination of its carriers: (1, x) W⁻¹ or (0, d) W⁻¹."""
    inverse, carriers = natural.W_inverse[body], natural.carriers[body]
    head = 1 if kind == "point" else 0
    parts: list[tuple[int, Complex]] = []
    if natural.plane is None:
        for n, index in enumerate(carriers):
            value = product(local, (inverse[1][n], inverse[2][n], inverse[3][n]))
            parts.append((index, (value + inverse[0][n] if head else value, NONE)))
        return parts
    x = in_plane(natural.body_planes[body], local)
    for n, index in enumerate(carriers):
        a, b = complex_product(x, inverse[1][n])
        parts.append((index, (a + head * inverse[0][n][0], b + head * inverse[0][n][1])))
    return parts


def direction(natural: NaturalCoordinates, body: int, local: Vector) -> Form:
    """A vector fixed in a body (−1: in ground)."""
    if body >= 0:
        return combination(natural, carried(natural, body, "vector", local))
    form = Form(3 if natural.plane is None else 2)
    form.constant = list(local if natural.plane is None else in_plane(natural.plane, local))
    return form


def _increase(polynomial: Polynomial, key: tuple[int, ...], value: Fraction) -> None:
    polynomial[key] = polynomial[key] + value if key in polynomial else value


def dot(f: Form, g: Form) -> Polynomial:
    """The scalar product. With w = p + iq = (coefficient of f)* · (coefficient of g), two planar vectors z and y give
    Re(w z* y) = p z·y − q z×y."""
    result: Polynomial = {}
    size = len(f.constant)
    for i, c in f.moving.items():
        for j, d in g.moving.items():
            p, q = complex_product((c[0], -c[1]), d)
            if p:
                for k in range(size):
                    _increase(result, (i + k, j + k) if i <= j else (j + k, i + k), p)
            if q and i != j:
                _increase(result, (i, j + 1) if i < j else (j + 1, i), -q)
                _increase(result, (i + 1, j) if i < j else (j, i + 1), q)
    for moving, fixed in ((f, g), (g, f)):
        for i, (p, q) in moving.moving.items():
            for k in range(size):
                value = p * fixed.constant[k]
                if q:
                    value += q * fixed.constant[1] if k == 0 else -q * fixed.constant[0]
                if value:
                    _increase(result, (i + k,), value)
    value = sum((a * b for a, b in zip(f.constant, g.constant, strict=True)), NONE)
    if value:
        _increase(result, (), value)
    return result


def component(form: Form, k: int) -> Polynomial:
    """Component k of a vector."""
    result: Polynomial = {}
    for i, (p, q) in form.moving.items():
        if p:
            _increase(result, (i + k,), p)
        if q:
            _increase(result, (i + 1 - k,), q if k else -q)
    if form.constant[k]:
        _increase(result, (), form.constant[k])
    return result


def terms(polynomial: Polynomial, factor: int = 1, turn: tuple[str, int] | None = None) -> tuple[Term, ...]:
    """The polynomial times ``factor`` and the cos or sin of an angle, highest degree first."""
    keys = sorted(polynomial, key=lambda key: (-len(key), key))
    return tuple(Term(Fraction(factor * polynomial[key]), key, turn) for key in keys if polynomial[key])
