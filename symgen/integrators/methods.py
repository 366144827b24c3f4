"""The methods: semi-implicit Euler, Runge–Kutta on coordinates and on the Lie group, the implicit midpoint rule, and
the variational one (`symgen.integrators.variational`).

All take tau as constant over the step. To add a method: one function here and its row in `METHODS`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from symgen.algebra.linear import mul, scale, total
from symgen.integrators.geometry import factored, logarithmic_rate, moved, normalised, rate, solved, square
from symgen.integrators.model import Arrays, Evaluate, Function, Method, Operation, Place, Update
from symgen.integrators.variational import variational

Scalar = Any
HALF = Fraction(1, 2)
SOLVES = 4
"""Corrections of the implicit midpoint rule. The Jacobian is that at the beginning of the step, so each takes the error
of the step's equation down by two powers of dt: four leave dt⁹."""


def _same(*names: str) -> dict[str, str]:
    return {name: name for name in names}


def _forward(a: str, q: str, v: str) -> Evaluate:
    return Evaluate("forward_dynamics", {"q": q, "v": v, "tau": "tau"}, {"a": a})


def _integrate(q: str, along: str) -> Evaluate:
    """q ⊕ dt · along, from the beginning of the step."""
    return Evaluate("integrate", {"q": "q", "v": along, "dt": "dt"}, {"q_next": q})


def _update(name: str, inputs: Sequence[str], outputs: Sequence[str], function: Function) -> Update:
    return Update(name, _same(*inputs, "dt"), _same(*outputs), function)


# --- semi-implicit Euler --------------------------------------------------------------------------------------------


