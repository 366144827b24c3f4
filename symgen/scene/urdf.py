"""URDF → bodies and joints of a Scene.

Read: links with their inertias, revolute, continuous, prismatic and fixed joints, limits, damping.
Noted and left out: what has no part in the dynamics (visual, collision, …), friction, mimic coupling.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.checks import check_name
from symgen.scene.document import Route, clean
from symgen.scene.exact import decimal, matmul, transpose, unit_vector
from symgen.scene.model import GROUND, Body, Joint, Matrix3, Transform, Vector
from symgen.scene.mounts import Mounts
from symgen.scene.names import identifier
from symgen.scene.schema import did_you_mean
from symgen.scene.xml import Element, parse_xml

ZERO = Fraction(0)
READ = ("revolute", "continuous", "prismatic", "fixed")
NOT_READ = ("floating", "planar")
LIMITS = ("lower", "upper", "velocity", "effort")


@dataclass(frozen=True)
class Model:
    """What a model file says, and where."""

    name: str
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    notes: tuple[str, ...]
    file: str
    elements: tuple[dict[str, Element], ...]
    """Links by name, joints by name."""

    def place(self, route: Route = ()) -> str:
        """``panda.urdf:36: link 'panda_link1'``."""
        kind, index = (*route, "", 0)[:2] if len(route) > 1 else ("", 0)
        items: Sequence[Body | Joint] = self.bodies if kind == "bodies" else self.joints
        if kind not in ("bodies", "joints") or not isinstance(index, int) or index >= len(items):
            return self.file
        element = self.elements[kind == "joints"].get(items[index].name)
        return place(self.file, element) if element else self.file


def place(file: str, element: Element) -> str:
    """``panda.urdf:36: link 'panda_link1'``."""
    name = element.attributes.get("name")
    return f"{file}:{element.line}: {clean(element.tag)}" + (f" {clean(name)!r}" if name else "")


def read_urdf(data: bytes, file: str, floating: bool, mounts: Mounts) -> Model:
    """The robot in a URDF text; its root is welded to ground, or hangs on a floating joint.

    Raises SceneError naming file, line and element; NotSupportedError for MJCF and joints not read yet.
    """
    robot = parse_xml(data, clean(file, 120))
    _check_root(robot, file)
    reader = _Reader(file, mounts)
    links = reader.by_name(robot, "link")
    joints = reader.by_name(robot, "joint")
    if not links:
        raise SceneError("the robot has no link", place(file, robot))
    bodies = [reader.body(link) for link in links.values()]
    read = [reader.joint(joint, links) for joint in joints.values()]
    root = reader.root(links, read, joints)
    edge = Joint(_free_name("floating_base" if floating else "root_joint", joints), "fixed", GROUND, root)
    if floating:
        edge = Joint(edge.name, "floating", GROUND, root)
    name = robot.attributes.get("name", "").strip() or "robot"
    notes = [*reader.notes(robot)]
    if identifier(name) != name:
        notes.append(f"the robot's name {clean(name)!r} became {identifier(name)!r}")
    return Model(identifier(name), tuple(bodies), (edge, *read), tuple(notes), file, (links, joints))


def _check_root(robot: Element, file: str) -> None:
    if robot.tag == "mujoco":
        raise NotSupportedError(f"{file}: MJCF files are not read yet; give a scene (.yaml) or URDF")
    if robot.tag == "sdf":
        raise NotSupportedError(f"{file}: SDF files are not read; give a scene (.yaml) or URDF")
    if robot.tag != "robot":
        raise SceneError(f"the root element is <{clean(robot.tag)}>; URDF starts with <robot>", f"{file}:{robot.line}")
    for child in robot.children:
        if child.tag.startswith("xacro:"):
            raise SceneError(
                f"<{clean(child.tag)}> is a macro; expand the file first: xacro {clean(file)} > model.urdf",
                f"{file}:{child.line}",
            )


def _free_name(name: str, taken: dict[str, Element]) -> str:
    while name in taken:
        name += "_"
    return name


class _Reader:
    """Reads one file; counts what it leaves out."""

    def __init__(self, file: str, mounts: Mounts) -> None:
        self.file = file
        self.mounts = mounts
        self.friction: list[str] = []
        self.mimics: list[str] = []

    def fail(self, element: Element, message: str) -> SceneError:
        return SceneError(message, place(self.file, element))

    def by_name(self, robot: Element, tag: str) -> dict[str, Element]:
        found: dict[str, Element] = {}
        for element in robot.all(tag):
            name = element.attributes.get("name")
            if name is None:
                raise self.fail(element, f"a {tag} needs a name")
            check_name(name, place(self.file, element))
            if name in found:
                raise self.fail(element, f"the name is taken by another {tag} (line {found[name].line})")
            found[name] = element
        return found

    # -- numbers ---------------------------------------------------------------------------------------------------

    def number(self, element: Element, key: str, owner: Element, default: Fraction | None = None) -> Fraction:
        text = element.attributes.get(key)
        if text is None:
            if default is None:
                raise self.fail(owner, f"<{element.tag}> needs the attribute {key!r}")
            return default
        return self._decimal(text.strip(), element, key, owner)

    def vector(self, element: Element | None, key: str, owner: Element, default: str = "0 0 0") -> Vector:
        text = default if element is None else element.attributes.get(key, default)
        words = text.split()
        if len(words) != 3:
            raise self.fail(owner, f"{key}={clean(text)!r} has {len(words)} numbers; 3 are wanted")
        x, y, z = (self._decimal(word, element or owner, key, owner) for word in words)
        return (x, y, z)

    def _decimal(self, text: str, element: Element, key: str, owner: Element) -> Fraction:
        try:
            return decimal(text)
        except ValueError as error:
            raise self.fail(owner, f"{key} of <{clean(element.tag)}>: {clean(str(error), 120)}") from None

    def origin(self, element: Element, owner: Element, label: str, joint: str = "") -> Transform:
        origin = element.find("origin")
        xyz, rpy = self.vector(origin, "xyz", owner), self.vector(origin, "rpy", owner)
        return self.mounts.transform(xyz, rpy, label, joint)

    # -- links -----------------------------------------------------------------------------------------------------

    def body(self, link: Element) -> Body:
        name = link.attributes["name"]
        inertial = link.find("inertial")
        if inertial is None:
            return Body(name)
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        if mass is None or inertia is None:
            raise self.fail(link, f"<inertial> needs <{'mass' if mass is None else 'inertia'}>")
        frame = self.origin(inertial, link, f"inertia of link {name!r}")
        ixx, iyy, izz = (self.number(inertia, key, link) for key in ("ixx", "iyy", "izz"))
        ixy, ixz, iyz = (self.number(inertia, key, link, ZERO) for key in ("ixy", "ixz", "iyz"))
        turned = turn_inertia(frame.rotation, ((ixx, ixy, ixz), (ixy, iyy, iyz), (ixz, iyz, izz)))
        return Body(name, self.number(mass, "value", link), frame.translation, turned)

    # -- joints ----------------------------------------------------------------------------------------------------

    def joint(self, element: Element, links: dict[str, Element]) -> Joint:
        name, kind = element.attributes["name"], element.attributes.get("type", "")
        if kind in NOT_READ:
            at = place(self.file, element)
            raise NotSupportedError(f"{at}: {kind} joints in URDF are not read yet; write the mechanism as a scene")
        if kind not in READ:
            raise self.fail(element, f"unknown joint type {clean(kind)!r}{did_you_mean(kind, READ + NOT_READ)}")
        ends = [self._end(element, side, links) for side in ("parent", "child")]
        origin = self.origin(element, element, f"joint {name!r}", name)
        if kind == "fixed":
            return Joint(name, kind, ends[0], ends[1], origin)
        axis = self.vector(element.find("axis"), "xyz", element, "1 0 0")
        if not any(axis):
            raise self.fail(element, "the axis is zero; a direction is wanted")
        dynamics, limit = element.find("dynamics"), element.find("limit")
        damping = self.number(dynamics, "damping", element, ZERO) if dynamics else ZERO
        if dynamics and self.number(dynamics, "friction", element, ZERO):
            self.friction.append(name)
        if element.find("mimic"):
            self.mimics.append(name)
        limits = [(key, float(self.number(limit, key, element))) for key in LIMITS if limit and key in limit.attributes]
        return Joint(
            name, kind, ends[0], ends[1], origin, axis=unit_vector(axis), damping=damping, limits=tuple(limits)
        )

    def _end(self, joint: Element, side: str, links: dict[str, Element]) -> str:
        element = joint.find(side)
        name = element.attributes.get("link") if element else None
        if name is None:
            raise self.fail(joint, f'needs <{side} link="…"/>')
        if name not in links:
            raise self.fail(joint, f"there is no link {clean(name)!r}{did_you_mean(name, links)}")
        return name

    def root(self, links: dict[str, Element], joints: Sequence[Joint], elements: dict[str, Element]) -> str:
        """The one link that no joint enters. URDF is a tree."""
        entered: dict[str, str] = {}
        for joint in joints:
            if joint.child in entered:
                raise self.fail(
                    elements[joint.name],
                    f"link {clean(joint.child)!r} is already the child of joint {clean(entered[joint.child])!r}; "
                    "URDF is a tree (write closed loops as a scene)",
                )
            entered[joint.child] = joint.name
        roots = [name for name in links if name not in entered]
        if len(roots) == 1:
            return roots[0]
        if not roots:
            raise SceneError("the joints go round in a circle: no link is the root", self.file)
        second = links[roots[1]]
        raise self.fail(second, f"is not connected: no joint enters it, and {clean(roots[0])!r} is the root already")

    # -- notes -----------------------------------------------------------------------------------------------------

    def notes(self, robot: Element) -> list[str]:
        """One line for all that has no part in the dynamics, one each for friction and mimic."""
        unused = Counter(child.tag for child in robot.children if child.tag not in ("link", "joint"))
        for link in robot.all("link"):
            unused.update(child.tag for child in link.children if child.tag != "inertial")
        notes = []
        if unused:
            notes.append("left out: " + ", ".join(f"{n} {clean(tag)}" for tag, n in sorted(unused.items())))
        if self.friction:
            notes.append(f"friction is not modelled: joints {_names(self.friction)}")
        if self.mimics:
            notes.append(f"mimic is not modelled; these joints move on their own: {_names(self.mimics)}")
        return notes


def _names(names: Sequence[str]) -> str:
    return clean(", ".join(names), 300)


Inertia = tuple[Fraction, Fraction, Fraction, Fraction, Fraction, Fraction]


def turn_inertia(rotation: Matrix3, inertia: Matrix3) -> Inertia:
    """R I Rᵀ: an inertia given in turned axes, in the body's axes. Exact."""
    m = matmul(matmul(rotation, inertia), transpose(rotation))
    return (m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])
