"""Choosing natural coordinates for a tree, and their values at a configuration (paper §3)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Protocol

from symgen.algebra import linear
from symgen.algebra.linear import Mat, Scalar, Vec
from symgen.algebra.numbers import Numbers, State
from symgen.natural.carriers import (
    Candidate,
    Carriers,
    choose_planar,
    choose_spatial,
    invert_planar,
    invert_spatial,
)
from symgen.natural.constraints import build_constraints
from symgen.natural.entities import Entity, Vector
from symgen.natural.forms import ground_position
from symgen.natural.layout import Basis, NaturalCoordinates, base_carrier, constants
from symgen.natural.plane import find_plane, in_plane, turned, vector
from symgen.natural.sharing import PLANAR, SPATIAL, UNSHARED, Slot, joint_vector
from symgen.scene.model import ZERO3
from symgen.topology.tree import Tree, TreeBody


class Pose(Protocol):
    """Where a body is: x_ground = rotation · x_body + origin."""

    @property
    def rotation(self) -> Mat: ...

    @property
    def origin(self) -> Vec: ...


@dataclass
class _Draft:
    """An entity while its bodies are still being found."""

    kind: str
    label: str
    home: int
    local: dict[int, Vector]
    listed: tuple[int, int]
    """The body it is listed under, and its rank there."""
    joint: int | None = None


@dataclass
class _Listing:
    """All drafts; ``known`` finds the entity that is fixed in a body at given coordinates."""

    planes: tuple[Basis, ...] | None
    ground: Basis | None
    drafts: list[_Draft] = field(default_factory=list)
    known: dict[tuple[int, str, tuple[Fraction, ...]], int] = field(default_factory=dict)
    labels: set[str] = field(default_factory=set)
    number: int = 0

    def key(self, body: int, kind: str, local: Vector) -> tuple[int, str, tuple[Fraction, ...]]:
        """In a planar scene points one above the other are the same."""
        if self.planes is None or self.ground is None:
            return (body, kind, local)
        return (body, kind, in_plane(self.ground if body < 0 else self.planes[body], local))

    def next_number(self) -> int:
        self.number += 1
        return self.number

    def label(self, letter: str, number: int | None, superscript: str = "") -> str:
        """``letter`` with the number given if that is still free, else with the next number."""
        if number is None or f"{letter}{number}{superscript}" in self.labels:
            number = self.next_number()
        label = f"{letter}{number}{superscript}"
        self.labels.add(label)
        return label

    def fixed(self, kind: str, places: Mapping[int, Vector]) -> int | None:
        """The entity that is already fixed in the first of these bodies there, extended to the others."""
        body, local = next(iter(places.items()))
        index = self.known.get(self.key(body, kind, local))
        if index is not None:
            self._extend(index, places)
        return index

    def add(self, draft: _Draft) -> int:
        self.drafts.append(draft)
        self._extend(len(self.drafts) - 1, dict(draft.local))
        return len(self.drafts) - 1

    def _extend(self, index: int, places: Mapping[int, Vector]) -> None:
        draft = self.drafts[index]
        for body, local in places.items():
            draft.local.setdefault(body, local)
            self.known.setdefault(self.key(body, draft.kind, local), index)

    def number_of(self, index: int) -> int:
        return int(self.drafts[index].label[1:].split("_")[0])


def choose_coordinates(tree: Tree, planar: bool = True, loose: Collection[str] = ()) -> NaturalCoordinates:
    """Points, unit vectors, mass carriers and constraints of a tree.

    Entities are listed body by body, depth first: those of the incoming joint (parent's side first), then the points
    and vectors that the scene declares, then auxiliary ones. Neighbours share them as their joint says, and an entity
    that falls on one already fixed in the body is that one. With ``planar`` a planar tree gets two coordinates per
    point and no vectors, unless a body declares unit vectors. ``loose`` names joints whose origins are run-time
    arguments: no point and no vector of theirs has constant coordinates in the parent, so nothing is shared across
    them, nothing declared beyond them is a coordinate, and no constraints are stated.
    """
    planar = planar and not loose
    declares = any(part.unit_vectors for body in tree.bodies for part, _ in body.parts)
    found = find_plane(tree) if planar and not declares else None
    ground, planes = found or (None, None)
    listing = _Listing(planes, ground)
    slots = SPATIAL if found is None else PLANAR
    joints = []
    for body in tree.bodies:
        unshared = any(joint.name in loose for joint in body.mount)
        joints.append(tuple(_joint_entities(listing, body, UNSHARED if unshared else slots[body.joint.type])))
        _declared_entities(listing, body, loose)
    members: list[list[int]] = [[] for _ in tree.bodies]
    for k, draft in enumerate(listing.drafts):
        for home in draft.local:
            if home >= 0:
                members[home].append(k)
    carriers = []
    for body in tree.bodies:
        plane = planes[body.index] if planes is not None else None
        carriers.append(_choose_carriers(listing, body, plane, members[body.index]))
    natural = _finish(listing, tree, joints, members, carriers)
    return natural if loose else replace(natural, constraints=build_constraints(natural, tree))


def _joint_entities(listing: _Listing, body: TreeBody, slots: Sequence[Slot]) -> list[int]:
    """The entities of the incoming joint, slot by slot. A vector takes the number of the joint's first point."""
    joint, found = body.joint, []
    number: int | None = None
    for rank, slot in enumerate(slots):
        if slot.kind == "angle":
            found.append(
                listing.add(_Draft("angle", f"phi_{joint.name}", body.index, {}, (body.index, rank), body.index))
            )
            continue
        local = ZERO3 if slot.kind == "point" else joint_vector(body, slot.which)
        sides: dict[int, Vector] = {}
        if slot.side != "child":
            outside = turned(joint.origin.rotation, local) if slot.kind == "vector" else joint.origin.translation
            sides[body.parent] = outside
        if slot.side != "parent":
            sides[body.index] = local
        index = listing.fixed(slot.kind, sides)
        if index is None:
            letter, wanted = ("r", None) if slot.kind == "point" else ("u", number)
            label = listing.label(letter, wanted, slot.superscript)
            index = listing.add(_Draft(slot.kind, label, min(sides), sides, (body.index, rank), body.index))
        if slot.kind == "point" and number is None:
            number = listing.number_of(index)
        found.append(index)
    return found


def _declared_entities(listing: _Listing, body: TreeBody, loose: Collection[str]) -> None:
    """Points and vectors the scene asks for; the k-th point and the k-th vector of a part share a number."""
    rank = 10
    for (part, pose), welds in zip(body.parts, body.welds, strict=True):
        if any(joint.name in loose for joint in welds):
            continue
        for k in range(max(len(part.basic_points), len(part.unit_vectors))):
            number: int | None = None
            for kind, locals_ in (("point", part.basic_points), ("vector", part.unit_vectors)):
                if k >= len(locals_):
                    continue
                local = turned(pose.rotation, locals_[k])
                if kind == "point":
                    local = vector(linear.vadd(local, pose.translation))
                index = listing.fixed(kind, {body.index: local})
                if index is None:
                    label = listing.label("r" if kind == "point" else "u", number)
                    rank += 1
                    index = listing.add(_Draft(kind, label, body.index, {body.index: local}, (body.index, rank)))
                number = listing.number_of(index)


def _choose_carriers(listing: _Listing, body: TreeBody, plane: Basis | None, members: list[int]) -> Carriers:
    """The carriers of one body; auxiliary entities are appended to the listing and to ``members``."""
    candidates = [
        Candidate(draft.kind, draft.local[body.index], draft.home != body.index)
        for draft in (listing.drafts[k] for k in members)
    ]
    chosen = choose_spatial(body, candidates) if plane is None else choose_planar(body, plane, candidates)
    for rank, auxiliary in enumerate(chosen.auxiliary):
        label = listing.label("u" if auxiliary.kind == "vector" else "r", None)
        place = {body.index: auxiliary.local}
        members.append(listing.add(_Draft(auxiliary.kind, label, body.index, place, (body.index, 100000 + rank))))
    return replace(chosen, chosen=tuple(members[k] for k in chosen.chosen))


def _finish(
    listing: _Listing,
    tree: Tree,
    joints: Sequence[tuple[int, ...]],
    members: Sequence[list[int]],
    carriers: Sequence[Carriers],
) -> NaturalCoordinates:
    """Put the drafts in listing order and give them their rows in x."""
    order = sorted(range(len(listing.drafts)), key=lambda k: listing.drafts[k].listed)
    index = {draft: place for place, draft in enumerate(order)}
    entities, nn = [], 0
    for k in order:
        draft = listing.drafts[k]
        size = 1 if draft.kind == "angle" else (3 if listing.planes is None else 2)
        start = nn if draft.home >= 0 else None
        entities.append(Entity(draft.kind, draft.label, draft.home, draft.local, start, size, draft.joint))
        nn += size if start is not None else 0
    natural = NaturalCoordinates(
        plane=listing.ground,
        body_planes=listing.planes or (),
        entities=tuple(entities),
        nn=nn,
        members=tuple(tuple(sorted(index[k] for k in row)) for row in members),
        joints=tuple(tuple(index[k] for k in row) for row in joints),
        carriers=tuple(tuple(sorted(index[k] for k in row.chosen)) for row in carriers),
        W=(),
        W_inverse=(),
        conditions=tuple(row.condition for row in carriers),
    )
    pairs = [_carrier_matrices(natural, body.index) for body in tree.bodies]
    return replace(natural, W=tuple(w for w, _ in pairs), W_inverse=tuple(inverse for _, inverse in pairs))


def _carrier_matrices(natural: NaturalCoordinates, body: int) -> tuple[Mat, Mat]:
    carriers = [natural.entities[k] for k in natural.carriers[body]]
    locals_ = [entity.local[body] for entity in carriers]
    if natural.plane is not None:
        basis = natural.body_planes[body]
        return invert_planar(in_plane(basis, locals_[0]), in_plane(basis, locals_[1]))
    return invert_spatial([entity.kind for entity in carriers], locals_, base_carrier(natural, body))


def ground_coordinates(natural: NaturalCoordinates) -> dict[int, tuple[Fraction, ...]]:
    """Entity index → its constant coordinates, for the entities fixed in ground."""
    found: dict[int, tuple[Fraction, ...]] = {}
    for k, entity in enumerate(natural.entities):
        if entity.start is None:
            found[k] = ground_position(natural, k)
    return found


def entity_position(
    natural: NaturalCoordinates, entity: Entity, poses: Sequence[Pose], numbers: Numbers | None = None
) -> Vec:
    """Point: r + A x; vector: A u; ground axes, or components along e1 and e2 in planar scenes. Not for angles."""
    local = constants(entity.local[entity.home], numbers)
    if entity.home < 0:
        position = local
    else:
        pose = poses[entity.home]
        position = linear.matvec(pose.rotation, local)
        if entity.kind == "point":
            position = linear.vadd(pose.origin, position)
    if natural.plane is None:
        return position
    return tuple(linear.dot(constants(axis, numbers), position) for axis in natural.plane[:2])


def natural_coordinates(
    natural: NaturalCoordinates, tree: Tree, poses: Sequence[Pose], state: State, numbers: Numbers | None = None
) -> tuple[Scalar, ...]:
    """x (nn): the moving entities in listing order; a screw joint's angle is the joint's q."""
    x: list[Scalar] = []
    for k in natural.moving:
        entity = natural.entities[k]
        if entity.kind == "angle":
            x.append(state.q[tree.bodies[entity.home].q])
        else:
            x.extend(entity_position(natural, entity, poses, numbers))
    return tuple(x)
