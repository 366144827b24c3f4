"""R and Ṙ as the paper prints them: blocks in its vectors d, u and their skew matrices D, U (Table 1; (4.9), (4.13)).

Nothing is asserted that is not derived. The joint table is run at a random point of a prime field; each of its columns
is recognised as the unit vector, the axes or the identity that it equals there, its reference point as the basic point
that it coincides with; blocks are put together from these names by the table's rule (v + w × d for a point, w × u for a
vector), Ṙ by differentiating the blocks, and every block is then evaluated and compared with the entries of R and Ṙ
that symgen derives. Different expressions agree there with a probability below 1e-16.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from symgen.algebra.field import MERSENNE_61, FieldNumbers, Residue
from symgen.algebra.linear import IDENTITY, Mat, Vec, matmul, matvec, scale, skew, transpose, vadd, vneg, vsub
from symgen.algebra.numbers import State
from symgen.literal.equations import Literal
from symgen.natural.coordinates import choose_coordinates
from symgen.natural.entities import Entity
from symgen.natural.layout import NaturalCoordinates, constants
from symgen.topology.tree import TreeBody
from symgen.velocity import kinematics as motion
from symgen.velocity.joint_table import Column
from symgen.velocity.values import Values

if TYPE_CHECKING:
    from symgen.system import System


@dataclass(frozen=True)
class Factor:
    """A symbol of the paper. ``letter``: D (skew matrix of d_ij = r_i − r_j), U (of u_i), u, A (axes of the child of a
    joint in ground axes), e (an axis fixed in the parent that is no natural coordinate), h (pitch) or 1."""

    letter: str
    indices: tuple[str, ...] = ()
    """As in the labels of points and vectors: ``("4", "2")`` for D₄₂; ``("3", "1")`` for the first axis of a universal
    joint."""
    dots: int = 0


@dataclass(frozen=True)
class Term:
    negative: bool
    factors: tuple[Factor, ...]


Block = tuple[Term, ...]
"""A sum of products; () is zero."""


@dataclass(frozen=True)
class Unit:
    """One or three columns of R that stand together: θ̇_j, or ṙ_j, ω_j of three components."""

    columns: tuple[int, ...]
    letter: str
    dots: int
    indices: tuple[str, ...]
    body: int
    angular: tuple[Factor, ...] = ()
    linear: tuple[Factor, ...] = ()
    reference: str = ""


@dataclass(frozen=True)
class BlockMatrix:
    """``blocks[row][column]``, with the entities that are the rows (ṙ, u̇) and the joint velocities of the columns."""

    rows: tuple[Entity, ...]
    columns: tuple[Unit, ...]
    blocks: tuple[tuple[Block, ...], ...]


def label_indices(label: str) -> tuple[str, ...]:
    """``r12`` → ("12",); ``u3_1`` → ("3", "1")."""
    return tuple(label[1:].split("_"))


# -- values at a point of the field ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Point:
    """Everything the symbols can stand for, at one random state."""

    literal: Literal
    seed: int

    @staticmethod
    def random(system: System, natural: NaturalCoordinates, seed: int) -> Point:
        numbers, tree = FieldNumbers(seed=seed), system.tree

        def draw(name: str, count: int) -> tuple[Residue, ...]:
            return tuple(Residue(numbers.random(name, k), MERSENNE_61) for k in range(count))

        state = State(draw("q", tree.nq), draw("v", tree.nv), p=draw("p", system.sizes.np))
        return Point(Literal(tree, natural, Values(system.scene, numbers, state.p), state), seed)

    def entity(self, entity: Entity) -> tuple[Vec, Vec]:
        """Position (or direction) and its rate, ground axes."""
        at, twists = self.literal.at, self.literal.twists
        local = constants(entity.local[entity.home], self.literal.values.numbers)
        if entity.kind == "point":
            place = at.pose(entity.home).point(local)
            return place, motion.point_velocity(at, twists, entity.home, place)
        place = at.pose(entity.home).vector(local)
        spin = twists[entity.home].angular if entity.home >= 0 else (0, 0, 0)
        return place, matvec(skew(spin), place)

    def named(self, kind: str, indices: tuple[str, ...]) -> tuple[Vec, Vec]:
        for entity in self.literal.natural.entities:
            if entity.kind == kind and label_indices(entity.label) == indices:
                return self.entity(entity)
        raise KeyError(indices)

    def axes(self, body: int) -> tuple[Mat, Mat]:
        """A of a body and Ȧ = ω̃ A."""
        rotation = self.literal.at.poses[body].rotation
        return rotation, matmul(skew(self.literal.twists[body].angular), rotation)

    def factor(self, factor: Factor, units: Sequence[Unit]) -> Any:
        """A scalar, vector or matrix."""
        if factor.letter == "1":
            return 1
        if factor.letter == "D":
            (a, a_rate), (b, b_rate) = (self.named("point", (index,)) for index in factor.indices)
            return skew(vsub(a_rate, b_rate) if factor.dots else vsub(a, b))
        if factor.letter in ("U", "u"):
            value = self.named("vector", factor.indices)[factor.dots]
            return skew(value) if factor.letter == "U" else value
        body = next(unit.body for unit in units if unit.indices[0] == factor.indices[0])
        if factor.letter == "A":
            return self.axes(body)[factor.dots]
        if factor.letter == "h":
            pitch = self.literal.tree.bodies[body].joint.pitch
            assert pitch is not None
            return self.literal.values.lift(pitch)
        columns = self.literal.at.motions[body].columns
        column = columns[int(factor.indices[1]) - 1]
        return self.literal.rates[body][int(factor.indices[1]) - 1][1] if factor.dots else column.v

    def block(self, block: Block, size: int, units: Sequence[Unit]) -> Mat:
        """The three rows of a block with ``size`` columns."""
        total: Mat = ((0,) * size,) * 3
        for term in block:
            value: Any = IDENTITY if size == 3 else 1
            for factor in reversed(term.factors):
                value = _multiply(self.factor(factor, units), value)
            rows = value if size == 3 else tuple((x,) for x in value)
            total = tuple(
                vadd(row, vneg(more) if term.negative else more) for row, more in zip(total, rows, strict=True)
            )
        return total


def _multiply(a: Any, b: Any) -> Any:
    """Product of scalars, vectors (tuples) and matrices (tuples of tuples)."""
    if not isinstance(a, tuple):
        if not isinstance(b, tuple):
            return a * b
        return tuple(scale(a, row) for row in b) if isinstance(b[0], tuple) else scale(a, b)
    if not isinstance(b, tuple):
        return _multiply(b, a)
    return matmul(a, b) if isinstance(b[0], tuple) else matvec(a, b)


def _zero(block: Mat) -> bool:
    return all(x == 0 for row in block for x in row)


# -- recognition of the joint table's columns ------------------------------------------------------------------------


def _number(own: Sequence[Entity], taken: set[str], joint: str) -> str:
    """A joint is numbered like its basic point (erratum 6); like its axis, or by its name, where another one is."""
    wanted = [label_indices(entity.label)[0] for kind in ("point", "vector") for entity in own if entity.kind == kind]
    return next((number for number in wanted if number not in taken), joint)


def _all_units(point: Point) -> tuple[Unit, ...]:
    found: list[Unit] = []
    natural = point.literal.natural
    for body in point.literal.tree.bodies:
        own = [natural.entities[k] for k in natural.joints[body.index]]
        number = _number(own, {unit.indices[0] for unit in found}, body.joint.name)
        found.extend(_units(point, body, own, number))
    return tuple(found)


def _units(point: Point, body: TreeBody, own: Sequence[Entity], number: str) -> list[Unit]:
    """The columns of a joint under their names."""
    literal = point.literal
    columns = literal.at.motions[body.index].columns
    points = [entity for entity in own if entity.kind == "point"]
    place = literal.at.motions[body.index].reference
    reference = next(entity.label for entity in points if point.entity(entity)[0] == place)
    found: list[Unit] = []
    k = 0
    while k < len(columns):
        triple = _triple(point, body, number, columns[k : k + 3])
        if triple is not None:
            angular, linear, letter, dots = triple
            span = tuple(range(body.v + k, body.v + k + 3))
            found.append(Unit(span, letter, dots, (number,), body.index, angular, linear, reference))
            k += 3
            continue
        indices = (number,) if len(columns) == 1 else (number, str(k + 1))
        angular, linear = (_vector(point, body, x, own, (number, str(k + 1))) for x in (columns[k].w, columns[k].v))
        found.append(Unit((body.v + k,), "theta", 1, indices, body.index, angular, linear, reference))
        k += 1
    return found


def _triple(
    point: Point, body: TreeBody, number: str, columns: Sequence[Column]
) -> tuple[tuple[Factor, ...], tuple[Factor, ...], str, int] | None:
    """Three columns that are the axes of ground or of the child: (angular, linear, letter, dots)."""
    if len(columns) < 3:
        return None
    w, v = transpose(tuple(c.w for c in columns)), transpose(tuple(c.v for c in columns))
    for matrix, factor in ((IDENTITY, Factor("1")), (point.axes(body.index)[0], Factor("A", (number,)))):
        if _equal(w, matrix) and _zero(v):
            return (factor,), (), "omega", 0
        if _equal(v, matrix) and _zero(w):
            return (), (factor,), ("r" if factor.letter == "1" else "v"), int(factor.letter == "1")
    return None


def _equal(a: Mat, b: Mat) -> bool:
    return all(x == y for p, q in zip(a, b, strict=True) for x, y in zip(p, q, strict=True))


def _vector(
    point: Point, body: TreeBody, value: Vec, own: Sequence[Entity], place: tuple[str, str]
) -> tuple[Factor, ...]:
    """The unit vector a column's part equals, with the pitch before it where it is that multiple; () for zero."""
    if all(x == 0 for x in value):
        return ()
    pitch = body.joint.pitch or Fraction(0)
    for entity in own:
        if entity.kind != "vector":
            continue
        u = Factor("u", label_indices(entity.label))
        direction = point.entity(entity)[0]
        if value == direction:
            return (u,)
        if pitch and value == scale(point.literal.values.lift(pitch), direction):
            return (Factor("h", (place[0],)), u)
    return (Factor("e", place),)


