"""The constants of a scene as scalars of one number type, run-time parameters put in their places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import Mat, Vec
from symgen.algebra.numbers import Numbers
from symgen.scene.model import Body, Joint, JointSpring, Scene, Spring, Transform

Scalar = Any


@dataclass(frozen=True)
class Values:
    """What a derivation reads of the scene. A zero or one stays the int 0 or 1 (structural, it costs nothing);
    any other constant becomes a scalar of the number type; a parameter is its entry of ``p``."""

    scene: Scene
    numbers: Numbers
    p: Sequence[Scalar] = ()
    _places: dict[str, tuple[int, int]] = field(default_factory=dict, repr=False, compare=False)
    _lifted: dict[tuple[int, int], Scalar] = field(default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        for parameter in self.scene.parameters:
            self._places[parameter.name] = (parameter.start, parameter.size)

    def lift(self, value: Fraction | int) -> Scalar:
        key = (value.numerator, value.denominator)
        if key[1] == 1 and key[0] in (0, 1):
            return key[0]
        found = self._lifted.get(key)
        if found is None:
            found = self._lifted[key] = self.numbers.const(value)
        return found

    def vector(self, values: Sequence[Fraction]) -> Vec:
        return tuple(self.lift(value) for value in values)

    def matrix(self, rows: Sequence[Sequence[Fraction]]) -> Mat:
        return tuple(self.vector(row) for row in rows)

    def _read(self, name: str, default: Sequence[Fraction]) -> Vec:
        place = self._places.get(name)
        if place is None:
            return self.vector(default)
        return tuple(self.p[place[0] : place[0] + place[1]])

    def mass(self, body: Body) -> Scalar:
        return self._read(f"{body.name}.mass", (body.mass,))[0]

    def com(self, body: Body) -> Vec:
        return self._read(f"{body.name}.com", body.com)

    def inertia(self, body: Body) -> Vec:
        """(xx, yy, zz, xy, xz, yz) about the centre of mass, body axes."""
        return self._read(f"{body.name}.inertia", body.inertia)

    def gravity(self) -> Vec:
        return self._read("gravity", self.scene.gravity)

    def armature(self, joint: Joint) -> Scalar:
        return self._read(f"{joint.name}.armature", (joint.armature,))[0]

    def damping(self, joint: Joint) -> Scalar:
        return self._read(f"{joint.name}.damping", (joint.damping,))[0]

    def force(self, force: Spring | JointSpring, quantity: str) -> Scalar:
        """``stiffness``, ``damping``, ``length`` or ``rest`` of a force."""
        return self._read(f"{force.name}.{quantity}", (getattr(force, quantity),))[0]

    def transform(self, transform: Transform) -> tuple[Mat, Vec]:
        return self.matrix(transform.rotation), self.vector(transform.translation)
