"""A scene as Exudyn rigid bodies with Euler parameters and joints: the redundant-coordinate DAE.

The state is laid into the nodes' reference values; joint frames are fixed in the bodies, so that no joint needs to know
its zero position. What this formulation cannot express is refused with a reason (`refusal`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from symgen.errors import NotSupportedError
from symgen.scene.model import GROUND, JointSpring, Scene
from symgen.validation.exudyn_model import Model, exudyn_items, frame_with_z, import_exudyn
from symgen.validation.exudyn_tree import add_springs, isotropic_damper
from symgen.validation.mechanism import (
    IDENTITY,
    Array,
    Link,
    Mechanism,
    Motion,
    Pose,
    build_mechanism,
    joint_pose,
    link_motions,
    link_poses,
    lump,
    quaternion_of,
    vector,
)

AXES_OF: dict[str, tuple[int, int, int, int, int, int]] = {
    "revolute": (1, 1, 1, 1, 1, 0),
    "continuous": (1, 1, 1, 1, 1, 0),
    "prismatic": (1, 1, 0, 1, 1, 1),
    "cylindrical": (1, 1, 0, 1, 1, 0),
    "planar": (0, 0, 1, 1, 1, 0),
    "spherical": (1, 1, 1, 0, 0, 0),
    "universal": (1, 1, 1, 0, 0, 1),
}
"""Constrained directions of ObjectJointGeneric, the joint's axis being z (universal: first axis x, second y)."""


def refusal(scene: Scene) -> str:
    """Why this formulation cannot hold the scene, or nothing."""
    sprung = {force.joint for force in scene.forces if isinstance(force, JointSpring)}
    for joint in scene.joints:
        if joint.mimic is not None:
            return f"joint {joint.name} is coupled to {joint.mimic.joint}"
        if joint.type == "helical":
            if joint.parent == GROUND:
                continue  # its passive parts act on the carrier's own angle
            return f"helical joint {joint.name} on a moving body: its angle is no function of the bodies' coordinates"
        if joint.armature and not (joint.parent == GROUND and joint.type in ("revolute", "continuous", "prismatic")):
            return f"armature of joint {joint.name} belongs to a joint coordinate, which redundant bodies lack"
        if joint.type == "planar" and (joint.damping or joint.name in sprung):
            return f"planar joint {joint.name} has a damper or spring on coordinates that redundant bodies lack"
    return ""


def build_exudyn_bodies(scene: Scene, q: Array, v: Array) -> Model:
    """The scene at state (q, v), no joint forces.

    Raises `ToolError` when Exudyn is missing, `NotSupportedError` when the scene does not fit.
    """
    exu = import_exudyn()
    reason = refusal(scene)
    if reason:
        raise NotSupportedError(reason)
    mechanism = build_mechanism(scene)
    mbs = exu.SystemContainer().AddSystem()
    poses = link_poses(mechanism, q)
    motions = link_motions(mechanism, q, v, poses)
    bodies = [
        add_body(exu, mbs, mechanism, *lump(link, IDENTITY), here, motion)
        for link, here, motion in zip(mechanism.links, poses, motions, strict=True)
    ]
    nodes = [node for node, _ in bodies]
    for link, node in zip(mechanism.links, nodes, strict=True):
        if link.joint.armature and link.joint.type != "helical":
            add_armature(mbs, link, node)
    marker = markers(mbs, mechanism, [body for _, body in bodies])
    for link in mechanism.links:
        add_joint(exu, mbs, mechanism, link, marker, q, (poses, motions, v))
    add_springs(mbs, mechanism, marker)
    sensors = tuple(add_sensors(exu, mbs, body) for _, body in bodies)
    mbs.Assemble()

    def accelerations(tt: Array) -> Array:
        """[r̈; ω̇] of every link, ground axes, from the nodes' coordinates."""
        found = []
        for node, here in zip(nodes, poses, strict=True):
            start = mbs.GetNodeODE2Index(node)
            p = euler_parameters(here.rotation)
            found.append(tt[start : start + 3])
            found.append(here.rotation @ (2.0 * rate_matrix(p) @ tt[start + 3 : start + 7]))
        return np.concatenate(found)

    local = tuple(IDENTITY for _ in mechanism.links)
    return Model(exu, mbs, mechanism, sensors, local, accelerations, True)


def euler_parameters(rotation: Array) -> Array:
    """[w x y z] of a rotation matrix."""
    return np.roll(quaternion_of(rotation), 1)


def rate_matrix(p: Array) -> Array:
    """G (3×4) with ω = 2 G ṗ and ω̇ = 2 G p̈ in body axes, ṗ = ½ Gᵀ ω."""
    w, x, y, z = p
    return np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])


