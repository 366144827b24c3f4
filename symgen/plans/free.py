"""What `base_velocity` means for a free link: its motions and forces in link axes and back (theory, §7).

world: linear and angular parts in ground axes; body: both in link axes; mixed: linear ground, angular link.
"""

from __future__ import annotations

from typing import Any

from symgen.algebra.linear import IDENTITY, ZERO, Mat, Vec, cross, scale, transpose, vadd
from symgen.plans.inertia import Inertia, moment_of_inertia
from symgen.plans.walk import Moving

Scalar = Any


def motions(at: Moving, convention: str) -> list[tuple[Vec, Vec]]:
    """(w, v) of every velocity, link axes."""
    ground = tuple(at.to_link(axis) for axis in IDENTITY)
    linear, angular = IDENTITY if convention == "body" else ground, ground if convention == "world" else IDENTITY
    return [*((ZERO, axis) for axis in linear), *((axis, ZERO) for axis in angular)]


def velocity(at: Moving, v: Vec, convention: str) -> tuple[Vec, Vec]:
    """Generalised velocity → (velocity of the origin, angular velocity), both in link axes."""
    linear = v[:3] if convention == "body" else at.to_link(v[:3])
    angular = at.to_link(v[3:]) if convention == "world" else v[3:]
    return linear, angular


def acceleration(at: Moving, linear_velocity: Vec, angular_velocity: Vec, a: Vec, convention: str) -> tuple[Vec, Vec]:
    """Generalised acceleration → (acceleration of the origin, angular acceleration), both in link axes."""
    if convention == "body":
        return vadd(a[:3], cross(angular_velocity, linear_velocity)), a[3:]
    return velocity(at, a, convention)


def generalised_force(at: Moving, force: Vec, moment: Vec, convention: str) -> Vec:
    """Wrench about the link's origin in link axes → generalised force."""
    linear = force if convention == "body" else at.to_parent(force)
    angular = at.to_parent(moment) if convention == "world" else moment
    return (*linear, *angular)


def wrench(at: Moving, generalised: Vec, convention: str) -> tuple[Vec, Vec]:
    """Generalised force → (force, moment) in link axes; the transformation is orthogonal, so it is `velocity`'s."""
    return velocity(at, generalised, convention)


def block(at: Moving, composite: Inertia, convention: str) -> Mat:
    """The 6×6 block of the mass matrix: [m 1, −h̃; h̃, I] with h and I in the axes of the velocities.

    The angular axes of ``mixed`` are the link's while its linear ones are ground's, so there the lower left block
    is h × each ground axis seen from the link.
    """
    if convention == "world":
        composite = Inertia(composite.mass, at.to_parent(composite.first), at.second_to_parent(composite.second))
    axes = tuple(at.to_link(axis) for axis in IDENTITY) if convention == "mixed" else IDENTITY
    coupling = transpose(tuple(cross(composite.first, axis) for axis in axes))
    upper = tuple((*scale(composite.mass, IDENTITY[i]), *(row[i] for row in coupling)) for i in range(3))
    lower = tuple((*coupling[i], *row) for i, row in enumerate(moment_of_inertia(composite)))
    return upper + lower
