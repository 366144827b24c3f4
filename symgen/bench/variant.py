"""What the bench measures: variants of one function, each a piece of C that the driver calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.program.instructions import Program
from symgen.scene.model import Scene
from symgen.system import System
from symgen.validation.mechanism import Mechanism

Array = NDArray[Any]
State = Mapping[str, Any]
OURS = "symgen"
"""The name of our scalar functions among the variants; ratios are to these."""
USUAL = (OURS, "symgen batch", "symgen soa")
"""Our functions as their scene asks for them: one state, and batches. What else is ours is a further form."""
KANE = "sympy-kane"
"""SymPy's KanesMethod."""
PRINTED = f"{OURS}-casadi"
"""Our expressions as CasADi prints them: a form of ours, in the tables beside what peers have."""


def is_ours(program: str) -> bool:
    """Whether a program of the bench is symgen's, in whatever form. What is not is a peer."""
    return program in (OURS, PRINTED) or program.startswith(f"{OURS} ")


STRIPPED = "springs and dampers are left out of the scene, for all: peers do not have them in these functions"
"""What is noted of scenes that have some."""
FUNCTIONS = (
    "mass_matrix",
    "bias_force",
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix_inverse",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
)
"""What peers have."""
INPUTS: dict[str, tuple[str, ...]] = {
    "mass_matrix": ("q",),
    "bias_force": ("q", "v"),
    "inverse_dynamics": ("q", "v", "a"),
    "forward_dynamics": ("q", "v", "tau"),
    "mass_matrix_inverse": ("q",),
    "inverse_dynamics_derivatives": ("q", "v", "a"),
    "forward_dynamics_derivatives": ("q", "v", "tau"),
}


@dataclass(frozen=True)
class Unit:
    """One file to compile: its text, and what else the result depends on."""

    name: str
    text: str
    language: str = "c"
    """c or c++."""
    flags: tuple[str, ...] = ()
    includes: tuple[Path, ...] = ()
    headers: tuple[tuple[str, str], ...] = ()
    """(name, text) of headers that are written beside it."""
    limited: bool = True
    """Whether it is given up when it takes the compiler too long."""
    compiler: str = ""
    """Another C compiler than what all are compiled with."""


@dataclass(frozen=True, eq=False)
class Variant:
    """One function by one program."""

    peer: str
    function: str
    declaration: str
    """C at file scope: prototypes, and what the call needs kept."""
    call: str
    """One C statement for one state; ``{q}`` is a pointer to the state's row of the array ``q``, ``{out}`` to the
    output. For a batch the statement does all ``n`` states at once."""
    arrays: Mapping[str, Array]
    """Inputs by name: (states, size), or (size,) for what all states share."""
    outputs: int
    """Doubles that one state's outputs are."""
    unpack: Callable[[Array, State], list[Array]]
    """The outputs, flat, at a state → the function's outputs in symgen's coordinates, each flat and row-major."""
    units: tuple[Unit, ...] = ()
    link: tuple[str, ...] = ()
    """Further words for the linker."""
    fetch: str = ""
    """C that leaves the outputs in ``out`` where the call itself does not."""
    setup: str = ""
    """C statements run once, with `return` of non-zero on failure."""
    batch: bool = False
    columns: bool = False
    """Whether a batch has a structure of arrays: states inside, coordinates outside."""
    real: str = "double"
    generate_s: float | None = None
    """Seconds that making the code took, compiling not included."""
    operations: int | None = None
    plan: str = ""
    """How it computes, for ours."""
    symbol: str = ""
    """The C function that is called, for ours."""
    sized: bool = True
    """Whether the compiled code of the units is this function's alone."""

    @property
    def name(self) -> str:
        return f"{self.peer} {self.function}"

    @property
    def own(self) -> bool:
        """Whether it is symgen's, in whatever form."""
        return is_ours(self.peer)


@dataclass(frozen=True)
class Problem:
    """A scene to be measured: functions, states, and where things are kept."""

    scene: Scene
    system: System
    programs: Mapping[str, Program]
    derive_s: Mapping[str, float]
    states: Sequence[State]
    mechanism: Mechanism
    folder: Path
    """Where generated files go."""

    def column(self, name: str) -> Array:
        """One input at all states: (states, size)."""
        return np.array([np.ravel(state[name]) for state in self.states], dtype=float)

    @property
    def wanted(self) -> tuple[str, ...]:
        """Functions that peers may have too."""
        return tuple(name for name in FUNCTIONS if name in self.programs)

    @property
    def nv(self) -> int:
        return self.system.tree.nv

    def shapes(self, function: str) -> list[int]:
        """Sizes of a function's outputs."""
        return [port.size for port in self.programs[function].outputs]


@dataclass(frozen=True)
class Left:
    """A peer, or one function of it, that was not measured, and why."""

    peer: str
    function: str
    why: str


@dataclass
class Found:
    """What a peer has to measure."""

    variants: list[Variant] = field(default_factory=list)
    left: list[Left] = field(default_factory=list)


def split(flat: Array, sizes: Sequence[int]) -> list[Array]:
    """A flat array in parts of these sizes."""
    return list(np.split(np.asarray(flat), np.cumsum(sizes)[:-1]))


def upper_to_full(flat: Array, n: int) -> Array:
    """A symmetric matrix from its upper triangle, row-major; flat."""
    full = np.zeros((n, n))
    full[np.triu_indices(n)] = flat
    return np.ravel(full + np.triu(full, 1).T)
