"""Base parameters: the combinations of inertial parameters that the regressor can feel, by exact rank.

The columns of Y at random points of prime fields have, but for a chance below 1e-8 a prime, the rank that they have as
functions. The first columns that are independent of those before them stand for the base parameters, so that a body's
parameters go to bodies nearer to the root where they can; every other column is a combination of these, Y = Yb K with
rational K. K is found from its residues, and Y = Yb K is verified at fresh points. The independence of the columns in
a field implies their independence as functions.
Sources: Gautier 1991 (numerical rank), Mayeda et al. 1990 (what base parameters are).
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from symgen.algebra.field import MERSENNE_61, FieldNumbers, NotInField, Residue, is_prime, random_prime
from symgen.algebra.linear import Mat, Vec, mul, total
from symgen.algebra.numbers import State
from symgen.algebra.residues import LARGEST, Ints, ResidueNumbers, Residues, inverses
from symgen.errors import CertificateError
from symgen.literal.equations import Literal
from symgen.literal.regressor import PARAMETERS, TEN, inertial_parameters, regressor
from symgen.natural.layout import NaturalCoordinates
from symgen.scene.model import Scene
from symgen.topology.tree import Tree
from symgen.velocity.values import Values

POINTS = 16
"""Points per prime: a joint's row must feel all ten parameters of the bodies that only it moves."""
MOST_PRIMES = 512


@dataclass(frozen=True)
class BaseParameters:
    """β = K π, with Y π = Yb β in every state."""

    names: tuple[str, ...]
    """Of π: ``link1.m``, ``link1.mcx`` … ten per moving body."""
    independent: tuple[int, ...]
    """Columns of Y that make Yb, one per base parameter, ascending."""
    rows: tuple[Mapping[int, Fraction], ...]
    """K by rows, zeros left out: the one that belongs to a base parameter's own column comes first, and is 1."""

    @property
    def matrix(self) -> tuple[tuple[Fraction, ...], ...]:
        """K (nbase, 10 · moving bodies), exact."""
        n = len(self.names)
        return tuple(tuple(row.get(k, Fraction(0)) for k in range(n)) for row in self.rows)

    @property
    def unfelt(self) -> tuple[str, ...]:
        """Parameters that no base parameter contains."""
        felt = {k for row in self.rows for k in row}
        return tuple(name for k, name in enumerate(self.names) if k not in felt)


def base_parameters(scene: Scene, tree: Tree, natural: NaturalCoordinates) -> BaseParameters:
    """The base parameters of a tree, with gravity and geometry that are run-time arguments left free. Found once."""
    known: BaseParameters | None = tree.kept.get("base parameters")
    if known is None:
        known = tree.kept["base parameters"] = _find(scene, tree, natural)
    return known


def _find(scene: Scene, tree: Tree, natural: NaturalCoordinates) -> BaseParameters:
    names = tuple(f"{body.name}.{name}" for body in tree.bodies for name in PARAMETERS)
    if not names:
        return BaseParameters((), (), ())
    primes = _primes()
    for points in (POINTS, 2 * POINTS, 4 * POINTS):
        found = _attempt(_Source(scene, tree, natural, len(names), points), primes)
        if found is not None:
            return BaseParameters(names, tuple(next(iter(row)) for row in found), found)
    raise CertificateError(f"{scene.name}: the base parameters are no rational combinations that could be found")


def _attempt(source: _Source, primes: Iterator[int]) -> tuple[Mapping[int, Fraction], ...] | None:
    """K by rows, verified; None where the points of the first prime were too few or unlucky."""
    (first,), (p,) = source.matrices([next(primes)])
    reduced = first.copy()
    pivots = echelon(reduced, int(p), range(source.columns))
    blocks = _blocks(first, reduced[: len(pivots)], pivots, int(p))
    residues: list[list[Ints]] = [[] for _ in blocks]
    used, batch = np.zeros(0, dtype=np.int64), 4
    while len(used) < MOST_PRIMES:
        matrices, p = source.matrices([next(primes) for _ in range(batch)])
        try:
            found = [solved(block.cut(matrices), p) for block in blocks]
        except NotInField:
            return None
        for known, values in zip(residues, found, strict=True):
            known.append(values)
        used = np.concatenate([used, p])
        batch = len(used)
        rows = _rational(blocks, [np.concatenate(values) for values in residues], used, pivots)
        if rows is not None:
            return rows if source.holds(rows) else None
    return None


