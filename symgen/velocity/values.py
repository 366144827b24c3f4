"""The constants of a scene as scalars of one number type, run-time parameters put in their places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import Mat, Vec, add, matmul, matvec, mul, scale, vadd
from symgen.algebra.numbers import Numbers
from symgen.scene.model import Body, Joint, JointSpring, Scene, Spring, Transform
from symgen.topology.tree import Tree, TreeBody
from symgen.velocity.rotation import axis_rotation

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

    def lift(self, value: Scalar) -> Scalar:
        """A rational as a scalar of the number type; what is a scalar already stays what it is."""
        if type(value) is not Fraction and type(value) is not int:
            return value
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

    def point(self, spring: Spring, end: int) -> Vec:
        """Where an end of a spring is fixed, body frame."""
        return self._read(f"{spring.name}.point{end + 1}", spring.points[end])

    def transform(self, transform: Transform) -> tuple[Mat, Vec]:
        return self.matrix(transform.rotation), self.vector(transform.translation)

    # --- geometry that may be given at run time -----------------------------------------------------------------

    def is_runtime(self, joint: Joint) -> bool:
        """True when the origin of a joint is a run-time argument."""
        return f"{joint.name}.xyz" in self._places or f"{joint.name}.rpy" in self._places

    def origin(self, joint: Joint) -> tuple[Mat, Vec]:
        """A joint's own origin (fixed-axis roll, pitch, yaw)."""
        rotation = self.matrix(joint.origin.rotation)
        if f"{joint.name}.rpy" in self._places:
            roll, pitch, yaw = self._read(f"{joint.name}.rpy", ())
            rotation = self._turn((0, 0, 1), yaw)
            rotation = matmul(rotation, matmul(self._turn((0, 1, 0), pitch), self._turn((1, 0, 0), roll)))
        return rotation, self._read(f"{joint.name}.xyz", joint.origin.translation)

    def _turn(self, axis: Vec, angle: Scalar) -> Mat:
        return axis_rotation(axis, self.numbers.cos(angle), self.numbers.sin(angle))

    def placed(self, chain: Sequence[Joint], pose: Transform) -> tuple[Mat, Vec]:
        """``pose`` of the end of a chain of joints that all stand at zero, run-time origins put in their places."""
        if not any(self.is_runtime(joint) for joint in chain):
            return self.transform(pose)
        rotation, translation = self.origin(chain[0])
        for joint in chain[1:]:
            turn, shift = self.origin(joint)
            rotation, translation = matmul(rotation, turn), vadd(translation, matvec(rotation, shift))
        return rotation, translation

    def frame(self, tree: Tree, name: str) -> tuple[int, Mat, Vec]:
        """A body or frame by name: the tree body it is fixed in, and its pose there."""
        home, pose = tree.frames[name]
        chain = tree.welds[name]
        if not any(self.is_runtime(joint) for joint in chain):
            return (home, *self.transform(pose))
        rotation, translation = self.placed(chain, pose)
        own = next((frame.origin for frame in self.scene.frames if frame.name == name), Transform())
        turn, shift = self.transform(own)
        return home, matmul(rotation, turn), vadd(translation, matvec(rotation, shift))

    # --- joint coordinates ---------------------------------------------------------------------------------------

    def multiplier(self, body: TreeBody) -> Scalar:
        """Rate of a body's joint over the rate it has in v: 1 unless the joint is coupled to another."""
        return 1 if body.coupling is None else self.lift(body.coupling.multiplier)

    def positions(self, body: TreeBody, q: Sequence[Scalar]) -> Vec:
        """A joint's own positions: its coordinates, or what its master's make them, and its run-time offset."""
        found = tuple(q[body.q : body.q + body.nq])
        if body.coupling is not None:
            found = (add(mul(self.multiplier(body), found[0]), self.lift(body.coupling.offset)),)
        if f"{body.joint.name}.offset" in self._places:
            found = (add(found[0], self._read(f"{body.joint.name}.offset", ())[0]),)
        return found

    def rates(self, body: TreeBody, v: Sequence[Scalar]) -> Vec:
        """A joint's own velocities (or accelerations)."""
        return scale(self.multiplier(body), tuple(v[body.v : body.v + body.nv]))
