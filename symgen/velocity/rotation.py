"""Rotations over any number type: exact in (cos, sin) or in a quaternion that need not be of unit norm."""

from __future__ import annotations

from typing import Any

from symgen.algebra.linear import IDENTITY, Mat, Vec, add, cross, dot, madd, mscale, mul, outer, skew, sub
from symgen.algebra.numbers import Numbers

Scalar = Any


def axis_rotation(axis: Vec, c: Scalar, s: Scalar) -> Mat:
    """Rodrigues: c 1 + s ã + (1 − c) a aᵀ, for a unit axis a and (c, s) = (cos, sin) of the angle."""
    return madd(madd(mscale(c, IDENTITY), mscale(s, skew(axis))), mscale(sub(1, c), outer(axis, axis)))


def quaternion_rotation(quaternion: Vec) -> Mat:
    """Rotation matrix of [x y z w], divided by its squared norm so that any non-zero quaternion is exact.

    With k = 2/|q|²: 1 + k (w ṽ + ṽ ṽ).
    """
    x, y, z, w = quaternion
    k = 2 / (x * x + y * y + z * z + w * w)
    kx, ky, kz = k * x, k * y, k * z
    xx, yy, zz = kx * x, ky * y, kz * z
    xy, xz, yz = kx * y, kx * z, ky * z
    wx, wy, wz = kx * w, ky * w, kz * w
    return (
        (1 - (yy + zz), xy - wz, xz + wy),
        (xy + wz, 1 - (xx + zz), yz - wx),
        (xz - wy, yz + wx, 1 - (xx + yy)),
    )


def quaternion_product(a: Vec, b: Vec) -> Vec:
    """a ⊗ b, both [x y z w]."""
    av, aw, bv, bw = a[:3], a[3], b[:3], b[3]
    crossed = cross(av, bv)
    vector = tuple(add(add(mul(aw, y), mul(bw, x)), c) for x, y, c in zip(av, bv, crossed, strict=True))
    return (*vector, sub(mul(aw, bw), dot(av, bv)))


def quaternion_exponential(turn: Vec, numbers: Numbers) -> Vec:
    """Unit quaternion of a rotation vector: [sinc(|φ|/2) φ/2, cos(|φ|/2)]."""
    half = tuple(x / 2 for x in turn)
    square = dot(half, half)
    s = numbers.sinc_sqrt(square)
    return (*(s * x for x in half), numbers.cos_sqrt(square))


def renormalise(quaternion: Vec) -> Vec:
    """One Newton step of q/|q|: q (3 − |q|²)/2; keeps the norm at 1 against rounding, without a root."""
    k = (3 - dot(quaternion, quaternion)) / 2
    return tuple(k * x for x in quaternion)
