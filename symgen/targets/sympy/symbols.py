"""The SymPy symbols of a system: one per entry of q, v, a, tau, dt and p, named after joints and parameters.

``theta_elbow`` and ``thetadot_elbow`` (which SymPy itself prints as θ with a dot), ``q_slider`` for displacements,
``x_base``, ``omega_base_x``, …; parameters as ``m_link``, ``c_link_x``, ``I_link_xx``, ``g_z``.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from symgen.algebra.linear import Vec, vecmat, vneg
from symgen.plans.links import SCREW, SLIDE, TURN, lower
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import Parameter, Scene
from symgen.scene.names import identifier, sanitise
from symgen.topology.tree import Tree

ANGLE, DISPLACEMENT = ("theta_{j}",), ("q_{j}",)
RATES = {0: "", 1: "dot", 2: "ddot"}

POSITIONS: dict[str, tuple[str, ...]] = {
    "revolute": ANGLE,
    "continuous": ANGLE,
    "prismatic": DISPLACEMENT,
    "helical": ANGLE,
    "cylindrical": (*ANGLE, *DISPLACEMENT),
    "universal": ("theta_{j}_1", "theta_{j}_2"),
    "planar": ("x_{j}", "y_{j}", *ANGLE),
    "spherical": ("q_{j}_x", "q_{j}_y", "q_{j}_z", "q_{j}_w"),
    "floating": ("x_{j}", "y_{j}", "z_{j}", "q_{j}_x", "q_{j}_y", "q_{j}_z", "q_{j}_w"),
}
"""Names of the entries of q; {j} is the joint."""

EFFORTS: dict[str, tuple[str, ...]] = {
    "cylindrical": ("tau_{j}", "F_{j}"),
    "universal": ("tau_{j}_1", "tau_{j}_2"),
    "planar": ("F_{j}_x", "F_{j}_y", "tau_{j}"),
    "spherical": ("tau_{j}_x", "tau_{j}_y", "tau_{j}_z"),
    "floating": ("F_{j}_x", "F_{j}_y", "F_{j}_z", "tau_{j}_x", "tau_{j}_y", "tau_{j}_z"),
    "prismatic": ("F_{j}",),
}
"""Names of the entries of tau, where they are not just ``tau_{j}``."""

COMPONENTS = {
    "com": ("c", ("x", "y", "z")),
    "inertia": ("I", ("xx", "yy", "zz", "xy", "xz", "yz")),
    "mass": ("m", ("",)),
    "damping": ("b", ("",)),
    "armature": ("J", ("",)),
    "stiffness": ("k", ("",)),
    "length": ("L", ("",)),
    "rest": ("theta0", ("",)),
    "xyz": ("d", ("x", "y", "z")),
    "rpy": ("rpy", ("x", "y", "z")),
    "offset": ("q0", ("",)),
    "point1": ("A", ("x", "y", "z")),
    "point2": ("B", ("x", "y", "z")),
}


def _rates(kind: str, order: int, base_velocity: str) -> tuple[str, ...]:
    """Names of the entries of v (order 1) or a (order 2)."""
    spin = tuple(f"{'omega' if order == 1 else 'alpha'}_{{j}}_{k}" for k in "xyz")
    if kind == "spherical":
        return spin
    if kind == "floating" and base_velocity == "body":
        return (*(f"{'v' if order == 1 else 'a'}_{{j}}_{k}" for k in "xyz"), *spin)
    dotted = tuple(name.replace("_", RATES[order] + "_", 1) for name in POSITIONS[kind])
    return (*dotted[:3], *spin) if kind == "floating" else dotted


@dataclass(frozen=True)
class Symbols:
    """Symbols of the arguments of generated functions, in their order."""

    q: tuple[sympy.Symbol, ...]
    v: tuple[sympy.Symbol, ...]
    a: tuple[sympy.Symbol, ...]
    tau: tuple[sympy.Symbol, ...]
    dt: sympy.Symbol
    p: tuple[sympy.Symbol, ...]

    @property
    def order(self) -> dict[sympy.Symbol, int]:
        """Symbol → its place among all arguments."""
        every = (*self.q, *self.v, *self.a, *self.tau, self.dt, *self.p)
        return {symbol: place for place, symbol in enumerate(every)}


def system_symbols(scene: Scene, tree: Tree) -> Symbols:
    """All symbols of a system."""
    joints = sanitise(body.joint.name for body in tree.bodies)
    rows: list[tuple[str, str]] = []
    for body in tree.bodies:
        if body.coupling is not None:  # a coupled joint has no coordinates of its own
            continue
        joint, kind = joints[body.joint.name].strip("_"), body.joint.type
        convention = scene.options.base_velocity
        efforts = EFFORTS.get(kind, ("tau_{j}",) * JOINT_TYPES[kind].nv)
        velocities, accelerations = _rates(kind, 1, convention), _rates(kind, 2, convention)
        for group, found in (("q", POSITIONS[kind]), ("v", velocities), ("a", accelerations), ("tau", efforts)):
            rows += [(group, name.format(j=joint)) for name in found]
    rows.append(("dt", "dt"))
    rows += [("p", name) for parameter in scene.parameters for name in _parameter(parameter)]
    groups: dict[str, list[sympy.Symbol]] = {"q": [], "v": [], "a": [], "tau": [], "dt": [], "p": []}
    taken: set[str] = set()
    for group, wanted in rows:
        name, count = wanted, 1
        while name in taken:  # numbered, because printers leave out underscores at the ends
            count += 1
            name = f"{wanted}_{count}"
        taken.add(name)
        groups[group].append(sympy.Symbol(name))
    q, v, a, tau, p = (tuple(groups[group]) for group in ("q", "v", "a", "tau", "p"))
    return Symbols(q, v, a, tau, groups["dt"][0], p)


def _parameter(parameter: Parameter) -> list[str]:
    owner, _, quantity = parameter.name.rpartition(".")
    if not owner:
        return [f"{parameter.name[0]}_{component}" for component in ("x", "y", "z")]
    letter, components = COMPONENTS[quantity]
    stem = f"{letter}_{_plain(owner)}"
    return [f"{stem}_{component}" if component else stem for component in components]


def _plain(name: str) -> str:
    """An identifier without the underscore that keeps C's reserved words (``j1``, ``free``) apart."""
    return identifier(name).strip("_")