def add_body(
    exu: Any, mbs: Any, mechanism: Mechanism, mass: float, centre: Array, inertia: Array, here: Pose, motion: Motion
) -> tuple[Any, Any]:
    """A rigid body with its weight; its inertia is given about the centre of mass. Returns (node, body)."""
    items = exudyn_items()

    p = euler_parameters(here.rotation)
    rate = 0.5 * rate_matrix(p).T @ (here.rotation.T @ motion.angular)
    node = mbs.AddNode(
        items.NodeRigidBodyEP(
            referenceCoordinates=[*here.position, *p],
            initialCoordinates=[0.0] * 7,
            initialVelocities=[*motion.linear, *rate],
        )
    )
    about = inertia + mass * ((centre @ centre) * np.eye(3) - np.outer(centre, centre))
    six = [about[0, 0], about[1, 1], about[2, 2], about[1, 2], about[0, 2], about[0, 1]]
    body = mbs.AddObject(items.ObjectRigidBody(nodeNumber=node, mass=mass, inertia=six, centerOfMass=centre))
    if mass:
        weight = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=vector(mechanism.scene.gravity)))
    return node, body


def add_armature(mbs: Any, link: Link, node: Any) -> None:
    """On a one-axis joint to ground, armature is a rotor about the axis, or a weightless mass that slides along."""
    rotor = np.zeros((3, 3)) if link.joint.type == "prismatic" else np.outer(link.axis, link.axis)
    rotor = rotor * float(link.joint.armature)
    six = [rotor[0, 0], rotor[1, 1], rotor[2, 2], rotor[1, 2], rotor[0, 2], rotor[0, 1]]
    mass = float(link.joint.armature) if link.joint.type == "prismatic" else 0.0
    mbs.AddObject(exudyn_items().ObjectRigidBody(nodeNumber=node, mass=mass, inertia=six))


def markers(mbs: Any, mechanism: Mechanism, bodies: list[Any]) -> Callable[[str, Array], Any]:
    """A maker of markers at points of the scene's bodies."""
    items = exudyn_items()

    ground = mbs.AddObject(items.ObjectGround())

    def marker(body: str, point: Array) -> Any:
        index, here = mechanism.frames[body]
        carrier = ground if index < 0 else bodies[index]
        return mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=carrier, localPosition=here.apply(point)))

    return marker


def add_sensors(exu: Any, mbs: Any, body: Any) -> tuple[Any, Any]:
    items = exudyn_items()

    kinds = (exu.OutputVariableType.Position, exu.OutputVariableType.RotationMatrix)
    place, turn = (
        mbs.AddSensor(items.SensorBody(bodyNumber=body, outputVariableType=kind, storeInternal=True, writeToFile=False))
        for kind in kinds
    )
    return place, turn


State = tuple[list[Pose], list[Motion], Array]
"""Poses and motions of the links, and v."""


def add_joint(
    exu: Any, mbs: Any, mechanism: Mechanism, link: Link, marker: Callable[[str, Array], Any], q: Array, state: State
) -> None:
    """The constraint between a link and its parent, and its spring and damper."""
    items = exudyn_items()

    parent = GROUND if link.parent < 0 else mechanism.links[link.parent].name
    if link.joint.type == "floating":
        if link.joint.damping:
            isotropic_damper(mbs, mechanism, link, marker)
        return
    ends = [marker(parent, link.origin.position), marker(link.name, np.zeros(3))]
    if link.joint.type == "helical":
        add_screw(exu, mbs, mechanism, link, ends[1], (q[link.q][0], state[2][link.v][0]))
        return
    oblique = abs(link.axis @ link.axis2) > 1e-14
    if link.joint.type == "universal" and (oblique or any(passive(mechanism, link))):
        add_universal_by_two(exu, mbs, mechanism, link, ends, q, state)
        return
    frame = np.eye(3)
    if link.joint.type == "universal":
        frame = np.column_stack([link.axis, link.axis2, np.cross(link.axis, link.axis2)])
    elif link.joint.type not in ("planar", "spherical"):
        frame = frame_with_z(link.axis)
    outer = link.origin.rotation @ frame
    mbs.AddObject(
        items.ObjectJointGeneric(
            markerNumbers=ends,
            constrainedAxes=AXES_OF[link.joint.type],
            rotationMarker0=outer,
            rotationMarker1=frame,
        )
    )
    if link.joint.type == "spherical":
        if link.joint.damping:
            isotropic_damper(mbs, mechanism, link, marker)
    else:
        add_damper(mbs, passive(mechanism, link), link, ends, outer, frame)


