"""A MuJoCo model of a scene, and the generated functions against it at the same random states.

The model is made from the scene alone: one MuJoCo body per link, with the joints that make up the scene's joint; its
masses, springs and dampers are written into the compiled model, since MuJoCo's compiler refuses bodies without mass.
MuJoCo's velocity of a free joint is that of ``base_velocity: mixed``, so v_mj = S v with S and Ṡ of `MuJoCo.maps`.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from symgen.errors import NotSupportedError, ToolError
from symgen.scene.model import GROUND, JointSpring, Scene, Spring
from symgen.validation.functions import Bound
from symgen.validation.mechanism import (
    IDENTITY,
    Array,
    Link,
    Mechanism,
    Pose,
    build_mechanism,
    lump,
    quaternion_of,
    rotation_of,
    vector,
)
from symgen.validation.result import Row, Skip

X, Y, Z = np.eye(3)
MISSING = "MuJoCo is not installed: pip install 'symgen[mjcf]'"


def import_mujoco() -> Any:
    try:
        return importlib.import_module("mujoco")
    except ImportError as error:
        raise ToolError(MISSING) from error


@contextmanager
def quiet(mujoco: Any) -> Iterator[None]:
    """MuJoCo's warnings (a mass matrix near singular) are not written to a log file where the program runs."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _message: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


@dataclass(frozen=True)
class MuJoCo:
    """Dynamics of a scene by MuJoCo, in symgen's coordinates and units."""

    mechanism: Mechanism
    mujoco: Any
    model: Any
    data: Any
    places: tuple[tuple[int, int], ...]
    """Where each link's coordinates start in MuJoCo's qpos and qvel."""
    loose_armature: Array
    """Armature of floating bases, which is on the diagonal of symgen's coordinates."""

    def expand(self, q: Array) -> Array:
        """MuJoCo's qpos."""
        full = np.zeros(self.model.nq)
        for link, (start, _) in zip(self.mechanism.links, self.places, strict=True):
            part = link.position(q)
            if link.joint.type == "floating":
                pose = link.origin @ Pose(rotation_of(part[3:]), part[:3])
                full[start : start + 7] = [*pose.position, *np.roll(quaternion_of(pose.rotation), 1)]
            elif link.joint.type == "spherical":
                full[start : start + 4] = np.roll(part, 1)
            else:
                full[start : start + len(part)] = part
        return full

    def maps(self, q: Array, v: Array) -> tuple[Array, Array]:
        """S (MuJoCo's nv, nv) and Ṡ v at a state."""
        S, rate = np.zeros((self.model.nv, self.mechanism.nv)), np.zeros(self.model.nv)
        kind = self.mechanism.scene.options.base_velocity
        for link, (_, start) in zip(self.mechanism.links, self.places, strict=True):
            size = link.v.stop - link.v.start
            S[start : start + size, link.v] = link.factor * np.eye(size)
            if link.joint.type != "floating" or kind == "mixed":
                continue
            turn = link.origin.rotation @ rotation_of(q[link.q][3:])
            if kind == "world":  # only ω differs, and d(Rᵀ)/dt ω = −ω × ω = 0 there
                S[start + 3 : start + 6, link.v.start + 3 : link.v.stop] = turn.T
            else:
                linear, omega = v[link.v][:3], v[link.v][3:]
                S[start : start + 3, link.v.start : link.v.start + 3] = turn
                rate[start : start + 3] = turn @ np.cross(omega, linear)
        return S, rate

    def _set(self, q: Array, v: Array) -> tuple[Array, Array]:
        S, rate = self.maps(q, v)
        self.data.qpos[:], self.data.qvel[:] = self.expand(q), S @ v
        return S, rate

    def _call(self, name: str) -> None:
        with quiet(self.mujoco):
            getattr(self.mujoco, name)(self.model, self.data)

    def mass_matrix(self, q: Array) -> Array:
        """M (nv, nv) by MuJoCo's composite-inertia algorithm."""
        S, _ = self._set(q, np.zeros(self.mechanism.nv))
        self._call("mj_forward")
        full = np.zeros((self.model.nv, self.model.nv))
        full_mass_matrix(self.mujoco, self.model, self.data, full)
        return np.asarray(S.T @ full @ S + np.diag(self.loose_armature))

    def bias_force(self, q: Array, v: Array) -> Array:
        """C v + gravity + passive forces (nv)."""
        return self.inverse_dynamics(q, v, np.zeros(self.mechanism.nv))

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """tau (nv) by mj_inverse."""
        S, rate = self._set(q, v)
        self.data.qacc[:] = S @ a + rate
        self._call("mj_inverse")
        return np.asarray(S.T @ np.array(self.data.qfrc_inverse) + self.loose_armature * a)

    def forward_dynamics(self, q: Array, v: Array, tau: Array) -> Array:
        """a (nv) by mj_forward; where joints are coupled, or a base has armature, by a solve with its M and bias."""
        if self.model.nv != self.mechanism.nv or np.any(self.loose_armature):
            return np.asarray(np.linalg.solve(self.mass_matrix(q), tau - self.bias_force(q, v)))
        S, rate = self._set(q, v)
        self.data.qfrc_applied[:] = S @ tau  # S is orthogonal here
        self._call("mj_forward")
        found = S.T @ (np.array(self.data.qacc) - rate)
        self.data.qfrc_applied[:] = 0.0
        return np.asarray(found)


