"""States carried from one layout to another."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from symgen.conventions.layouts import Follower, Layout, symgen_layout
from symgen.conventions.quaternions import Array
from symgen.conventions.slots import Slot, read_a, read_q, read_v, write_a, write_q, write_v
from symgen.errors import SceneError
from symgen.system import System

Held = Mapping[str, float | Sequence[float]]
"""Positions, as the other side writes them, of joints that only the other side has: those the scene locks."""

Parts = dict[str, Array]
"""Joint → its part of q, v, a or tau, in symgen's spelling and a free joint's velocity mixed."""


@dataclass(frozen=True)
class Converter:
    """Carries states from ``source`` to ``target``. ``q`` is always the source's; arrays (n,) or (N, n)."""

    source: Layout
    target: Layout
    followers: tuple[Follower, ...] = ()

    def q(self, q: ArrayLike) -> Array:
        """Positions. Quaternions keep their length; an angle from (cos, sin) lies in −π…π."""
        given = _checked(q, self.source.nq, "q", self.source.owner)
        parts = self._expanded(self._q(given), shifted=True)
        result = np.broadcast_to(self.target.neutral, (*given.shape[:-1], self.target.nq)).copy()
        for slot in self.target.slots:
            if slot.name in parts:
                result[..., slot.q : slot.q + slot.nq] = write_q(slot, parts[slot.name])
        return result

    def v(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Velocities."""
        at = self._q(_checked(q, self.source.nq, "q", self.source.owner))
        return self._joined(at, self._v(at, v), write_v)

    def a(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Accelerations: the time derivatives of the components of v."""
        at = self._q(_checked(q, self.source.nq, "q", self.source.owner))
        speed = self._v(at, v)
        given = self._split(a, "a")
        parts = {
            slot.name: read_a(slot, at[slot.name], speed[slot.name], given[slot.name]) for slot in self.source.slots
        }
        speed = self._expanded(speed)
        return self._joined(at, parts, lambda slot, x, common: write_a(slot, x, speed[slot.name], common))

    def tau(self, q: ArrayLike, tau: ArrayLike) -> Array:
        """Generalised forces, so that the power tau · v is the same.

        A mimic joint's force acts on its master; where the target has the mimic joint too, it gets none.
        """
        at = self._q(_checked(q, self.source.nq, "q", self.source.owner))
        given = self._split(tau, "tau")
        parts = {slot.name: read_v(slot, at[slot.name], given[slot.name]) for slot in self.source.slots}
        for follower in self.followers:
            if follower.name in parts:
                parts[follower.master] = parts[follower.master] + follower.multiplier * parts.pop(follower.name)
            else:
                parts[follower.name] = 0 * parts[follower.master]
        return self._joined(at, parts, write_v, expanded=True)

    def _q(self, q: Array) -> Parts:
        return {slot.name: read_q(slot, q) for slot in self.source.slots}

    def _v(self, at: Parts, v: ArrayLike) -> Parts:
        given = self._split(v, "v")
        return {slot.name: read_v(slot, at[slot.name], given[slot.name]) for slot in self.source.slots}

    def _split(self, values: ArrayLike, what: str) -> Parts:
        given = _checked(values, self.source.nv, what, self.source.owner)
        return {slot.name: given[..., slot.v : slot.v + slot.nv] for slot in self.source.slots}

    def _expanded(self, parts: Parts, shifted: bool = False) -> Parts:
        """With every mimic joint's part made from its master's."""
        made = {
            f.name: f.multiplier * parts[f.master] + (f.offset if shifted else 0.0)
            for f in self.followers
            if f.master in parts
        }
        return {**parts, **made}

    def _joined(
        self, at: Parts, parts: Parts, write: Callable[[Slot, Array, Array], Array], expanded: bool = False
    ) -> Array:
        at, parts = self._expanded(at, shifted=True), parts if expanded else self._expanded(parts)
        shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts.values()))
        result = np.zeros((*shape, self.target.nv))
        for slot in self.target.slots:
            if slot.name in parts:
                result[..., slot.v : slot.v + slot.nv] = write(slot, at[slot.name], parts[slot.name])
        return result


def _checked(values: ArrayLike, size: int, what: str, owner: str) -> Array:
    array = np.asarray(values, dtype=float)
    if array.ndim < 1 or array.shape[-1] != size:
        raise SceneError(f"{what} of {owner} has {size} numbers, not the shape {array.shape}")
    return array


def between(system: System, other: Layout, held: Held | None, forward: bool) -> Converter:
    """The converter between symgen and another layout whose joints are matched by name (a lone free joint by kind)."""
    ours, followers = symgen_layout(system)
    other = _matched(ours, other)
    known = {slot.name: slot for slot in other.slots}
    for slot in ours.slots:
        if slot.name not in known:
            raise SceneError(f"joint {slot.name!r} has no counterpart in {other.owner}: {_names(known)}")
        if known[slot.name].common != slot.common:
            theirs = known[slot.name].common
            raise SceneError(f"joint {slot.name!r} has {slot.common} here and {theirs} in {other.owner}")
    names = {slot.name for slot in ours.slots} | {follower.name for follower in followers}
    if not forward:
        kept = tuple(slot for slot in other.slots if slot.name in names)
        return Converter(replace(other, slots=kept), ours, followers)
    neutral = other.neutral.copy()
    for name, slot in known.items():
        if name not in names and name not in (held or {}):
            raise SceneError(f"joint {name!r} of {other.owner} is not in the scene: say with held where it stands")
        if name not in names and held is not None:
            neutral[slot.q : slot.q + slot.nq] = np.asarray(held[name], dtype=float)
    return Converter(ours, replace(other, neutral=neutral), followers)


def _matched(ours: Layout, other: Layout) -> Layout:
    """``other`` with its one free joint called as ours is: the names of floating bases are everybody's own."""
    mine = [slot for slot in ours.slots if slot.kind == "free"]
    theirs = [slot for slot in other.slots if slot.kind == "free"]
    if len(mine) != 1 or len(theirs) != 1:
        return other
    slots = tuple(replace(slot, name=mine[0].name) if slot is theirs[0] else slot for slot in other.slots)
    return replace(other, slots=slots)


def _names(names: Mapping[str, Slot]) -> str:
    text = ", ".join(names)
    return f"its joints are {text}" if len(text) < 200 else f"it has {len(names)} joints"
