"""The variational midpoint rule: steps of a discrete motion of stationary action, so that energy stays where it was.

The discrete Lagrangian is dt L(q_m, v), q_m half a step from either end along v (Marsden & West, Acta Numerica 2001,
§§ 1 and 3; forces as in § 3.2). Where joints are coordinates that is the implicit midpoint rule for (q, P), P = M(q) v.
Where they are rotations, each half of a step turns by Cayley's map of ½ dt ω, a quaternion (¼ dt ω, 1), all rational,
and its tangent makes the momenta at the ends from the one in the middle (compare Bou-Rabee & Marsden, Foundations of
Computational Mathematics 2009).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import Vec, add, cross, dot, matvec, mul, scale, sub, transpose, vadd, vsub
from symgen.integrators.geometry import HALF, factored, in_ground_axes, moved, rate, solved, square, turning
from symgen.integrators.model import Arrays, Evaluate, Function, Method, Operation, Place, Update
from symgen.topology.tree import TreeBody
from symgen.velocity.rotation import quaternion_product, quaternion_rotation, renormalise

Scalar = Any
CORRECTIONS = 8
"""Of Newton's method with one Jacobian; each takes two powers of dt off the error. What they leave adds up to drift: in
coarse steps, some forty of a swing, six are seen to be too few over a million of them, eight are not."""
QUARTER = Fraction(1, 4)


# --- where a step leads ----------------------------------------------------------------------------------------------


def places(place: Place, q: Sequence[Scalar], v: Sequence[Scalar], dt: Scalar) -> tuple[Vec, Vec]:
    """q in the middle of a step along v, its quaternions of any length, and q at its end."""
    along = rate(place, q, v)
    middle, end = list(moved(q, mul(HALF, dt), along)), list(moved(q, dt, along))
    for body in place.tree.bodies:
        if turning(body):
            start = body.q + body.nq - 4
            here = slice(start, start + 4)
            turn = tuple(v[body.v + body.nv - 3 : body.v + body.nv])
            middle[here], end[here] = _turned(place, body, tuple(q[here]), scale(mul(QUARTER, dt), turn))
            if body.joint.type == "floating" and place.values.scene.options.base_velocity == "body":
                travel = matvec(quaternion_rotation(tuple(middle[here])), tuple(v[body.v : body.v + 3]))
                xyz = slice(body.q, body.q + 3)
                middle[xyz], end[xyz] = moved(q[xyz], mul(HALF, dt), travel), moved(q[xyz], dt, travel)
    return tuple(middle), tuple(end)


def _turned(place: Place, body: TreeBody, q: Vec, x: Vec) -> tuple[Vec, Vec]:
    """q turned by (x, 1), and by its square over its norm, (2 x, 1 − x·x) / (1 + x·x)."""
    length = dot(x, x)
    over = 1 / add(1, length)
    whole = (*scale(mul(2, over), x), mul(sub(1, length), over))
    if in_ground_axes(place, body):
        to_joint = transpose(place.values.matrix(body.joint.origin.rotation))
        half, whole = (*matvec(to_joint, x), 1), (*matvec(to_joint, whole[:3]), whole[3])
        return quaternion_product(half, q), renormalise(quaternion_product(whole, q))
    return quaternion_product(q, (*x, 1)), renormalise(quaternion_product(q, whole))


# --- momenta at its ends ---------------------------------------------------------------------------------------------


def _cayley(u: Vec, x: Vec) -> Vec:
    """x turned by Cayley's map of u: x + (u × x + ½ u × (u × x)) / (1 + ¼ u·u)."""
    once = cross(u, x)
    over = 1 / add(1, mul(QUARTER, dot(u, u)))
    return vadd(x, scale(over, vadd(once, scale(HALF, cross(u, once)))))


