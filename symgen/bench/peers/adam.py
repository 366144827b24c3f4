"""adam (adam-robotics): its algorithms over CasADi's SX, as C by CasADi's code generator.

adam reads URDF: the scene is written out as one, links lumped, and given to it. It knows a floating base only; on a
base that stands still the rows of the base are left out before code is generated, so that nothing is computed for them.
"""

from __future__ import annotations

import time
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from symgen.bench.peers.casadi_c import by_columns, c_text, casadi_variant, operations
from symgen.bench.variant import INPUTS, Array, Found, Problem
from symgen.bench.workshop import Workshop
from symgen.errors import NotSupportedError
from symgen.validation.mechanism import IDENTITY, Link, Mechanism, lump

NAME = "adam"
HAS = ("mass_matrix", "bias_force")


def rpy(R: Array) -> Array:
    """Roll, pitch and yaw of a rotation, URDF's convention."""
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if np.hypot(R[0, 0], R[1, 0]) > 1e-9:
        return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])
    return np.array([np.arctan2(-R[1, 2], R[1, 1]), pitch, 0.0])


def _words(values: Array) -> str:
    return quoteattr(" ".join(repr(float(x)) for x in values))


def urdf(mechanism: Mechanism) -> str:
    """The mechanism as URDF: revolute and prismatic joints, and one floating joint at the root, which becomes the root
    link. Raises NotSupportedError for anything else."""
    floating = bool(mechanism.links) and mechanism.links[0].joint.type == "floating"
    lines = ['<robot name="scene">'] + ([] if floating else ['<link name="ground"/>'])
    for index, link in enumerate(mechanism.links):
        mass, centre, inertia = lump(link, IDENTITY)
        entries = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
        moments = " ".join(f'{name}="{float(inertia[at])!r}"' for name, at in entries.items())
        lines.append(
            f'<link name="link{index}"><inertial><origin xyz={_words(centre)} rpy="0 0 0"/>'
            f"<mass value={quoteattr(repr(float(mass)))}/><inertia {moments}/></inertial></link>"
        )
        if index or not floating:
            lines.append(_joint(index, link))
    return "\n".join([*lines, "</robot>"]) + "\n"


def _joint(index: int, link: Link) -> str:
    kinds = {"revolute": "continuous", "continuous": "continuous", "prismatic": "prismatic"}
    if link.joint.type not in kinds or link.coupling is not None:
        raise NotSupportedError(f"joint type {link.joint.type} is not measured with adam")
    parent = "ground" if link.parent < 0 else f"link{link.parent}"
    return (
        f'<joint name="joint{index}" type="{kinds[link.joint.type]}">'
        f'<parent link="{parent}"/><child link="link{index}"/>'
        f"<origin xyz={_words(link.origin.position)} rpy={_words(rpy(link.origin.rotation))}/>"
        f'<axis xyz={_words(link.axis)}/><limit lower="-4" upper="4" effort="1" velocity="1"/></joint>'
    )


def build(problem: Problem, workshop: Workshop) -> Found:
    """mass_matrix and bias_force, which are what it has for a base of either kind."""
    import adam
    import casadi
    from adam.casadi import KinDynComputations

    mechanism = problem.mechanism
    floating = mechanism.links[0].joint.type == "floating"
    if floating and not np.allclose(mechanism.links[0].origin.rotation, np.eye(3)):
        raise NotSupportedError("a floating base that is mounted turned")
    names = [f"joint{k}" for k in range(int(floating), len(mechanism.links))]
    gravity = np.array([float(x) for x in problem.scene.gravity] + [0.0] * 3)
    computations = KinDynComputations(urdf(mechanism), names, gravity=gravity)
    computations.set_frame_velocity_representation(adam.Representations.BODY_FIXED_REPRESENTATION)
    found = Found()
    q, v = casadi.SX.sym("q", problem.system.tree.nq), casadi.SX.sym("v", problem.nv)
    for name in (row for row in HAS if row in problem.wanted):
        started = time.process_time()
        y = _expression(computations, casadi, name, q, v, floating)
        if name == "mass_matrix":
            y = y + casadi.diag(casadi.DM(_armature(mechanism)))
        inputs = [q, v][: len(INPUTS[name])]
        function = casadi.Function(f"adamcasadi_{name}", inputs, [casadi.densify(y)], {"cse": True})
        text, taken = c_text(function), time.process_time() - started
        found.variants.append(
            casadi_variant(
                NAME, name, f"adamcasadi_{name}", text, {key: problem.column(key) for key in INPUTS[name]},
                [function.numel_out(0)], by_columns(function), taken, operations(function),
            )
        )  # fmt: skip
    return found


def _armature(mechanism: Mechanism) -> Array:
    found = np.zeros(mechanism.nv)
    for link in mechanism.links:
        found[link.v] = float(link.joint.armature)
    return found


def _expression(computations: Any, casadi: Any, name: str, q: Any, v: Any, floating: bool) -> Any:
    """The function in our coordinates: base pose from its quaternion, rows of a base that stands still left out."""
    H = casadi.SX.eye(4)
    if floating:
        H[:3, :3], H[:3, 3] = _rotation(casadi, q[3:7]), q[:3]
    joints = q[7:] if floating else q
    if name == "mass_matrix":
        M = computations.mass_matrix(H, joints)
        return M if floating else M[6:, 6:]
    base = v[:6] if floating else casadi.SX.zeros(6)
    h = computations.bias_force(H, joints, base, v[6:] if floating else v)
    return h if floating else h[6:]


def _rotation(casadi: Any, p: Any) -> Any:
    """Of the unit quaternion [x y z w]."""
    x, y, z, w = (p[k] for k in range(4))
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return casadi.vertcat(*(casadi.horzcat(*row) for row in rows))
