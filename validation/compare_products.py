"""Directional derivatives and gradients of rows (jvp:ROW, vjp:ROW) and parameter_jacobian:ROW.

They are held to the whole Jacobian of the row. Where Pinocchio has the row it is Pinocchio's, by its analytical
derivatives or by extrapolated central differences; else the row's own, differenced. What depends on parameters is
differenced through the row itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from symgen.catalogue import CATALOGUE
from symgen.scene.model import Scene
from symgen.scene.outputs import function_name
from symgen.validation.compare import norm
from symgen.validation.compare_rows import DERIVATIVE, port_difference, sizes, states_of
from symgen.validation.differences import derivative
from symgen.validation.functions import Bound
from symgen.validation.mechanism import Array
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio
from symgen.validation.pinocchio_rows import (
    PEER_ROWS,
    State,
    forward_dynamics_derivatives,
    inverse_dynamics_gradient,
    move,
)
from symgen.validation.result import Row, Skip

GROUP = "products of derivatives"
KINDS = ("jvp", "vjp", "parameter_jacobian")
STATES = 3
Ports = tuple[Array, ...]
Jacobian = dict[str, Ports]
"""Input → the derivative of every output: its shape, and one axis for the input's directions."""


@dataclass(frozen=True)
class Target:
    """The row under a product: its name, its frame, and itself as a function of state and parameters."""

    row: str
    frame: str
    peer: Pinocchio
    functions: Bound

    @property
    def name(self) -> str:
        return function_name(f"{self.row}:{self.frame}" if self.frame else self.row)

    def own(self, s: State, p: Array) -> Ports:
        bound = Bound(self.functions.functions, p)
        found = bound.all(self.name, *(getattr(s, x) for x in bound.inputs(self.name)))
        return tuple(np.asarray(x, dtype=float) for x in (found if isinstance(found, tuple) else (found,)))

    def value(self, s: State) -> Ports:
        if self.row in PEER_ROWS:
            return PEER_ROWS[self.row](self.peer, s, self.frame)
        return self.own(s, self.functions.p)


def columns(along: Callable[[Array, float], Ports], n: int) -> Ports:
    """All outputs differentiated in n unit directions, the directions last."""
    found = []
    for unit in np.eye(n):
        shapes = [x.shape for x in along(unit, 0.0)]
        flat = derivative(lambda t, unit=unit: np.concatenate([x.ravel() for x in along(unit, t)]))  # type: ignore[misc]
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes])[:-1]
        found.append([x.reshape(shape) for x, shape in zip(np.split(flat, ends), shapes, strict=True)])
    return tuple(np.stack([row[k] for row in found], axis=-1) for k in range(len(found[0])))


def jacobian(target: Target, s: State, inputs: tuple[str, ...]) -> Jacobian:
    """The whole Jacobian with respect to ``inputs`` (q in the tangent space; p by the row itself)."""
    peer, n = target.peer, target.peer.mechanism.nv
    found: Jacobian = {}
    if target.row == "inverse_dynamics":
        found = {x: (J,) for x, J in zip("qva", inverse_dynamics_gradient(peer, s), strict=True)}
    elif target.row == "forward_dynamics":
        by = forward_dynamics_derivatives(peer, s)
        found = {x: (J,) for x, J in zip(("q", "v", "tau"), by, strict=True)}
    for name in inputs:
        if name == "p":
            found["p"] = by_parameters(target, s)
        elif name == "q" and "q" not in found:
            found["q"] = columns(lambda unit, t: target.value(s._replace(q=move(peer, s.q, unit, t))), n)
        elif name not in found:

            def along(unit: Array, t: float, name: str = name) -> Ports:
                return target.value(s._replace(**{name: getattr(s, name) + t * unit}))

            found[name] = columns(along, n)
    return found


def by_parameters(target: Target, s: State) -> Ports:
    p = target.functions.p
    return columns(lambda unit, t: target.own(s, p + t * unit), p.size)


