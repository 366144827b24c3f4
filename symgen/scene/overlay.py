"""A scene over a model: bodies and joints added to it, subtrees taken from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from symgen.errors import SceneError
from symgen.scene.document import Document, clean
from symgen.scene.model import Joint, JointSpring, Scene, Spring
from symgen.scene.models import Model
from symgen.scene.schema import did_you_mean

_KINDS = (("bodies", "body"), ("joints", "joint"), ("frames", "frame"), ("forces", "force"))


def over_model(own: Scene, model: Model, document: Document) -> Scene:
    """``own`` on top of what ``model`` holds. A joint into the model's root takes the place of its weld to ground.

    Raises SceneError for a name that the model has already.
    """
    for kind, word in _KINDS:
        taken = {item.name for item in getattr(model, kind)} - {""}
        for i, item in enumerate(getattr(own, kind)):
            if item.name in taken:
                raise SceneError(
                    f"{clean(model.file, 120)} has a {word} {clean(item.name)!r} already; choose another name",
                    document.place((kind, i, "name")),
                )
    joints = model.joints
    root = next((joint for joint in joints if joint.name == model.weld), None)
    for i, joint in enumerate(own.joints):
        if root is None or joint.child != root.child or joint.cut:
            continue
        if root.type != "fixed":
            raise SceneError(
                f"{clean(root.child)!r}, the root of the model, has a floating joint already (base: floating)",
                document.place(("joints", i, "child")),
            )
        joints = tuple(other for other in joints if other is not root)
    return replace(
        own,
        bodies=(*model.bodies, *own.bodies),
        joints=(*joints, *own.joints),
        forces=(*model.forces, *own.forces),
        frames=(*model.frames, *own.frames),
    )


def remove_subtrees(scene: Scene, own: Scene, data: Mapping[str, Any], document: Document) -> Scene:
    """``scene`` without the bodies listed under ``remove`` and all that hangs on them.

    What the model itself has on them (frames, forces) goes too. Raises SceneError for a body that is not there, and
    where the scene or a coupling of the model still refers to something that went.
    """
    names = data.get("remove", [])
    if not names:
        return scene
    gone: dict[str, str] = {}
    bodies = {body.name: body for body in scene.bodies}
    mine = {body.name for body in own.bodies}
    for i, name in enumerate(names):
        place = document.place(("remove", i))
        if name not in bodies:
            raise SceneError(f"there is no body {clean(name)!r}{did_you_mean(name, bodies)}", place)
        if name in mine:
            raise SceneError(f"body {clean(name)!r} is one of this scene's own; take it from 'bodies'", place)
        for body in _subtree(scene, name, mine):
            gone.setdefault(body, name)
    if len(gone) == len(bodies):
        raise SceneError("nothing of the model is left", document.place(("remove",)))
    joints = tuple(joint for joint in scene.joints if not {joint.parent, joint.child} & gone.keys())
    lost = {joint.name: gone.get(joint.child, joint.child) for joint in scene.joints if joint not in joints}
    _check_bodies(own, gone, document)
    _check_names(data, gone, lost, document)
    _check_couplings(joints, lost, document)
    return replace(
        scene,
        bodies=tuple(body for body in scene.bodies if body.name not in gone),
        joints=joints,
        frames=tuple(frame for frame in scene.frames if frame.body not in gone),
        forces=tuple(force for force in scene.forces if not _acts_on(force, gone, lost)),
    )


def _subtree(scene: Scene, name: str, mine: set[str]) -> Iterator[str]:
    """``name`` and all bodies of the model that are reached through it."""
    stack, seen = [name], {name}
    while stack:
        body = stack.pop()
        yield body
        for joint in scene.joints:
            if joint.parent == body and joint.child not in seen | mine and not joint.cut:
                seen.add(joint.child)
                stack.append(joint.child)


def _removed(kind: str, name: str, gone: Mapping[str, str], place: str) -> None:
    """Raise SceneError where ``name`` is among what is gone."""
    if name in gone:
        with_it = f" with {clean(gone[name])!r}" if gone[name] != name else ""
        raise SceneError(f"{kind} {clean(name)!r} is removed{with_it} (see 'remove')", place)


def _check_bodies(own: Scene, gone: Mapping[str, str], document: Document) -> None:
    """The scene's own joints, frames and springs must not be fixed to removed bodies."""
    for i, joint in enumerate(own.joints):
        _removed("body", joint.parent, gone, document.place(("joints", i, "parent")))
        _removed("body", joint.child, gone, document.place(("joints", i, "child")))
    for i, frame in enumerate(own.frames):
        _removed("body", frame.body, gone, document.place(("frames", i, "body")))
    for i, force in enumerate(own.forces):
        for k, body in enumerate(force.between if isinstance(force, Spring) else ()):
            _removed("body", body, gone, document.place(("forces", i, "between", k)))


def _check_names(data: Mapping[str, Any], gone: Mapping[str, str], lost: Mapping[str, str], document: Document) -> None:
    """What the scene asks for must not name removed bodies or joints."""
    for i, force in enumerate(data.get("forces", [])):
        _removed("joint", force.get("joint", ""), lost, document.place(("forces", i, "joint")))
    for i, parameter in enumerate(data.get("parameters", [])):
        owner, _, field = parameter.rpartition(".")
        inertial = field in ("mass", "com", "inertia")
        _removed("body" if inertial else "joint", owner, gone if inertial else lost, document.place(("parameters", i)))
    for i, output in enumerate(data.get("outputs", [])):
        for row in [output] if isinstance(output, str) else output["of"]:
            _, colon, frame = row.rpartition(":")
            _removed("body", frame if colon else "", gone, document.place(("outputs", i)))


def _check_couplings(joints: Sequence[Joint], lost: Mapping[str, str], document: Document) -> None:
    for joint in joints:
        if joint.mimic and joint.mimic.joint in lost:
            master = clean(joint.mimic.joint)
            raise SceneError(
                f"joint {clean(joint.name)!r} mimics {master!r}, which is removed; "
                f"lock {master!r} at a position, or remove {clean(joint.child)!r} too",
                document.place(("remove",)),
            )


def _acts_on(force: Spring | JointSpring, gone: Mapping[str, str], lost: Mapping[str, str]) -> bool:
    if isinstance(force, JointSpring):
        return force.joint in lost
    return any(body in gone for body in force.between)
