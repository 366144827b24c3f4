"""The functions under test, whoever made them, and run-time parameters bound to values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Protocol

import numpy as np

from symgen.scene.model import ZERO3, Joint, JointSpring, Matrix3, Scene, Spring, Transform
from symgen.validation.mechanism import Array, Pose, pose, rotation_about, vector

Function = Callable[..., Any]


class Functions(Protocol):
    """An object with one attribute per function of the catalogue, as ``artifact.load()`` returns.

    ``f.mass_matrix(q)`` takes (nq,) or (N, nq) and returns (nv, nv) or (N, nv, nv); the rest alike.
    """

    def __getattr__(self, name: str) -> Any: ...


@dataclass(frozen=True)
class Bound:
    """Functions with the scene's parameters at fixed values; ``has`` tells which exist."""

    functions: Any
    p: Array
    """Empty for a scene without parameters."""

    def has(self, *names: str) -> bool:
        return all(callable(getattr(self.functions, name, None)) for name in names)

    def __call__(self, name: str, *arguments: Any) -> Array:
        """One function's single output, float64."""
        return np.asarray(self.all(name, *arguments), dtype=float)

    def all(self, name: str, *arguments: Any) -> Any:
        """One function's outputs as it returns them: an array, or a tuple of them."""
        function: Function = getattr(self.functions, name)
        takes_p = self.p.size > 0 and "p" in getattr(function, "inputs", ("p",))
        return function(*arguments, p=self.p) if takes_p else function(*arguments)

    def inputs(self, name: str) -> tuple[str, ...]:
        """Names of a function's inputs, p excluded, where the function tells them."""
        known = getattr(getattr(self.functions, name), "inputs", ())
        return tuple(x for x in known if x != "p")


def bind(functions: Any, scene: Scene) -> Bound:
    """At the parameters' defaults."""
    return Bound(functions, np.array([float(x) for parameter in scene.parameters for x in parameter.default]))


def vary_parameters(scene: Scene, rng: np.random.Generator) -> tuple[Scene, Array]:
    """The scene with every parameter scaled by its own factor in 0.75…1.25, zeros of geometry moved by up to 0.25, and
    the values of ``p`` that say so."""
    values: list[float] = []
    changes: list[tuple[str, tuple[Fraction, ...]]] = []
    for parameter in scene.parameters:
        factor = Fraction(float(rng.uniform(0.75, 1.25)))
        new = tuple(Fraction(float(x * factor)) for x in parameter.default)
        if parameter.name.endswith(GEOMETRY):
            new = tuple(x or Fraction(float(rng.uniform(-0.25, 0.25))) for x in new)
        values.extend(float(x) for x in new)
        changes.append((parameter.name, new))
    changed = scene
    for name, new in sorted(changes, key=lambda change: change[0].endswith(".offset")):
        changed = with_parameter(changed, name, new)
    return changed, np.array(values)


GEOMETRY = (".xyz", ".rpy", ".offset", ".point1", ".point2")


def with_parameter(scene: Scene, name: str, values: tuple[Fraction, ...]) -> Scene:
    """The scene with one parameter's value replaced (``link1.mass``, ``gravity``, ``j1.damping``, …).

    An ``offset`` is put into the joint's origin and its springs' rest, as they are then: change those first.
    """
    if name == "gravity":
        x, y, z = values
        return replace(scene, gravity=(x, y, z))
    owner, _, field = name.rpartition(".")
    if field == "offset":
        return with_offset(scene, owner, values[0])

    def new(item: Any) -> Any:
        if item.name != owner:
            return item
        if field in ("xyz", "rpy") and isinstance(item, Joint):
            part = {"translation": values} if field == "xyz" else {"rotation": rotation_rpy(values)}
            return replace(item, origin=replace(item.origin, **part))
        if field in ("point1", "point2") and isinstance(item, Spring):
            x, y, z = values
            points = ((x, y, z), item.points[1]) if field == "point1" else (item.points[0], (x, y, z))
            return replace(item, points=points)
        value: Any = values if field in ("com", "inertia") else values[0]
        return replace(item, **{field: value}) if hasattr(item, field) else item

    bodies, joints, forces = (tuple(map(new, items)) for items in (scene.bodies, scene.joints, scene.forces))
    return replace(scene, bodies=bodies, joints=joints, forces=forces)


def with_offset(scene: Scene, name: str, offset: Fraction) -> Scene:
    """The scene whose joint stands at q + offset when it is told q: further along its own motion, where a motion about
    one axis commutes with itself, and with springs that rest earlier."""
    joint = scene.joint(name)
    u = vector(joint.axis or ZERO3)
    slide = 1.0 if joint.type == "prismatic" else float(joint.pitch or 0)
    turn = np.eye(3) if joint.type == "prismatic" else rotation_about(u, float(offset))
    moved = pose(joint.origin) @ Pose(turn, slide * float(offset) * u)
    x, y, z = (Fraction(float(value)) for value in moved.position)
    origin = Transform(exact_matrix(moved.rotation), (x, y, z))
    forces = tuple(
        replace(force, rest=force.rest - offset) if isinstance(force, JointSpring) and force.joint == name else force
        for force in scene.forces
    )
    joints = tuple(replace(x, origin=origin) if x.name == name else x for x in scene.joints)
    return replace(scene, joints=joints, forces=forces)


def rotation_rpy(values: tuple[Fraction, ...]) -> Matrix3:
    """Fixed-axis roll, pitch, yaw, rounded to floats."""
    roll, pitch, yaw = (float(value) for value in values)
    x, y, z = np.eye(3)
    return exact_matrix(rotation_about(z, yaw) @ rotation_about(y, pitch) @ rotation_about(x, roll))


def exact_matrix(rows: Array) -> Matrix3:
    a, b, c = ((Fraction(float(x)), Fraction(float(y)), Fraction(float(z))) for x, y, z in rows)
    return (a, b, c)
