"""What a scene leaves out on purpose: each restriction, and the scene without it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from symgen.errors import SymgenError
from symgen.scene.assemble import assemble
from symgen.scene.checks import fixed_to_ground
from symgen.scene.document import Description, Document, clean
from symgen.scene.model import Parameter, Scene
from symgen.scene.parameters import available_parameters

ONE_BY_ONE = 12
"""Up to so many joints locked (or subtrees removed) are looked at each by itself; more of them together."""
INERTIAL = ("mass", "com", "inertia")


@dataclass(frozen=True)
class Restriction:
    """One thing a scene does without. ``scene`` is None where there is none without it, and ``why`` says why."""

    label: str
    scene: Scene | None
    why: str = ""


def restrictions(scene: Scene) -> Iterator[Restriction]:
    """Locked joints, removed subtrees, and inertial parameters that are constants, each with the scene without it.

    Outputs and options stay those of ``scene``. The scenes are made one after the other, as they are asked for.
    """
    if isinstance(scene.description, Description):
        data = scene.description.document.data
        locked = {joint: clean(_position(value)) for joint, value in data.get("lock", {}).items()}
        yield from _one_by_one(scene, "lock", {f"lock {clean(name)} = {at}": name for name, at in locked.items()})
        yield from _one_by_one(scene, "remove", {f"remove {clean(name)}": name for name in data.get("remove", [])})
    parameters = with_inertial_parameters(scene)
    added = sum(parameter.size for parameter in parameters) - sum(parameter.size for parameter in scene.parameters)
    if added:
        yield Restriction(f"{added} inertial parameters constant", replace(scene, parameters=parameters))


def with_inertial_parameters(scene: Scene) -> tuple[Parameter, ...]:
    """The parameters of a scene, and after them mass, centre and inertia of every body that moves and has mass."""
    still, listed = fixed_to_ground(scene), {parameter.name for parameter in scene.parameters}
    heavy = [body.name for body in scene.bodies if body.mass and body.name not in still]
    known = available_parameters(scene)
    result = list(scene.parameters)
    for name in (f"{body}.{field}" for body in heavy for field in INERTIAL):
        if name not in listed:
            values, unit = known[name]
            result.append(Parameter(name, values, unit, sum(parameter.size for parameter in result)))
    return tuple(result)


def _one_by_one(scene: Scene, key: str, named: Mapping[str, str]) -> Iterator[Restriction]:
    """The entries under ``key`` of the scene's description, each left out by itself; many of them together."""
    if len(named) > ONE_BY_ONE:
        what = {"lock": "joints locked", "remove": "subtrees removed"}[key]
        yield _without(scene, key, set(named.values()), f"{len(named)} {what}")
        return
    for label, name in named.items():
        yield _without(scene, key, {name}, label)


def _without(scene: Scene, key: str, names: set[str], label: str) -> Restriction:
    description = scene.description
    assert isinstance(description, Description)
    data: dict[str, Any] = dict(description.document.data)
    if key == "lock":
        data[key] = {joint: value for joint, value in data[key].items() if joint not in names}
    else:
        data[key] = [body for body in data[key] if body not in names]
    document = Document(data, description.document.file, description.document.lines)
    try:
        other = assemble(document, description.folder)
    except SymgenError as error:
        return Restriction(label, None, f"no scene without it: {error}")
    return Restriction(label, replace(other, outputs=scene.outputs, options=scene.options))


def _position(value: Any) -> str:
    numbers = value if isinstance(value, list) else [value]
    text = ", ".join(f"{float(Fraction(number)):.6g}" for number in numbers)
    return f"[{text}]" if isinstance(value, list) else text
