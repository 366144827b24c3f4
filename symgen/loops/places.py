"""Where states live: arrays of few places, used again when nobody needs what is there any more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symgen.plans.links import Link


@dataclass(frozen=True)
class Pool:
    """Places of states of links, and how many there are."""

    place: Mapping[int, int]
    """By link: where its state is (outward), or where what its children send arrives (inward)."""
    count: int


class _Free:
    """Places that are free, lowest first."""

    def __init__(self, reserved: int) -> None:
        self.free: list[int] = []
        self.count = reserved

    def take(self) -> int:
        if self.free:
            return self.free.pop(self.free.index(min(self.free)))
        self.count += 1
        return self.count - 1


def outward_pool(links: Sequence[Link]) -> Pool:
    """A place for the state of every link, kept until its last child has read it."""
    last = {link.parent: link.index for link in links}
    pool, place = _Free(0), dict[int, int]()
    for link in links:
        place[link.index] = pool.take()
        if link.index not in last:
            pool.free.append(place[link.index])
        if link.parent >= 0 and last[link.parent] == link.index:
            pool.free.append(place[link.parent])
    return Pool(place, pool.count)


def inward_pool(links: Sequence[Link], reserved: int) -> Pool:
    """A place for what arrives at every link with children, from its first child on, after ``reserved`` ones."""
    pool, place = _Free(reserved), dict[int, int]()
    for link in reversed(links):
        if link.parent >= 0 and link.parent not in place:
            place[link.parent] = pool.take()
        if link.index in place:
            pool.free.append(place[link.index])
    return Pool(place, pool.count)


def branches(links: Sequence[Link]) -> bool:
    """Whether any link has several children."""
    parents = [link.parent for link in links if link.parent >= 0]
    return len(set(parents)) < len(parents)
