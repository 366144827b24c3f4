"""Links sorted into classes, sweep by sweep.

A class is what links must have in common to share code: kind, what their constants look like, and which entries of the
states that arrive at them may differ from zero. Patterns are propagated from link to link in the order of the sweep.
Where that gives many classes, small ones are widened: a zero is then a number like any other.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from symgen.algebra.linear import Vec
from symgen.loops.constants import Tabulated, tabulate
from symgen.loops.model import CONSTANTS
from symgen.loops.one_link import Key, OneLink, Pattern, is_nothing
from symgen.loops.slots import ANY, SLOTS, Slots, covers, widened
from symgen.loops.steps import Step
from symgen.program.graph import extract
from symgen.program.instructions import Port, Program
from symgen.scene.model import Scene

MOST = 10
"""Classes a sweep may have before small ones are widened: their code should stay in the instruction cache."""


@dataclass(frozen=True)
class Derived:
    """A step of a class before its constants are tabulated, and the patterns of what it gives."""

    program: Program
    patterns: Mapping[str, Pattern]


@dataclass(frozen=True)
class Sorted:
    """The classes of a sweep."""

    order: tuple[int, ...]
    """Links in the order in which the sweep visits them."""
    number: Mapping[int, int]
    """Class of a link."""
    steps: tuple[Program, ...]
    constants: Mapping[int, tuple]  # type: ignore[type-arg]
    """Constants of a link for its step."""
    patterns: Mapping[int, Mapping[str, Pattern]]
    """By link: patterns of what its step gives."""


@dataclass
class Sorter:
    """Sorts the links that one sweep visits. ``arriving(link, patterns so far)`` gives the states at a link."""

    scene: Scene
    name: str
    links: Sequence[Slots]
    slots: Sequence[int]
    step: Step
    gravity: Vec
    arriving: Callable[[Slots, Mapping[int, Mapping[str, Pattern]]], tuple[tuple[str, Pattern], ...]]
    _derived: dict[Key, Derived] = field(default_factory=dict)

    def sort(self) -> Sorted:
        keys, patterns = self._walk(lambda key: key)
        least = 2
        while len(set(keys.values())) > MOST and least <= 2 * len(self.links):
            keys, patterns = self._walk(self._widening(keys, least))
            least *= 2
        numbers: dict[Key, int] = {}
        for slots in self.links:
            numbers.setdefault(keys[slots.link.index], len(numbers))
        steps, constants = list[Program](), dict[int, tuple]()  # type: ignore[type-arg]
        for key, number in numbers.items():
            members = [slots for slots in self.links if keys[slots.link.index] == key]
            found = self._tabulated(key, number, members)
            steps.append(found.program)
            for slots, row in zip(members, found.rows or [()] * len(members), strict=True):
                constants[slots.link.index] = row
        return Sorted(
            tuple(slots.link.index for slots in self.links),
            {index: numbers[key] for index, key in keys.items()},
            tuple(steps),
            constants,
            patterns,
        )

    def _tabulated(self, key: Key, number: int, members: Sequence[Slots]) -> Tabulated:
        program = self._derive(key, members[0]).program
        found = tabulate(program, [slots.values for slots in members])
        named = Program(
            f"{self.name}_{number}", found.program.inputs, found.program.outputs, found.program.instructions,
            found.program.results,
        )  # fmt: skip
        return Tabulated(named, found.rows)

    def _walk(self, resolve: Callable[[Key], Key]) -> tuple[dict[int, Key], dict[int, Mapping[str, Pattern]]]:
        keys: dict[int, Key] = {}
        patterns: dict[int, Mapping[str, Pattern]] = {}
        for slots in self.links:
            key = resolve(self._key(slots, patterns))
            keys[slots.link.index] = key
            patterns[slots.link.index] = self._derive(key, slots).patterns
        return keys, patterns

    def _key(self, slots: Slots, patterns: Mapping[int, Mapping[str, Pattern]]) -> Key:
        looks = tuple(slots.looks[k] for k in self.slots)
        link = slots.link
        return Key(link.kind, slots.form, link.parent < 0, looks, self.arriving(slots, patterns))

    def _widening(self, keys: Mapping[int, Key], least: int) -> Callable[[Key], Key]:
        """Keys of fewer than ``least`` links become the narrowest kept one that covers them, or that of everything."""
        counts = Counter(keys.values())
        kept = [key for key, times in counts.items() if times >= least]
        groups: dict[object, list[Key]] = {}
        for slots in self.links:
            groups.setdefault(keys[slots.link.index].group, []).append(keys[slots.link.index])
        looks = {group: widened([key.looks for key in dict.fromkeys(found)]) for group, found in groups.items()}

        def resolve(key: Key) -> Key:
            everything = looks.get(key.group, (ANY,) * len(self.slots))
            if not covers(everything, key.looks):
                everything = widened([everything, key.looks])
            whole = Key(
                key.kind, key.form, key.grounded, everything,
                tuple((name, (True,) * len(pattern)) for name, pattern in key.states),
            )  # fmt: skip
            covering = [other for other in kept if other.group == key.group and _covers(other, key)]
            return min(covering, key=_breadth, default=whole)

        return resolve

    def _derive(self, key: Key, slots: Slots) -> Derived:
        if key not in self._derived:
            one = OneLink(self.scene, key, self.slots, slots.link, self.gravity)
            results = self.step(one)
            found = {name: tuple(row) for name, row in results.items()}
            program = extract(
                one.graph,
                self.name,
                _inputs(one),
                tuple(Port(name, (len(row),)) for name, row in found.items()),
                list(found.values()),
            )
            patterns = {name: tuple(not is_nothing(x) for x in row) for name, row in found.items()}
            self._derived[key] = Derived(program, patterns)
        return self._derived[key]


def _covers(wider: Key, narrower: Key) -> bool:
    return covers(wider.looks, narrower.looks) and all(
        a or not b
        for (_, x), (_, y) in zip(wider.states, narrower.states, strict=True)
        for a, b in zip(x, y, strict=True)
    )


def _breadth(key: Key) -> int:
    return sum(look == ANY for look in key.looks) + sum(sum(pattern) for _, pattern in key.states)


def _inputs(one: OneLink) -> tuple[Port, ...]:
    """The ports that a step reads, as large as the state they hold; constants as many as slots."""
    sizes: dict[str, int] = {}
    for node in one.graph.nodes:
        if node.op == "input":
            name, index = node.value
            sizes[name] = max(sizes.get(name, 0), index + 1)
    sizes |= {name: len(pattern) for name, pattern in one.key.states if name in sizes}
    return tuple(
        Port(name, () if name[0] == "w" and name[1:].isdigit() else (SLOTS if name == CONSTANTS else size,))
        for name, size in sizes.items()
    )
