"""Mechanisms that hard cases share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction as F

from symgen.scene.builder import Number, SceneBuilder
from symgen.scene.model import Scene

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
Axis = tuple[int, int, int]


def chain(
    links: int, axes: Sequence[Axis] = (Y,), mass: Callable[[int], Number] = lambda k: 1, at: Number = 0
) -> Scene:
    """Slender rods of one metre that hang from one another, the first from the point (at, at, at)."""
    made = SceneBuilder(f"chain{links}")
    for k in range(links):
        m = F(str(mass(k))) if isinstance(mass(k), float) else F(mass(k))
        made.body(f"l{k}", m, (0, 0, F(-1, 2)), (m / 12, m / 12, m / 1000, 0, 0, 0))
        parent, place = (f"l{k - 1}", (0, 0, -1)) if k else ("ground", (at, at, at))
        made.joint(f"j{k}", "revolute", parent, f"l{k}", axis=axes[k % len(axes)], xyz=place)
    return made.build()


def pendulum(length: Number = 1, mass: Number = 1) -> Scene:
    """A point mass on a massless rod that turns about y."""
    made = SceneBuilder("pendulum").body("bob", mass, (0, 0, -F(length)))
    return made.joint("hinge", "revolute", "ground", "bob", axis=Y).build()


def free_body(inertia: Sequence[Number] = (1, 2, 3), gravity: Sequence[Number] = (0, 0, 0)) -> Scene:
    """One body on a floating joint, velocities in its own axes."""
    made = SceneBuilder("free_body", gravity).body("body", 1, inertia=(*inertia, 0, 0, 0))
    return made.joint("base", "floating", "ground", "body").options(base_velocity="body").build()


def wrist() -> Scene:
    """Three revolutes z, y, z through one point; only the last of the three bodies has inertia."""
    made = (
        SceneBuilder("wrist")
        .body("a")
        .body("b")
        .body("tool", 1, (0, 0, F(1, 5)), (F(1, 50), F(3, 100), F(1, 70), 0, 0, 0))
    )
    made.joint("z1", "revolute", "ground", "a", axis=Z).joint("y", "revolute", "a", "b", axis=Y)
    return made.joint("z2", "revolute", "b", "tool", axis=Z).build()


def elbow(upper: Number, lower: Number, armature: Number = 0) -> Scene:
    """Two massless rods with a point mass at the end: its mass matrix is singular where they lie in line."""
    made = SceneBuilder("elbow").body("upper").body("lower", 1, (0, 0, -F(str(lower))))
    made.joint("shoulder", "revolute", "ground", "upper", axis=Y, armature=armature)
    return made.joint("elbow", "revolute", "upper", "lower", axis=Y, xyz=(0, 0, -F(str(upper)))).build()