def _half_turn(place: Place, body: TreeBody, v: Sequence[Scalar], dt: Scalar) -> Vec:
    """u = ½ dt ω, with the sign of the side from which it turns."""
    turn = tuple(v[body.v + body.nv - 3 : body.v + body.nv])
    return scale(mul(-HALF if in_ground_axes(place, body) else HALF, dt), turn)


def _impulses(place: Place, body: TreeBody, x: Arrays) -> tuple[list[Vec], list[Vec]]:
    """Of a joint with a rotation: in the middle's axes, the momenta's mean of both ends and their difference, linear
    part first where there is one; each in vectors of three.

    The difference is k = dt (P_rate + tau) + 2 u × P, since velocities in turning axes are no coordinates' rates; the
    mean of the angular part is (1 + ¼ u·u) P + ¼ u × k."""
    dt, u = x["dt"][0], _half_turn(place, body, x["v"], x["dt"][0])
    parts = [slice(at, at + 3) for at in range(body.v, body.v + body.nv, 3)]
    means, changes = [], []
    for part in parts:
        momentum = tuple(x["P"][part])
        force = scale(dt, vadd(tuple(x["P_rate"][part]), tuple(x["tau"][part])))
        angular = part is parts[-1]
        if angular or place.values.scene.options.base_velocity == "body":
            force = vadd(force, scale(2, cross(u, momentum)))
        if angular:
            longer = add(1, mul(QUARTER, dot(u, u)))
            momentum = vadd(scale(longer, momentum), scale(QUARTER, cross(u, force)))
        means.append(momentum)
        changes.append(force)
    return means, changes


def _carried(place: Place, body: TreeBody, u: Vec, parts: Sequence[Vec]) -> list[Scalar]:
    """Momenta from the middle's axes to those of the end that u points away from: a linear part turns with the body
    only where its velocity does."""
    both = body.joint.type == "spherical" or place.values.scene.options.base_velocity == "body"
    found = [_cayley(u, part) if both or part is parts[-1] else part for part in parts]
    return [entry for part in found for entry in part]


def momenta_before(place: Place, x: Arrays) -> list[Scalar]:
    """The momenta with which a step that has P and P_rate in its middle began: P − ½ dt (P_rate + tau) along
    coordinates."""
    half = mul(HALF, x["dt"][0])
    found = [sub(p, mul(half, add(f, t))) for p, f, t in zip(x["P"], x["P_rate"], x["tau"], strict=True)]
    for body in place.tree.bodies:
        if turning(body):
            means, changes = _impulses(place, body, x)
            before = [vsub(mean, scale(HALF, change)) for mean, change in zip(means, changes, strict=True)]
            u = _half_turn(place, body, x["v"], x["dt"][0])
            found[body.v : body.v + body.nv] = _carried(place, body, u, before)
    return found


def momenta_after(place: Place, x: Arrays) -> list[Scalar]:
    """The momenta P0 of the beginning and what the step adds to them; in turning axes they are carried along."""
    dt = x["dt"][0]
    found = [add(p, mul(dt, add(f, t))) for p, f, t in zip(x["P0"], x["P_rate"], x["tau"], strict=True)]
    for body in place.tree.bodies:
        if turning(body):
            _, changes = _impulses(place, body, x)
            back = scale(-1, _half_turn(place, body, x["v"], dt))
            first = tuple(x["P0"][body.v : body.v + body.nv])
            parts = [first[at : at + 3] for at in range(0, body.nv, 3)]
            entries = _carried(place, body, back, parts)
            middle = [tuple(entries[at : at + 3]) for at in range(0, body.nv, 3)]
            after = [vadd(part, change) for part, change in zip(middle, changes, strict=True)]
            found[body.v : body.v + body.nv] = _carried(place, body, back, after)
    return found


# --- the method ------------------------------------------------------------------------------------------------------


