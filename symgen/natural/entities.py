"""What natural coordinates are made of: basic points, unit vectors, and the extra angle of a screw joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

Vector = tuple[Fraction, Fraction, Fraction]


@dataclass(frozen=True)
class Entity:
    """A basic point or unit vector, shared by every body in ``local``; or an ``angle`` (helical joints)."""

    kind: str
    """``point``, ``vector`` or ``angle``."""
    label: str
    """``r3``, ``u3`` (numbered like basic points in the paper), ``phi_<joint>``."""
    home: int
    """Index of the tree body nearest to the root it is fixed in; −1 when it is fixed in ground.
    For an angle: the body its joint enters."""
    local: Mapping[int, Vector]
    """Body index → coordinates in that body's frame (−1 → ground axes). Exact. Empty for an angle."""
    start: int | None
    """Offset of its rows in the natural coordinates x; None when it is fixed in ground (a constant)."""
    size: int
    """Rows it occupies in x when it moves: 3 (2 in planar scenes), 1 for an angle."""
    joint: int | None = None
    """Tree joint it came from, if any."""