@dataclass(frozen=True)
class Turn:
    """A joint angle among angles about one direction: the sum by which its child has turned ({entry of q: ±1}), the
    entry of q whose sum that continues (None: there is none), and the sign with which it does."""

    total: dict[int, int]
    before: int | None = None
    sign: int = 1


def angle_sums(tree: Tree) -> dict[int, Turn]:
    """Every turning entry of q, with the sums of angles that consecutive parallel axes make.

    In a plane these are the bodies' absolute angles, in which positions are linear. Where joints are coupled, multiples
    of angles would be among the summands, and every angle stays alone.
    """
    if tree.coupled:
        return _alone(tree)
    found: dict[int, Turn] = {}
    carried: list[tuple[Vec, int] | None] = []
    for link in lower(tree):
        before = carried[link.parent] if link.parent >= 0 else None
        if link.kind in (TURN, SCREW):
            axis = tuple(row[2] for row in link.turn)
            found[link.q] = _continued(axis, before, found, link.q)
            carried.append(((0, 0, 1), link.q))
        elif link.kind == SLIDE and before is not None:
            carried.append((vecmat(before[0], link.turn), before[1]))
        else:
            carried.append(None)
    return found


def _alone(tree: Tree) -> dict[int, Turn]:
    """Links count all joints' coordinates, the entries of q are those of independent joints."""
    found: dict[int, Turn] = {}
    first: dict[int, int] = {}
    for link in lower(tree):
        body = tree.bodies[link.body]
        place = body.q + link.q - first.setdefault(link.body, link.q)
        if body.coupling is None and link.kind in (TURN, SCREW):
            found[place] = Turn({place: 1})
    return found


def _continued(axis: Vec, before: tuple[Vec, int] | None, found: dict[int, Turn], q: int) -> Turn:
    if before is not None:
        for sign, direction in ((1, before[0]), (-1, vneg(before[0]))):
            if axis == direction:
                total = {k: sign * n for k, n in found[before[1]].total.items()}
                return Turn({**total, q: 1}, before[1], sign)
    return Turn({q: 1})
