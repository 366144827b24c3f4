"""Textbook solutions, applied to any scene that is one of them by structure (not by name)."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from symgen.scene.model import Body
from symgen.validation.functions import Bound
from symgen.validation.invariants import is_conservative
from symgen.validation.mechanism import Array, Link, Mechanism, link_poses, rotation_about, skew, vector
from symgen.validation.pinocchio_model import body_inertia
from symgen.validation.exudyn_tree import lump
from symgen.validation.mechanism import IDENTITY
from symgen.validation.reference import import_scipy_integrate, integrate_motion
from symgen.validation.result import Row

GROUP = "closed form"
MOTION = 1e-9
"""Criterion of solutions followed over several periods, relative."""
POINT = 1e-12
"""Criterion of closed-form accelerations, relative."""
DZHANIBEKOV_PERIOD = 55.061681107466372
"""s, of a free body with I = (1, 2, 3) started at ω = (1e-3, 1, 1e-3): 4 K/λ, evaluated to 17 digits."""


def special() -> Any:
    import_scipy_integrate()
    return importlib.import_module("scipy.special")