# -- blocks ----------------------------------------------------------------------------------------------------------


def _r_block(entity: Entity, unit: Unit) -> Block:
    """Table 1: v − D w for a point, −U w for a vector."""
    indices = label_indices(entity.label)
    if entity.kind == "vector":
        return (Term(True, (Factor("U", indices), *unit.angular)),) if unit.angular else ()
    terms = [Term(False, unit.linear)] if unit.linear else []
    if unit.angular:
        terms.append(Term(True, (Factor("D", (*indices, *label_indices(unit.reference))), *unit.angular)))
    return tuple(terms)


def _rate(block: Block) -> Block:
    """The product rule."""
    found = []
    for term in block:
        for k, factor in enumerate(term.factors):
            if factor.letter not in ("1", "h"):
                moved = replace(factor, dots=1)
                found.append(Term(term.negative, (*term.factors[:k], moved, *term.factors[k + 1 :])))
    return tuple(found)


def _alive(point: Point, block: Block, size: int, units: Sequence[Unit]) -> Block:
    """Without the terms that vanish identically (d_ii, rates of what is fixed in ground, a point on the axis)."""
    return tuple(term for term in block if not _zero(point.block((term,), size, units)))


def paper_natural(system: System) -> NaturalCoordinates:
    """Natural coordinates in space, also for a planar mechanism: the paper's vectors are vectors of space."""
    return system.natural if system.natural.plane is None else choose_coordinates(system.tree, planar=False)


