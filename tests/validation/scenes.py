"""Scenes built straight from the dataclasses, one for every joint type and some that mix them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F

from symgen.scene.model import (
    GROUND,
    Body,
    Joint,
    JointSpring,
    Matrix3,
    Mimic,
    Options,
    Scene,
    Spring,
    Transform,
    Vector,
)


def vec(*values: str | int) -> Vector:
    x, y, z = (F(value) for value in values)
    return (x, y, z)


def rotation(w: int, x: int, y: int, z: int) -> Matrix3:
    """Exactly orthogonal rational rotation of an integer quaternion."""
    n = F(w * w + x * x + y * y + z * z)
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    a, b, c = (vec(*(F(value) / n for value in row)) for row in rows)  # type: ignore[arg-type]
    return (a, b, c)


AXES = (vec("9/25", "12/25", "4/5"), vec("2/3", "-1/3", "2/3"), vec("-6/7", "2/7", "3/7"), vec(0, "3/5", "4/5"))
TURNS = (rotation(3, 1, -2, 1), rotation(1, 2, 0, -1), rotation(5, -1, 1, 2), rotation(2, 0, 1, 1))


def body(name: str, k: int = 0) -> Body:
    """A generic body; ``k`` varies it."""
    return Body(
        name,
        F(12 + 3 * k, 10),
        vec(F(1 + k, 10), F(-1, 20), F(2 - k, 15)),  # type: ignore[arg-type]
        (F(8 + k, 100), F(9, 100), F(10 + k, 100), F(1, 200), F(-1, 100), F(1, 150 + k)),
    )


def joint(name: str, kind: str, parent: str, child: str, k: int = 0, **more: object) -> Joint:
    """A joint on a generic frame; ``k`` varies frame and axis."""
    facts: dict[str, object] = {}
    if kind in ("revolute", "continuous", "prismatic", "helical", "cylindrical", "universal"):
        facts["axis"] = AXES[k % 4]
    if kind == "universal":
        facts["axis2"] = AXES[(k + 1) % 4]
    if kind == "helical":
        facts["pitch"] = F(1, 8)
    origin = Transform(TURNS[k % 4], vec(F(1 + k, 10), F(3, 10), F(-k, 7)))  # type: ignore[arg-type]
    return Joint(name, kind, parent, child, origin, **(facts | more))  # type: ignore[arg-type]


def chain(name: str, kinds: tuple[str, ...], **more: object) -> Scene:
    """Ground → b1 → b2 … by the joints given."""
    names = [GROUND] + [f"b{i + 1}" for i in range(len(kinds))]
    bodies = tuple(body(names[i + 1], i) for i in range(len(kinds)))
    joints = tuple(joint(f"j{i + 1}", kind, names[i], names[i + 1], i) for i, kind in enumerate(kinds))
    return Scene(name, bodies, joints, **more)  # type: ignore[arg-type]


def floating_tree(base_velocity: str = "world") -> Scene:
    """Like the paper's Fig. 2: a floating body with branches R-R-P and R."""
    bodies = tuple(body(f"b{i}", i) for i in range(1, 6))
    joints = (
        joint("j1", "floating", GROUND, "b1", 0),
        joint("j2", "revolute", "b1", "b2", 1),
        joint("j3", "revolute", "b2", "b3", 2),
        joint("j4", "prismatic", "b3", "b4", 3),
        joint("j7", "revolute", "b1", "b5", 4),
    )
    return Scene("floating_tree", bodies, joints, options=Options(base_velocity=base_velocity))


def coupled(armature: int = 0) -> Scene:
    """The floating tree whose last joint follows the third one, with a damper on it."""
    scene = floating_tree("world")
    follower = replace(scene.joints[4], armature=F(armature), damping=F(1, 2), mimic=Mimic("j3", F(-2), F(1, 3)))
    base = replace(scene.joints[0], armature=F(armature, 3))
    return replace(scene, name="coupled", joints=(base, *scene.joints[1:4], follower))


def every_joint() -> Scene:
    """All types on one tree, a body lumped by a fixed joint, joints listed out of depth-first order."""
    bodies = tuple(body(f"b{i}", i) for i in range(10))
    joints = (
        joint("base", "floating", GROUND, "b0", 0),
        joint("arm", "revolute", "b0", "b1", 1),
        joint("slide", "prismatic", "b0", "b2", 2),
        joint("screw", "helical", "b1", "b3", 3),
        joint("weld", "fixed", "b3", "b9", 1),
        joint("sleeve", "cylindrical", "b9", "b4", 4),
        joint("cross", "universal", "b2", "b5", 5),
        joint("table", "planar", "b5", "b6", 6),
        joint("ball", "spherical", "b1", "b7", 7),
        joint("spin", "continuous", "b7", "b8", 8),
    )
    return Scene("every_joint", bodies, joints)


def sprung() -> Scene:
    """Springs between points, joint springs, damping and armature."""
    bodies = tuple(body(f"b{i}", i) for i in range(1, 4))
    joints = (
        joint("j1", "revolute", GROUND, "b1", 0, damping=F(3, 10), armature=F(1, 20)),
        joint("j2", "prismatic", "b1", "b2", 1, damping=F(1, 5)),
        joint("j3", "universal", "b2", "b3", 2),
    )
    forces = (
        Spring(("b3", GROUND), (vec("1/5", 0, "1/10"), vec(1, 1, 1)), F(20), F(1, 2), F(1, 2)),
        Spring(("b1", "b3"), (vec(0, "1/10", 0), vec("1/10", 0, 0)), F(15), F(1, 5), F(3, 10)),
        JointSpring("j1", F(2), F(1, 20), F(1, 10)),
        JointSpring("j2", F(30), F(1, 10), F(-1, 10)),
    )
    return Scene("sprung", bodies, joints, forces=forces)


def sprung_pendulum() -> Scene:
    """One joint alone and a spring to ground: the smallest Jacobian there is."""
    spring = Spring(("b1", GROUND), (vec(0, 0, "-4/5"), vec(1, 0, 0)), F(10), F(1, 10), F(1, 2))
    return Scene("sprung_pendulum", (body("b1"),), (joint("j1", "revolute", GROUND, "b1", 1),), forces=(spring,))


SINGLES = (
    "revolute",
    "continuous",
    "prismatic",
    "helical",
    "cylindrical",
    "universal",
    "planar",
    "spherical",
    "floating",
)


def single(kind: str, base_velocity: str = "world") -> Scene:
    """The joint from ground, a revolute behind it, so that its velocity-dependent terms matter."""
    scene = chain(f"single_{kind}", (kind, "revolute"))
    return Scene(scene.name, scene.bodies, scene.joints, options=Options(base_velocity=base_velocity))
