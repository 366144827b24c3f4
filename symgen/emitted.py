"""What a certificate's checks are given of a candidate: its outputs in GF(p), and random vectors of the field."""

from __future__ import annotations

import operator
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from symgen.algebra.field import Residue
from symgen.literal.equations import Literal
from symgen.plans.walk import Lowered

Pairs = Iterator[tuple[Any, Any]]
"""(what the literal form says, what was emitted)."""


@dataclass(frozen=True)
class Emitted:
    """Outputs of a candidate and the inputs they were found at, with the row that is being checked."""

    ints: Mapping[str, Sequence[int]]
    """The outputs, flat, as residues of p."""
    inputs: Mapping[str, list[Residue]]
    lowered: Lowered
    rng: random.Random
    p: int
    row: str = ""
    ports: tuple[str, ...] = ()
    """Names of the row's outputs, in its order."""

    def of(self, row: str, ports: tuple[str, ...]) -> Emitted:
        return replace(self, row=row, ports=ports)

    @cached_property
    def values(self) -> Mapping[str, list[Residue]]:
        """The outputs as elements of the field."""
        return residues(self.ints, self.p)

    def times(self, port: str, x: Sequence[Residue]) -> list[Any]:
        """A matrix times a vector; of a tensor, its last index times it."""
        flat, vector, n = self.ints[port], [element.x for element in x], len(x)
        products = (sum(map(operator.mul, flat[i : i + n], vector)) for i in range(0, len(flat), n)) if n else ()
        return [Residue(value, self.p) for value in products]

    def random(self, n: int) -> list[Residue]:
        """A random vector of n elements of the field."""
        return [Residue(self.rng.randrange(self.p), self.p) for _ in range(n)]


Check = Callable[[Literal, Emitted], Pairs]


def residues(values: Mapping[str, Sequence[int]], p: int) -> dict[str, list[Residue]]:
    return {name: [Residue(x, p) for x in row] for name, row in values.items()}
