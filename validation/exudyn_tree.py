"""A scene as Exudyn's ObjectKinematicTree: minimal coordinates, revolute and prismatic links only.

Every joint becomes one to six one-axis links, massless but the last. Spherical and floating joints turn by three
revolutes x, y, z that start at zero at the state given, so that they are exact there and valid until the second reaches
±90°; the last axis is laid along the initial angular velocity, which keeps a spinning body away from that.
A helical joint is a prismatic and a revolute link tied by a coordinate constraint.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from symgen.errors import NotSupportedError
from symgen.scene.model import GROUND, JointSpring, Scene, Spring
from symgen.validation.exudyn_model import Model, exudyn_items, frame_with_z, import_exudyn
from symgen.validation.mechanism import (
    IDENTITY,
    Array,
    Link,
    Mechanism,
    Pose,
    build_mechanism,
    lump,
    rotation_of,
    vector,
)


@dataclass(frozen=True)
class Piece:
    """One link of the kinematic tree: a turn about or a slide along ``axis``, in the frame left by the piece before."""

    turns: bool
    axis: Array
    position: float
    velocity: float


@dataclass(frozen=True)
class Unfolded:
    """A joint as pieces. v = T q̇, q̇ = E v, a = T q̈ + c with T E = 1 at the state it was made for."""

    before: Pose
    """Joint frame in the parent link's frame, with the turn reached by a quaternion folded in."""
    pieces: tuple[Piece, ...]
    T: Array
    E: Array
    c: Array


def unfold(link: Link, q: Array, v: Array, base_velocity: str) -> Unfolded:
    """The pieces of one joint at a state."""
    x, y, z = np.eye(3)
    axis, one = link.axis, np.eye(len(v))
    match link.joint.type:
        case "revolute" | "continuous":
            return Unfolded(link.origin, (Piece(True, axis, q[0], v[0]),), one, one, np.zeros(1))
        case "prismatic":
            return Unfolded(link.origin, (Piece(False, axis, q[0], v[0]),), one, one, np.zeros(1))
        case "helical":
            h = link.pitch
            pieces = (Piece(False, axis, h * q[0], h * v[0]), Piece(True, axis, q[0], v[0]))
            return Unfolded(link.origin, pieces, np.array([[0.0, 1.0]]), np.array([[h], [1.0]]), np.zeros(1))
        case "cylindrical":
            pieces = (Piece(True, axis, q[0], v[0]), Piece(False, axis, q[1], v[1]))
            return Unfolded(link.origin, pieces, one, one, np.zeros(2))
        case "universal":
            pieces = (Piece(True, axis, q[0], v[0]), Piece(True, link.axis2, q[1], v[1]))
            return Unfolded(link.origin, pieces, one, one, np.zeros(2))
        case "planar":
            slides = tuple(Piece(False, e, q[k], v[k]) for k, e in enumerate((x, y)))
            return Unfolded(link.origin, (*slides, Piece(True, z, q[2], v[2])), one, one, np.zeros(3))
        case "spherical":
            return unfold_turn(link, rotation_of(q), v)
        case "floating":
            return unfold_floating(link, q, v, base_velocity)
    raise NotSupportedError(f"joint type {link.joint.type} has no kinematic-tree model")


def turn_pieces(omega: Array) -> tuple[Array, tuple[Piece, ...], Array]:
    """Three revolutes for ω in child axes: their axes as columns C, the pieces, and ω̇ − C q̈."""
    C = frame_with_z(omega) if np.linalg.norm(omega) > 0 else np.eye(3)
    a, b, c = C.T @ omega
    pieces = tuple(Piece(True, C[:, k], 0.0, rate) for k, rate in enumerate((a, b, c)))
    # ω = Rzᵀ Ryᵀ x ȧ + Rzᵀ y ḃ + z ċ, differentiated at zero angles.
    return C, pieces, C @ np.array([b * c, -a * c, a * b])


def unfold_turn(link: Link, turn: Array, omega: Array) -> Unfolded:
    C, pieces, correction = turn_pieces(omega)
    return Unfolded(link.origin @ Pose(turn, np.zeros(3)), pieces, C, C.T, correction)


