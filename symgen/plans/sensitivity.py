"""Rows of derivatives: the analytic plan completed by springs and couplings, or tangents of the graph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from symgen.algebra.linear import add, mul, sub, transpose
from symgen.plans import columns as columns_of
from symgen.plans.derivatives import Derivation
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


def _plus(x: Matrix, y: Matrix) -> Matrix:
    return [[add(p, q) for p, q in zip(row, other, strict=True)] for row, other in zip(x, y, strict=True)]


def forward_dynamics(b: Builder) -> tuple[Matrix, Matrix, Matrix]:
    """∂a/∂q, ∂a/∂v, ∂a/∂τ: −M⁻¹ times the derivatives of inverse dynamics at a(q, v, τ), and M⁻¹. What a joint alone
    can undo is not solved for, where joints can move alone (couplings do not let them) and there are others."""
    a = b.forward_dynamics
    if b.family.differentiated:
        return jacobian(b, a, "q"), jacobian(b, a, "v"), jacobian(b, a, "tau")
    relieved = not b.tree.coupled and any(at.link.parent >= 0 for at in b.shared.moving)
    found = Derivation(b.shared, b.v, b.values.gravity(), relieved).by_both(b.rates(a))
    changes = _with_passive(b, *(b.reduce_matrix(change.rest) for change in found))
    undone = [b.reduce_matrix(change.undone) for change in found]
    columns, own = list[list[Scalar]](), list[list[Scalar]]()
    for change, matrix in zip(changes, undone, strict=True):
        for column, undo in zip(_columns(change), _columns(matrix), strict=True):
            motors = [mul(extra, y) for extra, y in zip(b.armature, undo, strict=True)]
            columns.append([sub(y, x) for x, y in zip(column, motors, strict=True)])
            own.append(undo)
    with b.graph.phase("solve for every column, and for the inverse"):
        solutions, inverse = columns_of.solved(b.factored, columns)
        moved = [[sub(x, y) for x, y in zip(*pair, strict=True)] for pair in zip(solutions, own, strict=True)]
    nv = b.tree.nv
    return _columns(moved[:nv]), _columns(moved[nv:]), inverse


def _columns(matrix: Sequence[Sequence[Scalar]]) -> Matrix:
    return [list(column) for column in zip(*matrix, strict=True)]


def second_derivatives(b: Builder) -> tuple[list[Matrix], ...]:
    """d2tau_dqdq, d2tau_dqdv, d2tau_dvdv, d2tau_dadq: tangents of the first derivatives. What is symmetric in the two
    directions is derived once: everything but pairs of directions of one quaternion joint."""
    by_position, by_velocity = inverse_dynamics(b, b.state.a)
    group = _turning_groups(b)
    nv = b.tree.nv

    def mirrored(j: int, k: int) -> bool:
        return j < k and (group[j] != group[k] or group[j] < 0)

    dqdq = _tensor(b, by_position, "q", mirrored)
    dqdv = _tensor(b, by_position, "v", lambda j, k: False)
    dvdv = _tensor(b, by_velocity, "v", lambda j, k: j < k)
    # M[i][j] by q: the tensor [i][j][k] is symmetric in i and j.
    lower = [[x if j <= i else 0 for j, x in enumerate(row)] for i, row in enumerate(b.mass_matrix)]
    half = _tensor(b, lower, "q", lambda j, k: False)
    dadq = [[half[max(i, j)][min(i, j)] for j in range(nv)] for i in range(nv)]
    return dqdq, dqdv, dvdv, dadq


def _turning_groups(b: Builder) -> list[int]:
    """Per velocity, the quaternion joint it belongs to, or −1."""
    found = [-1] * b.tree.nv
    for body in b.tree.bodies:
        if JOINT_TYPES[body.joint.type].nq != JOINT_TYPES[body.joint.type].nv:
            found[body.v : body.v + body.nv] = [body.index] * body.nv
    return found


def _tensor(b: Builder, matrix: Sequence[Sequence[Scalar]], name: str, mirrored: Any) -> list[Matrix]:
    """[i][j][k] = derivative of matrix[i][j] along direction k of ``name``; mirrored entries are [i][k][j]."""
    nv = b.tree.nv
    wanted = [sum(1 << k for k in range(nv) if not mirrored(j, k)) for j in range(nv)]
    with b.graph.phase(f"second derivatives along {name}"):
        rates = tangents(b.graph, [x for row in matrix for x in row], seeds(b, name), wanted * nv)
    found = [[[rates[k][i * nv + j] for k in range(nv)] for j in range(nv)] for i in range(nv)]
    for j in range(nv):
        for k in range(nv):
            if mirrored(j, k):
                for i in range(nv):
                    found[i][j][k] = found[i][k][j]
    return found
