"""Matrices with one field for each velocity (`symgen.plans.fields`): entry [i][j] is what joint velocity i feels of
field j on everything beyond both. RᵀMṘ is one, the derivatives of inverse dynamics are others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import Vec
from symgen.plans.composite import composite_inertias, motions, project
from symgen.plans.fields import Composite, Field, Wrench, carried_functional, carried_wrench, composites
from symgen.plans.walk import Links, Moving

Scalar = Any
Matrix = list[list[Scalar]]


@dataclass(frozen=True)
class Columns:
    """The fields of every link's velocities, seen from that link. ``transmitted`` (link, its velocity, wrench) → what
    the joint itself feels of a column's wrench, and the wrench that it hands on; without it, that wrench and no other.
    """

    fields: Sequence[Sequence[Field]]
    transmitted: Callable[[Moving, int, Wrench], tuple[Vec, Wrench]] | None = None


@dataclass(frozen=True)
class Bodies:
    """Composite bodies of all links, and the velocities (ω of links, and of joints) that their moments are made of."""

    links: Links
    spins: Sequence[Vec]
    v: Sequence[Scalar]
    composites: Sequence[Composite]

    def matrices(self, heading: str, wanted: Sequence[Columns]) -> list[Matrix]:
        """One matrix (nv × nv) for each set of columns; entries between branches are structural zeros."""
        links, convention = self.links, self.links.values.scene.options.base_velocity
        found: list[Matrix] = [[[0] * links.nv for _ in range(links.nv)] for _ in wanted]
        for at in links.moving:
            with links.phase(f"{heading} of {at.link.name}"):
                for matrix, columns in zip(found, wanted, strict=True):
                    self._fill_columns(matrix, at, columns, convention)
                for k, motion in enumerate(motions(at, convention) if at.link.parent >= 0 else ()):
                    felt = self.composites[at.link.index].functional(*motion)
                    for above, functional in carried_functional(links, at, felt, self.spins, self.v):
                        for matrix, columns in zip(found, wanted, strict=True):
                            for j, field in enumerate(columns.fields[above.link.index]):
                                matrix[at.link.v + k][above.link.v + j] = functional.of(field)
        return found

    def _fill_columns(self, matrix: Matrix, at: Moving, columns: Columns, convention: str) -> None:
        """The columns of a link's own joint, from its rows up."""
        for k, field in enumerate(columns.fields[at.link.index]):
            wrench = self.composites[at.link.index].wrench(field)
            if columns.transmitted is None:
                own = project(at, *wrench, convention)
            else:
                own, wrench = columns.transmitted(at, k, wrench)
            write(matrix, at.link.v, at.link.v + k, own)
            for above, felt in carried_wrench(self.links, at, wrench):
                write(matrix, above.link.v, at.link.v + k, project(above, *felt, convention))


def write(matrix: Matrix, row: int, column: int, values: Sequence[Scalar]) -> None:
    """Entries of a column, from a row on."""
    for i, value in enumerate(values):
        matrix[row + i][column] = value


def bodies(links: Links, spins: Sequence[Vec], v: Sequence[Scalar]) -> Bodies:
    return Bodies(links, spins, v, composites(links, composite_inertias(links), spins, v))
