"""What a point of a body is called where a reader chooses it: by the joint, frame or part that stands there."""

from __future__ import annotations

import numpy as np

from symgen.report.sketch import array, cut_place
from symgen.report.solids import Array
from symgen.system import System


def place_name(system: System, body: int, point: Array) -> str:
    """``the joint elbow``, ``the frame tool of hand``, ``the origin of box``; empty where nothing with a name stands.

    ``point``: in the frame of the tree body with that index, m.
    """

    def here(place: Array) -> bool:
        return bool(np.allclose(place, point, atol=1e-9))

    tree, scene = system.tree, system.scene
    for name in (frame.name for frame in scene.frames):
        if tree.frames[name][0] == body and here(array(tree.frames[name][1].translation)):
            return f"the frame {name}"
    for child in tree.bodies:
        if child.parent == body and here(array(child.joint.origin.translation)):
            return f"the joint {child.joint.name}"
    for joint in tree.cut_joints:
        index, place, _ = cut_place(system, joint)
        if index == body and here(place):
            return f"the joint {joint.name}"
    for part, transform in tree.bodies[body].parts if body >= 0 else ():
        if part.name != tree.bodies[body].name and here(array(transform.translation)):
            return f"the origin of {part.name}"
    # A part without mass is not among the parts, but it has a frame.
    for name, (index, transform) in tree.frames.items():
        if index == body and name != tree.bodies[body].name and here(array(transform.translation)):
            return f"the origin of {name}"
    return ""