def block_matrix(system: System, rate: bool = False, seed: int = 1) -> BlockMatrix:
    """R (or with ``rate`` Ṙ) in the paper's symbols. Raises ArithmeticError if a block is not what symgen derives."""
    natural = paper_natural(system)
    point = Point.random(system, natural, seed)
    literal = point.literal
    units = _all_units(point)
    derived = literal.r_rate_columns if rate else literal.r_columns
    rows = []
    for entity, columns in zip(literal.moving, derived, strict=True):
        row = []
        for unit in units:
            on_path = system.secondary_path_matrix[entity.home, unit.body] < 0
            block = _block(point, entity, unit, units, rate) if on_path else ()
            wanted = tuple(zip(*(columns.get(j, (0,) * entity.size) for j in unit.columns), strict=True))
            check_block(point, block, wanted, entity, unit, units)
            row.append(block)
        rows.append(tuple(row))
    return BlockMatrix(literal.moving, units, tuple(rows))


def _block(point: Point, entity: Entity, unit: Unit, units: Sequence[Unit], rate: bool) -> Block:
    if entity.kind == "angle":
        return (Term(False, (Factor("1"),)),) if unit.body == entity.home and not rate else ()
    block = _r_block(entity, unit)
    block = _alive(point, _rate(block) if rate else block, len(unit.columns), units)
    return () if _zero(point.block(block, len(unit.columns), units)) else block


def check_block(point: Point, block: Block, wanted: Mat, entity: Entity, unit: Unit, units: Sequence[Unit]) -> None:
    """A block must be the derived one: raises ArithmeticError."""
    if entity.kind == "angle":
        value: Mat = ((1 if block else 0,) * len(unit.columns),)
    else:
        value = point.block(block, len(unit.columns), units)
    if not _equal(value, wanted):
        place = f"({entity.label}, {unit.letter}_{unit.indices[0]})"
        raise ArithmeticError(f"block {place} is not what the joint table gives")


__all__ = ["Block", "BlockMatrix", "Factor", "Term", "Unit", "block_matrix", "paper_natural"]
