"""MJCF → bodies and joints of a Scene, by way of MuJoCo's own reader (`symgen.scene.mjcf_process`).

Read: bodies with the inertias that MuJoCo computes, hinge, slide, ball and free joints (several in a body are a chain
of massless bodies), reference positions, springs, dampers, armature, limits, sites, gravity. Everything else that a
file has is counted in one note.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from symgen.errors import SceneError
from symgen.scene.document import clean
from symgen.scene.exact import cross, unit_vector
from symgen.scene.mjcf_exact import ROUNDING, exact_inertia, exact_turn, settled
from symgen.scene.mjcf_names import body_names, joined, joint_names, unused
from symgen.scene.mjcf_process import MAX_BODIES, Compiled, CompiledBody, CompiledJoint, compile_mjcf
from symgen.scene.model import GROUND, ZERO3, Body, Frame, Joint, JointSpring, Transform, Vector
from symgen.scene.models import Model, place
from symgen.scene.mounts import Mounts, compose
from symgen.scene.names import identifier
from symgen.scene.xml import MAX_ELEMENTS, Element

UNNAMED = "MuJoCo Model"
"""What MuJoCo calls a model without a name."""

KINDS = {"hinge": "revolute", "slide": "prismatic", "ball": "spherical", "free": "floating"}


def read_mjcf(root: Element, path: Path, floating: bool, mounts: Mounts) -> Model:
    """The model of an MJCF file. ``root`` is its text, read already; ``floating`` puts its root body on a free joint.

    Raises SceneError naming file and element; ToolError when MuJoCo is not installed.
    """
    file = clean(path.name, 120)
    _check_size(root, file)
    compiled = compile_mjcf(path, file)
    elements = {"bodies": _by_name(root, ("body",)), "joints": _by_name(root, ("joint", "freejoint"))}
    reader = _Reader(compiled, mounts, file, elements)
    for index in range(1, len(compiled.bodies)):
        reader.body(index)
    if floating:
        reader.free_root()
    frames = tuple(reader.frames())
    title = compiled.name if compiled.name not in ("", UNNAMED) else path.stem
    name = identifier(title)
    roots = [body for body in compiled.bodies[1:] if body.parent == 0]
    return Model(
        name,
        tuple(reader.bodies),
        tuple(reader.joints),
        tuple(reader.notes(title, name)),
        file,
        forces=tuple(reader.springs),
        frames=frames,
        gravity=(compiled.gravity[0], compiled.gravity[1], compiled.gravity[2]),
        weld=reader.joints[0].name if len(roots) == 1 and reader.joints[0].type == "fixed" else "",
        elements=elements,
    )


def _check_size(root: Element, file: str) -> None:
    """Raise SceneError for more than MuJoCo makes in seconds; ``replicate`` multiplies what is in it."""
    bodies = elements = 0
    waiting = [(element, 1) for element in root.all("worldbody")]
    while waiting:
        element, times = waiting.pop()
        elements += times
        bodies += times if element.tag == "body" else 0
        for counted, most, what in ((bodies, MAX_BODIES, "bodies"), (elements, MAX_ELEMENTS, "elements")):
            if counted > most:
                raise SceneError(f"has more than {most} {what}", f"{file}:{element.line}")
        if element.tag == "replicate":
            count = element.attributes.get("count", "1").strip()[:10]
            times *= int(count) if count.isascii() and count.isdigit() else 1
        waiting.extend((child, times) for child in element.children)


def _inside(root: Element, tags: tuple[str, ...]) -> Iterator[Element]:
    """The elements of these tags inside the file's <worldbody>."""
    waiting = list(root.all("worldbody"))
    while waiting:
        element = waiting.pop()
        waiting.extend(element.children)
        if element.tag in tags:
            yield element


def _by_name(root: Element, tags: tuple[str, ...]) -> dict[str, Element]:
    found: dict[str, Element] = {}
    for element in _inside(root, tags):
        if "name" in element.attributes:
            found.setdefault(element.attributes["name"], element)
    return found