def full_mass_matrix(mujoco: Any, model: Any, data: Any, full: Array) -> None:
    """mj_fullM, whose arguments changed in version 4."""
    if int(mujoco.__version__.split(".")[0]) >= 4:
        mujoco.mj_fullM(model, data, full)
    else:
        mujoco.mj_fullM(model, full, data.qM)


# -- the model ---------------------------------------------------------------------------------------------------------


def elements(link: Link) -> list[tuple[str, Array]]:
    """(MuJoCo joint type, axis) of the joints that make up the link's joint."""
    match link.joint.type:
        case "revolute" | "continuous":
            return [("hinge", link.axis)]
        case "prismatic":
            return [("slide", link.axis)]
        case "cylindrical":
            return [("hinge", link.axis), ("slide", link.axis)]
        case "universal":
            return [("hinge", link.axis), ("hinge", link.axis2)]
        case "planar":
            return [("slide", X), ("slide", Y), ("hinge", Z)]
        case "spherical":
            return [("ball", Z)]
        case "floating":
            return [("free", Z)]
        case other:
            raise NotSupportedError(f"joint {link.joint.name!r} is {other}, which MuJoCo does not have")


def build_mujoco(scene: Scene) -> MuJoCo:
    """The scene as a MuJoCo model.

    Raises `ToolError` when MuJoCo is missing, `NotSupportedError` for helical joints and closed loops.
    """
    mujoco = import_mujoco()
    mechanism = build_mechanism(scene)
    spec = mujoco.MjSpec()
    spec.option.gravity = vector(scene.gravity)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    bodies: list[Any] = []
    for index, link in enumerate(mechanism.links):
        home = spec.worldbody if link.parent < 0 else bodies[link.parent]
        bodies.append(_add_body(mujoco, home, link, index))
    springs = [force for force in scene.forces if isinstance(force, Spring)]
    for number, spring in enumerate(springs):
        _add_tendon(spec, mechanism, bodies, spring, number)
    with quiet(mujoco):
        model = spec.compile()
    places, loose = _fill(model, mechanism)
    for number, spring in enumerate(springs):
        row = model.tendon(f"spring{number}").id
        model.tendon_stiffness[row], model.tendon_damping[row] = float(spring.stiffness), float(spring.damping)
        model.tendon_lengthspring[row] = float(spring.length)
    return MuJoCo(mechanism, mujoco, model, mujoco.MjData(model), places, loose)


def _add_body(mujoco: Any, home: Any, link: Link, index: int) -> Any:
    """A body with a stand-in inertia that takes none of MuJoCo's short cuts; `_fill` puts the link's in its place."""
    body = home.add_body(name=f"link{index}", pos=link.origin.position, quat=_wxyz(link.origin.rotation))
    body.mass, body.ipos, body.iquat = 1.0, [0.1, 0.2, 0.3], [0.8, 0.6, 0.0, 0.0]
    body.inertia, body.explicitinertial = [1.0, 1.1, 1.2], True
    kinds = {name: getattr(mujoco.mjtJoint, f"mjJNT_{name.upper()}") for name in ("hinge", "slide", "ball", "free")}
    for number, (kind, axis) in enumerate(elements(link)):
        body.add_joint(name=f"joint{index}_{number}", type=kinds[kind], axis=axis)
    return body


