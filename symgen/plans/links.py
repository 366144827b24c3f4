"""Lowering a tree to elementary links in body axes: what the recursive plans walk.

Every joint becomes one or several elementary joints (a universal joint two turns with a massless link between,
a planar joint two slides and a turn), and every link gets axes of its own in which its joint moves along z.
Frames are free, so they are chosen to make zeros: origins slide along turning axes until offsets vanish. All of it
is exact, and none of it is trusted: whatever is computed from it is certified against the literal definition.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symgen.algebra.linear import IDENTITY, Mat, Vec, dot, matmul, matvec, scale, transpose, vadd, vsub
from symgen.scene.model import Joint
from symgen.topology.tree import Tree
from symgen.velocity.values import Values

TURN, SLIDE, SCREW, BALL, FREE = "turn", "slide", "screw", "ball", "free"
Z: Vec = (0, 0, 1)


@dataclass(frozen=True)
class Elementary:
    """One elementary motion of a joint: its kind, its axis in joint axes, and its places in the joint's q and v."""

    kind: str
    axis: Vec
    q: int
    v: int


def elementary_motions(joint: Joint) -> tuple[Elementary, ...]:
    """How a joint type is built of elementary motions, from the parent's side to the child's."""
    axis: Vec = joint.axis or Z
    axis2: Vec = joint.axis2 or Z
    table: dict[str, tuple[Elementary, ...]] = {
        "revolute": (Elementary(TURN, axis, 0, 0),),
        "continuous": (Elementary(TURN, axis, 0, 0),),
        "prismatic": (Elementary(SLIDE, axis, 0, 0),),
        "helical": (Elementary(SCREW, axis, 0, 0),),
        "cylindrical": (Elementary(TURN, axis, 0, 0), Elementary(SLIDE, axis, 1, 1)),
        "universal": (Elementary(TURN, axis, 0, 0), Elementary(TURN, axis2, 1, 1)),
        "planar": (
            Elementary(SLIDE, (1, 0, 0), 0, 0),
            Elementary(SLIDE, (0, 1, 0), 1, 1),
            Elementary(TURN, Z, 2, 2),
        ),
        "spherical": (Elementary(BALL, Z, 0, 0),),
        "floating": (Elementary(FREE, Z, 0, 0),),
    }
    return table[joint.type]


@dataclass(frozen=True)
class Link:
    """An elementary link. ``turn`` (K) takes link axes to the parent's axes at zero position, ``offset`` is the link's
    origin in the parent's axes at zero position; the joint then moves along the link's z (ball and free: any way)."""

    index: int
    parent: int
    kind: str
    joint: Joint
    body: int
    """Tree body whose joint this belongs to."""
    carries: bool
    """True for the last elementary link of a joint: the one the body's mass hangs on."""
    q: int
    v: int
    """Places among all joint coordinates of the tree, coupled joints' own ones included."""
    turn: Mat
    offset: Vec
    axes: Mat
    """Link axes to the body's own axes: x_body = axes x_link + shift."""
    shift: Vec
    loose: bool
    """True when turn and offset are not exact numbers but scalars: they hold run-time arguments."""
    planar: bool
    """True when from here to the root every link's z is parallel to its parent's: then only the moments of inertia
    about z matter on the way, and turning does not change those."""

    @property
    def nv(self) -> int:
        return {BALL: 3, FREE: 6}.get(self.kind, 1)

    @property
    def name(self) -> str:
        return self.joint.child if self.carries else f"{self.joint.child}_{self.v}"


def axes_with_z(axis: Vec) -> Mat:
    """A rational rotation that takes z to a rational unit vector; a signed permutation where the axis allows."""
    x, y, z = axis
    if (x, y) == (0, 0):
        return IDENTITY if z > 0 else ((1, 0, 0), (0, -1, 0), (0, 0, -1))
    if (y, z) == (0, 0):
        return ((0, 0, 1), (1, 0, 0), (0, 1, 0)) if x > 0 else ((0, 0, -1), (1, 0, 0), (0, -1, 0))
    if (x, z) == (0, 0):
        return ((0, 1, 0), (0, 0, 1), (1, 0, 0)) if y > 0 else ((0, 1, 0), (0, 0, -1), (-1, 0, 0))
    # Half a turn about the bisector b of z and the axis: 2 b bᵀ/(b·b) − 1.
    b = vadd(axis, Z)
    k = Fraction(2) / dot(b, b)
    return tuple(tuple(k * bi * bj - (1 if i == j else 0) for j, bj in enumerate(b)) for i, bi in enumerate(b))


