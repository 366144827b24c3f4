"""Small robots with everything that conventions differ in."""

from __future__ import annotations

from typing import Any

import symgen

INERTIA = (0.11, 0.12, 0.13, 0.01, -0.02, 0.015)


def branched_scene() -> symgen.Scene:
    """A floating base, mounted askew, with two branches; every joint type that somebody writes differently."""
    builder = symgen.SceneBuilder("branched")
    joints: list[tuple[str, str, str, dict[str, Any]]] = [
        ("base", "floating", "ground", {"xyz": (0.1, 0.2, 0.3), "rpy": (0.4, -0.5, 0.6)}),
        ("turn", "continuous", "base", {"axis": (0, 1, 0), "xyz": (0.2, 0, 0.1), "rpy": (1, 0, 0.5)}),
        ("sleeve", "cylindrical", "turn", {"axis": (0, 0, 1), "xyz": (0, 0.3, 0)}),
        ("plane", "planar", "base", {"xyz": (0, 0.1, -0.2), "rpy": (0.3, 0, 0)}),
        ("ball", "spherical", "plane", {"xyz": (0.1, 0.1, 0)}),
        ("slide", "prismatic", "ball", {"axis": (1, 0, 0)}),
        ("cross", "universal", "base", {"axis": (1, 0, 0), "axis2": (0, 1, 0)}),
    ]
    for name, kind, parent, more in joints:
        child = f"{name}_link"
        builder.body(child, mass=1.5, com=(0.1, -0.05, 0.2), inertia=INERTIA)
        builder.joint(name, kind, parent if parent == "ground" else f"{parent}_link", child, **more)
    return builder.build()


def link(name: str) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="0.1 -0.05 0.2"/><mass value="1.5"/><inertia ixx="0.11" iyy="0.12" '
        'izz="0.13" ixy="0.01" ixz="-0.02" iyz="0.015"/></inertial></link>'
    )


def joint(name: str, kind: str, parent: str, child: str, more: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><axis xyz="0 0.6 0.8"/>'
        f'<limit lower="-1" upper="1" effort="1" velocity="1"/>{more}</joint>'
    )


URDF = "".join([
    '<robot name="r">', *(link(name) for name in ("trunk", "z1", "z2", "a1", "a2", "a3")),
    joint("zeta", "continuous", "trunk", "z1"),
    joint("zulu", "prismatic", "z1", "z2"),
    joint("alpha", "revolute", "trunk", "a1"),
    joint("beta", "revolute", "a1", "a2", '<mimic joint="alpha" multiplier="-2" offset="0.25"/>'),
    joint("gamma", "continuous", "a2", "a3"),
    "</robot>",
])  # fmt: skip

MJCF = """
<mujoco><compiler angle="radian"/><option><flag contact="disable"/></option>
<worldbody><body name="trunk"><freejoint/><geom size="0.1"/>
<body name="thigh" pos="0 0.2 0"><joint axis="0 1 0"/><joint name="push" type="slide" axis="1 0 0" ref="-0.1"/>
<geom size="0.1" pos="0 0.1 0.2"/>
<body name="shin" pos="0 0 0.5"><joint name="knee" axis="0 1 0" ref="0.5" pos="0.1 0 0"/>
<geom size="0.1" pos="0.1 0 0"/></body></body>
<body name="tail" pos="0.3 0 0"><joint type="ball" pos="0 0 0.1"/><geom type="box" size="0.1 0.2 0.3"/></body>
</body></worldbody></mujoco>
"""
