"""Closed forms of motions, with more digits than a double has: what benchmarks are compared with.

Sources: Landau & Lifshitz, Mechanics, §§ 35–37 (pendulum, tops); Goldstein, Poole & Safko, Classical Mechanics, § 5.7.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DIGITS = 40


def pendulum(t: float, gravity: float, length: float, amplitude: float) -> tuple[float, float]:
    """Angle from the vertical and its rate, t after rest at ``amplitude``: θ = 2 asin(k sn(ω₀ t + K, k))."""
    with mpmath.workdps(DIGITS):
        rate = mpmath.sqrt(mpmath.mpf(gravity) / mpmath.mpf(length))
        k = mpmath.sin(mpmath.mpf(amplitude) / 2)
        u = rate * mpmath.mpf(t) + mpmath.ellipk(k * k)
        return float(2 * mpmath.asin(k * mpmath.ellipfun("sn", u, m=k * k))), float(
            2 * k * rate * mpmath.ellipfun("cn", u, m=k * k)
        )


def free_body_period(moments: tuple[float, float, float], start: tuple[float, float, float]) -> float:
    """Period of ω of a free body with I₁ < I₂ < I₃."""
    with mpmath.workdps(DIGITS):
        return float(_euler(moments, start)[1])


def free_body(
    t: float, moments: tuple[float, float, float], start: tuple[float, float, float]
) -> tuple[float, float, float]:
    """ω in principal axes, t after ``start`` (Landau & Lifshitz § 37), for I₁ < I₂ < I₃ and 2 E I₂ < L²."""
    with mpmath.workdps(DIGITS):
        at, _ = _euler(moments, start)
        x, y, z = at(mpmath.mpf(t))
        return float(x), float(y), float(z)


def _euler(moments: tuple[float, float, float], start: tuple[float, float, float]) -> tuple[Callable[[Any], Any], Any]:
    (i1, i2, i3), (w1, w2, w3) = (tuple(mpmath.mpf(x) for x in row) for row in (moments, start))
    twice_energy = i1 * w1**2 + i2 * w2**2 + i3 * w3**2
    square = (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
    if square <= twice_energy * i2:
        raise ValueError("exchange the roles of the first and third axis: L² is not above 2 E I₂")
    a1 = mpmath.sqrt((twice_energy * i3 - square) / (i1 * (i3 - i1)))
    a2 = mpmath.sqrt((twice_energy * i3 - square) / (i2 * (i3 - i2)))
    a3 = mpmath.sqrt((square - twice_energy * i1) / (i3 * (i3 - i1)))
    rate = mpmath.sqrt((i3 - i2) * (square - twice_energy * i1) / (i1 * i2 * i3))
    m = (i2 - i1) * (twice_energy * i3 - square) / ((i3 - i2) * (square - twice_energy * i1))
    # ω₁ = ± a₁ cn, ω₂ = a₂ sn, ω₃ = ± a₃ dn; the signs of the first and third at the start, sn and cn give the phase
    s1, s3 = (1 if w1 >= 0 else -1), (1 if w3 >= 0 else -1)
    sign = s1 * s3
    phase = mpmath.ellipf(mpmath.atan2(sign * w2 / a2, s1 * w1 / a1), m)

    def at(t: Any) -> Any:
        u = rate * t + phase
        cn, sn, dn = (mpmath.ellipfun(name, u, m=m) for name in ("cn", "sn", "dn"))
        return s1 * a1 * cn, sign * a2 * sn, s3 * a3 * dn

    return at, 4 * mpmath.ellipk(m) / rate


def rotation(axis: Array, angle: float) -> Array:
    """Rodrigues."""
    x, y, z = axis / np.linalg.norm(axis)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew)


def symmetric_body(t: float, across: float, along: float, omega: Array) -> Array:
    """Rotation of a free body whose axis of symmetry is z, from the identity: about L with |L|/I₁, and about its own
    axis with ω₃ (I₁ − I₃)/I₁. ``across``, ``along``: I₁ and I₃."""
    momentum = np.array([across * omega[0], across * omega[1], along * omega[2]])
    turned = rotation(momentum, float(np.linalg.norm(momentum)) / across * t)
    return np.asarray(turned @ rotation(np.array([0.0, 0.0, 1.0]), omega[2] * (across - along) / across * t))


def sleeping_top(t: float, across: float, moment: float, weight: float, start: complex) -> complex:
    """Where the axis of a nearly upright fast top points, x + i y, after it was let go at ``start`` without velocity:
    I₁ z̈ − i L₃ ż − m g l z = 0. ``moment``: L₃; ``weight``: m g l. Grows where L₃² < 4 I₁ m g l."""
    root = np.sqrt(complex(moment * moment - 4.0 * across * weight))
    first, second = (1j * (moment + sign * root) / (2.0 * across) for sign in (1.0, -1.0))
    c = start * second / (second - first)
    return complex(c * np.exp(first * t) + (start - c) * np.exp(second * t))


def oscillator(t: float, rate: float, damping: float, start: float) -> float:
    """x of ẍ + 2 d ẋ + ω² x = 0 after rest at ``start``, d < ω."""
    turn = np.sqrt(rate * rate - damping * damping)
    return float(start * np.exp(-damping * t) * (np.cos(turn * t) + damping / turn * np.sin(turn * t)))
