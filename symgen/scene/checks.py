"""What a scene must be beyond its shape: references, physics, topology. Exact arithmetic throughout.

Every loader and the builder end here, so whatever is downstream may rely on it. The first thing wrong
is raised as one SceneError; what a user should merely know is returned as notes.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from fractions import Fraction

import numpy as np

from symgen.errors import SceneError
from symgen.scene.document import Places, clean
from symgen.scene.exact import cross
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.mimics import check_mimics
from symgen.scene.model import GROUND, Body, Joint, JointSpring, Scene, Spring
from symgen.scene.schema import did_you_mean

MAX_NAME = 200


def check_scene(scene: Scene, places: Places, published: Set[str] | None = None, locked: bool = False) -> list[str]:
    """Raise SceneError for the first mistake; return notes.

    ``published``: bodies that come from a model file. An inertia that no rigid body can have is noted for these, not
    refused, and where there are any, bodies and joints have separate name spaces. ``locked``: joints were locked or
    removed, so a force that can do nothing is no mistake.
    """
    if scene.name.lower() == "main":
        raise SceneError("a scene cannot be called 'main': that is the example program", places.place(("name",)))
    _check_names(scene, places, separate=published is not None)
    known = frozenset((GROUND, *(body.name for body in scene.bodies)))
    notes = _check_bodies(scene.bodies, places, published or frozenset())
    for i, joint in enumerate(scene.joints):
        _check_joint(joint, i, known, places)
    check_tree(scene, places)
    check_mimics(scene.joints, places)
    if not any(JOINT_TYPES[joint.type].nq for joint in scene.joints):
        free = "; 'base: floating' in a scene over this model frees it" if published is not None else ""
        raise SceneError(f"no joint can move (every one is fixed): nothing to derive{free}", places.place(("joints",)))
    for i, force in enumerate(scene.forces):
        _check_force(force, i, known, scene, places)
        if not locked and is_idle(force, scene):
            raise SceneError("can do nothing: what it acts on cannot move", places.place(("forces", i)))
    for i, frame in enumerate(scene.frames):
        _check_reference(frame.body, known, places.place(("frames", i, "body")))
    return notes + massless_ends(scene)


def _check_names(scene: Scene, places: Places, separate: bool) -> None:
    """No name twice: one name space for all, or (``separate``) one for bodies and frames, one for joints and forces."""
    seen: dict[tuple[str, str], str] = {}
    for kind, space, items in (
        ("bodies", "frame", scene.bodies),
        ("joints", "joint", scene.joints),
        ("frames", "frame", scene.frames),
        ("forces", "joint", scene.forces),
    ):
        for i, item in enumerate(items):
            route = (kind, i, "name")
            if not item.name and kind == "forces":
                continue
            check_name(item.name, places.place(route))
            key = (space if separate else "", item.name)
            if key in seen:
                owner = f"another {_SINGULAR[kind]}" if seen[key] == kind else f"a {_SINGULAR[seen[key]]}"
                raise SceneError(f"the name {clean(item.name)!r} is taken by {owner}", places.place(route))
            seen[key] = kind


_SINGULAR = {"bodies": "body", "joints": "joint", "frames": "frame", "forces": "force"}


def check_name(name: str, place: str) -> None:
    """A name must be printable, not too long, and not ``ground``."""
    if name == GROUND:
        raise SceneError(f"the name {GROUND!r} is reserved for the fixed world", place)
    if not name.strip() or len(name) > MAX_NAME or not name.isprintable():
        raise SceneError(f"{clean(name)!r} cannot be a name: 1 to {MAX_NAME} printable characters are wanted", place)


# -- bodies --------------------------------------------------------------------------------------------------------


def _check_bodies(bodies: Sequence[Body], places: Places, published: Set[str]) -> list[str]:
    """Refuse what no body can be; of published bodies, note it in one line."""
    flaws: dict[str, list[str]] = {}
    for i, body in enumerate(bodies):
        label = f"body {clean(body.name)!r}"
        if body.mass < 0:
            message = f"{label} has the negative mass {float(body.mass):.12g}"
            raise SceneError(message, places.place(("bodies", i, "mass")))
        flaw = inertia_flaw(body) if any(body.inertia) else None
        if flaw is None:
            continue
        if body.name not in published:
            raise SceneError(f"{label} has {flaw[0]}{flaw[1]}", places.place(("bodies", i, "inertia")))
        flaws.setdefault(flaw[0], []).append(clean(body.name))
    if not flaws:
        return []
    found = "; ".join(f"{flaw}: {', '.join(names)}" for flaw, names in flaws.items())
    return [f"inertias that no rigid body has, used as given: {found}"]


def inertia_flaw(body: Body) -> tuple[str, str] | None:
    """Why no distribution of mass has this inertia (what it is, with which numbers), or None.

    Exact: minors of Σ = ½ tr(I)·1 − I over the rationals.
    """
    if body.mass == 0:
        return "inertia but no mass", ""
    ixx, iyy, izz, ixy, ixz, iyz = body.inertia
    inertia = ((ixx, ixy, ixz), (ixy, iyy, iyz), (ixz, iyz, izz))
    if not is_semidefinite(inertia):
        return "an inertia that is not positive semidefinite", f" (principal moments {_moments(inertia)})"
    half = (ixx + iyy + izz) / 2
    sigma = ((half - ixx, -ixy, -ixz), (-ixy, half - iyy, -iyz), (-ixz, -iyz, half - izz))
    if not is_semidefinite(sigma):
        moments = f": of the principal moments {_moments(inertia)} the largest exceeds the sum of the others"
        return "an inertia that violates the triangle inequality", moments
    return None


def is_semidefinite(m: Sequence[Sequence[Fraction]]) -> bool:
    """Symmetric 3×3, exact: all seven principal minors are non-negative."""
    pairs = ((0, 1), (0, 2), (1, 2))
    determinant = (
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] ** 2)
        - m[0][1] * (m[0][1] * m[2][2] - m[1][2] * m[0][2])
        + m[0][2] * (m[0][1] * m[1][2] - m[1][1] * m[0][2])
    )
    minors = [m[i][i] for i in range(3)] + [m[i][i] * m[j][j] - m[i][j] ** 2 for i, j in pairs] + [determinant]
    return all(minor >= 0 for minor in minors)


def _moments(inertia: Sequence[Sequence[Fraction]]) -> str:
    values = np.linalg.eigvalsh(np.array([[float(x) for x in row] for row in inertia]))
    return ", ".join(f"{x:.6g}" for x in values)


# -- joints --------------------------------------------------------------------------------------------------------


def _check_joint(joint: Joint, i: int, known: Set[str], places: Places) -> None:
    label = f"joint {clean(joint.name)!r}"

    def fail(field: str, message: str) -> SceneError:
        return SceneError(f"{label} {message}", places.place(("joints", i, field)))

    for field, body in (("parent", joint.parent), ("child", joint.child)):
        _check_reference(body, known, places.place(("joints", i, field)), f"{label}: ")
    if joint.child == GROUND:
        raise fail("child", "has 'ground' as its child; swap parent and child")
    if joint.parent == joint.child:
        raise fail("child", f"connects {clean(joint.child)!r} to itself")
    if joint.type == "floating" and joint.parent != GROUND:
        raise fail("parent", "is floating, so its parent must be 'ground'")
    if joint.axis is not None and joint.axis2 is not None and not any(cross(joint.axis, joint.axis2)):
        raise fail("axis2", "has parallel axes; a universal joint needs two directions")
    if joint.type == "helical" and joint.pitch == 0:
        raise fail("pitch", "has pitch 0; that is a revolute joint")
    for field, value in (("damping", joint.damping), ("armature", joint.armature)):
        if value < 0:
            raise fail(field, f"has the negative {field} {float(value):.12g}")


def _check_reference(body: str, known: Set[str], place: str, owner: str = "") -> None:
    if body not in known:
        raise SceneError(f"{owner}there is no body {clean(body)!r}{did_you_mean(body, sorted(known))}", place)


# -- graph ---------------------------------------------------------------------------------------------------------


def check_tree(scene: Scene, places: Places) -> None:
    """Every body can be reached from ground along joints that are not cut, parent to child."""
    reached = _reach(scene, [joint for joint in scene.joints if not joint.cut])
    missing = [i for i, body in enumerate(scene.bodies) if body.name not in reached]
    if not missing:
        return
    everything = _reach(scene, scene.joints)
    for i, joint in enumerate(scene.joints):
        if joint.cut and joint.child in everything and joint.child not in reached and joint.parent in reached:
            raise SceneError(
                f"joint {clean(joint.name)!r} cannot be cut: it lies on no closed loop that keeps "
                f"{clean(joint.child)!r} connected without it",
                places.place(("joints", i, "cut")),
            )
    for i, joint in enumerate(scene.joints):
        if joint.child in everything and joint.parent not in everything:
            raise SceneError(
                f"joint {clean(joint.name)!r} points toward ground: {clean(joint.child)!r} is nearer to it than "
                f"{clean(joint.parent)!r}; swap parent and child",
                places.place(("joints", i)),
            )
    raise SceneError(
        f"body {clean(scene.bodies[missing[0]].name)!r} is not connected to ground by any chain of joints",
        places.place(("bodies", missing[0])),
    )


def _reach(scene: Scene, joints: Sequence[Joint]) -> set[str]:
    """Bodies that can be reached from ground, parent to child."""
    children: dict[str, list[str]] = {}
    for joint in joints:
        children.setdefault(joint.parent, []).append(joint.child)
    reached, stack = {GROUND}, [GROUND]
    while stack:
        for child in children.get(stack.pop(), ()):
            if child not in reached:
                reached.add(child)
                stack.append(child)
    return reached


def fixed_to_ground(scene: Scene) -> set[str]:
    """Ground and every body that hangs on it by fixed joints only."""
    return _reach(scene, [joint for joint in scene.joints if joint.type == "fixed"])


def massless_ends(scene: Scene) -> list[str]:
    """A note for every joint that moves nothing with mass: its row of the mass matrix is zero."""
    entering: dict[str, list[str]] = {}
    for joint in scene.joints:
        entering.setdefault(joint.child, []).append(joint.parent)
        if joint.type == "fixed":
            entering.setdefault(joint.parent, []).append(joint.child)
    heavy = {body.name for body in scene.bodies if body.mass}
    stack = list(heavy)
    while stack:
        for parent in entering.get(stack.pop(), ()):
            if parent not in heavy:
                heavy.add(parent)
                stack.append(parent)
    return [
        f"joint {clean(joint.name)!r} moves nothing that has mass: the mass matrix is singular and forward_dynamics NaN"
        for joint in scene.joints
        if joint.type != "fixed" and not joint.armature and joint.child not in heavy
    ]


# -- forces and frames ---------------------------------------------------------------------------------------------


def _check_force(force: Spring | JointSpring, i: int, known: Set[str], scene: Scene, places: Places) -> None:
    for field, value in (("stiffness", force.stiffness), ("damping", force.damping)):
        if value < 0:
            raise SceneError(f"is {float(value):.12g}; it cannot be negative", places.place(("forces", i, field)))
    if isinstance(force, Spring):
        _check_spring(force, i, known, scene, places)
        return
    place = places.place(("forces", i, "joint"))
    joints = {joint.name: joint for joint in scene.joints}
    if force.joint not in joints:
        moving = [joint.name for joint in scene.joints if joint.type != "fixed"]
        raise SceneError(f"there is no joint {clean(force.joint)!r}{did_you_mean(force.joint, moving)}", place)
    kind = joints[force.joint].type
    if kind in ("spherical", "floating"):
        raise SceneError(f"a {kind} joint has no coordinate for a joint spring; use a spring between points", place)


def is_idle(force: Spring | JointSpring, scene: Scene) -> bool:
    """A spring on a fixed joint, or between two things that cannot move."""
    if isinstance(force, JointSpring):
        return scene.joint(force.joint).type == "fixed"
    return set(force.between) <= fixed_to_ground(scene)


def _check_spring(force: Spring, i: int, known: Set[str], scene: Scene, places: Places) -> None:
    for k, body in enumerate(force.between):
        _check_reference(body, known, places.place(("forces", i, "between", k)))
    if force.between[0] == force.between[1]:
        raise SceneError(
            f"the spring connects {clean(force.between[0])!r} to itself", places.place(("forces", i, "between"))
        )
    if force.length < 0:
        raise SceneError("the length of a spring cannot be negative", places.place(("forces", i, "length")))