def expected_jvp(J: Jacobian, directions: dict[str, Array]) -> Ports:
    ports = range(len(next(iter(J.values()))))
    return tuple(np.asarray(sum(J[x][k] @ d for x, d in directions.items())) for k in ports)


def expected_vjp(J: Jacobian, weights: Ports, inputs: tuple[str, ...]) -> Ports:
    found = []
    for x in inputs:
        parts = [np.tensordot(w, J[x][k], axes=w.ndim) for k, w in enumerate(weights)]
        found.append(np.asarray(sum(parts)))
    return tuple(found)


def product_difference(target: Target, kind: str, s: State, rng: np.random.Generator) -> tuple[float, int]:
    """Largest relative difference of one product at one state, and the output it is in."""
    functions, name = target.functions, f"{kind}_{target.name}"
    inputs = tuple(x for x in CATALOGUE[target.row].inputs if x != "dt")
    if functions.p.size:
        inputs += ("p",)
    state = {x: getattr(s, x) for x in inputs if x != "p"}
    if kind == "parameter_jacobian":
        expected = by_parameters(target, s)
        found = functions.all(name, *state.values())
    else:
        J = jacobian(target, s, inputs)
        if kind == "jvp":
            directions = {x: np.asarray(rng.uniform(-1, 1, J[x][0].shape[-1:])) for x in inputs}
            expected = expected_jvp(J, directions)
            given = {**state, **{f"d{x}": d for x, d in directions.items()}}
        else:
            weights = tuple(rng.uniform(-1, 1, x.shape) for x in target.value(s))
            expected = expected_vjp(J, weights, inputs)
            names = [x for x in functions.inputs(name) if x.startswith("w_")]
            given = {**state, **dict(zip(names, weights, strict=True))}
        found = functions.all(name, *(given[x] for x in functions.inputs(name)))
    ours = found if isinstance(found, tuple) else (found,)
    floor = sizes(target.peer, s).forces(norm(s.a))
    pairs = zip(ours, expected, strict=True)
    values = [port_difference(np.asarray(x, dtype=float), y, floor) for x, y in pairs]
    bad = [k for k, value in enumerate(values) if not np.isfinite(value)]
    worst = bad[0] if bad else int(np.argmax(values))
    return values[worst], worst


def asked_products(scene: Scene) -> list[tuple[str, str, str]]:
    """(kind, row, frame) of every product among the scene's outputs."""
    found = []
    for row in dict.fromkeys(row for output in scene.outputs for row in output.of):
        kind, _, rest = row.partition(":")
        if kind in KINDS:
            name, _, frame = rest.partition(":")
            found.append((kind, name, frame))
    return found


def compare_products(scene: Scene, functions: Bound, seed: int) -> tuple[list[Row], list[Skip]]:
    """Every jvp, vjp and parameter_jacobian that the scene asks for."""
    asked = asked_products(scene)
    if not asked:
        return [], []
    peer, rng = build_pinocchio(scene), np.random.default_rng(seed)
    rows: list[Row] = []
    skipped: list[Skip] = []
    for kind, row, frame in asked:
        target = Target(row, frame, peer, functions)
        needed = f"{kind}_{target.name}", *(() if row in PEER_ROWS and not scene.parameters else (target.name,))
        if not functions.has(*needed):
            skipped.append(Skip(f"{GROUP}: {kind}:{row}", f"needs {' and '.join(needed)}"))
            continue
        found = [product_difference(target, kind, s, rng) for s in states_of(peer, STATES, seed)]
        value, port = max(found, key=lambda pair: pair[0] if np.isfinite(pair[0]) else np.inf)
        source = (
            f"Pinocchio {peer.pin.__version__}" if row in PEER_ROWS and kind != "parameter_jacobian" else "differences"
        )
        label = f"{kind}:{row}" + (f":{frame}" if frame else "")
        rows.append(Row(GROUP, label, value, DERIVATIVE, f"worst in output {port + 1}", source))
    return rows, skipped
