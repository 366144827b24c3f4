"""Which numbers of a scene become run-time arguments."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from fractions import Fraction

from symgen.errors import SceneError
from symgen.scene.checks import fixed_to_ground
from symgen.scene.document import Places, clean
from symgen.scene.exact import roll_pitch_yaw
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import Parameter, Scene, Spring
from symgen.scene.schema import did_you_mean

Values = tuple[tuple[Fraction, ...], str]
"""Default values and unit."""


def resolve_parameters(names: Sequence[str], scene: Scene, places: Places) -> tuple[Parameter, ...]:
    """The parameters ``names`` of ``scene``, in the order given; raises SceneError for unknown or repeated ones.

    A shell pattern (``link4.*``, ``*.mass``) stands for what it matches and is not listed before, in the order of
    `available_parameters`.
    """
    known = available_parameters(scene) if names else {}
    by: dict[str, str] = {}
    for i, name in enumerate(names):
        place = places.place(("parameters", i))
        if name not in known and _is_pattern(name):
            matches = [each for each in known if fnmatchcase(each, name)]
            if not matches:
                raise SceneError(_no_match(name, known), place)
            for each in matches:
                by.setdefault(each, name)
            continue
        if name not in known:
            raise SceneError(_unknown(name, scene, known), place)
        if name in by:
            already = f" (it is one of {clean(by[name])!r})" if by[name] != name else ""
            raise SceneError(f"the parameter {clean(name)!r} is listed twice{already}", place)
        by[name] = name
    result: list[Parameter] = []
    for name in by:
        values, unit = known[name]
        result.append(Parameter(name, values, unit, sum(p.size for p in result)))
    return tuple(result)


def _is_pattern(name: str) -> bool:
    return any(c in name for c in "*?[")


def _no_match(pattern: str, known: Iterable[str]) -> str:
    owner, dot, field = pattern.rpartition(".")
    owners = list(dict.fromkeys(name.rpartition(".")[0] for name in known if "." in name))
    of_owner = [name.rpartition(".")[2] for name in known if dot and fnmatchcase(name.rpartition(".")[0], owner)]
    text = f"no parameter matches {clean(pattern)!r}"
    if of_owner:
        return f"{text}; what {clean(owner)!r} matches has {', '.join(dict.fromkeys(of_owner))}"
    return text + did_you_mean(owner.strip("*?") or field, owners)


def available_parameters(scene: Scene) -> dict[str, Values]:
    """Every name that may be listed under ``parameters``, with its default values and unit."""
    still = fixed_to_ground(scene)
    known: dict[str, Values] = {"gravity": (scene.gravity, "m/s^2")}
    for body in scene.bodies:
        if body.name not in still:
            known[f"{body.name}.mass"] = ((body.mass,), "kg")
            known[f"{body.name}.com"] = (body.com, "m")
            known[f"{body.name}.inertia"] = (body.inertia, "kg.m^2")
    for joint in scene.joints:
        if joint.type != "fixed":
            damping, armature, _ = joint_units(joint.type)
            known[f"{joint.name}.damping"] = ((joint.damping,), damping)
            known[f"{joint.name}.armature"] = ((joint.armature,), armature)
        known[f"{joint.name}.xyz"] = (joint.origin.translation, "m")
        known[f"{joint.name}.rpy"] = (roll_pitch_yaw(joint.origin.rotation), "rad")
        if JOINT_TYPES[joint.type].nq == 1:
            known[f"{joint.name}.offset"] = ((Fraction(0),), JOINT_TYPES[joint.type].q_units[0])
    for force in scene.forces:
        if not force.name:
            continue
        if isinstance(force, Spring):
            known[f"{force.name}.stiffness"] = ((force.stiffness,), "N/m")
            known[f"{force.name}.damping"] = ((force.damping,), "N.s/m")
            known[f"{force.name}.length"] = ((force.length,), "m")
            known[f"{force.name}.point1"] = (force.points[0], "m")
            known[f"{force.name}.point2"] = (force.points[1], "m")
        else:
            kind = scene.joint(force.joint).type
            known[f"{force.name}.stiffness"] = ((force.stiffness,), joint_units(kind)[2])
            known[f"{force.name}.damping"] = ((force.damping,), joint_units(kind)[0])
            known[f"{force.name}.rest"] = ((force.rest,), _either(JOINT_TYPES[kind].q_units))
    return known


def joint_units(kind: str) -> tuple[str, str, str]:
    """Units of damping, armature and stiffness of a joint type; ``a or b`` where its coordinates differ."""
    units = JOINT_TYPES[kind].v_units
    angular = {"m/s": ("N.s/m", "kg", "N/m"), "rad/s": ("N.m.s/rad", "kg.m^2", "N.m/rad")}
    damping, armature, stiffness = (_either(tuple(angular[unit][k] for unit in units)) for k in range(3))
    return damping, armature, stiffness


def _either(units: tuple[str, ...]) -> str:
    return " or ".join(dict.fromkeys(units))


def _unknown(name: str, scene: Scene, known: dict[str, Values]) -> str:
    owner, _, field = name.rpartition(".")
    if owner in fixed_to_ground(scene) and field in ("mass", "com", "inertia"):
        return f"{clean(name)!r} has no effect: {clean(owner)!r} does not move"
    fields = [key.rpartition(".")[2] for key in known if owner and key.rpartition(".")[0] == owner]
    if fields:
        return f"{clean(owner)!r} has no parameter {clean(field)!r}; it has {', '.join(fields)}"
    return f"unknown parameter {clean(name)!r}{did_you_mean(name, known)}"