def add_screw(exu: Any, mbs: Any, mechanism: Mechanism, link: Link, end: Any, start: tuple[float, float]) -> None:
    """A helical joint on ground: the child rides on a massless slide and turn, whose coordinates the pitch ties."""
    items = exudyn_items()
    frame, h = frame_with_z(link.axis), link.pitch
    zero = np.zeros(3)
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0.0] * 2,
            initialCoordinates=[h * start[0], start[0]],
            initialCoordinates_t=[h * start[1], start[1]],
            numberOfODE2Coordinates=2,
        )
    )
    carrier = mbs.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[exu.JointType.PrismaticZ, exu.JointType.RevoluteZ],
            linkParents=[-1, 0],
            jointTransformations=exu.Matrix3DList([link.origin.rotation @ frame, np.eye(3)]),
            jointOffsets=exu.Vector3DList([link.origin.position, zero]),
            linkInertiasCOM=exu.Matrix3DList([np.zeros((3, 3))] * 2),
            linkCOMs=exu.Vector3DList([zero, zero]),
            linkMasses=[0.0, 0.0],
        )
    )
    ride = mbs.AddMarker(items.MarkerKinematicTreeRigid(objectNumber=carrier, linkNumber=1, localPosition=zero))
    mbs.AddObject(
        items.ObjectJointGeneric(
            markerNumbers=[ride, end], constrainedAxes=[1] * 6, rotationMarker0=np.eye(3), rotationMarker1=frame
        )
    )
    ends = [mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=k)) for k in (1, 0)]
    mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=ends, factorValue1=1.0 / h))
    stiffness, damping, preload = passive(mechanism, link)
    on_angle = np.diag([0.0, 1.0])
    mbs.AddObject(
        items.ObjectGenericODE2(
            nodeNumbers=[node],
            massMatrix=float(link.joint.armature) * on_angle,
            stiffnessMatrix=stiffness * on_angle,
            dampingMatrix=damping * on_angle,
            forceVector=[0.0, preload],
        )
    )


def passive(mechanism: Mechanism, link: Link) -> tuple[float, float, float]:
    """Stiffness, damping and stiffness·rest on each coordinate of a joint."""
    springs = [s for s in mechanism.scene.forces if isinstance(s, JointSpring) and s.joint == link.joint.name]
    return (
        sum(float(s.stiffness) for s in springs),
        float(link.joint.damping) + sum(float(s.damping) for s in springs),
        sum(float(s.stiffness * s.rest) for s in springs),
    )


def add_damper(
    mbs: Any, facts: tuple[float, float, float], link: Link, ends: list[Any], outer: Array, inner: Array
) -> None:
    """Spring and damper on the turn about and the slide along a joint's axis (z of both frames)."""
    items = exudyn_items()

    stiffness, damping, preload = facts
    if not (stiffness or damping):
        return
    rest = preload / stiffness if stiffness else 0.0
    turns = link.joint.type != "prismatic"
    if turns:
        tracker = mbs.AddNode(items.NodeGenericData(initialCoordinates=[0.0], numberOfDataCoordinates=1))
        mbs.AddObject(
            items.ObjectConnectorTorsionalSpringDamper(
                markerNumbers=ends,
                nodeNumber=tracker,
                stiffness=stiffness,
                damping=damping,
                offset=rest,
                rotationMarker0=outer,
                rotationMarker1=inner,
            )
        )
    if link.joint.type in ("prismatic", "cylindrical"):
        mbs.AddObject(
            items.ObjectConnectorLinearSpringDamper(
                markerNumbers=ends, stiffness=stiffness, damping=damping, axisMarker0=outer[:, 2], offset=rest
            )
        )


def add_universal_by_two(
    exu: Any, mbs: Any, mechanism: Mechanism, link: Link, ends: list[Any], q: Array, state: State
) -> None:
    """A universal joint on oblique or sprung axes: two revolutes and a massless cross between them."""
    items = exudyn_items()

    poses, motions, _v = state
    parent = IDENTITY if link.parent < 0 else poses[link.parent]
    carried = Motion(np.zeros(3), np.zeros(3)) if link.parent < 0 else motions[link.parent]
    # The cross turns with the first angle only: the second one at zero leaves its frame.
    here = parent @ link.origin @ joint_pose(link, np.array([q[link.q][0], 0.0]))
    axis2 = here.rotation @ link.axis2
    child = motions[mechanism.links.index(link)]
    relative = child.angular - carried.angular
    # relative = u1 v1 + u2 v2
    u = np.column_stack([here.rotation @ link.axis, axis2])
    rates = np.linalg.lstsq(u, relative, rcond=None)[0]
    cross = Motion(child.linear, carried.angular + u[:, 0] * rates[0])
    _, body = add_body(exu, mbs, mechanism, 0.0, np.zeros(3), np.zeros((3, 3)), here, cross)
    middle = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=np.zeros(3)))
    first, second = frame_with_z(link.axis), frame_with_z(link.axis2)
    for pair, outer, inner in (
        ([ends[0], middle], link.origin.rotation @ first, first),
        ([middle, ends[1]], second, second),
    ):
        mbs.AddObject(
            items.ObjectJointGeneric(
                markerNumbers=pair,
                constrainedAxes=AXES_OF["revolute"],
                rotationMarker0=outer,
                rotationMarker1=inner,
            )
        )
        add_damper(mbs, passive(mechanism, link), link, pair, outer, inner)
