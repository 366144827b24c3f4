"""What a method is made of: rows of the catalogue that it evaluates, and updates of vectors between them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symgen.topology.tree import Tree
from symgen.velocity.values import Values

Scalar = Any
Arrays = Mapping[str, Sequence[Scalar]]
"""Name → flat entries."""


@dataclass(frozen=True)
class Place:
    """What updates may know of the scene, in one number type."""

    tree: Tree
    values: Values
    sparse: bool
    """Leave out entries of nv × nv matrices that belong to different branches."""


Function = Callable[[Place, Arrays], tuple[Sequence[Scalar], ...]]


@dataclass(frozen=True)
class Evaluate:
    """A row of the catalogue at some arrays: port of the row → array."""

    row: str
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]


@dataclass(frozen=True)
class Update:
    """New vectors from old ones: port → array. Updates of one name have one ``function``, which gives the entries of
    every output in their order; what it does not read is not passed."""

    name: str
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    function: Function


Operation = Evaluate | Update


@dataclass(frozen=True)
class Method:
    """One way to step: ``operations`` on the arrays q, v, tau, dt (and p), which leave q_next and v_next."""

    name: str
    plan: str
    summary: str
    rows: tuple[str, ...]
    """The rows it evaluates: their functions are emitted beside it."""
    operations: tuple[Operation, ...]
    locals: Mapping[str, tuple[str, ...]]
    """Its own arrays and their shapes, in terms of nq and nv."""
