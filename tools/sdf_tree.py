"""The spanning tree of an SDF model as a scene, for models that exist in no other format (Cassie).

Only what such a file needs: links with poses in the model's frame, revolute, prismatic and ball joints whose frame is
the child's. A joint that would close a loop is left out and named.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from defusedxml import ElementTree

from symgen import Scene, SceneBuilder

KINDS = {"revolute": "revolute", "prismatic": "prismatic", "ball": "spherical"}


def rotation(rpy: list[float]) -> Any:
    r, p, y = rpy
    cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(y), np.sin(y)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def angles(R: Any) -> list[float]:
    """Roll, pitch, yaw of a rotation away from the poles of the pitch; there with roll zero."""
    if abs(R[2, 0]) > 1 - 1e-9:
        return [0.0, float(-np.sign(R[2, 0]) * np.pi / 2), float(np.arctan2(-R[0, 1], R[1, 1]))]
    return [float(np.arctan2(R[2, 1], R[2, 2])), float(-np.arcsin(R[2, 0])), float(np.arctan2(R[1, 0], R[0, 0]))]


def numbers(element: Any, path: str, default: str) -> list[float]:
    return [float(x) for x in (element.findtext(path) or default).split()]


def identifier(name: str) -> str:
    return re.sub(r"\W", "_", name)


def load_sdf_tree(path: Path, name: str, base: str) -> tuple[Scene, list[str]]:
    """The model as a tree on a floating ``base``, and the joints that were left out because they close loops."""
    model: Any = ElementTree.parse(path).getroot()
    model = model.find("model")
    poses = {}
    builder = SceneBuilder(name)
    for link in model.findall("link"):
        here = numbers(link, "pose", "0 0 0 0 0 0")
        poses[link.get("name")] = rotation(here[3:]), np.array(here[:3])
        at = numbers(link, "inertial/pose", "0 0 0 0 0 0")
        xx, yy, zz, xy, xz, yz = (
            float(link.findtext(f"inertial/inertia/{key}") or 0) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        )
        turn = rotation(at[3:])
        tensor = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
        entries = [float(tensor[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        mass = float(link.findtext("inertial/mass") or 0)
        builder.body(identifier(link.get("name")), mass=mass, com=at[:3], inertia=entries)
    builder.joint("floating_base", "floating", "ground", identifier(base))
    joints, reached = list(model.findall("joint")), {base}
    while ready := [j for j in joints if j.findtext("parent") in reached and j.findtext("child") not in reached]:
        joint = ready[0]
        joints.remove(joint)
        parent, child = joint.findtext("parent"), joint.findtext("child")
        reached.add(child)
        (R1, r1), (R2, r2) = poses[parent], poses[child]
        axis = numbers(joint, "axis/xyz", "0 0 1")
        facts: dict[str, Any] = {} if joint.get("type") == "ball" else {"axis": axis}
        damping = joint.findtext("axis/dynamics/damping")
        if damping:
            facts["damping"] = float(damping)
        xyz, rpy = [float(x) for x in R1.T @ (r2 - r1)], angles(R1.T @ R2)
        kind = KINDS[joint.get("type")]
        builder.joint(
            identifier(joint.get("name")), kind, identifier(parent), identifier(child), xyz=xyz, rpy=rpy, **facts
        )
    return builder.build(), [j.get("name") for j in joints]