def _semi_implicit_euler() -> Method:
    def velocity(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
        return (moved(x["v"], x["dt"][0], x["a"]),)

    operations: tuple[Operation, ...] = (
        _forward("a", "q", "v"),
        _update("velocity", ("v", "a"), ("v_next",), velocity),
        _integrate("q_next", "v_next"),
    )
    return Method(
        "semi_implicit_euler",
        "v first, then q with the new v",
        "by semi-implicit Euler, order 1",
        ("forward_dynamics", "integrate"),
        operations,
        {"a": ("nv",)},
    )


# --- Runge–Kutta of order 4 ------------------------------------------------------------------------------------------

STAGES = ((1, HALF), (2, HALF), (3, Fraction(1)))
"""(stage before, how far) of stages 2, 3, 4."""
WEIGHTS = (Fraction(1, 6), Fraction(1, 3), Fraction(1, 3), Fraction(1, 6))


def _state(k: int) -> tuple[str, str]:
    """Names of q and v at a stage."""
    return ("q", "v") if k == 1 else (f"q{k}", f"v{k}")


def _mean(rows: Sequence[Sequence[Scalar]]) -> list[Scalar]:
    """The weighted sum of the four stages' rates."""
    return [total(mul(w, x) for w, x in zip(WEIGHTS, entries, strict=True)) for entries in zip(*rows, strict=True)]


def _rk4() -> Method:
    """On coordinates: quaternions move along dq/dt as any other coordinate, and are normalised at the end."""

    def stage(before: int, part: Fraction) -> Function:
        q_before, v_before = _state(before)

        def function(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
            h = mul(part, x["dt"][0])
            along = rate(place, x[q_before], x[v_before])
            return moved(x["q"], h, along), moved(x["v"], h, x[f"a{before}"])

        return function

    def finish(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
        along = _mean([rate(place, x[q], x[v]) for q, v in map(_state, (1, 2, 3, 4))])
        q = normalised(place, moved(x["q"], x["dt"][0], along))
        return q, moved(x["v"], x["dt"][0], _mean([x[f"a{k}"] for k in (1, 2, 3, 4)]))

    operations: list[Operation] = [_forward("a1", "q", "v")]
    for before, part in STAGES:
        names = dict.fromkeys(("q", "v", *_state(before), f"a{before}"))
        k = before + 1
        operations.append(_update(f"stage{k}", tuple(names), _state(k), stage(before, part)))
        operations.append(_forward(f"a{k}", *_state(k)))
    everything = [name for k in (1, 2, 3, 4) for name in (*_state(k), f"a{k}")]
    operations.append(_update("finish", everything, ("q_next", "v_next"), finish))
    sizes: dict[str, tuple[str, ...]] = {f"q{k}": ("nq",) for k in (2, 3, 4)}
    sizes |= {f"v{k}": ("nv",) for k in (2, 3, 4)} | {f"a{k}": ("nv",) for k in (1, 2, 3, 4)}
    return Method(
        "rk4",
        "Runge-Kutta on coordinates",
        "by Runge and Kutta's classical method, order 4",
        ("forward_dynamics",),
        tuple(operations),
        sizes,
    )


def _lie() -> Method:
    """Runge, Kutta, Munthe-Kaas: stages are q ⊕ w with w in the tangent space at q, dw/dt = (d exp)⁻¹ v. What the
    coordinates mean is kept exactly; without quaternions it is `_rk4`."""

    def stage(before: int, part: Fraction) -> Function:
        along = "v" if before == 1 else f"w{before}"

        def function(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
            dt = x["dt"][0]
            u = scale(part, tuple(x[along])) if part != 1 else tuple(x[along])
            v = moved(x["v"], mul(part, dt), x[f"a{before}"])
            w = logarithmic_rate(place, tuple(mul(dt, y) for y in u), v)
            return u, v, w

        return function

    def finish(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
        u = _mean([x["v"], x["w2"], x["w3"], x["w4"]])
        return u, moved(x["v"], x["dt"][0], _mean([x[f"a{k}"] for k in (1, 2, 3, 4)]))

    operations: list[Operation] = [_forward("a1", "q", "v")]
    for before, part in STAGES:
        k, along = before + 1, "v" if before == 1 else f"w{before}"
        inputs = tuple(dict.fromkeys(("v", along, f"a{before}")))
        operations.append(_update(f"stage{k}", inputs, (f"u{k}", f"v{k}", f"w{k}"), stage(before, part)))
        operations += [_integrate(f"q{k}", f"u{k}"), _forward(f"a{k}", f"q{k}", f"v{k}")]
    everything = ("v", "w2", "w3", "w4", "a1", "a2", "a3", "a4")
    operations.append(_update("finish", everything, ("u", "v_next"), finish))
    operations.append(_integrate("q_next", "u"))
    sizes: dict[str, tuple[str, ...]] = {f"q{k}": ("nq",) for k in (2, 3, 4)}
    sizes |= {"u": ("nv",)}
    sizes |= {f"{x}{k}": ("nv",) for x in "uvw" for k in (2, 3, 4)} | {f"a{k}": ("nv",) for k in (1, 2, 3, 4)}
    return Method(
        "lie",
        "Runge-Kutta-Munthe-Kaas",
        "by Runge, Kutta and Munthe-Kaas on the Lie group of the joints, order 4",
        ("forward_dynamics", "integrate"),
        tuple(operations),
        sizes,
    )


# --- the implicit midpoint rule --------------------------------------------------------------------------------------


def _factor(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
    """The Jacobian of the rule's equation by a, factored."""
    n, half = place.tree.nv, mul(HALF, x["dt"][0])
    quarter = mul(half, half)
    rows = [
        m + mul(half, by_v) + mul(quarter, by_q)
        for m, by_v, by_q in zip(x["M"], x["dtau_dv"], x["dtau_dq"], strict=True)
    ]
    return ([y for row in factored(place, square(rows, n)) for y in row],)


def _implicit_midpoint() -> Method:
    """The acceleration a with M a + h = tau in the middle, q ⊕ ½ dt v_m and v_m = v + ½ dt a, by Newton's method with
    the Jacobian M + ½ dt ∂h/∂v + ¼ dt² ∂h/∂q at the beginning; then v + dt a and q ⊕ dt v_m. Symmetric in time."""

    def start(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
        return [0] * place.tree.nv, scale(HALF, tuple(x["v"]))

    def correction(place: Place, x: Arrays) -> tuple[list[Scalar], list[Scalar]]:
        rest = [f - tau for f, tau in zip(x["f"], x["tau"], strict=True)]
        step = solved(place, square(x["J"], place.tree.nv), rest)
        a = [y - z for y, z in zip(x["a"], step, strict=True)]
        return a, list(moved(x["v"], mul(HALF, x["dt"][0]), a))

    def correct(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
        a, v = correction(place, x)
        return a, v, scale(HALF, tuple(v))

    def finish(place: Place, x: Arrays) -> tuple[Sequence[Scalar], ...]:
        a, v = correction(place, x)
        return v, moved(x["v"], x["dt"][0], a)

    def inputs(k: int) -> dict[str, str]:
        return {"J": "J", "f": f"f{k}", "tau": "tau", "a": f"a{k}", "v": "v", "dt": "dt"}

    operations: list[Operation] = [
        _update("start", ("v",), ("a1", "w1"), start),
        _integrate("q1", "w1"),
        Evaluate("mass_matrix", {"q": "q1"}, {"M": "M"}),
        Evaluate("inverse_dynamics_derivatives", {"q": "q1", "v": "v", "a": "a1"}, _same("dtau_dq", "dtau_dv")),
        _update("factor", ("M", "dtau_dq", "dtau_dv"), ("J",), _factor),
    ]
    for k in range(1, SOLVES + 1):
        v = "v" if k == 1 else f"v{k}"
        if k > 1:
            operations.append(_integrate(f"q{k}", f"w{k}"))
        operations.append(Evaluate("inverse_dynamics", {"q": f"q{k}", "v": v, "a": f"a{k}"}, {"tau": f"f{k}"}))
        if k < SOLVES:
            outputs = {"a_new": f"a{k + 1}", "v_new": f"v{k + 1}", "w_new": f"w{k + 1}"}
            operations.append(Update("correct", inputs(k), outputs, correct))
    operations.append(Update("finish", inputs(SOLVES), _same("u", "v_next"), finish))
    operations.append(_integrate("q_next", "u"))
    sizes: dict[str, tuple[str, ...]] = dict.fromkeys(("M", "dtau_dq", "dtau_dv", "J"), ("nv", "nv"))
    sizes |= {f"q{k}": ("nq",) for k in range(1, SOLVES + 1)} | {"u": ("nv",)}
    sizes |= {f"{x}{k}": ("nv",) for x in "awf" for k in range(1, SOLVES + 1)}
    sizes |= {f"v{k}": ("nv",) for k in range(2, SOLVES + 1)}
    return Method(
        "implicit_midpoint",
        f"{SOLVES} Newton corrections with one Jacobian",
        f"by the implicit midpoint rule, order 2, {SOLVES} Newton corrections",
        ("integrate", "mass_matrix", "inverse_dynamics", "inverse_dynamics_derivatives"),
        tuple(operations),
        sizes,
    )


METHODS: dict[str, Method] = {
    method.name: method
    for method in (_semi_implicit_euler(), _rk4(), _lie(), _implicit_midpoint(), variational(_factor))
}
"""By name: ``step:NAME`` in the catalogue."""