def unfold_floating(link: Link, q: Array, v: Array, base_velocity: str) -> Unfolded:
    turn, outer = rotation_of(q[3:]), link.origin.rotation
    child = outer @ turn
    omega = child.T @ v[3:] if base_velocity == "world" else v[3:]
    C, turns, correction = turn_pieces(omega)
    # The slides run along the joint frame's axes turned by the quaternion, too: the turn is folded in before them.
    linear = np.eye(3) if base_velocity == "body" else child
    rate = linear.T @ v[:3]
    start = turn.T @ q[:3]
    slides = tuple(Piece(False, e, start[k], rate[k]) for k, e in enumerate(np.eye(3)))
    angular = child if base_velocity == "world" else np.eye(3)
    zero = np.zeros((3, 3))
    T = np.block([[linear, zero], [zero, angular @ C]])
    c = np.concatenate([-np.cross(omega, v[:3]) if base_velocity == "body" else np.zeros(3), angular @ correction])
    return Unfolded(link.origin @ Pose(turn, np.zeros(3)), slides + turns, T, T.T, c)


@dataclass(frozen=True)
class TreeModel:
    """The assembled system and the maps to symgen's coordinates at its state."""

    model: Model
    T: Array
    E: Array
    c: Array

    def mass_matrix(self) -> Array:
        return np.asarray(self.E.T @ self.model.terms().M @ self.E)

    def accelerations(self) -> Array:
        """symgen's a (nv)."""
        return np.asarray(self.T @ self.model.terms().accelerations() + self.c)


def refusal(scene: Scene) -> str:
    """Why this formulation cannot hold the scene, or nothing."""
    for joint in scene.joints:
        if joint.mimic is not None:
            return f"joint {joint.name} is coupled to {joint.mimic.joint}"
        if joint.armature and joint.type in ("spherical", "floating"):
            return f"armature on the {joint.type} joint {joint.name} has no place in a kinematic tree's angles"
    return ""


def build_exudyn_tree(scene: Scene, q: Array, v: Array, tau: Array | None = None) -> TreeModel:
    """The scene at state (q, v) under constant joint forces ``tau`` (constant in Exudyn's joint axes).

    Raises `ToolError` when Exudyn is missing, `NotSupportedError` when the scene does not fit.
    """
    exu = import_exudyn()
    reason = refusal(scene)
    if reason:
        raise NotSupportedError(reason)
    mechanism = build_mechanism(scene)
    kind = scene.options.base_velocity
    joints = [unfold(link, q[link.q], v[link.v], kind) for link in mechanism.links]
    T, E = block_diagonal([joint.T for joint in joints]), block_diagonal([joint.E for joint in joints])
    c = np.concatenate([joint.c for joint in joints])
    force = T.T @ (np.zeros(mechanism.nv) if tau is None else tau)
    mbs = exu.SystemContainer().AddSystem()
    tree, last, local = add_tree(exu, mbs, mechanism, joints, force)
    add_passive(exu, mbs, mechanism, tree, last, local)
    sensors = tuple(add_sensors(exu, mbs, tree, index) for index in last)
    constrained = any(link.joint.type == "helical" for link in mechanism.links)
    mbs.Assemble()
    return TreeModel(Model(exu, mbs, mechanism, sensors, tuple(local), lambda x: T @ x + c, constrained), T, E, c)


def block_diagonal(blocks: list[Array]) -> Array:
    whole = np.zeros((sum(b.shape[0] for b in blocks), sum(b.shape[1] for b in blocks)))
    row = column = 0
    for b in blocks:
        whole[row : row + b.shape[0], column : column + b.shape[1]] = b
        row, column = row + b.shape[0], column + b.shape[1]
    return whole


def add_tree(
    exu: Any, mbs: Any, mechanism: Mechanism, joints: list[Unfolded], force: Array
) -> tuple[Any, list[int], list[Pose]]:
    """The ObjectKinematicTree; per link the number of its last piece and the body's frame in that piece's frame."""
    items = exudyn_items()

    types, parents, rotations, offsets = [], [], [], []
    inertias, coms, masses, start, rate = [], [], [], [], []
    last: list[int] = []
    local: list[Pose] = []
    for link, joint in zip(mechanism.links, joints, strict=True):
        before = joint.before if link.parent < 0 else local[link.parent] @ joint.before
        parent = -1 if link.parent < 0 else last[link.parent]
        for piece in joint.pieces:
            turn = frame_with_z(piece.axis)
            types.append(exu.JointType.RevoluteZ if piece.turns else exu.JointType.PrismaticZ)
            parents.append(parent)
            rotations.append(before.rotation @ turn)
            offsets.append(before.position)
            start.append(piece.position)
            rate.append(piece.velocity)
            parent, before = len(types) - 1, Pose(turn.T, np.zeros(3))
            inertias.append(np.zeros((3, 3)))
            coms.append(np.zeros(3))
            masses.append(0.0)
        last.append(parent)
        local.append(before)
        masses[-1], coms[-1], inertias[-1] = lump(link, before)
    n = len(types)
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0.0] * n,
            initialCoordinates=start,
            initialCoordinates_t=rate,
            numberOfODE2Coordinates=n,
        )
    )
    tree = mbs.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=types,
            linkParents=parents,
            jointTransformations=exu.Matrix3DList(rotations),
            jointOffsets=exu.Vector3DList(offsets),
            linkInertiasCOM=exu.Matrix3DList(inertias),
            linkCOMs=exu.Vector3DList(coms),
            linkMasses=masses,
            gravity=vector(mechanism.scene.gravity),
            jointForceVector=force,
        )
    )
    return tree, last, local


