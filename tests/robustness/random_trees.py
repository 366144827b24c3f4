"""Random mechanisms as texts: drawn by hypothesis, written as a scene and, where URDF has the joints, as a URDF file.

Everything awkward is likely: points that coincide, axes that are parallel, antiparallel or nearly so, bodies without
mass, needles, plates and points, branches, chains of couplings, far origins, mounting angles near a quarter turn.
"""

# ruff: noqa: E501  (tables)

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from hypothesis import strategies as st

Mapping = dict[str, Any]
ONE_DOF = ("revolute", "continuous", "prismatic")
TYPES = (*ONE_DOF, "helical", "cylindrical", "universal", "planar", "spherical", "floating", "fixed")
URDF_TYPES = (*ONE_DOF, "planar", "floating", "fixed")

AXES = (
    ["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1"], ["0", "0", "-1"], ["0", "-2", "0"], ["0.6", "0", "0.8"], ["1", "2", "3"],
    ["-1", "-2", "-3"], ["1e-7", "0", "1"], ["1", "1e-12", "0"], ["3e150", "-4e150", "0"], ["1e-200", "1e-200", "1e-200"],
)  # fmt: skip
POINTS = (
    ["0", "0", "0"], ["0", "0", "0"], ["0", "0", "0.5"], ["0.3", "0", "0"], ["0", "-0.4", "0"], ["0.1", "-0.2", "0.3"],
    ["-0.7", "0.05", "1.1"], ["1e-9", "0", "0"], ["100", "-20", "3"],
)  # fmt: skip
TURNS = (
    ["0", "0", "0"], ["0", "0", "0"], ["1.5707963267948966", "0", "0"], ["0", "0", "3.141592653589793"], ["0.1", "0.2", "0.3"],
    ["-1.5707963267948966", "1.5707963267948966", "0"], ["1e-9", "0", "0"], ["1.5708", "0", "-3.14"], ["2.5", "-1.2", "40"],
)  # fmt: skip
INERTIAS = {
    "solid": ["0.5", "0.6", "0.7", "0.02", "-0.03", "0.01"],
    "ball": ["0.4", "0.4", "0.4", "0", "0", "0"],
    "plate": ["0.2", "0.3", "0.5", "0", "0", "0"],
    "needle": ["0.3", "0.3", "0", "0", "0", "0"],
    "turned needle": ["0.2", "0.2", "0.4", "0.2", "0", "0"],
    "point": ["0", "0", "0", "0", "0", "0"],
    "heavy": ["5e5", "6e5", "7e5", "0", "0", "1e4"],
    "light": ["5e-7", "6e-7", "7e-7", "0", "0", "0"],
}
MASSES = {"heavy": ["1e6"], "light": ["1e-5"]}


@dataclass(frozen=True)
class Made:
    """A mechanism in words; numbers are decimal texts."""

    bodies: list[Mapping]
    joints: list[Mapping]
    forces: list[Mapping] = field(default_factory=list)
    options: Mapping = field(default_factory=dict)

    def yaml(self, outputs: list[str]) -> str:
        """The scene file."""
        parts: Mapping = {"bodies": self.bodies, "joints": self.joints, "forces": self.forces}
        lines = ["name: random_tree"]
        for key, rows in parts.items():
            lines += [f"{key}:", *(f"  - {flow(row)}" for row in rows)] if rows else []
        return "\n".join(
            [*lines, f"outputs: {flow([repr(row) for row in outputs])}", f"options: {flow(self.options)}", ""]
        )

    def urdf(self) -> str:
        """The URDF file: the fixed world is its root link. Springs, armature and options have no place in it."""
        rows = [
            '<robot name="random_tree">',
            '<link name="world"/>',
            *map(_link, self.bodies),
            *map(_joint, self.joints),
        ]
        return "\n".join([*rows, "</robot>", ""])


