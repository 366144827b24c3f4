"""The problem statement: a scene in sentences."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from fractions import Fraction

from symgen.scene.model import GROUND, Joint, JointSpring, Matrix3, Scene, Spring
from symgen.show import number
from symgen.system import System
from symgen.topology.tree import TreeBody

NO_BREAK = "\u00a0"
NARROW = "\u202f"
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
COUNT = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")


def minus(text: str) -> str:
    """A number with a real minus sign, for reading."""
    return text.replace("-", "−")


def exact(value: Fraction) -> str:
    """A number as `symgen show` writes it, powers of ten set as such."""
    mantissa, _, exponent = number(value).partition("e")
    return ten_to(minus(mantissa), int(exponent)) if exponent else minus(mantissa)


def superscript(exponent: int) -> str:
    return str(exponent).translate(SUPERSCRIPT)


def ten_to(mantissa: str, exponent: int) -> str:
    """``3.2 × 10⁻¹⁴``, which no line breaks; a mantissa of 1 or none is left out."""
    power = f"10{superscript(exponent)}"
    return power if mantissa in ("", "1") else f"{mantissa}{NO_BREAK}×{NO_BREAK}{power}"


def thousands(value: float, digits: int = 0) -> str:
    """``1200``, ``12 000``: narrow spaces that no line breaks between thousands, from ten thousand on."""
    text = f"{value:,.{digits}f}"
    return minus(text.replace(",", NARROW if abs(value) >= 1e4 else ""))


def triple(values: Sequence[Fraction]) -> str:
    """Components in parentheses, with one ``≈`` before them where they are rounded."""
    texts = [number(Fraction(value)) for value in values]
    rounded = any(text.startswith("≈") for text in texts)
    if rounded:
        texts = [f"{float(value):.4g}" for value in values]
    return ("≈" if rounded else "") + minus(f"({f',{NO_BREAK}'.join(texts)})")


def slug(name: str) -> str:
    """A name as an address within a page."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def counted(n: int, singular: str, plural: str = "") -> str:
    word = COUNT[n] if n < len(COUNT) else str(n)
    return f"{word} {singular if n == 1 else plural or singular + 's'}"


def listed(items: Sequence[str]) -> str:
    """``a, b and c``."""
    return items[0] if len(items) == 1 else ", ".join(items[:-1]) + " and " + items[-1] if items else "nothing"


def direction(axis: Sequence[Fraction]) -> str:
    """An axis by the name of a coordinate axis where it is one."""
    for name, component in zip("xyz", axis, strict=True):
        if abs(component) == 1:
            return name if component > 0 else f"−{name}"
    return triple(axis)


def _kind(system: System) -> str:
    tree = system.tree
    plane = "planar " if system.natural.plane is not None else ""
    if tree.cut_joints:
        return f"a {plane}mechanism with {counted(len(tree.cut_joints), 'closed loop')}"
    branched = any(len(row) > 1 for row in tree.children) or sum(b.parent < 0 for b in tree.bodies) > 1
    if len(tree.bodies) == 1:
        return f"a single {'body in the plane' if plane else 'rigid body'}"
    return f"a {plane}{'tree' if branched else 'chain'} of rigid bodies"


def _standing(system: System) -> str:
    """How the tree stands on the ground."""
    roots = [body for body in system.tree.bodies if body.parent < 0]
    floating = [body.name for body in roots if body.joint.type == "floating"]
    if len(floating) == len(roots):
        return "It is not fixed to the ground."
    return f"It stands on the ground by {listed([b.joint.name for b in roots if b.joint.type != 'floating'])}."


def _joints(system: System) -> str:
    """How many joints move, and what else counts as one: those that are fixed, those that close loops."""
    fixed = sum(joint.type == "fixed" for joint in system.scene.joints)
    cut = sum(joint.type != "fixed" for joint in system.tree.cut_joints)
    moving = len(system.scene.joints) - fixed
    parts = [counted(moving, "joint that moves", "joints that move") if fixed else counted(moving, "joint")]
    if cut:
        parts[0] += f" ({counted(cut, 'of them closes', 'of them close')} a loop)"
    if fixed:
        parts.append(f"{counted(fixed, 'fixed one')}")
    return ", ".join(parts)


def introduction(system: System) -> list[str]:
    """What the mechanism is, how it may move, what acts on it: one sentence each."""
    scene, tree = system.scene, system.tree
    bodies = counted(len(tree.bodies), "moving body", "moving bodies")
    sentences = [
        f"{scene.name} is {_kind(system)}: {bodies}, {_joints(system)}.",
        _standing(system),
    ]
    if tree.cut_joints:
        names = listed([joint.name for joint in tree.cut_joints])
        sentences.append(f"Its spanning tree, left when {names} is cut, has {counted(tree.nv, 'degree')} of freedom.")
    else:
        sentences.append(f"It has {counted(tree.nv, 'degree')} of freedom.")
    size = sum(g * g for g in scene.gravity)
    if size:
        sentences.append(f"Gravity is {triple(scene.gravity)} m/s² in ground axes.")
    else:
        sentences.append("There is no gravity.")
    return sentences


