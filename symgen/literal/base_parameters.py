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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from symgen.algebra.field import MERSENNE_61, FieldNumbers, NotInField, Residue, is_prime, random_prime
from symgen.algebra.linear import Mat, Vec, mul, total
from symgen.algebra.numbers import State
from symgen.algebra.residues import LARGEST, Ints, ResidueNumbers, Residues
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
    source = _Source(scene, tree, natural, len(names))
    primes = _primes()
    first = source.matrices([next(primes)])
    pivots = independent_columns(*first)
    residues: list[tuple[int, Ints]] = []
    batch = 4
    while len(residues) < MOST_PRIMES:
        for p, values in zip(*source.matrices([next(primes) for _ in range(batch)]), strict=True):
            found = combination_of(values, pivots, p)
            if found is not None:
                residues.append((p, found))
        batch = len(residues) or batch
        rows = _rational(residues, pivots)
        if rows is not None and source.holds(rows):
            return BaseParameters(names, pivots, rows)
    raise CertificateError(f"{scene.name}: the base parameters are no rational combinations that could be found")


# --- columns of Y in prime fields -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Source:
    scene: Scene
    tree: Tree
    natural: NaturalCoordinates
    columns: int

    def literal(self, numbers: Any, state: State) -> Literal:
        return Literal(self.tree, self.natural, Values(self.scene, numbers, state.p), state)

    def state(self, draw: Any) -> State:
        sizes = (self.tree.nq, self.tree.nv, self.tree.nv, sum(x.size for x in self.scene.parameters))
        q, v, a, p = ([draw() for _ in range(n)] for n in sizes)
        return State(q=q, v=v, a=a, p=p)

    def matrices(self, primes: Sequence[int]) -> tuple[list[int], list[Ints]]:
        """Y at `POINTS` random points of every prime, stacked: (primes, matrices of POINTS · nv rows)."""
        p = np.repeat(np.array(primes, dtype=np.int64), POINTS)
        rng = np.random.default_rng(primes[0])
        numbers = ResidueNumbers(p, primes[0])
        state = self.state(lambda: Residues(rng.integers(1, p), p))
        y = regressor(self.literal(numbers, state))
        stacked = np.zeros((len(primes), POINTS, len(y), self.columns), dtype=np.int64)
        for i, row in enumerate(y):
            for j, entry in enumerate(row):
                if isinstance(entry, Residues):
                    stacked[:, :, i, j] = entry.x.reshape(len(primes), POINTS)
                elif entry:
                    stacked[:, :, i, j] = numbers.const(Fraction(entry)).x.reshape(len(primes), POINTS)
        return list(primes), list(stacked.reshape(len(primes), -1, self.columns))

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


def independent_columns(primes: Sequence[int], matrices: Sequence[Ints]) -> tuple[int, ...]:
    """The columns that are independent of those before them."""
    (p,), (matrix,) = primes, matrices
    return tuple(_echelon(matrix.copy(), p, range(matrix.shape[1])))


def _echelon(m: Ints, p: int, columns: Sequence[int]) -> list[int]:
    """Reduce ``m`` in place to row echelon form, fully reduced in the pivots' columns; the pivots."""
    found: list[int] = []
    for column in columns:
        row = len(found)
        candidates = np.nonzero(m[row:, column])[0]
        if not len(candidates):
            continue
        pick = row + int(candidates[0])
        m[[row, pick]] = m[[pick, row]]
        m[row] = m[row] * pow(int(m[row, column]), -1, p) % p
        others = np.nonzero(m[:, column])[0]
        others = others[others != row]
        m[others] = (m[others] - m[others, column][:, None] * m[row]) % p
        found.append(column)
        if len(found) == len(m):
            break
    return found


def combination_of(matrix: Ints, pivots: Sequence[int], p: int) -> Ints | None:
    """K (nbase × columns) modulo p, or None where these pivots are not independent at this prime's points."""
    m = matrix.copy()
    found = _echelon(m, p, pivots)
    return m[: len(pivots)] if found == list(pivots) else None


# --- rational numbers from residues -----------------------------------------------------------------------------------


def _rational(residues: Sequence[tuple[int, Ints]], pivots: Sequence[int]) -> tuple[Mapping[int, Fraction], ...] | None:
    """K from its residues, or None where they are too few: the last prime is kept to tell."""
    (*used, last) = residues
    if not used:
        return None
    support = np.any([values != 0 for _, values in residues], axis=0)
    modulus = math.prod(p for p, _ in used)
    weights = [modulus // p * pow(modulus // p, -1, p) for p, _ in used]
    known: dict[tuple[int, ...], Fraction | None] = {}
    rows: list[dict[int, Fraction]] = []
    for i, pivot in enumerate(pivots):
        row = {pivot: Fraction(1)}
        for k in np.nonzero(support[i])[0].tolist():
            key = tuple(int(values[i, k]) for _, values in used)
            if key not in known:
                known[key] = reconstruct(sum(w * x for w, x in zip(weights, key, strict=True)) % modulus, modulus)
            value = known[key]
            if value is None or (value.numerator - int(last[1][i, k]) * value.denominator) % last[0]:
                return None
            row[k] = value
        rows.append(row)
    return tuple(rows)


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
