"""URDF → bodies and joints of a Scene.

Read: links with their inertias; revolute, continuous, prismatic, fixed, floating and planar joints; limits, damping,
mimic. What a file has beyond that (visual, collision, friction, …) is counted in one note.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

from symgen.errors import SceneError
from symgen.scene.checks import check_name
from symgen.scene.document import clean
from symgen.scene.exact import decimal, matmul, transpose, turn_to, unit_vector
from symgen.scene.model import GROUND, IDENTITY3, ZERO3, Body, Joint, Matrix3, Mimic, Transform, Vector
from symgen.scene.models import Model, place
from symgen.scene.mounts import Mounts, compose, compose_floats
from symgen.scene.names import identifier
from symgen.scene.schema import did_you_mean
from symgen.scene.xml import Element

ZERO, ONE = Fraction(0), Fraction(1)
READ = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
LIMITS = ("lower", "upper", "velocity", "effort")
MAX_LINKS = 3000
"""Far beyond what can be derived; reading a file of some ten thousand would take a minute."""
PARTS = {
    "robot": ("link", "joint"),
    "link": ("inertial",),
    "joint": ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic"),
}
"""What is read inside an element; the rest is counted."""


def read_urdf(robot: Element, file: str, floating: bool, mounts: Mounts) -> Model:
    """The robot of a URDF file; its root is welded to ground, or hangs on a floating joint.

    Raises SceneError naming file, line and element.
    """
    refuse_macros(robot, file)
    reader = _Reader(file, mounts)
    links = reader.by_name(robot, "link")
    elements = reader.by_name(robot, "joint")
    if not links:
        expanded = "; its xacro source was expanded without a call of the macro that makes it"
        raise SceneError("the robot has no link" + expanded * ("xmlns:xacro" in robot.attributes), place(file, robot))
    bodies = [reader.body(name, link) for name, link in links.items()]
    joints = [reader.joint(name, element) for name, element in elements.items()]
    root = reader.root(joints)
    joints = [reader.from_ground(joint, root, joints) for joint in joints]
    notes = [reader.summary(robot), *reader.renamed()]
    free = next((joint for joint in joints if joint.type == "floating"), None)
    if floating and free is not None:
        notes.append(f"base: floating is what the model has already: joint {clean(free.name)!r}")
        floating = False
    edge = Joint(_free_name("root_joint", elements), "fixed", GROUND, root)
    if floating:
        edge = Joint(_free_name("floating_base", elements), "floating", GROUND, root)
    name = robot.attributes.get("name", "").strip() or "robot"
    if identifier(name) != name:
        notes.append(f"the robot's name {clean(name)!r} became {identifier(name)!r}")
    turned, planes = _on_planes(joints, links, mounts)
    return Model(
        identifier(name),
        (*bodies, *planes),
        (edge, *turned),
        tuple(note for note in notes if note),
        file,
        weld=edge.name,
        elements={"bodies": links, "joints": elements},
    )


def refuse_macros(robot: Element, file: str) -> None:
    """Raise SceneError where a xacro macro is left that decides what the robot is."""
    owners = [robot, *(part for part in robot.children if part.tag in ("link", "joint"))]
    owners += [part for link in robot.all("link") for part in link.all("inertial")]
    for owner in owners:
        for child in owner.children:
            if child.tag.startswith("xacro:"):
                raise SceneError(f"<{clean(child.tag)}> is a macro; {expand(file)}", f"{file}:{child.line}")


def expand(file: str) -> str:
    """How to make a URDF of a xacro file."""
    return f"expand the file first: xacro {clean(file)} > model.urdf (pip install xacro)"


def _free_name(name: str, taken: Iterable[str]) -> str:
    known = set(taken)
    while name in known:
        name += "_"
    return name


class _Reader:
    """Reads one file; remembers what it leaves out."""

    def __init__(self, file: str, mounts: Mounts) -> None:
        self.file = file
        self.mounts = mounts
        self.unread: Counter[str] = Counter()
        self.aliases: dict[str, dict[str, str]] = {"link": {}, "joint": {}}
        self.elements: dict[str, dict[str, Element]] = {}

    def fail(self, element: Element, message: str) -> SceneError:
        return SceneError(message, place(self.file, element))

    def by_name(self, robot: Element, tag: str) -> dict[str, Element]:
        """Name → element; one called ``ground``, the name of the fixed world, gets another name."""
        found: dict[str, Element] = {}
        for element in robot.all(tag):
            name = element.attributes.get("name")
            if name is None:
                raise self.fail(element, f"a {tag} needs a name")
            if name != GROUND:
                check_name(name, place(self.file, element))
            if name in found:
                raise self.fail(element, f"the name is taken by another {tag} (line {found[name].line})")
            if len(found) == MAX_LINKS:
                raise self.fail(element, f"is one too many: at most {MAX_LINKS} {tag}s are read")
            found[name] = element
        if GROUND in found:
            other = self.aliases[tag][GROUND] = _free_name(f"{GROUND}_", found)
            found = {other if name == GROUND else name: element for name, element in found.items()}
        self.elements[tag] = found
        return found

    def named(self, name: str, tag: str, owner: Element) -> str:
        """What the file calls ``name``, by its name here; SceneError when there is no such link or joint."""
        here = self.aliases[tag].get(name, name)
        if here not in self.elements[tag]:
            raise self.fail(owner, f"there is no {tag} {clean(name)!r}{did_you_mean(name, self.elements[tag])}")
        return here

    def renamed(self) -> Iterator[str]:
        for tag, aliases in self.aliases.items():
            for old, new in aliases.items():
                yield f"{tag} {old!r} is called {new!r} here: {old!r} is the fixed world"

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
        if len(words) != 3 and "${" not in text:
            raise self.fail(owner, f"{key}={clean(text)!r} has {len(words)} numbers; 3 are wanted")
        x, y, z = (self._decimal(word, element or owner, key, owner) for word in words)
        return (x, y, z)

    def _decimal(self, text: str, element: Element, key: str, owner: Element) -> Fraction:
        try:
            return decimal(text)
        except ValueError as error:
            macro = f"; {expand(self.file)}" if "${" in text else ""
            message = f"{key} of <{clean(element.tag)}>: {clean(str(error), 120)}{macro}"
            raise self.fail(owner, message) from None

    def origin(self, element: Element, owner: Element, label: str, joint: str = "") -> Transform:
        origin = element.find("origin")
        xyz, rpy = self.vector(origin, "xyz", owner), self.vector(origin, "rpy", owner)
        return self.mounts.transform(xyz, rpy, label, joint)

    # -- links -----------------------------------------------------------------------------------------------------

    def body(self, name: str, link: Element) -> Body:
        self._count(link, PARTS["link"])
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

    def joint(self, name: str, element: Element) -> Joint:
        kind = element.attributes.get("type", "")
        if kind not in READ:
            raise self.fail(element, f"unknown joint type {clean(kind)!r}{did_you_mean(kind, READ)}")
        self._count(element, PARTS["joint"])
        parent, child = (self._end(element, side) for side in ("parent", "child"))
        plain = Joint(name, kind, parent, child, self.origin(element, element, f"joint {name!r}", name))
        if kind == "fixed":
            self.unread["mimic of a fixed joint"] += element.find("mimic") is not None
            return plain
        dynamics, limit = element.find("dynamics"), element.find("limit")
        if dynamics and self.number(dynamics, "friction", element, ZERO):
            self.unread["friction"] += 1
        return replace(
            plain,
            axis=None if kind == "floating" else self._axis(element),
            damping=self.number(dynamics, "damping", element, ZERO) if dynamics else ZERO,
            limits=self._limits(element, limit) if limit else (),
            mimic=self._mimic(element),
        )

    def _limits(self, element: Element, limit: Element) -> tuple[tuple[str, float], ...]:
        """Those that the file gives; an infinite one is none."""
        given = {key: limit.attributes[key].strip() for key in LIMITS if key in limit.attributes}
        finite = [key for key, text in given.items() if text.lower().strip("+-") not in ("inf", "infinity")]
        return tuple((key, float(self.number(limit, key, element))) for key in finite)

    def _axis(self, element: Element) -> Vector:
        axis = self.vector(element.find("axis"), "xyz", element, "1 0 0")
        if not any(axis):
            raise self.fail(element, "the axis is zero; a direction is wanted")
        return unit_vector(axis)

    def _mimic(self, element: Element) -> Mimic | None:
        mimic = element.find("mimic")
        if mimic is None:
            return None
        name = mimic.attributes.get("joint")
        if name is None:
            raise self.fail(element, "<mimic> needs the attribute 'joint'")
        multiplier = self.number(mimic, "multiplier", element, ONE)
        name = self.aliases["joint"].get(name, name)  # checked later: a scene may remove or lock what is wrong
        return Mimic(name, multiplier, self.number(mimic, "offset", element, ZERO))

    def _end(self, joint: Element, side: str) -> str:
        element = joint.find(side)
        name = element.attributes.get("link") if element else None
        if name is None:
            raise self.fail(joint, f'needs <{side} link="…"/>')
        return self.named(name, "link", joint)

    def root(self, joints: Sequence[Joint]) -> str:
        """The one link that no joint enters. URDF is a tree."""
        links, entered = self.elements["link"], dict[str, str]()
        for joint in joints:
            if joint.child in entered:
                raise self.fail(
                    self.elements["joint"][joint.name],
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

    def from_ground(self, joint: Joint, root: str, joints: Sequence[Joint]) -> Joint:
        """A floating joint, which here starts at ground: the fixed joints before it become part of its origin."""
        if joint.type != "floating":
            return joint
        entering = {other.child: other for other in joints}
        origin, link, passed = joint.origin, joint.parent, set[str]()
        while link not in passed and link != root and entering[link].type == "fixed":
            passed.add(link)
            origin, link = compose(entering[link].origin, origin), entering[link].parent
        if link != root:
            raise self.fail(
                self.elements["joint"][joint.name],
                f"is floating, so it can start at the root link (or what is fixed to it) only; {clean(joint.parent)!r} "
                f"moves by joint {clean(entering[link].name)!r}",
            )
        if passed:
            self.mounts.raw.pop(joint.name, None)
        return replace(joint, parent=GROUND, origin=origin)

    # -- notes -----------------------------------------------------------------------------------------------------

    def _count(self, element: Element, read: Sequence[str]) -> None:
        self.unread.update(clean(child.tag) for child in element.children if child.tag not in read)

    def summary(self, robot: Element) -> str:
        """One line for all that the file has and that has no part in the model."""
        self._count(robot, PARTS["robot"])
        counted = [f"{n} {what}" for what, n in sorted(self.unread.items()) if n]
        return "not modelled: " + ", ".join(counted) if counted else ""


def _on_planes(joints: Sequence[Joint], links: Iterable[str], mounts: Mounts) -> tuple[list[Joint], list[Body]]:
    """Planar joints, whose plane here is the joint frame's x and y: the frame is turned until its z is URDF's normal,
    and a massless link turned back lets the child keep its frame."""
    names = {joint.name for joint in joints}
    taken = set(links)
    result: list[Joint] = []
    planes: list[Body] = []
    for joint in joints:
        if joint.type != "planar" or joint.axis is None:
            result.append(joint)
            continue
        turn = turn_to(joint.axis)
        if turn == IDENTITY3:
            result.append(replace(joint, axis=None))
            continue
        if joint.name in mounts.raw:
            mounts.raw[joint.name] = compose_floats(mounts.raw[joint.name], turn)
        plane, weld = _free_name(f"{joint.name}_plane", taken), _free_name(f"{joint.name}_weld", names)
        taken.add(plane)
        names.add(weld)
        planes.append(Body(plane))
        origin = compose(joint.origin, Transform(turn))
        result.append(replace(joint, child=plane, origin=origin, axis=None))
        result.append(Joint(weld, "fixed", plane, joint.child, Transform(transpose(turn), ZERO3)))
    return result, planes


Inertia = tuple[Fraction, Fraction, Fraction, Fraction, Fraction, Fraction]


def turn_inertia(rotation: Matrix3, inertia: Matrix3) -> Inertia:
    """R I Rᵀ: an inertia given in turned axes, in the body's axes. Exact."""
    m = matmul(matmul(rotation, inertia), transpose(rotation))
    return (m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])