def lower(tree: Tree, values: Values | None = None) -> tuple[Link, ...]:
    """The elementary links of a tree, parents first, with origins slid to make offsets sparse. ``values`` are needed
    where origins are run-time arguments."""
    links: list[Link] = []
    last: dict[int, int] = {-1: -1}
    q = v = 0
    for body in tree.bodies:
        motions = elementary_motions(body.joint)
        parent = last[body.parent]
        rotation: Mat = body.joint.origin.rotation
        translation: Vec = body.joint.origin.translation
        loose = values is not None and any(values.is_runtime(joint) for joint in body.mount)
        if values is not None and loose:
            rotation, translation = values.placed(body.mount, body.joint.origin)
        for place, motion in enumerate(motions):
            axes = axes_with_z(motion.axis)
            before = links[parent].axes if parent >= 0 else IDENTITY
            turn = matmul(transpose(before), matmul(rotation, axes))
            parallel = not loose and motion.kind in (TURN, SLIDE, SCREW) and abs(turn[2][2]) == 1
            links.append(
                Link(
                    index=len(links),
                    parent=parent,
                    kind=motion.kind,
                    joint=body.joint,
                    body=body.index,
                    carries=place == len(motions) - 1,
                    q=q + motion.q,
                    v=v + motion.v,
                    turn=turn,
                    offset=matvec(transpose(before), translation),
                    axes=axes,
                    shift=(0, 0, 0),
                    loose=loose,
                    planar=(parent < 0 and not loose) or (parallel and links[parent].planar),
                )
            )
            parent = len(links) - 1
            rotation, translation, loose = IDENTITY, (0, 0, 0), False
        last[body.index] = parent
        q, v = q + body.nq, v + body.nv
    return _slide_origins(tuple(links))


def _offset_after(link: Link, slides: Sequence[Fraction | int]) -> Vec:
    own = scale(slides[link.index], tuple(row[2] for row in link.turn))
    parent = (0, 0, slides[link.parent]) if link.parent >= 0 else (0, 0, 0)
    return vsub(vadd(link.offset, own), parent)


def _weight(link: Link, offset: Vec) -> int:
    """How dear an offset is: its non-zero entries, none where the parent is ground."""
    return 0 if link.parent < 0 else sum(1 for x in offset if x != 0)


def _slide_origins(links: tuple[Link, ...]) -> tuple[Link, ...]:
    """Slide the origins of turning links along their axes until no single slide makes the offsets sparser."""
    children: list[list[Link]] = [[] for _ in links]
    for link in links:
        if link.parent >= 0:
            children[link.parent].append(link)
    slides: list[Fraction | int] = [0] * len(links)

    def cost(link: Link) -> int:
        return sum(_weight(near, _offset_after(near, slides)) for near in (link, *children[link.index]))

    def candidates(link: Link) -> set[Fraction | int]:
        found = {slides[link.index]}
        offset, axis = _offset_after(link, slides), tuple(row[2] for row in link.turn)
        found |= {slides[link.index] - x / a for x, a in zip(offset, axis, strict=True) if a != 0}
        found |= {
            slides[link.index] + _offset_after(child, slides)[2] for child in children[link.index] if not child.loose
        }
        return found

    for _ in range(4):
        changed = False
        for link in links:
            if link.kind != TURN or link.loose:
                continue
            before, kept = cost(link), slides[link.index]
            options = []
            for option in sorted(candidates(link)):
                slides[link.index] = option
                options.append((cost(link), option != kept, abs(option), option))
            slides[link.index] = min(options)[3]
            changed = changed or min(options)[0] < before
        if not changed:
            break
    return tuple(
        replace(
            link,
            offset=_offset_after(link, slides),
            shift=scale(slides[link.index], tuple(row[2] for row in link.axes)),
        )
        for link in links
    )
