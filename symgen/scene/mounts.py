"""Mounting rotations while a scene is read: made exact, and what that changed written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from symgen.scene.document import clean
from symgen.scene.exact import Rotation, matmul, matvec, rotation_from_rpy
from symgen.scene.model import Matrix3, Transform, Vector

Floats3 = tuple[tuple[float, float, float], ...]


@dataclass
class Mounts:
    """Collects, over one scene, the rotations that were snapped and those that narrowly were not, and odd positions."""

    snap: Fraction
    snapped: dict[str, float] = field(default_factory=dict)
    near: dict[tuple[str, str], list[str]] = field(default_factory=dict)
    """(angle as given, exact value) → whose it is."""
    raw: dict[str, Floats3] = field(default_factory=dict)
    """Joint → rotation as it was described, for the joints that were snapped."""
    beyond: list[str] = field(default_factory=list)
    """Joints locked beyond their limits."""

    def transform(self, xyz: Vector, rpy: Sequence[Fraction], owner: str, joint: str = "") -> Transform:
        """The exact transform of an ``origin``; ``owner`` names it in notes."""
        rotation = rotation_from_rpy(rpy, self.snap)
        self._record(rotation, owner, joint)
        return Transform(rotation.matrix, xyz)

    def _record(self, rotation: Rotation, owner: str, joint: str) -> None:
        owner = clean(owner)
        if rotation.snapped is not None:
            self.snapped[owner] = rotation.snapped
            if joint:
                self.raw[joint] = rotation.raw
        for miss in rotation.near_misses:
            owners = self.near.setdefault(miss, [])
            if owner not in owners:
                owners.append(owner)

    def notes(self) -> list[str]:
        """One line that lists every snap with the largest change, one for each angle that is a near miss, one for
        joints locked beyond their limits."""
        notes = [
            f"{', '.join(owners)}: the angle {given} is near a quarter turn, but not within the snap angle "
            f"{float(self.snap):g} rad; {exact} would make it exact (or a larger 'snap' option)"
            for (given, exact), owners in self.near.items()
        ]
        if self.beyond:
            notes.append(f"locked beyond their limits: {', '.join(self.beyond)}")
        if not self.snapped:
            return notes
        owners = ", ".join(f"{owner} ({angle:.1e} rad)" for owner, angle in self.snapped.items())
        return [f"rotations snapped to exact quarter turns: {owners}", *notes]


def compose(outer: Transform, inner: Transform) -> Transform:
    """outer ∘ inner: x ↦ outer(inner(x))."""
    moved = matvec(outer.rotation, inner.translation)
    x, y, z = (a + b for a, b in zip(outer.translation, moved, strict=True))
    return Transform(matmul(outer.rotation, inner.rotation), (x, y, z))


def compose_floats(outer: Floats3, inner: Matrix3) -> Floats3:
    """Product of two rotations in floats."""
    rows = [tuple(sum(row[k] * float(inner[k][j]) for k in range(3)) for j in range(3)) for row in outer]
    return tuple((row[0], row[1], row[2]) for row in rows)