def flow(value: Any) -> str:
    """YAML in flow style; texts as they are."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow(item)}" for key, item in value.items()) + "}"
    return f"[{', '.join(map(flow, value))}]" if isinstance(value, list) else str(value)


def _link(body: Mapping) -> str:
    if "mass" not in body:
        return f'<link name="{body["name"]}"/>'
    entries = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), body["inertia"], strict=True)
    inertia = " ".join(f'{key}="{value}"' for key, value in entries)
    origin = f'<origin xyz="{" ".join(body["com"])}"/>'
    inner = f'<inertial>{origin}<mass value="{body["mass"]}"/><inertia {inertia}/></inertial>'
    return f'<link name="{body["name"]}">{inner}</link>'


def _joint(joint: Mapping) -> str:
    parent = "world" if joint["parent"] == "ground" else joint["parent"]
    origin = " ".join(f'{key}="{" ".join(value)}"' for key, value in joint["origin"].items())
    inner = f'<parent link="{parent}"/><child link="{joint["child"]}"/><origin {origin}/>'
    axis = ["0", "0", "1"] if joint["type"] == "planar" else joint.get("axis")
    inner += f'<axis xyz="{" ".join(axis)}"/>' if axis else ""
    inner += f'<dynamics damping="{joint["damping"]}"/>' if "damping" in joint else ""
    inner += "<mimic " + " ".join(f'{k}="{v}"' for k, v in joint["mimic"].items()) + "/>" if "mimic" in joint else ""
    return f'<joint name="{joint["name"]}" type="{joint["type"]}">{inner}</joint>'


def _body(draw: Any, name: str) -> Mapping:
    if draw(st.integers(0, 4)) == 0:
        return {"name": name}  # no mass
    kind = draw(st.sampled_from(sorted(INERTIAS)))
    mass = draw(st.sampled_from(MASSES.get(kind, ["1", "2.5", "0.04"])))
    return {
        "name": name,
        "mass": mass,
        "com": list(draw(st.sampled_from(POINTS[:-2]))),
        "inertia": list(INERTIAS[kind]),
    }


def _axes(draw: Any, parent: Mapping | None) -> list[str]:
    """Often the parent's own axis, or its opposite."""
    before = parent.get("axis") if parent else None
    if before and draw(st.booleans()):
        return [_opposite(x) for x in before] if draw(st.booleans()) else list(before)
    return list(draw(st.sampled_from(AXES)))


def _opposite(number: str) -> str:
    return number[1:] if number.startswith("-") else f"-{number}"


def _tree_joint(draw: Any, k: int, types: tuple[str, ...], joints: list[Mapping]) -> Mapping:
    parent = draw(st.integers(max(-1, k - 4), k - 1)) if draw(st.booleans()) else k - 1
    kind = draw(st.sampled_from(types))
    joint: Mapping = {"name": f"j{k}", "type": kind, "child": f"b{k}"}
    joint["parent"] = f"b{parent}" if parent >= 0 and kind != "floating" else "ground"
    xyz, rpy = list(draw(st.sampled_from(POINTS))), list(draw(st.sampled_from(TURNS)))
    joint["origin"] = {"xyz": xyz, "rpy": rpy}
    if kind in (*ONE_DOF, "helical", "cylindrical", "universal"):
        joint["axis"] = _axes(draw, joints[parent] if parent >= 0 else None)
    if kind == "universal":
        others = ["0", "1", "0.5"], ["0.02", "1", "-1"], ["1", "-0.05", "0.1"]
        joint["axis2"] = list(draw(st.sampled_from([axis for axis in others if axis != joint["axis"]])))
    if kind == "helical":
        joint["pitch"] = draw(st.sampled_from(["0.05", "-0.3", "1e-4"]))
    if kind != "fixed" and draw(st.booleans()):
        joint["damping"] = draw(st.sampled_from(["0.1", "3"]))
    masters = [other["name"] for other in joints if other["type"] in ONE_DOF]
    if kind in ONE_DOF and masters and draw(st.integers(0, 4)) == 0:
        numbers = st.sampled_from(["1", "-1", "0.5", "-2.25"])
        joint["mimic"] = {"joint": draw(st.sampled_from(masters)), "multiplier": draw(numbers), "offset": draw(numbers)}
    return joint


def _force(draw: Any, joints: list[Mapping]) -> Mapping:
    coordinates = [joint for joint in joints if joint["type"] not in ("fixed", "spherical", "floating")]
    if coordinates and draw(st.booleans()):
        on = draw(st.sampled_from(coordinates))["name"]
        return {"type": "joint_spring", "joint": on, "stiffness": "2", "damping": "0.1", "rest": "0.3"}
    moving = draw(st.sampled_from([joint for joint in joints if joint["type"] != "fixed"]))
    ends = [moving["child"], moving["parent"]]
    far = [["0.1", "2", "0"], ["0", "-3", "0.5"]]
    return {"type": "spring", "between": ends, "points": far, "stiffness": "5", "damping": "0.2", "length": "0.25"}


@st.composite
def trees(draw: Any, smallest: int = 1, largest: int = 8, types: tuple[str, ...] = TYPES) -> Made:
    """A tree that can move; with types of URDF only, one without springs and armature."""
    size = draw(st.integers(smallest, largest))
    bodies: list[Mapping] = []
    joints: list[Mapping] = []
    for k in range(size):
        bodies.append(_body(draw, f"b{k}"))
        joints.append(_tree_joint(draw, k, types, joints))
    if all(joint["type"] == "fixed" for joint in joints):
        joints[-1].update(type="revolute", axis=["0", "1", "0"])
    options = {
        "base_velocity": draw(st.sampled_from(["world", "body", "mixed"])),
        "trigonometry": draw(st.sampled_from(["polynomial", "libm"])),
        "targets": ["c"],
    }
    if types == URDF_TYPES:
        return Made(bodies, joints, [], {"targets": ["c"]})
    for joint in joints:
        if joint["type"] != "fixed" and draw(st.booleans()):
            joint["armature"] = draw(st.sampled_from(["0.01", "0.5"]))
    forces = [_force(draw, joints) for _ in range(draw(st.integers(0, 2)))]
    return Made(bodies, joints, forces, options)
