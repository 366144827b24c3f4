"""A checked document → the Scene dataclasses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeVar

from symgen.errors import SceneError
from symgen.scene.canonical import with_hash
from symgen.scene.checks import check_scene, is_idle
from symgen.scene.document import Description, Document, Places, Route, read_bytes
from symgen.scene.exact import unit_vector
from symgen.scene.lock import lock_joints
from symgen.scene.model import (
    ZERO3,
    Body,
    Frame,
    Joint,
    JointSpring,
    Mimic,
    Options,
    Output,
    Scene,
    Spring,
    Transform,
    Vector,
)
from symgen.scene.models import Model, read_model
from symgen.scene.mounts import Mounts
from symgen.scene.outputs import check_outputs, frame_names
from symgen.scene.overlay import over_model, remove_subtrees
from symgen.scene.parameters import resolve_parameters
from symgen.scene.schema import check_schema

ZERO = Fraction(0)
T = TypeVar("T")
INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def assemble(document: Document, folder: Path | None = None) -> Scene:
    """The Scene a document describes; ``folder`` is where its ``model`` is looked for.

    Raises SceneError (NotSupportedError for what is right but cannot be done yet).
    """
    check_schema(document)
    data = document.data
    options = _options(data.get("options", {}))
    mounts = Mounts(options.snap)
    model = _model(document, folder, mounts)
    reader = _Reader(document, mounts)
    own = Scene(
        name=data["name"],
        bodies=_each("bodies", data, reader.body),
        joints=_each("joints", data, reader.joint),
        gravity=tuple(data["gravity"]) if "gravity" in data else (model and model.gravity) or Scene.gravity,
        forces=_each("forces", data, reader.force),
        frames=_each("frames", data, reader.frame),
        options=options,
        source=document.file,
        description=Description(document, folder),
    )
    scene = over_model(own, model, document) if model else own
    scene = replace(scene, joints=lock_joints(scene.joints, data.get("lock", {}), mounts, document))
    if model:
        scene = remove_subtrees(scene, own, data, document)
    return _finish(scene, _Places(document, scene, own, model), mounts, model, data)


def model_scene(data: bytes, path: Path) -> Scene:
    """The Scene of a model file alone: its root welded to ground, default outputs and options."""
    mounts = Mounts(Options().snap)
    model = read_model(data, path, floating=False, mounts=mounts)
    own = Scene(model.name, (), (), model.gravity or Scene.gravity, source=model.file)
    scene = replace(own, bodies=model.bodies, joints=model.joints, forces=model.forces, frames=model.frames)
    return _finish(scene, _Places(Document({}, model.file), scene, own, model), mounts, model, {})


def _finish(scene: Scene, places: Places, mounts: Mounts, model: Model | None, data: dict[str, Any]) -> Scene:
    """Checks, outputs, parameters, notes and hash: what every way to a Scene ends with."""
    published = frozenset(body.name for body in model.bodies) if model else None
    notes = check_scene(scene, places, published, locked=bool(data.keys() & {"lock", "remove"}))
    idle = [force for force in scene.forces if is_idle(force, scene)]
    if idle:
        notes.append(f"{len(idle)} of the forces left out: the joints they act on are locked")
        scene = replace(scene, forces=tuple(force for force in scene.forces if force not in idle))
    outputs = tuple(_output(item) for item in data.get("outputs", []))
    check_outputs(outputs, frame_names(scene), [places.place(("outputs", i)) for i in range(len(outputs))])
    parameters = resolve_parameters(data.get("parameters", []), scene, places)
    notes = [*mounts.notes(), *(model.notes if model else ()), *notes]
    raw: dict[str, object] = dict(mounts.raw)
    return with_hash(replace(scene, outputs=outputs, parameters=parameters, notes=tuple(notes), raw=raw))


@dataclass(frozen=True)
class _Places:
    """Of ``scene``, what is its ``own`` is in the scene's file, the rest in the model's."""

    document: Document
    scene: Scene
    own: Scene
    model: Model | None

    def place(self, route: Route = ()) -> str:
        if self.model is None or len(route) < 2 or route[0] not in ("bodies", "joints", "forces", "frames"):
            return self.document.place(route)
        kind, index = route[0], route[1]
        item = getattr(self.scene, kind)[index]
        mine = [other.name for other in getattr(self.own, kind)]
        if kind == "forces":  # which may have no names; the scene's own come after the model's
            place = int(index) - (len(self.scene.forces) - len(self.own.forces))
            return self.document.place((kind, place, *route[2:])) if place >= 0 else self.model.file
        if item.name in mine:
            return self.document.place((kind, mine.index(item.name), *route[2:]))
        return self.model.place(kind, item.name)


def _each(kind: str, data: dict[str, Any], read: Callable[[Any, Route], T]) -> tuple[T, ...]:
    return tuple(read(item, (kind, i)) for i, item in enumerate(data.get(kind, [])))


def _model(document: Document, folder: Path | None, mounts: Mounts) -> Model | None:
    path = document.data.get("model")
    if path is None:
        return None
    if folder is None:
        raise SceneError("a model file needs a scene file beside it", document.place(("model",)))
    if path.endswith((".yaml", ".yml")):
        raise SceneError("is a scene; 'model' names a URDF file", document.place(("model",)))
    file = folder / path
    try:
        data = read_bytes(file)
    except SceneError as error:
        raise SceneError(f"{error.place}: {error.message}", document.place(("model",))) from None
    return read_model(data, file, document.data.get("base", "fixed") == "floating", mounts)


def _options(data: dict[str, Any]) -> Options:
    values = dict(data)
    if "targets" in values:
        values["targets"] = tuple(dict.fromkeys(values["targets"]))
    if values.get("code") == "auto":
        del values["code"]
    return Options(**values)


def _output(item: str | dict[str, Any]) -> Output:
    return Output(item, (item,)) if isinstance(item, str) else Output(item["name"], tuple(item["of"]))


@dataclass(frozen=True)
class _Reader:
    """One method for each kind of thing; ``route`` says where it is, for errors."""

    document: Document
    mounts: Mounts

    def body(self, item: dict[str, Any], route: Route) -> Body:
        inertia = item.get("inertia", [ZERO] * 6)
        if isinstance(inertia, dict):
            inertia = [inertia.get(key, ZERO) for key in INERTIA]
        ixx, iyy, izz, ixy, ixz, iyz = inertia
        return Body(
            name=item["name"],
            mass=item.get("mass", ZERO),
            com=_vector(item.get("com")),
            inertia=(ixx, iyy, izz, ixy, ixz, iyz),
            basic_points=tuple(_vector(point) for point in item.get("basic_points", [])),
            unit_vectors=tuple(
                self.direction(vector, (*route, "unit_vectors", k))
                for k, vector in enumerate(item.get("unit_vectors", []))
            ),
        )

    def joint(self, item: dict[str, Any], route: Route) -> Joint:
        return Joint(
            name=item["name"],
            type=item["type"],
            parent=item["parent"],
            child=item["child"],
            origin=self.origin(item, f"joint {item['name']!r}", item["name"]),
            axis=self.direction(item["axis"], (*route, "axis")) if "axis" in item else None,
            axis2=self.direction(item["axis2"], (*route, "axis2")) if "axis2" in item else None,
            pitch=item.get("pitch"),
            armature=item.get("armature", ZERO),
            damping=item.get("damping", ZERO),
            cut=item.get("cut", False),
            limits=tuple((key, float(value)) for key, value in item.get("limits", {}).items()),
            mimic=_mimic(item.get("mimic")),
        )

    def force(self, item: dict[str, Any], route: Route) -> Spring | JointSpring:
        stiffness, damping = item.get("stiffness", ZERO), item.get("damping", ZERO)
        name = item.get("name", "")
        if item["type"] == "joint_spring":
            return JointSpring(item["joint"], stiffness, damping, item.get("rest", ZERO), name)
        first, second = item["points"]
        return Spring(
            (item["between"][0], item["between"][1]),
            (_vector(first), _vector(second)),
            stiffness,
            damping,
            item.get("length", ZERO),
            name,
        )

    def frame(self, item: dict[str, Any], route: Route) -> Frame:
        return Frame(item["name"], item["body"], self.origin(item, f"frame {item['name']!r}"))

    def origin(self, item: dict[str, Any], owner: str, joint: str = "") -> Transform:
        data = item.get("origin", {})
        return self.mounts.transform(_vector(data.get("xyz")), _vector(data.get("rpy")), owner, joint)

    def direction(self, vector: Any, route: Route) -> Vector:
        if not any(vector):
            raise SceneError("is zero; a direction is wanted", self.document.place(route))
        return unit_vector(_vector(vector))


def _mimic(data: dict[str, Any] | None) -> Mimic | None:
    if data is None:
        return None
    return Mimic(data["joint"], data.get("multiplier", Fraction(1)), data.get("offset", ZERO))


def _vector(data: Any) -> Vector:
    if data is None:
        return ZERO3
    x, y, z = data
    return (x, y, z)
