"""A model file (URDF; MJCF by its own reader) as parts of a Scene: what it holds, and where in the file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.document import clean
from symgen.scene.model import Body, Frame, Joint, JointSpring, Spring, Vector
from symgen.scene.mounts import Mounts
from symgen.scene.xml import Element, parse_xml

KINDS = ("bodies", "joints")


@dataclass(frozen=True)
class Model:
    """What a model file says, and where."""

    name: str
    """An identifier: the scene's name when the file is loaded alone."""
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    """Those that hold the roots in ground included."""
    notes: tuple[str, ...]
    file: str
    """Base name, for messages."""
    forces: tuple[Spring | JointSpring, ...] = ()
    frames: tuple[Frame, ...] = ()
    gravity: Vector | None = None
    """None: the scene's own, or its default."""
    weld: str = ""
    """The joint between ground and the root link that the file does not have; empty when it has one."""
    elements: Mapping[str, Mapping[str, Element]] = field(default_factory=dict)
    """``bodies`` and ``joints``: name → element, for places."""

    def place(self, kind: str = "", name: str = "") -> str:
        """``panda.urdf:36: link 'panda_link1'``; the file alone for what it has no element of."""
        element = self.elements.get(kind, {}).get(name)
        return place(self.file, element) if element else self.file


def place(file: str, element: Element) -> str:
    """``panda.urdf:36: link 'panda_link1'``."""
    name = element.attributes.get("name")
    return f"{file}:{element.line}: {clean(element.tag)}" + (f" {clean(name)!r}" if name else "")


def read_model(data: bytes, path: Path, floating: bool, mounts: Mounts) -> Model:
    """The model in an XML text, URDF or MJCF.

    ``path`` is where it was read (for what it includes); ``floating`` frees its root. Raises SceneError naming file,
    line and element; NotSupportedError for formats that are not read; ToolError for MJCF without MuJoCo.
    """
    from symgen.scene.urdf import read_urdf

    file = clean(path.name, 120)
    root = parse_xml(data, file)
    if root.tag == "mujoco":
        from symgen.scene.mjcf import read_mjcf

        return read_mjcf(root, path, floating, mounts)
    if root.tag == "mujocoinclude":
        raise SceneError("is a part that an MJCF model includes; give the model", file)
    if root.tag == "sdf":
        raise NotSupportedError(f"{file}: SDF files are not read; give a scene (.yaml) or URDF")
    if root.tag != "robot":
        raise SceneError(f"the root element is <{clean(root.tag)}>; URDF starts with <robot>", f"{file}:{root.line}")
    return read_urdf(root, file, floating, mounts)
