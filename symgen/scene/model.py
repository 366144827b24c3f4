"""The scene: what is described and what is asked, with every number exact.

Frozen dataclasses only. They are made by the loaders (`symgen.scene.load`) and by the
Python builder, both of which validate; everything downstream may rely on the invariants
stated here. Angles are radians, everything else SI.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

Vector = tuple[Fraction, Fraction, Fraction]
Matrix3 = tuple[Vector, Vector, Vector]
"""Three rows."""

GROUND = "ground"

ZERO3: Vector = (Fraction(0), Fraction(0), Fraction(0))
IDENTITY3: Matrix3 = (
    (Fraction(1), Fraction(0), Fraction(0)),
    (Fraction(0), Fraction(1), Fraction(0)),
    (Fraction(0), Fraction(0), Fraction(1)),
)


@dataclass(frozen=True)
class Transform:
    """Pose of a frame in another: x_outer = rotation · x_inner + translation.

    ``rotation`` is exactly orthogonal (rational quaternion or signed permutation).
    """

    rotation: Matrix3 = IDENTITY3
    translation: Vector = ZERO3


@dataclass(frozen=True)
class Body:
    """A rigid body. ``com`` in body axes from the body origin; ``inertia`` is
    (ixx, iyy, izz, ixy, ixz, iyz) about the centre of mass in body axes (matrix entries,
    so ixy is *minus* the product of inertia integral)."""

    name: str
    mass: Fraction = Fraction(0)
    com: Vector = ZERO3
    inertia: tuple[Fraction, Fraction, Fraction, Fraction, Fraction, Fraction] = (Fraction(0),) * 6
    basic_points: tuple[Vector, ...] = ()
    """Extra basic points the user wants as natural coordinates, body frame."""
    unit_vectors: tuple[Vector, ...] = ()
    """Extra unit vectors the user wants as natural coordinates, body frame, exactly unit."""


@dataclass(frozen=True)
class Mimic:
    """A linear coupling: the joint's position is multiplier · (position of ``joint``) + offset (URDF's mimic)."""

    joint: str
    multiplier: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)


@dataclass(frozen=True)
class Joint:
    """An edge of the graph. ``origin`` is the joint frame in the parent's frame; the child's
    frame coincides with the joint frame at zero position. ``axis`` (on the parent's side) and
    ``axis2`` (universal, on the child's side) are exact rational unit vectors in joint axes."""

    name: str
    type: str
    parent: str
    child: str
    origin: Transform = Transform()
    axis: Vector | None = None
    axis2: Vector | None = None
    pitch: Fraction | None = None
    armature: Fraction = Fraction(0)
    damping: Fraction = Fraction(0)
    cut: bool = False
    """The user asks that this joint be cut when it lies on a cycle."""
    limits: tuple[tuple[str, float], ...] = ()
    """What the source says of limits (lower, upper, velocity, effort); kept for the manifest."""
    mimic: Mimic | None = None
    """Moved by another joint: it has no coordinate of its own. One-dof joints only."""


@dataclass(frozen=True)
class Spring:
    """Spring–damper between two points of two bodies (``ground`` allowed), along the line joining them.
    Tension = stiffness·(distance − length) + damping·(rate of distance)."""

    between: tuple[str, str]
    points: tuple[Vector, Vector]
    stiffness: Fraction = Fraction(0)
    damping: Fraction = Fraction(0)
    length: Fraction = Fraction(0)
    name: str = ""


@dataclass(frozen=True)
class JointSpring:
    """Spring–damper on every coordinate of a joint (not spherical, not floating):
    force = −stiffness·(q − rest) − damping·v."""

    joint: str
    stiffness: Fraction = Fraction(0)
    damping: Fraction = Fraction(0)
    rest: Fraction = Fraction(0)
    name: str = ""


@dataclass(frozen=True)
class Frame:
    """A named frame fixed in a body (or in ground)."""

    name: str
    body: str
    origin: Transform = Transform()


@dataclass(frozen=True)
class Output:
    """One function to emit: ``name`` and the catalogue rows it holds (one, or several that share work)."""

    name: str
    of: tuple[str, ...]


@dataclass(frozen=True)
class Parameter:
    """A run-time argument. ``name`` as in the scene (``link1.mass``), ``default`` its values."""

    name: str
    default: tuple[Fraction, ...]
    unit: str
    start: int
    """Position of the first value in the argument ``p``."""

    @property
    def size(self) -> int:
        return len(self.default)


@dataclass(frozen=True)
class Options:
    base_velocity: str = "world"  # world | body | mixed
    precision: str = "double"  # double | float
    trigonometry: str = "polynomial"  # polynomial | libm
    snap: Fraction = Fraction(1, 1000000)
    status: bool = False
    batch: bool = False
    code: str | None = None  # straight | loops; None: whichever runs faster
    targets: tuple[str, ...] = ("c", "casadi")


@dataclass(frozen=True)
class Scene:
    name: str
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    gravity: Vector = (Fraction(0), Fraction(0), Fraction(-981, 100))
    forces: tuple[Spring | JointSpring, ...] = ()
    frames: tuple[Frame, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    outputs: tuple[Output, ...] = ()
    """Empty: the default set of the catalogue."""
    options: Options = Options()
    notes: tuple[str, ...] = ()
    """What the loader did that a user should know: snapped rotations, ignored elements."""
    source: str = ""
    """Base name of the file it came from, for messages; never a path."""
    sha256: str = ""
    """Hash of the canonical form of the scene's meaning (not of its bytes)."""
    raw: dict[str, object] = field(default_factory=dict, compare=False, repr=False)
    """What snapping changed: {"joint name": original 3×3 rotation as floats}; for validators."""
    description: object = field(default=None, compare=False, repr=False)
    """What the scene was made from (`symgen.scene.document.Description`), where that can be changed and made again."""

    @property
    def runtime_origins(self) -> frozenset[str]:
        """Joints whose origins are run-time arguments."""
        return frozenset(p.name.rpartition(".")[0] for p in self.parameters if p.name.endswith((".xyz", ".rpy")))

    def body(self, name: str) -> Body:
        for body in self.bodies:
            if body.name == name:
                return body
        raise KeyError(name)

    def joint(self, name: str) -> Joint:
        for joint in self.joints:
            if joint.name == name:
                return joint
        raise KeyError(name)