def _turned(rotation: Matrix3) -> str:
    """A mounting rotation as angle and axis; nothing where there is none."""
    r = [[float(x) for x in row] for row in rotation]
    cosine = max(-1.0, min(1.0, (r[0][0] + r[1][1] + r[2][2] - 1) / 2))
    angle = math.acos(cosine)
    if angle < 1e-9:
        return ""
    if angle > math.pi - 1e-6:  # the axis is a column of R + 1
        k = max(range(3), key=lambda i: r[i][i])
        axis = [r[i][k] + (1.0 if i == k else 0.0) for i in range(3)]
    else:
        axis = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    size = math.sqrt(sum(x * x for x in axis))
    unit = ", ".join(f"{x / size + 0.0:.3g}" for x in axis)
    return minus(f", turned by {math.degrees(angle):.4g}° about ({unit})")


_ANGLE = {"armature": " kg·m²", "damping": " N·m·s/rad", "stiffness": " N·m/rad", "rest": " rad", "effort": " N·m"}
_LINE = {"armature": " kg", "damping": " N·s/m", "stiffness": " N/m", "rest": " m", "effort": " N"}
UNITS: dict[str, dict[str, str]] = {
    "mixed": dict.fromkeys(_ANGLE, ""),
    "prismatic": _LINE,
    **dict.fromkeys(("revolute", "continuous", "helical", "universal", "spherical"), _ANGLE),
}
"""Of quantities of a joint; none where its coordinates have different ones."""


def _limits(joint: Joint) -> list[str]:
    """What the source says of limits, which the equations do not know."""
    limits, units = dict(joint.limits), UNITS.get(joint.type, UNITS["mixed"])
    found = []
    if {"lower", "upper"} <= limits.keys() and limits["lower"] < limits["upper"]:
        found.append(minus(f"limits {limits['lower']:g} to {limits['upper']:g}{units['rest']}"))
    if limits.get("velocity"):
        found.append(f"speed at most {limits['velocity']:g}{units['rest']}{'/s' if units['rest'] else ''}")
    if limits.get("effort"):
        found.append(f"effort at most {limits['effort']:g}{units['effort']}")
    return found


NAMELESS = " (free bases that a robot file does not name are called floating_base, with _ where that is taken)"
"""Of the free joint that the readers of robot files add."""


def joint_sentence(joint: Joint, parent: str, child: str) -> str:
    """What a joint lets its child do."""
    there = "the ground" if parent == GROUND else parent
    at = f"; the joint stands at {triple(joint.origin.translation)} m in {there}{_turned(joint.origin.rotation)}"
    axis = direction(joint.axis) if joint.axis is not None else ""
    second = direction(joint.axis2) if joint.axis2 is not None else ""
    kinds = {
        "revolute": f"turns about {axis}",
        "continuous": f"turns about {axis} without end",
        "prismatic": f"slides along {axis}",
        "helical": f"turns about {axis} and climbs {exact(joint.pitch or Fraction(0))} m per radian",
        "cylindrical": f"turns about and slides along {axis}",
        "universal": f"turns about {axis} of {there} and {second} of its own",
        "planar": "slides along x and y and turns about z",
        "spherical": "turns any way about a point",
        "floating": "moves freely" + (NAMELESS if joint.name.startswith("floating_base") else ""),
        "fixed": "is fixed",
    }
    extra = []
    if joint.mimic:
        multiplier, offset = joint.mimic.multiplier, joint.mimic.offset
        times = "" if multiplier == 1 else f"{exact(multiplier)} times "
        shift = f" {'plus' if offset > 0 else 'minus'} {exact(abs(offset))}" if offset else ""
        extra.append(f"at {times}the position of {joint.mimic.joint}{shift}")
    turning = UNITS.get(joint.type, UNITS["mixed"])
    if joint.armature:
        extra.append(f"armature {exact(joint.armature)}{turning['armature']}")
    if joint.damping:
        extra.append(f"damping {exact(joint.damping)}{turning['damping']}")
    extra += _limits(joint)
    tail = f" ({', '.join(extra)})" if extra else ""
    where = "" if joint.type == "floating" else at
    return f"{child} {kinds[joint.type]}{where}{tail}."


def force_sentences(scene: Scene) -> list[str]:
    sentences = []
    types = {joint.name: joint.type for joint in scene.joints}
    for force in scene.forces:
        name = f"{force.name}: " if force.name else ""
        if isinstance(force, Spring):
            (a, b), (p, q) = force.between, force.points
            sentences.append(
                f"{name}a spring of {exact(force.stiffness)} N/m and {exact(force.damping)} N·s/m, "
                f"{exact(force.length)} m long at rest, joins {triple(p)} m of {a} and {triple(q)} m of {b}."
            )
        elif isinstance(force, JointSpring):
            units = UNITS.get(types.get(force.joint, "mixed"), UNITS["mixed"])
            damping = f", damping {exact(force.damping)}{units['damping']}" if force.damping else ""
            sentences.append(
                f"{name}a spring on {force.joint}: stiffness {exact(force.stiffness)}{units['stiffness']}{damping}, "
                f"at rest at {exact(force.rest)}{units['rest']}."
            )
    return sentences


def parent_name(system: System, body: TreeBody) -> str:
    return system.tree.bodies[body.parent].name if body.parent >= 0 else GROUND
