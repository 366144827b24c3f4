"""What the two bodies of a joint share, one row per joint type (theory of natural coordinates; paper §3)."""

from __future__ import annotations

from dataclasses import dataclass

from symgen.natural.entities import Vector
from symgen.natural.plane import X, joint_axis, turned
from symgen.topology.tree import TreeBody


@dataclass(frozen=True)
class Slot:
    """One entity of a joint."""

    kind: str
    """``point``, ``vector``, ``angle``."""
    side: str
    """The body it is fixed in: ``both``, ``parent``, ``child``. A point of the parent's side is the joint's origin,
    a point of the child's side the child's origin; they coincide at zero position."""
    which: str = ""
    """The vector: ``axis`` (planar joints: the normal), ``axis2``, ``x`` (see `joint_vector`)."""
    superscript: str = ""
    """Tells the two vectors of a universal joint apart (u¹, u² of Table 1)."""


POINT = Slot("point", "both")
AXIS = Slot("vector", "both", "axis")
SLIDING = (Slot("point", "parent"), AXIS, Slot("point", "child"))

SPATIAL: dict[str, tuple[Slot, ...]] = {
    "revolute": (POINT, AXIS),
    "continuous": (POINT, AXIS),
    "spherical": (POINT,),
    "universal": (POINT, Slot("vector", "parent", "axis", "_1"), Slot("vector", "child", "axis2", "_2")),
    "prismatic": SLIDING,
    "cylindrical": SLIDING,
    "planar": SLIDING,
    "helical": (*SLIDING, Slot("angle", "child")),
    "floating": (Slot("point", "child"), Slot("vector", "child", "x")),
}

UNSHARED = (Slot("point", "child"), Slot("vector", "child", "x"))
"""Of a joint whose place in the parent is not a constant."""

PLANAR: dict[str, tuple[Slot, ...]] = {
    "revolute": (POINT,),
    "continuous": (POINT,),
    "prismatic": (Slot("point", "parent"), Slot("point", "child")),
    "planar": (Slot("point", "child"),),
}


def joint_vector(body: TreeBody, which: str) -> Vector:
    """The vector of a slot of a body's incoming joint, in joint axes (the child's axes at zero position).

    A floating body's vector is the first that the scene declares in it, else its x axis.
    """
    if which == "x":
        declared = (turned(pose.rotation, u) for part, pose in body.parts for u in part.unit_vectors)
        return next(declared, X)
    if which == "axis2":
        if body.joint.axis2 is None:
            raise ValueError(f"joint '{body.joint.name}' has no second axis")
        return body.joint.axis2
    return joint_axis(body.joint)