def add_sensors(exu: Any, mbs: Any, tree: Any, link: int) -> tuple[Any, Any]:
    items = exudyn_items()

    kinds = (exu.OutputVariableType.Position, exu.OutputVariableType.RotationMatrix)
    place, turn = (
        mbs.AddSensor(
            items.SensorKinematicTree(
                objectNumber=tree, linkNumber=link, outputVariableType=kind, storeInternal=True, writeToFile=False
            )
        )
        for kind in kinds
    )
    return place, turn


def add_passive(exu: Any, mbs: Any, mechanism: Mechanism, tree: Any, last: list[int], local: list[Pose]) -> None:
    """Armature, joint springs and dampers on the tree's coordinates; springs between points by markers."""
    items = exudyn_items()

    n = last[-1] + 1 if last else 0
    M, K, D, f = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    ground = mbs.AddObject(items.ObjectGround())

    def marker(body: str, point: Array) -> Any:
        index, here = mechanism.frames[body]
        if index < 0:
            return mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=here.apply(point)))
        place = (local[index] @ here).apply(point)
        return mbs.AddMarker(
            items.MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=last[index], localPosition=place)
        )

    first = 0
    node = mbs.GetObject(tree)["nodeNumber"]
    for link, end in zip(mechanism.links, last, strict=True):
        turn = {"helical": slice(first + 1, end + 1)}.get(link.joint.type, slice(first, end + 1))
        if link.joint.type in ("spherical", "floating"):
            if link.joint.damping:
                isotropic_damper(mbs, mechanism, link, marker)
        else:
            springs = [s for s in mechanism.scene.forces if isinstance(s, JointSpring) and s.joint == link.joint.name]
            diagonal = np.arange(turn.start, turn.stop)
            M[diagonal, diagonal] += float(link.joint.armature)
            D[diagonal, diagonal] += float(link.joint.damping) + sum(float(s.damping) for s in springs)
            K[diagonal, diagonal] += sum(float(s.stiffness) for s in springs)
            f[diagonal] += sum(float(s.stiffness * s.rest) for s in springs)
        if link.joint.type == "helical":
            ends = [mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=k)) for k in (end, first)]
            mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=ends, factorValue1=1.0 / link.pitch))
        first = end + 1
    if np.any(M) or np.any(K) or np.any(D):
        mbs.AddObject(
            items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=M, stiffnessMatrix=K, dampingMatrix=D, forceVector=f)
        )
    add_springs(mbs, mechanism, marker)


def add_springs(mbs: Any, mechanism: Mechanism, marker: Any) -> None:
    """Springs between points; ``marker(body, point)`` makes a marker."""
    items = exudyn_items()

    for spring in mechanism.scene.forces:
        if isinstance(spring, Spring):
            ends = [marker(b, vector(p)) for b, p in zip(spring.between, spring.points, strict=True)]
            mbs.AddObject(
                items.ObjectConnectorSpringDamper(
                    markerNumbers=ends,
                    referenceLength=float(spring.length),
                    stiffness=float(spring.stiffness),
                    damping=float(spring.damping),
                )
            )


def isotropic_damper(mbs: Any, mechanism: Mechanism, link: Link, marker: Any) -> None:
    """Damping of a spherical joint (−d ω) or a floating one (−d ω and −d ṙ): the same in any axes."""
    items = exudyn_items()

    parent = GROUND if link.parent < 0 else mechanism.links[link.parent].name
    d = float(link.joint.damping)
    moves = d if link.joint.type == "floating" else 0.0
    ends = [marker(parent, link.origin.position), marker(link.name, IDENTITY.position)]
    mbs.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(markerNumbers=ends, damping=np.diag([moves] * 3 + [d] * 3))
    )
