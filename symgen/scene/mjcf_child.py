"""Reads an MJCF file with MuJoCo's own reader and writes what it holds as JSON. Runs as a program of its own.

    python mjcf_child.py MODEL.xml RESULT.json SECONDS BODIES

A C reader may crash, hang or ask for all memory on a hostile file; here that ends this process only. Nothing of
symgen is imported. RESULT.json is ``{"error": what MuJoCo says}``, ``{"refusal": a message}`` or what `described` says.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections import Counter
from contextlib import suppress
from math import isfinite
from typing import Any

import mujoco

MEMORY = 8 << 30
"""Bytes of address space."""

COUNTED = {
    "geoms": "geom", "actuators": "actuator", "tendons": "tendon", "equalities": "equality constraint",
    "sensors": "sensor", "keys": "keyframe", "pairs": "contact pair", "excludes": "contact exclusion",
    "cameras": "camera", "lights": "light", "flexes": "flex", "skins": "skin", "plugins": "plugin",
}  # fmt: skip
"""What a file may hold that has no part in the tree of bodies and joints."""

UNUSED = ("keys", "sensors", "skins", "equalities", "pairs", "excludes", "tuples", "cameras", "lights")
ASSETS = ("skins", "materials", "textures", "hfields")
TYPES = ("free", "ball", "slide", "hinge")


class RefusedError(ValueError):
    """Refused here, not by MuJoCo. The message is for the user."""


def limit(seconds: int) -> None:
    """Bounds on time and memory, where the system has them."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def parsed(path: str) -> Any:
    """The spec of a file. MuJoCo tells a decoder by the suffix .xml; a text of another name is read where it is."""
    if path.endswith(".xml"):
        return mujoco.MjSpec.from_file(path)
    folder, here = os.path.dirname(path), os.getcwd()
    with open(path, encoding="utf-8") as stream:
        text = stream.read()
    os.chdir(folder)  # what it includes is looked for from here
    try:
        spec = mujoco.MjSpec.from_string(text)
    finally:
        os.chdir(here)
    spec.modelfiledir = folder
    return spec


def compiled(path: str, bodies: int = 10_000) -> tuple[Any, Any, Counter[str]]:
    """(spec, model, what the file holds). Only what inertia needs is read from disk; all of it where that fails."""
    spec = parsed(path)
    if len(spec.bodies) > bodies:
        raise RefusedError(f"has {len(spec.bodies)} bodies; at most {bodies} are read")
    held = Counter({label: len(getattr(spec, kind)) for kind, label in COUNTED.items()})
    held["linear joint equality"] = sum(_couples_linearly(equality) for equality in spec.equalities)
    try:
        slim(spec)
        return spec, spec.compile(), held
    except ValueError as error:
        reason = missing_mesh(spec, str(error))
    if reason:
        raise RefusedError(reason)
    spec = parsed(path)
    return spec, spec.compile(), held


def _couples_linearly(equality: Any) -> bool:
    return bool(
        equality.type == mujoco.mjtEq.mjEQ_JOINT and equality.name1 and equality.name2 and not any(equality.data[2:5])
    )


# -- what inertia does not need ----------------------------------------------------------------------------------------


def slim(spec: Any) -> None:
    """Delete what has no part in masses, frames and joints, so that its files need not be there."""
    for kind in UNUSED:
        delete(spec, getattr(spec, kind))
    delete(spec, [actuator for actuator in spec.actuators if not reflects(actuator)])
    delete(spec, spec.tendons)
    meshes: set[str] = set()
    for geom in list(spec.geoms):
        if not (geom.meshname or geom.hfieldname):
            geom.material = ""
        elif weighs(spec, geom):
            geom.material, geom.contype, geom.conaffinity = "", 0, 0  # without contacts no convex hull is wanted
            meshes.add(geom.meshname)
        else:
            spec.delete(geom)
    for site in spec.sites:
        site.material = ""
    for kind in ASSETS:
        delete(spec, getattr(spec, kind))
    delete(spec, [mesh for mesh in spec.meshes if mesh.name not in meshes])


def delete(spec: Any, elements: Any) -> None:
    for element in list(elements):
        spec.delete(element)


def reflects(actuator: Any) -> bool:
    """Adds inertia or damping to the joint it moves."""
    if int(actuator.trntype) not in JOINT_TRANSMISSIONS or not hasattr(actuator, "armature"):
        return False
    return bool(actuator.armature or any(actuator.damping))


JOINT_TRANSMISSIONS = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))


def weighs(spec: Any, geom: Any) -> bool:
    """Whether the inertia of a body that can move is computed from this geom."""
    mode, body = spec.compiler.inertiafromgeom, geom.parent
    if mode == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE:
        return False
    if mode == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO and body.explicitinertial:
        return False
    low, high = spec.compiler.inertiagrouprange
    massless = geom.mass == 0 if isfinite(geom.mass) else geom.density == 0  # NaN: the density counts
    if massless or not low <= geom.group <= high:
        return False
    return spec.compiler.settotalmass > 0 or moves(spec, body)


def moves(spec: Any, body: Any) -> bool:
    """Whether a joint is between the body and the world."""
    while body is not None and body.name != "world":
        if body.joints:
            return True
        body = body.parent
    return False


def missing_mesh(spec: Any, message: str) -> str:
    """The error in a file's words, when a mesh that inertia needs cannot be read."""
    match = re.search(r"[Ee]rror opening file '([^']*)'", message)
    if match is None:
        return ""
    file = os.path.basename(match[1])
    users = [geom.parent.name for geom in spec.geoms if mesh_file(spec, geom.meshname) == file]
    owner = f"body {users[0]!r}" if users and users[0] else "a body"
    return f"the mesh file {file!r} cannot be read, and the inertia of {owner} comes from it; write an <inertial> there"


