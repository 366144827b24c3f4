"""Facts about joint types that need no mathematics: sizes, fields, names of coordinates.

The kinematics of a type (its motion subspace and its position map) are the rows of the
table in `symgen.velocity.joint_table`; this module is what the loaders need.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class JointType:
    nq: int
    nv: int
    needs: tuple[str, ...] = ()
    """Fields of the scene file beyond name, type, parent, child."""
    q_units: tuple[str, ...] = ()
    v_units: tuple[str, ...] = ()
    letter: str = ""
    """How mechanism theory abbreviates it."""


JOINT_TYPES: dict[str, JointType] = {
    "revolute": JointType(1, 1, ("axis",), ("rad",), ("rad/s",), "R"),
    "continuous": JointType(1, 1, ("axis",), ("rad",), ("rad/s",), "R"),
    "prismatic": JointType(1, 1, ("axis",), ("m",), ("m/s",), "P"),
    "helical": JointType(1, 1, ("axis", "pitch"), ("rad",), ("rad/s",), "H"),
    "cylindrical": JointType(2, 2, ("axis",), ("rad", "m"), ("rad/s", "m/s"), "C"),
    "universal": JointType(2, 2, ("axis", "axis2"), ("rad", "rad"), ("rad/s", "rad/s"), "U"),
    "planar": JointType(3, 3, (), ("m", "m", "rad"), ("m/s", "m/s", "rad/s"), "E"),
    "spherical": JointType(4, 3, (), ("1",) * 4, ("rad/s",) * 3, "S"),
    "floating": JointType(7, 6, (), ("m",) * 3 + ("1",) * 4, ("m/s",) * 3 + ("rad/s",) * 3, "F"),
    "fixed": JointType(0, 0, (), (), (), ""),
}