@dataclass
class _Reader:
    """Collects the parts of one model, body by body in MuJoCo's (depth first) order."""

    compiled: Compiled
    mounts: Mounts
    file: str
    elements: Mapping[str, Mapping[str, Element]]
    bodies: list[Body] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    springs: list[JointSpring] = field(default_factory=list)
    near: dict[str, float] = field(default_factory=dict)
    left_out: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        found = self.compiled
        self.names = body_names([body.name for body in found.bodies])
        owners = [self.names[joint.body] for joint in found.joints]
        self.joint_names = joint_names([j.name for j in found.joints], [j.type for j in found.joints], owners)
        self.taken_bodies = {*self.names}
        self.taken_joints = {GROUND, *self.joint_names}
        places = [(*body.position, *body.com) for body in found.bodies]
        self.size = max((abs(x) for place in places for x in place), default=Fraction(1))

    # -- bodies and joints -----------------------------------------------------------------------------------------

    def body(self, index: int) -> None:
        """One body and the joints that carry it, or the weld that holds it."""
        given, name = self.compiled.bodies[index], self.names[index]
        carried = [k for k, joint in enumerate(self.compiled.joints) if joint.body == index]
        com = settled(given.com, self.size)
        if carried and self.compiled.joints[carried[0]].type == "free":
            self._add(Joint(self.joint_names[carried[0]], "floating", GROUND, name), carried[0])
        elif carried:
            self._chain(given, name, carried)
        else:
            joint = unused(joined(name, "weld"), self.taken_joints)
            origin = self._mount(given.position, given.quaternion, f"body {name!r}", joint)
            self.joints.append(Joint(joint, "fixed", self.names[given.parent], name, origin))
        self.bodies.append(Body(name, given.mass, com, exact_inertia(given)))

    def _chain(self, given: CompiledBody, name: str, carried: Sequence[int]) -> None:
        """Joints one after the other, massless bodies between them. The last body's frame is MuJoCo's.

        MuJoCo's hinges turn about an anchor in the body; the joint frame sits there, at ``offset`` from the body's.
        """
        first = self.joint_names[carried[0]]
        origin = self._mount(given.position, given.quaternion, f"body {name!r}", first)
        parent, offset = self.names[given.parent], ZERO3
        for k in carried:
            joint, axis = self.compiled.joints[k], self._axis(self.compiled.joints[k])
            anchor = settled(joint.anchor, self.size)
            choices = (ZERO3, offset, anchor) if k == carried[-1] else (offset, ZERO3, anchor)
            place = next(choice for choice in choices if _serves(choice, joint.type, anchor, axis))
            moved = compose(origin, Transform(translation=_difference(place, offset)))
            child = name
            if k != carried[-1] or place != ZERO3:
                label = self.joint_names[k]
                child = unused(label if label.startswith(name) else joined(name, label), self.taken_bodies)
                self.bodies.append(Body(child))
            turning = axis if joint.type in ("hinge", "slide") else None
            self._add(Joint(self.joint_names[k], KINDS[joint.type], parent, child, moved, turning), k)
            parent, offset, origin = child, place, Transform()
        if offset != ZERO3:
            mount = unused(joined(name, "mount"), self.taken_joints)
            back = Transform(translation=_difference(ZERO3, offset))
            self.joints.append(Joint(mount, "fixed", parent, name, back))

    def _axis(self, joint: CompiledJoint) -> Vector:
        if not any(joint.axis):  # of MuJoCo's own arithmetic, on an axis beyond the range of its numbers
            raise SceneError(f"joint {clean(joint.name)!r} has no axis", self.file)
        return unit_vector(settled(joint.axis, Fraction(1)))

    def _add(self, joint: Joint, k: int) -> None:
        """The joint with the numbers of MuJoCo's ``k``-th, and its spring."""
        given = self.compiled.joints[k]
        limits: list[tuple[str, float]] = []
        if given.range:
            limits += [("lower", float(given.range[0] - given.reference))]
            limits += [("upper", float(given.range[1] - given.reference))]
        if given.force_range and given.force_range[0] == -given.force_range[1]:
            limits += [("effort", float(given.force_range[1]))]
        self.joints.append(
            Joint(
                joint.name, joint.type, joint.parent, joint.child, joint.origin, joint.axis,
                armature=given.armature, damping=given.damping, limits=tuple(limits),
            )
        )  # fmt: skip
        if given.stiffness < 0:
            element = self.elements["joints"].get(joint.name)
            where = place(self.file, element) if element else self.file
            message = f"joint {clean(joint.name)!r} has the negative stiffness {float(given.stiffness):.12g}"
            raise SceneError(message, where)
        if given.stiffness and given.type in ("hinge", "slide"):
            rest = given.spring_reference - given.reference
            name = unused(joined(joint.name, "spring"), self.taken_joints)
            self.springs.append(JointSpring(joint.name, given.stiffness, rest=rest, name=name))

    def _mount(self, position: Sequence[Fraction], quaternion: Sequence[Fraction], owner: str, joint: str) -> Transform:
        """The exact pose of a frame in its parent's; what snapping changed is written down."""
        turn = exact_turn(quaternion, self.mounts.snap)
        label = clean(owner)
        if turn.snapped > ROUNDING:
            self.mounts.snapped[label] = turn.snapped
            if joint:
                self.mounts.raw[joint] = turn.raw
        if turn.near > ROUNDING:
            self.near[label] = turn.near
        return Transform(turn.matrix, settled(position, self.size))

    # -- the root --------------------------------------------------------------------------------------------------

    def free_root(self) -> None:
        """``base: floating``: the weld between ground and the one root body becomes a floating joint."""
        moving = {self.names[joint.body] for joint in self.compiled.joints}
        roots = [k for k, joint in enumerate(self.joints) if joint.parent == GROUND]
        if len(roots) > 1:  # what merely stands in the world is no root
            roots = [k for k in roots if self._carries(self.joints[k].child, moving)]
        if len(roots) != 1:
            many = f"{len(roots)} bodies on the world that move or carry what moves" if roots else "nothing that moves"
            raise SceneError(f"base: floating needs one root body; the model has {many}", self.file)
        joint = self.joints[roots[0]]
        if joint.type == "floating":
            return
        if joint.type != "fixed":
            raise SceneError(
                f"base: floating needs a root body without joints; {clean(joint.child)!r} has {clean(joint.name)!r}",
                self.file,
            )
        self.taken_joints.discard(joint.name)
        self.mounts.raw.pop(joint.name, None)
        name = unused("floating_base", self.taken_joints)
        self.joints[roots[0]] = Joint(name, "floating", GROUND, joint.child)

    def _carries(self, body: str, moving: set[str]) -> bool:
        waiting = [body]
        while waiting:
            name = waiting.pop()
            if name in moving or name not in self.names:
                return True
            waiting.extend(joint.child for joint in self.joints if joint.parent == name)
        return False

    # -- frames and notes ------------------------------------------------------------------------------------------

    def frames(self) -> Iterator[Frame]:
        """Sites with names that no body has."""
        for site in self.compiled.sites:
            if not site.name or site.name in self.taken_bodies:
                what = "site whose name a body has" if site.name else "site without a name"
                self.left_out[what] = self.left_out.get(what, 0) + 1
                continue
            self.taken_bodies.add(site.name)
            origin = self._mount(site.position, site.quaternion, f"site {site.name!r}", "")
            yield Frame(site.name, self.names[site.body], origin)

    def notes(self, title: str, name: str) -> Iterator[str]:
        """One line for all that is not modelled; lines for what a user must know to use the numbers."""
        held = {**self.compiled.held, **self.left_out}
        linear = held.pop("linear joint equality", 0)
        counted = [f"{count} {what}" for what, count in sorted(held.items())]
        if counted:
            advice = f" (linear couplings of joints among the constraints: {linear}; a scene can have them as mimic)"
            yield "not modelled: " + ", ".join(counted) + (advice if linear else "")
        shifted = [
            f"{clean(name)!r} ({float(joint.reference):g})"
            for name, joint in zip(self.joint_names, self.compiled.joints, strict=True)
            if joint.reference
        ]
        if shifted:
            yield clean(f"positions count from MuJoCo's ref, q = qpos - ref, in joint {', '.join(shifted)}", 1000)
        if GROUND in (body.name for body in self.compiled.bodies[1:]):
            index = [body.name for body in self.compiled.bodies].index(GROUND, 1)
            yield f"body {GROUND!r} is called {self.names[index]!r} here: {GROUND!r} is the fixed world"
        if self.near:
            owners = ", ".join(f"{owner} ({angle:.1e} rad)" for owner, angle in self.near.items())
            snap = f"{float(self.mounts.snap):g} rad"
            yield clean(f"rotations near quarter turns, but not within the snap angle {snap}: {owners}", 1000)
        if name != title:
            yield f"the model's name {clean(title)!r} became {name!r}"


def _serves(place: Vector, kind: str, anchor: Vector, axis: Vector) -> bool:
    """Whether a joint frame at ``place`` moves the body as one at the anchor does."""
    if kind == "slide":
        return True
    away = _difference(anchor, place)
    return not any(cross(away, axis)) if kind == "hinge" else not any(away)


def _difference(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