def _begin(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
    """Momenta, the middle as the first guess has it, and no acceleration."""
    momenta = [dot(row, tuple(x["v"])) for row in square(x["M"], place.tree.nv)]
    return momenta, places(place, x["q"], x["v"], x["dt"][0])[0], [0] * place.tree.nv


def corrected(place: Place, x: Arrays) -> Vec:
    """v after one correction: towards the velocity along which the step began with the momenta P0."""
    rest = [sub(p, wanted) for p, wanted in zip(momenta_before(place, x), x["P0"], strict=True)]
    return tuple(sub(v, y) for v, y in zip(x["v"], solved(place, square(x["J"], place.tree.nv), rest), strict=True))


def _correct(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
    v = corrected(place, x)
    return v, places(place, x["q"], v, x["dt"][0])[0]


def _finish(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
    return places(place, x["q"], corrected(place, x), x["dt"][0])[1], momenta_after(place, x)


def _solve(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
    return (solved(place, factored(place, square(x["M"], place.tree.nv)), x["P"]),)


def variational(factor: Function) -> Method:
    """``factor``: the update (M, dtau_dq, dtau_dv) → J = M + ½ dt dtau_dv + ¼ dt² dtau_dq, factored. With M at the
    beginning and the derivatives in the middle, that is the derivative of `momenta_before` by v up to dt²."""

    def update(name: str, inputs: Sequence[str], outputs: dict[str, str], function: Function, k: str = "") -> Update:
        own = {"P": f"P{k}", "P_rate": f"P_rate{k}", "v": "v" if k == "1" else f"v{k}"} if k else {}
        return Update(name, {x: own.get(x, x) for x in inputs}, outputs, function)

    again = ("J", "P", "P_rate", "tau", "P0", "q", "v", "dt")
    operations: list[Operation] = [
        Evaluate("mass_matrix", {"q": "q"}, {"M": "M"}),
        update("begin", ("M", "q", "v", "dt"), {"P0": "P0", "q1": "q1", "a": "a"}, _begin),
        Evaluate(
            "inverse_dynamics_derivatives",
            {"q": "q1", "v": "v", "a": "a"},
            {"dtau_dq": "dtau_dq", "dtau_dv": "dtau_dv"},
        ),
        update("factor", ("M", "dtau_dq", "dtau_dv", "dt"), {"J": "J"}, factor),
    ]
    for k in range(1, CORRECTIONS + 1):
        inputs = {"q": f"q{k}", "v": "v" if k == 1 else f"v{k}"}
        operations.append(Evaluate("joint_momentum", inputs, {"P": f"P{k}", "P_rate": f"P_rate{k}"}))
        if k < CORRECTIONS:
            outputs = {"v_new": f"v{k + 1}", "q_new": f"q{k + 1}"}
            operations.append(update("correct", again, outputs, _correct, str(k)))
    last = {"q_next": "q_next", "P_next": "P_next"}
    operations.append(update("finish", again, last, _finish, str(CORRECTIONS)))
    operations.append(Evaluate("mass_matrix", {"q": "q_next"}, {"M": "M_next"}))
    operations.append(Update("solve", {"M": "M_next", "P": "P_next"}, {"v_next": "v_next"}, _solve))
    sizes: dict[str, tuple[str, ...]] = dict.fromkeys(("M", "dtau_dq", "dtau_dv", "J", "M_next"), ("nv", "nv"))
    sizes |= {"P0": ("nv",), "a": ("nv",), "P_next": ("nv",)}
    for k in range(1, CORRECTIONS + 1):
        sizes |= {f"q{k}": ("nq",), f"P{k}": ("nv",), f"P_rate{k}": ("nv",)} | ({f"v{k}": ("nv",)} if k > 1 else {})
    return Method(
        "variational",
        f"{CORRECTIONS} Newton corrections with one Jacobian",
        f"by the variational midpoint rule, order 2, {CORRECTIONS} Newton corrections",
        ("mass_matrix", "joint_momentum", "inverse_dynamics_derivatives"),
        tuple(operations),
        sizes,
    )
