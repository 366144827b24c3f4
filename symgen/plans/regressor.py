"""Regressor plan: every joint's motion carried outward to every body, in body axes, against the body's own motion.

A parameter's forces are sparse in the body's own axes, and a joint's motion is one twist where the forces of ten
parameters would be ten wrenches: so motions travel, and forces stay where they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from symgen.algebra.linear import Mat, Vec, cross, dot, matvec, mul, sub, total, vadd, vecmat, vsub
from symgen.plans.composite import motions
from symgen.plans.recursive import Motion, link_motions, spin_matrix
from symgen.plans.walk import Links, Moving

Scalar = Any


@dataclass(frozen=True)
class Column:
    """The motion of a body with one joint velocity: angular part and velocity of the origin."""

    index: int
    w: Vec
    v: Vec


def regressor(links: Links, v: Sequence[Scalar], a: Sequence[Scalar], gravity: Vec) -> list[list[Scalar]]:
    """Y (joint velocities, 10 · moving bodies), parameters as in `symgen.literal.regressor`."""
    motion_of = link_motions(links, v, a, gravity)
    columns = links.outward("motions of the joints", list[Column](), lambda at, above: _columns(links, at, above))
    bodies = len(links.tree.bodies)
    rows: list[list[Scalar]] = [[0] * (10 * bodies) for _ in range(links.nv)]
    for at in links.moving:
        if not at.link.carries:
            continue
        with links.phase(f"regressor: {at.link.name}"):
            body, turn = _Body.of(links, at, motion_of[at.link.index]), links.values.matrix(at.link.axes)
            shift = links.values.vector(at.link.shift)
            for column in columns[at.link.index]:
                w = matvec(turn, column.w)
                velocity = vsub(matvec(turn, column.v), cross(w, shift))
                rows[column.index][10 * at.link.body : 10 * at.link.body + 10] = body.powers(w, velocity)
    return rows


def _columns(links: Links, at: Moving, above: list[Column]) -> list[Column]:
    """The motions of all joints on the way, in link axes."""
    convention = links.values.scene.options.base_velocity
    found = [Column(c.index, at.to_link(c.w), at.to_link(vadd(c.v, cross(c.w, at.offset)))) for c in above]
    return found + [Column(at.link.v + k, w, v) for k, (w, v) in enumerate(motions(at, convention))]


@dataclass(frozen=True)
class _Body:
    """A body's motion in its own axes: U = ω̇̃ + ω̃ω̃, ω̇, ω_iω_j, ω_i², and its origin's acceleration less gravity."""

    u: Mat
    w_rate: Vec
    products: Vec
    """ω_yω_z, ω_xω_z, ω_xω_y."""
    differences: Vec
    """ω_y² − ω_z², ω_z² − ω_x², ω_x² − ω_y²."""
    a: Vec

    @staticmethod
    def of(links: Links, at: Moving, motion: Motion) -> _Body:
        turn, shift = links.values.matrix(at.link.axes), links.values.vector(at.link.shift)
        w, w_rate = matvec(turn, motion.w), matvec(turn, motion.w_rate)
        u, (xx, yy, zz) = spin_matrix(w, w_rate)
        a = vsub(matvec(turn, motion.a), matvec(u, shift))
        products = (mul(w[1], w[2]), mul(w[0], w[2]), mul(w[0], w[1]))
        return _Body(u, w_rate, products, (sub(yy, zz), sub(zz, xx), sub(xx, yy)), a)

    def powers(self, w: Vec, v: Vec) -> list[Scalar]:
        """The power of each parameter's forces in the motion (w, v): m a; U e_k and e_k × a; I ω̇ + ω × I ω."""
        u, a, (yz, xz, xy) = self.u, self.a, self.products
        x, y, z = w
        first = vadd(vecmat(v, u), cross(a, w))
        rate = self.w_rate
        return [
            dot(v, a),
            *first,
            total((mul(x, rate[0]), mul(y, xz), mul(sub(0, z), xy))),
            total((mul(y, u[2][1]), mul(sub(0, x), u[2][0]), mul(z, self.differences[2]))),
            total((mul(y, rate[1]), mul(z, xy), mul(sub(0, x), yz))),
            total((mul(x, u[1][0]), mul(sub(0, z), u[1][2]), mul(y, self.differences[1]))),
            total((mul(z, u[0][2]), mul(sub(0, y), u[0][1]), mul(x, self.differences[0]))),
            total((mul(z, rate[2]), mul(x, yz), mul(sub(0, y), xz))),
        ]
