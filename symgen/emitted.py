"""What a certificate's checks are given of a candidate: its outputs in GF(p), and random vectors of the field."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from symgen.algebra.field import Residue
from symgen.algebra.linear import dot
from symgen.literal.equations import Literal
from symgen.plans.walk import Lowered

Pairs = Iterator[tuple[Any, Any]]
"""(what the literal form says, what was emitted)."""


@dataclass(frozen=True)
class Emitted:
    """Outputs of a candidate and the inputs they were found at, with the row that is being checked."""

    values: Mapping[str, list[Residue]]
    inputs: Mapping[str, list[Residue]]
    lowered: Lowered
    rng: random.Random
    p: int
    row: str = ""
    ports: tuple[str, ...] = ()
    """Names of the row's outputs, in its order."""

    def of(self, row: str, ports: tuple[str, ...]) -> Emitted:
        return replace(self, row=row, ports=ports)

    def rows(self, port: str, columns: int) -> list[list[Residue]]:
        """A matrix or a tensor by rows of its last index."""
        flat = self.values[port]
        return [flat[i : i + columns] for i in range(0, len(flat), columns)] if columns else []

    def times(self, port: str, x: Sequence[Residue]) -> list[Any]:
        """A matrix times a vector."""
        return [dot(row, x) for row in self.rows(port, len(x))]

    def random(self, n: int) -> list[Residue]:
        """A random vector of n elements of the field."""
        return [Residue(self.rng.randrange(self.p), self.p) for _ in range(n)]


Check = Callable[[Literal, Emitted], Pairs]


def residues(values: Mapping[str, Sequence[int]], p: int) -> dict[str, list[Residue]]:
    return {name: [Residue(x, p) for x in row] for name, row in values.items()}
