"""Chains of revolute joints of any length."""

from __future__ import annotations

from fractions import Fraction as F

from symgen.scene.model import GROUND, Body, Joint, Output, Scene, Transform, Vector

DYNAMICS = tuple(Output(row, (row,)) for row in ("mass_matrix", "bias_force", "forward_dynamics"))
AXES: tuple[Vector, ...] = ((F(0), F(0), F(1)), (F(0), F(1), F(0)))


def chain(n: int, axes: tuple[Vector, ...] = AXES) -> Scene:
    """n equal links with generic centres of mass and inertias, joint axes taken in turn from ``axes``."""
    bodies = tuple(
        Body(
            f"link{k}",
            F(12, 10),
            (F(1, 10), F(1, 20), F(1, 7)),
            (F(3, 100), F(4, 100), F(5, 100), F(1, 500), F(1, 700), F(-1, 300)),
        )
        for k in range(n)
    )
    step = Transform(translation=(F(1, 5), F(1, 10), F(3, 10)))
    joints = tuple(
        Joint(f"j{k}", "revolute", GROUND if k == 0 else f"link{k - 1}", f"link{k}", step, axis=axes[k % len(axes)])
        for k in range(n)
    )
    return Scene(f"chain{n}", bodies, joints, outputs=DYNAMICS)