# --- columns of Y in prime fields -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Source:
    scene: Scene
    tree: Tree
    natural: NaturalCoordinates
    columns: int
    points: int

    def literal(self, numbers: Any, state: State) -> Literal:
        return Literal(self.tree, self.natural, Values(self.scene, numbers, state.p), state)

    def state(self, draw: Any) -> State:
        sizes = (self.tree.nq, self.tree.nv, self.tree.nv, sum(x.size for x in self.scene.parameters))
        q, v, a, p = ([draw() for _ in range(n)] for n in sizes)
        return State(q=q, v=v, a=a, p=p)

    def matrices(self, primes: Sequence[int]) -> tuple[Ints, Ints]:
        """Y at random points of every prime, stacked (primes, points · nv, columns), and the primes."""
        p = np.repeat(np.array(primes, dtype=np.int64), self.points)
        rng = np.random.default_rng(primes[0])
        while True:
            numbers = ResidueNumbers(p, int(rng.integers(2**60)))
            try:
                y = regressor(self.literal(numbers, self.state(lambda: Residues(rng.integers(1, p), p))))
                break
            except NotInField:
                continue  # other points
        stacked = np.zeros((len(primes), self.points, len(y), self.columns), dtype=np.int64)
        for i, row in enumerate(y):
            for j, entry in enumerate(row):
                if isinstance(entry, Residues):
                    stacked[:, :, i, j] = entry.x.reshape(len(primes), self.points)
                elif entry:
                    stacked[:, :, i, j] = numbers.const(Fraction(entry)).x.reshape(len(primes), self.points)
        return stacked.reshape(len(primes), -1, self.columns), np.array(primes, dtype=np.int64)

    def holds(self, rows: Sequence[Mapping[int, Fraction]]) -> bool:
        """Whether Y = Yb K at fresh points of two large fields."""
        pivots = [next(iter(row)) for row in rows]
        return all(self._holds_at(rows, pivots, p) for p in (MERSENNE_61, random_prime(len(self.scene.name))))

    def _holds_at(self, rows: Sequence[Mapping[int, Fraction]], pivots: Sequence[int], p: int) -> bool:
        rng = random.Random(f"{self.scene.name}:{p}")
        while True:
            numbers = FieldNumbers(p, rng.getrandbits(60))
            state = self.state(lambda: Residue(rng.randrange(1, p), p))
            try:
                y = regressor(self.literal(numbers, state))
                lifted = [{k: numbers.const(x) for k, x in row.items()} for row in rows]
                break
            except NotInField:
                continue
        for row in y:
            combined: list[Any] = [0] * self.columns
            for pivot, entries in zip(pivots, lifted, strict=True):
                for k, entry in entries.items():
                    combined[k] = combined[k] + row[pivot] * entry
            if not all(Residue(0, p) + x == z for x, z in zip(row, combined, strict=True)):
                return False
        return True


def _primes() -> Iterator[int]:
    """Primes below 2³¹, largest first."""
    return (p for p in range(LARGEST, 2, -2) if is_prime(p))


def echelon(m: Ints, p: int, columns: Iterable[int], rows: list[int] | None = None) -> list[int]:
    """Reduce ``m`` in place to row echelon form, fully reduced in the pivots' columns; the columns that are independent
    of those before them. ``rows`` takes the rows that the pivots were found in."""
    found: list[int] = []
    order = list(range(len(m)))
    for column in columns:
        row = len(found)
        candidates = np.nonzero(m[row:, column])[0]
        if not len(candidates):
            continue
        pick = row + int(candidates[0])
        m[[row, pick]] = m[[pick, row]]
        order[row], order[pick] = order[pick], order[row]
        m[row] = m[row] * pow(int(m[row, column]), -1, p) % p
        others = np.nonzero(m[:, column])[0]
        others = others[others != row]
        m[others] = (m[others] - m[others, column][:, None] * m[row]) % p
        found.append(column)
        if len(found) == len(m):
            break
    if rows is not None:
        rows[:] = order[: len(found)]
    return found


