"""The loops of a function: which sweeps its rows need, in which order, on which arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from symgen.algebra.linear import Vec
from symgen.catalogue import function_name, function_summary, input_ports, output_ports, sizes, split_row
from symgen.errors import SceneError
from symgen.loops import steps
from symgen.loops.classes import Sorted, Sorter
from symgen.loops.model import (
    CONSTANTS,
    Angles,
    Clear,
    Diagonal,
    Join,
    LoopProgram,
    Mirror,
    Part,
    Spread,
    Sweep,
    Zeros,
)
from symgen.loops.one_link import Pattern, frame_size
from symgen.loops.places import branches, inward_pool, outward_pool
from symgen.loops.slots import ARMATURE_AT, DAMPING_AT, INERTIAL, PLACED, WHOLE, Slots, link_slots
from symgen.natural.layout import NaturalCoordinates
from symgen.plans.links import SCREW, TURN, Link
from symgen.plans.walk import Lowered
from symgen.scene.model import Output

ROWS = frozenset({"inverse_dynamics", "bias_force", "gravity_force", "mass_matrix", "forward_dynamics"})
"""Rows that can be computed in loops."""
PLANS = {
    "inverse_dynamics": "recursive",
    "bias_force": "recursive",
    "gravity_force": "recursive",
    "mass_matrix": "composite",
    "forward_dynamics": "articulated",
}
Patterns = Mapping[int, Mapping[str, Pattern]]
Offsets = Mapping[str, Callable[[Link], int]]


def why_not(lowered: Lowered, output: Output) -> str:
    """Why a function cannot be computed in loops; empty where it can."""
    others = [row for row in output.of if split_row(row)[0] not in ROWS]
    scene = lowered.scene
    if others:
        return f"{others[0]} is not computed in loops"
    if scene.parameters:
        return "run-time parameters"
    if scene.forces and not set(output.of) <= {"mass_matrix", "gravity_force"}:
        return "springs"
    if lowered.tree.coupled:
        return "coupled joints"
    return "" if lowered.links else "no joints"


def build_loops(lowered: Lowered, natural: NaturalCoordinates, output: Output) -> LoopProgram:
    """The loops of one function. Raises SceneError where it cannot be computed so."""
    reason = why_not(lowered, output)
    if reason:
        raise SceneError(f"{output.name}: no loops with {reason}", "options.code")
    size = sizes(lowered.scene, lowered.tree, natural)
    inputs, outputs = input_ports(output.of, size), output_ports(output.of, size)
    maker = _Maker(lowered)
    maker.placements()
    for row, port in zip(output.of, outputs, strict=True):
        ROW_MAKERS[row](maker, port.name)
    plan = " + ".join(dict.fromkeys(PLANS[row] for row in output.of))
    return LoopProgram(
        function_name(output.name),
        inputs,
        outputs,
        (),
        ((),) * len(outputs),
        tuple(range(len(maker.pivots))),
        f"{plan}, in loops",
        function_summary(output),
        tuple(maker.parts),
        maker.locals,
        maker.pivots,
    )


@dataclass
class _Maker:
    """Collects the parts of one function; rows share the sweeps that they have in common."""

    lowered: Lowered
    parts: list[Part] = field(default_factory=list)
    locals: dict[str, int] = field(default_factory=dict)
    pivots: dict[str, int] = field(default_factory=dict)
    wrenches: dict[str, Patterns] = field(default_factory=dict)
    """Arrays of wrenches that the sweep of motions has left, with their patterns."""

    @cached_property
    def slots(self) -> list[Slots]:
        return link_slots(self.lowered)

    @property
    def links(self) -> Sequence[Link]:
        return self.lowered.links

    @property
    def nv(self) -> int:
        return self.lowered.tree.nv

    @cached_property
    def gravity(self) -> Vec:
        return tuple(int(x) if x == 0 else x for x in self.lowered.scene.gravity)

    @cached_property
    def has_armature(self) -> bool:
        return any(slots.values[ARMATURE_AT] for slots in self.slots)

    @cached_property
    def angle_of(self) -> dict[int, int]:
        """Turning link → where its sine and cosine are."""
        turning = [link for link in self.links if link.kind in (TURN, SCREW)]
        return {link.index: k for k, link in enumerate(turning)}

    @cached_property
    def frame_of(self) -> dict[int, int]:
        """Link whose rotation is kept as a whole → where it is."""
        found, start = dict[int, int](), 0
        for slots in self.slots:
            if slots.form == WHOLE:
                found[slots.link.index] = start
                start += frame_size(slots.link.kind)
        return found

    def placements(self) -> None:
        """Sines and cosines, and the rotations that are kept whole."""
        if self.angle_of:
            self.parts.append(Angles(tuple(self.links[k].q for k in self.angle_of)))
            padded = len(self.angle_of) + -len(self.angle_of) % 4
            self.locals |= {"angles": padded, "sines": padded, "cosines": padded}
        if self.frame_of:
            whole = [slots for slots in self.slots if slots.form == WHOLE]
            self.locals["frames"] = sum(frame_size(slots.link.kind) for slots in whole)
            found = self.sorter("place", whole, PLACED, steps.place, lambda slots, patterns: ()).sort()
            self.sweep("place", "rotations", found, {"frame": "frames"}, {})

    def sorter(
        self, name: str, links: Sequence[Slots], slots: Sequence[int], step: steps.Step, arriving: object
    ) -> Sorter:
        return Sorter(self.lowered.scene, name, links, tuple(slots), step, self.gravity, arriving)  # type: ignore[arg-type]

    def sweep(
        self,
        name: str,
        heading: str,
        found: Sorted,
        arrays: Mapping[str, str],
        offsets: Offsets,
        join: tuple[str, int, Callable[[Link], int], Callable[[Link], int]] | None = None,
        span: tuple[Callable[[Link], int], Callable[[Link], int]] | None = None,
    ) -> None:
        """Lay out the table of a sweep: the class of every link, then the offsets, equal columns once."""
        ports = {port.name for step in found.steps for port in (*step.inputs, *step.outputs) if port.shape}
        standard: dict[str, Callable[[Link], int]] = {
            "c": lambda link: self.angle_of.get(link.index, 0),
            "s": lambda link: self.angle_of.get(link.index, 0),
            "frame": lambda link: self.frame_of.get(link.index, 0),
            "q": lambda link: link.q,
            "v": lambda link: link.v,
            "a": lambda link: link.v,
            "tau": lambda link: link.v,
            "result": lambda link: link.v,
        }
        constants, starts = list[Fraction](), dict[int, int]()
        for index in found.order:
            starts[index] = len(constants)
            constants.extend(found.constants[index])
        standard[CONSTANTS] = lambda link: starts[link.index]
        standard |= offsets
        rows = [self.links[index] for index in found.order]
        columns: dict[tuple[int, ...], int] = {tuple(found.number[link.index] for link in rows): 0}
        place = {
            port: columns.setdefault(tuple(standard[port](link) for link in rows), len(columns))
            for port in sorted(ports & standard.keys())
        }
        joined = None
        if join is not None:
            array, size, to, used = join
            ends = [columns.setdefault(tuple(end(link) for link in rows), len(columns)) for end in (to, used)]
            joined = Join(array, size, *ends)
        spanned = None
        if span is not None:
            first, end = (columns.setdefault(tuple(edge(link) for link in rows), len(columns)) for edge in span)
            spanned = (first, end)
        known = {"c": "cosines", "s": "sines", "frame": "frames", "q": "q", "v": "v", "a": "a", "tau": "tau"}
        table = tuple(zip(*columns, strict=True))
        self.parts.append(
            Sweep(
                name, heading, found.steps,
                {port: array for port, array in (known | dict(arrays)).items() if port in ports},
                place, table, tuple(constants), joined, spanned,
            )
        )  # fmt: skip

    # --- states that go outward and inward -------------------------------------------------------------------------

    def outward(
        self, name: str, heading: str, step: steps.Step, slots: Sequence[int], size: int, **more: object
    ) -> Sorted:
        """A sweep from the root to the leaves with a state ``up`` → ``own`` of ``size``."""
        pool = outward_pool(self.links)
        extra: Mapping[str, Patterns] = more.get("states", {})  # type: ignore[assignment]

        def arriving(one: Slots, patterns: Patterns) -> tuple[tuple[str, Pattern], ...]:
            own = [("up", patterns[one.link.parent]["own"])] if one.link.parent >= 0 else []
            return (*own, *((port, found[one.link.index][port]) for port, found in extra.items()))

        found = self.sorter(name, self.slots, slots, step, arriving).sort()
        state = f"{name}_state"
        self.locals[state] = size * pool.count
        self.sweep(
            name,
            heading,
            found,
            {"up": state, "own": state, **more.get("arrays", {})},  # type: ignore[dict-item]
            {
                "up": lambda link: size * pool.place[link.parent] if link.parent >= 0 else 0,
                "own": lambda link: size * pool.place[link.index],
                **more.get("offsets", {}),  # type: ignore[dict-item]
            },
        )
        return found

    def inward(
        self, name: str, heading: str, step: steps.Step, slots: Sequence[int], size: int, **more: object
    ) -> Sorted:
        """A sweep from the leaves to the root with a state that children send and that arrives as their sum."""
        joining = branches(self.links)
        pool = inward_pool(self.links, 1 if joining else 0)
        extra: Mapping[str, Patterns] = more.get("states", {})  # type: ignore[assignment]
        children: dict[int, list[int]] = {}
        for link in self.links:
            children.setdefault(link.parent, []).append(link.index)

        def arriving(one: Slots, patterns: Patterns) -> tuple[tuple[str, Pattern], ...]:
            sent = [patterns[child]["sent"] for child in children.get(one.link.index, ())]
            arrived = [("arrived", tuple(map(any, zip(*sent, strict=True))))] if sent else []
            return (*arrived, *((port, found[one.link.index][port]) for port, found in extra.items()))

        found = self.sorter(name, self.slots[::-1], slots, step, arriving).sort()
        state = f"{name}_state"
        self.locals[state] = size * pool.count

        def to(link: Link) -> int:
            return size * pool.place.get(link.parent, 0)

        def used(link: Link) -> int:
            return size * pool.place.get(link.index, 0)

        arrays = {"arrived": state, **more.get("arrays", {})}  # type: ignore[dict-item]
        offsets = {
            "arrived": used,
            **more.get("offsets", {}),  # type: ignore[dict-item]
        }
        if joining:
            self.locals["sent"] = max(self.locals.get("sent", 0), size)
            self.parts += [Clear(state, size * pool.count), Clear("sent", size)]
            self.sweep(name, heading, found, {**arrays, "sent": "sent"}, offsets, (state, size, to, used))
        else:
            self.sweep(name, heading, found, {**arrays, "sent": state}, {**offsets, "sent": to})
        return found

    # --- rows ------------------------------------------------------------------------------------------------------

    def motion(self, with_v: bool, with_a: bool) -> str:
        """The array of the links' own wrenches."""
        name = f"motion{'_v' if with_v else ''}{'_a' if with_a else ''}"
        array = f"{name}_wrench"
        if array not in self.wrenches:
            self.locals[array] = steps.WRENCH * len(self.links)
            found = self.outward(
                name, "outward: motion of links, and the wrenches it takes", steps.motion(with_v, with_a),
                (*PLACED, *INERTIAL), steps.MOTION, arrays={"wrench": array},
                offsets={"wrench": lambda link: steps.WRENCH * link.index},
            )  # fmt: skip
            self.wrenches[array] = found.patterns
        return array

    def forces(self, port: str, with_v: bool, with_a: bool) -> None:
        wrench = self.motion(with_v, with_a)
        self.inward(
            f"force_{port}", "inward: wrenches that joints transmit", steps.force(with_v, with_a),
            (*PLACED, ARMATURE_AT, DAMPING_AT), steps.WRENCH, states={"wrench": self.wrenches[wrench]},
            arrays={"wrench": wrench, "result": port}, offsets={"wrench": lambda link: steps.WRENCH * link.index},
        )  # fmt: skip

    def mass_matrix(self, port: str) -> None:
        nv, past = self.nv, self._past()
        self.locals |= {"column_wrenches": steps.WRENCH * nv, "columns": steps.WRENCH * nv}
        self.inward(
            "composite", "inward: composite inertias", steps.composite, (*PLACED, *INERTIAL), steps.INERTIA,
            arrays={"wrenches": "column_wrenches"}, offsets={"wrenches": lambda link: steps.WRENCH * link.v},
        )  # fmt: skip
        self.parts.append(Spread("column_wrenches", "columns", nv))
        apart = any(end < nv for end in past)
        if apart:
            self.parts.append(Zeros(port, nv * nv))
        found = self.sorter("column", self.slots[::-1], PLACED, steps.column, lambda slots, patterns: ()).sort()
        self.sweep(
            "column", "inward: rows of the matrix, wrenches of all velocities beyond at once", found,
            {"m": port, "x": "columns"}, {"m": lambda link: nv * link.v},
            span=(lambda link: link.v, lambda link: past[link.v]),
        )  # fmt: skip
        self.parts.append(Mirror(port, nv, tuple(past) if apart else ()))
        if self.has_armature:
            own = [slots.values[ARMATURE_AT] for slots in self.slots for _ in range(slots.link.nv)]
            self.parts.append(Diagonal(port, tuple(own)))

    def _past(self) -> list[int]:
        """Per velocity, the first one that is not beyond its link."""
        past = [0] * self.nv
        end = [link.v + link.nv for link in self.links]
        for link in reversed(self.links):
            if link.parent >= 0:
                end[link.parent] = max(end[link.parent], end[link.index])
        for link in self.links:
            past[link.v : link.v + link.nv] = [end[link.index]] * link.nv
        return past

    def forward_dynamics(self, port: str) -> None:
        wrench = self.motion(True, False)
        self.locals |= {"kept": steps.FREED * self.nv, "pivots": self.nv}
        self.pivots["pivots"] = self.nv
        at_kept = {"kept": lambda link: steps.FREED * link.v}
        found = self.inward(
            "articulated", "inward: articulated inertias", steps.articulated(True),
            (*PLACED, *INERTIAL, ARMATURE_AT, DAMPING_AT), steps.ARTICULATED, states={"wrench": self.wrenches[wrench]},
            arrays={"wrench": wrench, "kept": "kept", "pivot": "pivots"},
            offsets={**at_kept, "wrench": lambda link: steps.WRENCH * link.index, "pivot": lambda link: link.v},
        )  # fmt: skip
        self.outward(
            "acceleration", "outward: accelerations", steps.acceleration, PLACED, steps.ACCELERATION,
            states={"kept": found.patterns}, arrays={"kept": "kept", "result": port}, offsets=at_kept,
        )  # fmt: skip


ROW_MAKERS: dict[str, Callable[[_Maker, str], None]] = {
    "inverse_dynamics": lambda maker, port: maker.forces(port, True, True),
    "bias_force": lambda maker, port: maker.forces(port, True, False),
    "gravity_force": lambda maker, port: maker.forces(port, False, False),
    "mass_matrix": lambda maker, port: maker.mass_matrix(port),
    "forward_dynamics": lambda maker, port: maker.forward_dynamics(port),
}
