"""Rows of derivatives: the analytic plan completed by springs and couplings, or tangents of the graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

from symgen.algebra.linear import add, dot, half, mul, neg, sub, total, transpose
from symgen.plans import coriolis
from symgen.plans.derivatives import Change, Derivation
from symgen.plans.walk import FREE
from symgen.program.derivative import tangents
from symgen.program.graph import Node
from symgen.scene.joints import JOINT_TYPES
from symgen.velocity.kinematics import configuration_rate

if TYPE_CHECKING:
    from symgen.plans.build import Builder

Scalar = Any
Matrix = list[list[Scalar]]
Seed = Mapping[Node, Scalar]


def seeds(b: Builder, name: str) -> list[Seed]:
    """One seed per velocity: of ``q`` along its manifold, of ``v``, ``a`` or ``tau`` by themselves; ``p`` per
    parameter."""
    inputs = getattr(b.state, name)
    if name != "q":
        return [{node: 1} for node in inputs]
    found: list[Seed] = []
    for j in range(b.tree.nv):
        unit = [1 if i == j else 0 for i in range(b.tree.nv)]
        rates = configuration_rate(b.tree, b.values, b.state.q, unit)
        found.append(dict(zip(inputs, rates, strict=True)))
    return found


def jacobian(b: Builder, roots: Sequence[Scalar], name: str) -> Matrix:
    """∂roots/∂(q tangent, v, a, tau or p): one row per root."""
    with b.graph.phase(f"tangents along {name}"):
        columns = tangents(b.graph, roots, seeds(b, name))
    return [list(row) for row in transpose(tuple(tuple(column) for column in columns))] if columns else []


def inverse_dynamics(b: Builder, a: Sequence[Scalar]) -> tuple[Matrix, Matrix]:
    """∂τ/∂q and ∂τ/∂v at the accelerations ``a``, which do not change with q and v."""
    if b.family.differentiated:
        tau = b.inverse_dynamics(b.state.a)
        return jacobian(b, tau, "q"), jacobian(b, tau, "v")
    by_position, by_velocity = Derivation(b.shared, b.v, b.values.gravity()).by_both(b.rates(a))
    return _with_passive(b, b.reduce_matrix(by_position.rest), b.reduce_matrix(by_velocity.rest))


def _with_passive(b: Builder, by_position: Matrix, by_velocity: Matrix) -> tuple[Matrix, Matrix]:
    passive = b.passive()
    return _plus(by_position, jacobian(b, passive, "q")), _plus(by_velocity, jacobian(b, passive, "v"))


def _minus(x: Matrix, y: Matrix) -> Matrix:
    return [[sub(p, q) for p, q in zip(row, other, strict=True)] for row, other in zip(x, y, strict=True)]


def _plus(x: Matrix, y: Matrix) -> Matrix:
    return [[add(p, q) for p, q in zip(row, other, strict=True)] for row, other in zip(x, y, strict=True)]


def forward_dynamics(b: Builder) -> tuple[Matrix, Matrix, Matrix]:
    """∂a/∂q, ∂a/∂v, ∂a/∂τ: −M⁻¹ times the derivatives of inverse dynamics at a(q, v, τ), and M⁻¹."""
    if b.family.differentiated:
        a = b.forward_dynamics
        return jacobian(b, a, "q"), jacobian(b, a, "v"), jacobian(b, a, "tau")
    others = any(at.link.parent >= 0 for at in b.shared.moving)
    found = Derivation(b.shared, b.v, b.values.gravity(), relieved=others and not b.tree.coupled)
    by_velocity = _Change.of(b, found.by_velocity())
    wanted_too = not {"forward_dynamics", "bias_force"}.isdisjoint(b.output.of)
    a = b.forward_dynamics if wanted_too or not others else _accelerations(b, by_velocity)
    by_position = _Change.of(b, found.by_position(b.rates(a)))
    passive, columns = b.passive(), list[list[Scalar]]()
    for change, name in ((by_position, "q"), (by_velocity, "v")):
        columns += [[neg(x) for x in column] for column in _columns(_plus(change.rest, jacobian(b, passive, name)))]
    with b.graph.phase("solve for every column"):
        solutions = [b.factored.solve(column) for column in columns]
        by_q = _minus(_columns(solutions[: b.tree.nv]), by_position.undone)
        by_v = _minus(_columns(solutions[b.tree.nv :]), by_velocity.undone)
    with b.graph.phase("inverse of the mass matrix"):
        return by_q, by_v, b.factored.inverse_matrix()


@dataclass(frozen=True)
class _Change:
    """∂τ = rest + mass_matrix · undone, of the coordinates, armature included: what a joint alone can undo is not
    solved for, where joints can move alone (couplings do not let them) and there are others."""

    rest: Matrix
    undone: Matrix

    @staticmethod
    def of(b: Builder, change: Change) -> _Change:
        undone = b.reduce_matrix(change.undone)
        motors = [[mul(extra, x) for x in row] for extra, row in zip(b.armature, undone, strict=True)]
        return _Change(_minus(b.reduce_matrix(change.rest), motors), undone)


def _accelerations(b: Builder, by_velocity: _Change) -> list[Scalar]:
    """a(q, v, τ). Forces of velocities are quadratic in them: half of their derivative, times v."""
    passive = b.passive()
    with b.graph.phase("forces of velocities and weight"):
        quadratic, undone = (
            [half(dot(row, b.state.v)) for row in part] for part in (by_velocity.rest, by_velocity.undone)
        )
        weight, falling = _weight(b)
    with b.graph.phase("solve"):
        rest = [sub(tau, total(forces)) for tau, *forces in zip(b.state.tau, passive, quadratic, weight, strict=True)]
        return [total((x, neg(y), z)) for x, y, z in zip(b.factored.solve(rest), undone, falling, strict=True)]


def _weight(b: Builder) -> tuple[list[Scalar], list[Scalar]]:
    """gravity_force = forces − mass_matrix · accelerations: none of these where everything hangs on free bodies, which
    fall, else none of those."""
    gravity, roots = b.values.gravity(), [at for at in b.shared.moving if at.link.parent < 0]
    falling: list[Scalar] = [0] * b.tree.nv
    if b.tree.coupled or any(at.link.kind != FREE for at in roots):
        return b.reduce(coriolis.gravity_force(b.shared, gravity)), falling
    for at in roots:
        body = b.scene.options.base_velocity == "body"
        falling[at.link.v : at.link.v + 3] = at.to_link(gravity) if body else gravity
    return [mul(extra, x) for extra, x in zip(b.armature, falling, strict=True)], falling


def _columns(matrix: Sequence[Sequence[Scalar]]) -> Matrix:
    return [list(column) for column in zip(*matrix, strict=True)]


def second_derivatives(b: Builder) -> tuple[list[Matrix], ...]:
    """d2tau_dqdq, d2tau_dqdv, d2tau_dvdv, d2tau_dadq: tangents of the first derivatives and of the mass matrix along q.
    What is symmetric in two indices is derived once: everything but pairs of directions of one quaternion joint."""
    by_position, by_velocity = inverse_dynamics(b, b.state.a)
    group, indices = _turning_groups(b), range(b.tree.nv)

    def alike(j: int, k: int) -> bool:
        return group[j] == group[k] >= 0

    dqdq = _tensor(b, by_position, "q", lambda i, j, k: k >= j or alike(j, k))
    for i, j, k in product(indices, indices, indices):
        if j > k and not alike(j, k):
            dqdq[i][j][k] = dqdq[i][k][j]
    dvdq = _tensor(b, by_velocity, "q", lambda i, j, k: True)
    # M[i][j] by q: the tensor [i][j][k] is symmetric in i and j.
    lower = _tensor(b, b.mass_matrix, "q", lambda i, j, k: j <= i)
    dadq = [[lower[max(i, j)][min(i, j)] for j in indices] for i in indices]
    return dqdq, [_columns(matrix) for matrix in dvdq], _by_velocities(b, by_velocity, dadq, alike), dadq


def _by_velocities(
    b: Builder, by_velocity: Matrix, dadq: Sequence[Matrix], alike: Callable[[int, int], bool]
) -> list[Matrix]:
    """d2tau_dvdv: Christoffel's symbols ∂M[i][j]/∂q_k + ∂M[i][k]/∂q_j − ∂M[j][k]/∂q_i where i is no direction of the
    quaternion joint that j or k is of (those do not commute), else tangents."""
    indices = range(b.tree.nv)
    found = _tensor(b, by_velocity, "v", lambda i, j, k: k <= j and (alike(i, j) or alike(i, k)))
    for i, j, k in product(indices, indices, indices):
        if j < k:
            continue
        if not (alike(i, j) or alike(i, k)):
            found[i][j][k] = sub(add(dadq[i][j][k], dadq[i][k][j]), dadq[j][k][i])
        found[i][k][j] = found[i][j][k]
    return found


def _turning_groups(b: Builder) -> list[int]:
    """Per velocity, the quaternion joint it belongs to, or −1."""
    found = [-1] * b.tree.nv
    for body in b.tree.bodies:
        if JOINT_TYPES[body.joint.type].nq != JOINT_TYPES[body.joint.type].nv:
            found[body.v : body.v + body.nv] = [body.index] * body.nv
    return found


def _tensor(
    b: Builder, matrix: Sequence[Sequence[Scalar]], name: str, asked: Callable[[int, int, int], bool]
) -> list[Matrix]:
    """[i][j][k] = derivative of matrix[i][j] along direction k of ``name``, where asked for; elsewhere 0."""
    nv, roots = b.tree.nv, [x for row in matrix for x in row]
    wanted = [sum(1 << k for k in range(nv) if asked(i, j, k)) for i in range(nv) for j in range(nv)]
    with b.graph.phase(f"second derivatives along {name}"):
        rates = tangents(b.graph, roots, seeds(b, name), wanted)
    return [[[rates[k][i * nv + j] for k in range(nv)] for j in range(nv)] for i in range(nv)]