@dataclass(frozen=True)
class Block:
    """Dependent columns of one body, and the few independent columns that they are combinations of."""

    rows: tuple[int, ...]
    """Rows of Y that determine the combinations, in an order that needs no pivoting."""
    support: tuple[int, ...]
    dependent: tuple[int, ...]

    def cut(self, matrices: Ints) -> Ints:
        return matrices[:, self.rows][:, :, (*self.support, *self.dependent)]


def _blocks(first: Ints, combinations: Ints, pivots: Sequence[int], p: int) -> list[Block]:
    """What to solve for K, from K modulo the first prime."""
    kept, found = set(pivots), []
    for start in range(0, combinations.shape[1], TEN):
        dependent = [k for k in range(start, start + TEN) if k not in kept and np.any(combinations[:, k])]
        places = np.nonzero(np.any(combinations[:, dependent], axis=1))[0]
        support = [pivots[i] for i in places.tolist()]
        if dependent:
            rows: list[int] = []
            echelon(first[:, support].copy(), p, range(len(support)), rows)
            found.append(Block(tuple(rows), tuple(support), tuple(dependent)))
    return found


def solved(m: Ints, p: Ints) -> Ints:
    """X (primes, n, k) with A X = B for m = [A B] (primes, n, n + k). Raises NotInField where a pivot is 0."""
    n = m.shape[1]
    modulus = p[:, None, None]
    for k in range(n):
        row = m[:, k] * inverses(m[:, k, k], p)[:, None] % p[:, None]
        factor = m[:, :, k].copy()
        factor[:, k] = 0
        m = (m - factor[:, :, None] * row[:, None, :]) % modulus
        m[:, k] = row
    return m[:, :, n:]


# --- rational numbers from residues -----------------------------------------------------------------------------------


def _rational(
    blocks: Sequence[Block], residues: Sequence[Ints], primes: Ints, pivots: Sequence[int]
) -> tuple[Mapping[int, Fraction], ...] | None:
    """K from its residues, or None where they are too few: the last prime is kept to tell."""
    *used, last = primes.tolist()
    modulus = math.prod(used)
    weights = [modulus // p * pow(modulus // p, -1, p) for p in used]
    known: dict[tuple[int, ...], Fraction | None] = {}
    rows: dict[int, dict[int, Fraction]] = {pivot: {pivot: Fraction(1)} for pivot in pivots}
    for block, values in zip(blocks, residues, strict=True):
        for i, pivot in enumerate(block.support):
            for j, column in enumerate(block.dependent):
                *key, check = values[:, i, j].tolist()
                if not any(key) and not check:
                    continue
                if tuple(key) not in known:
                    number = sum(w * x for w, x in zip(weights, key, strict=True)) % modulus
                    known[tuple(key)] = reconstruct(number, modulus)
                value = known[tuple(key)]
                if value is None or (value.numerator - check * value.denominator) % last:
                    return None
                rows[pivot][column] = value
    return tuple(rows[pivot] for pivot in pivots)


def reconstruct(x: int, modulus: int) -> Fraction | None:
    """The rational n/d ≡ x with |n|, d ≤ √(modulus/2), if there is one (Wang 1981)."""
    bound = math.isqrt(modulus // 2)
    (r0, t0), (r1, t1) = (modulus, 0), (x, 1)
    while r1 > bound:
        quotient = r0 // r1
        (r0, t0), (r1, t1) = (r1, t1), (r0 - quotient * r1, t0 - quotient * t1)
    if t1 == 0 or abs(t1) > bound or math.gcd(r1, t1) != 1:
        return None
    return Fraction(r1, t1)


# --- rows of the catalogue ----------------------------------------------------------------------------------------


def of_literal(literal: Literal) -> BaseParameters:
    return base_parameters(literal.values.scene, literal.tree, literal.natural)


def base_regressor(literal: Literal) -> Mat:
    """Yb (nv, nbase): the columns of Y that the base parameters stand for."""
    independent = of_literal(literal).independent
    return tuple(tuple(row[k] for k in independent) for row in regressor(literal))


def base_parameter_values(literal: Literal) -> Vec:
    """β (nbase) = K π."""
    pi, lift = inertial_parameters(literal), literal.values.lift
    return tuple(total(mul(lift(x), pi[k]) for k, x in row.items()) for row in of_literal(literal).rows)


__all__ = ["TEN", "BaseParameters", "base_parameter_values", "base_parameters", "base_regressor", "reconstruct"]