def _add_tendon(spec: Any, mechanism: Mechanism, bodies: list[Any], spring: Spring, number: int) -> None:
    tendon = spec.add_tendon(name=f"spring{number}")
    for end, (name, point) in enumerate(zip(spring.between, spring.points, strict=True)):
        index, inner = mechanism.frames[name] if name != GROUND else (-1, IDENTITY)
        owner = spec.worldbody if index < 0 else bodies[index]
        site = owner.add_site(name=f"spring{number}_{end}", pos=inner.apply(vector(point)))
        tendon.wrap_site(site.name)


def _wxyz(rotation: Array) -> Array:
    return np.roll(quaternion_of(rotation), 1)


def _fill(model: Any, mechanism: Mechanism) -> tuple[tuple[tuple[int, int], ...], Array]:
    """Masses, armature, dampers and joint springs; where each link's coordinates start; loose armature."""
    loose, places = np.zeros(mechanism.nv), list[tuple[int, int]]()
    for index, link in enumerate(mechanism.links):
        body = model.body(f"link{index}").id
        mass, centre, inertia = lump(link, IDENTITY)
        moments, axes = np.linalg.eigh(inertia)
        model.body_mass[body], model.body_ipos[body], model.body_inertia[body] = mass, centre, moments
        model.body_iquat[body] = _wxyz(axes * np.sign(np.linalg.det(axes)))
        first = model.body_jntadr[body]
        q, v = int(model.jnt_qposadr[first]), int(model.jnt_dofadr[first])
        places.append((q, v))
        size = link.v.stop - link.v.start
        if link.joint.type == "floating":
            loose[link.v] = float(link.joint.armature)
        else:
            model.dof_armature[v : v + size] = float(link.joint.armature)
        model.dof_damping[v : v + size] = float(link.joint.damping)
        for force in mechanism.scene.forces:
            if isinstance(force, JointSpring) and force.joint == link.joint.name:
                _add_spring(model, force, slice(first, first + size), slice(q, q + size), slice(v, v + size))
    model.body_subtreemass[:] = model.body_mass
    for body in range(model.nbody - 1, 0, -1):
        model.body_subtreemass[model.body_parentid[body]] += model.body_subtreemass[body]
    return tuple(places), loose


def _add_spring(model: Any, spring: JointSpring, joints: slice, q: slice, v: slice) -> None:
    """Several springs of one joint are one: their stiffnesses add, and the rests count by stiffness."""
    before, more = np.array(model.jnt_stiffness[joints]), float(spring.stiffness)
    model.dof_damping[v] += float(spring.damping)
    if more:
        rest = before * model.qpos_spring[q] + more * float(spring.rest)
        model.jnt_stiffness[joints] = before + more
        model.qpos_spring[q] = rest / (before + more)


# -- the comparison ----------------------------------------------------------------------------------------------------


def compare_with_mujoco(
    scene: Scene, functions: Bound, states: int, seed: int, label: str = ""
) -> tuple[list[Row], list[Skip]]:
    """Rows for mass_matrix, bias_force, inverse_dynamics and forward_dynamics; one skip for what MuJoCo lacks."""
    from symgen.validation.compare import CRITERION, draw, same_state_row

    try:
        peer = build_mujoco(scene)
    except NotSupportedError as error:
        return [], [Skip("MuJoCo", str(error))]
    samples = draw(peer, states, seed)
    source = f"MuJoCo {peer.mujoco.__version__}"
    rows: list[Row] = []
    arguments = {
        "mass_matrix": (samples.q,),
        "bias_force": (samples.q, samples.v),
        "inverse_dynamics": (samples.q, samples.v, samples.a),
        "forward_dynamics": (samples.q, samples.v, samples.tau),
    }
    for name, inputs in arguments.items():
        if functions.has(name):
            ours, theirs = functions(name, *inputs), getattr(samples, name)
            rows.append(same_state_row(name, label, ours, theirs, samples, CRITERION, source))
    return rows, []