def mesh_file(spec: Any, name: str) -> str:
    mesh = spec.mesh(name) if name else None
    return os.path.basename(mesh.file) if mesh is not None else ""


# -- what is told ------------------------------------------------------------------------------------------------------


def described(spec: Any, model: Any, held: Counter[str]) -> dict[str, Any]:
    """Bodies, joints, sites, gravity and counts, as numbers and names."""
    disabled = mujoco.mjtDisableBit
    off = {flag: bool(model.opt.disableflags & getattr(disabled, f"mjDSBL_{flag}")) for flag in OFF}
    full = {part.id: part.fullinertia.tolist() for part in spec.bodies if part.explicitinertial}
    return {
        "version": mujoco.__version__,
        "name": spec.modelname,
        "gravity": [0.0, 0.0, 0.0] if off["GRAVITY"] else model.opt.gravity.tolist(),
        "bodies": [body(model, i, full.get(i, [])) for i in range(model.nbody)],
        "joints": [joint(model, i, off) for i in range(model.njnt)],
        "sites": [site(model, i) for i in range(model.nsite)],
        "held": dict(held + extras(model)),
    }


OFF = ("GRAVITY", "SPRING", "DAMPER")


def body(model: Any, i: int, full: list[float]) -> dict[str, Any]:
    return {
        "name": model.body(i).name,
        "parent": int(model.body_parentid[i]),
        "position": model.body_pos[i].tolist(),
        "quaternion": model.body_quat[i].tolist(),
        "mass": float(model.body_mass[i]),
        "com": model.body_ipos[i].tolist(),
        "axes": model.body_iquat[i].tolist(),
        "moments": model.body_inertia[i].tolist(),
        "full": full if all(map(isfinite, full)) else [],
    }


def joint(model: Any, i: int, off: dict[str, bool]) -> dict[str, Any]:
    kind, q, v = TYPES[model.jnt_type[i]], int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i])
    armature, damping = float(model.dof_armature[v]), float(model.dof_damping[v])
    for k in range(model.nu if hasattr(model, "actuator_armature") else 0):
        if model.actuator_trntype[k] in JOINT_TRANSMISSIONS and model.actuator_trnid[k][0] == i:
            gear = float(model.actuator_gear[k][0]) ** 2
            armature += gear * float(model.actuator_armature[k])
            damping += gear * float(model.actuator_damping[k])
    scalar = kind in ("slide", "hinge")
    return {
        "name": model.joint(i).name,
        "type": kind,
        "body": int(model.jnt_bodyid[i]),
        "anchor": model.jnt_pos[i].tolist(),
        "axis": model.jnt_axis[i].tolist(),
        "reference": float(model.qpos0[q]) if scalar else 0.0,
        "spring_reference": float(model.qpos_spring[q]) if scalar else 0.0,
        "stiffness": 0.0 if off["SPRING"] else float(model.jnt_stiffness[i]),
        "damping": 0.0 if off["DAMPER"] else damping,
        "armature": armature,
        "range": model.jnt_range[i].tolist() if scalar and model.jnt_limited[i] else [],
        "force_range": model.jnt_actfrcrange[i].tolist() if scalar and model.jnt_actfrclimited[i] else [],
    }


def site(model: Any, i: int) -> dict[str, Any]:
    return {
        "name": model.site(i).name,
        "body": int(model.site_bodyid[i]),
        "position": model.site_pos[i].tolist(),
        "quaternion": model.site_quat[i].tolist(),
    }


def extras(model: Any) -> Counter[str]:
    """What bodies and joints have beyond inertia, linear springs and linear dampers."""
    round_joints = [i for i in range(model.njnt) if TYPES[model.jnt_type[i]] in ("free", "ball")]
    medium = (model.opt.density, model.opt.viscosity, *model.opt.wind)
    return Counter({
        "dof with friction loss": int((model.dof_frictionloss != 0).sum()),
        "gravity-compensated body": int((model.body_gravcomp != 0).sum()),
        "mocap body held in place": int(model.nmocap),
        "ball or free joint's stiffness": sum(bool(model.jnt_stiffness[i]) for i in round_joints),
        "nonlinear joint spring": rows_with(model, "jnt_stiffnesspoly"),
        "nonlinear damper": rows_with(model, "dof_dampingpoly"),
        "yielding joint spring": rows_with(model, "jnt_springyield"),
        "fluid": int(any(medium)),
    })  # fmt: skip


def rows_with(model: Any, name: str) -> int:
    """Rows of an array that are not zero; older versions of MuJoCo lack the array."""
    values = getattr(model, name, None)
    return 0 if values is None else sum(bool(row.any()) for row in values)


def said(path: str, bodies: int) -> str:
    """What is known of the file, as JSON."""
    try:
        found = described(*compiled(path, bodies))
    except RefusedError as error:
        return json.dumps({"refusal": str(error)})
    except UnicodeDecodeError:
        return json.dumps({"refusal": "has text that is not UTF-8"})
    except (ValueError, RuntimeError, OverflowError, TypeError, MemoryError, mujoco.FatalError) as error:
        return json.dumps({"error": str(error) or type(error).__name__})
    try:
        return json.dumps(found, allow_nan=False)
    except ValueError:
        return json.dumps({"refusal": "has numbers that are not finite (masses, sizes, positions)"})


def main(path: str, result: str, seconds: str, bodies: str) -> None:
    limit(int(seconds))
    text = said(path, int(bodies))
    with open(result, "w", encoding="utf-8") as stream:
        stream.write(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
