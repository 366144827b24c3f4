"""Hard cases of configuration: gimbal lock, universal joints, huge and tiny angles, quaternions off the sphere."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction as F

import numpy as np

from symgen.accuracy.balls import relative
from symgen.accuracy.states import rounded
from symgen.accuracy.variants import Compiled, Variant, compile_variant
from symgen.scene.builder import SceneBuilder
from symgen.scene.model import Scene
from symgen.validation.hard.case import Bench, Case, Finding, Hard, States, states
from symgen.validation.hard.scenes import X, chain, free_body, pendulum, wrist

EVERY = (Variant(), Variant(trigonometry="libm"), Variant(batch=True), Variant("float"), Variant("float", batch=True))


def gimbal(bench: Bench) -> Iterator[Finding]:
    for angle in (1e-2, 1e-4):
        some, what = states(q=[[0.3, angle, 0.4]], v=[[1, -1, 2]], tau=[[1, 2, 3]]), f"middle angle {angle:.0e}"
        yield from bench.accurate(
            wrist(), "forward_dynamics", some, f"{what}, a mass matrix of condition {angle**-2:.0e}", units=angle**-2,
            plans=True, variants=(Variant(),),
        )  # fmt: skip
    locked = states(q=[[0.3, 0.0, 0.4], [0.3, np.pi, 0.4], [0.3, 1e-9, 0.4]], v=[[0.0] * 3] * 3, tau=[[1.0, 0, 0]] * 3)
    for row in ("forward_dynamics", "mass_matrix_inverse", "forward_dynamics_derivatives"):
        for precision in ("double", "float"):
            yield from bench.none(wrist(), row, locked, f"{row}, locked: no inertia about a direction", precision)


def universal(bench: Bench) -> Iterator[Finding]:
    rng = np.random.default_rng(8)
    some = {name: rng.uniform(-2, 2, (20, 2)) for name in ("q", "v", "tau")}

    def cross(axis2: tuple[object, ...]) -> Scene:
        made = SceneBuilder("cross").body("b", 1, (F(1, 10), F(1, 5), F(1, 2)), (F(1, 10), F(1, 12), F(1, 30), 0, 0, 0))
        return made.joint("j", "universal", "ground", "b", axis=X, axis2=axis2).build()  # type: ignore[arg-type]

    yield from bench.accurate(cross((0, 1, 0)), "forward_dynamics", some, "axes at right angles", plans=True)
    yield from bench.accurate(cross((1, F(1, 1000), 0)), "forward_dynamics", some, "axes 1e-3 rad apart", plans=True)
    folded = states(q=[[0.2, np.pi / 2], [0.2, np.pi]], v=[[1, 2], [0, 1]], tau=[[1, 0], [0, 1]])
    yield from bench.accurate(cross((0, 1, 0)), "forward_dynamics", folded, "cross folded by 90° and 180°")
    yield bench.refused("axes in one line", lambda: cross((1, 0, 0)), "axis")


def huge_angles(bench: Bench) -> Iterator[Finding]:
    """Nothing is excused by the condition here: the sine of the given number is asked for."""
    for angles, variants in (
        ((1e3, 99999.0, 100001.0, 1e6, 1e9), EVERY), ((1e15, 1e22, 1.7e308), EVERY[:3]), ((3e38,), EVERY[3:]),
    ):  # fmt: skip
        for angle in angles:
            some = states(q=[[angle]] * 4)
            for variant in variants:
                yield _sharp(bench, pendulum(), "gravity_force", some, variant, f"angle {angle:g}", 4.0)
    for word in ("inf", "nan"):
        for variant in (Variant(), Variant("float")):
            f = bench.loaded(pendulum(), "gravity_force", precision=variant.precision)
            found = f.gravity_force([float(word)])
            yield bench.finding(f"angle {word}", variant.name, float(np.isfinite(found).any()), 0.0, "NaN")


def tiny(bench: Bench) -> Iterator[Finding]:
    for angle in (1e-5, 1e-20, 1e-200, 5e-324):
        some = states(q=[[angle]] * 4)
        yield _sharp(bench, pendulum(), "gravity_force", some, Variant(), f"angle {angle:g}", 4.0)
    scene = chain(3)
    for size in (1e-8, 1e-20):
        some = states(q=[[size, -size, size]], v=[[size, size, -size]], tau=[[size, 0, -size]])
        yield from bench.accurate(scene, "forward_dynamics", some, f"three links, q, v, tau of {size:g}")
    step = Hard(free_body(), "integrate")
    for size in (0.0, 1e-300, 1e-160, 1e-8):
        q, v = [[0, 0, 0, 0.5, 0.5, 0.5, 0.5]], [[0, 0, 0, size, -size, size]]
        some = states(q=q, v=v, dt=[[1e-3]])
        for compiled in compile_variant(step.system, (step.output,), Variant(), bench.place()):
            yield _against(bench, step, compiled, some, f"integrate, spin of {size:g} rad/s", 8.0)


def top_of_pendulum(bench: Bench) -> Iterator[Finding]:
    for q in (np.pi, float(np.nextafter(np.pi, 4)), -np.pi, 101 * np.pi):
        some = states(q=[[q]] * 4, v=[[0.0]] * 4, tau=[[0.0]] * 4)
        for variant in (Variant(), Variant(trigonometry="libm"), Variant("float")):
            yield _sharp(bench, pendulum(), "forward_dynamics", some, variant, f"q = {q!r}", 4.0)


def quaternions(bench: Bench) -> Iterator[Finding]:
    rng = np.random.default_rng(9)
    unit = rng.normal(size=(20, 4))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    place, v, tau = rng.uniform(-1, 1, (20, 3)), rng.uniform(-2, 2, (20, 6)), rng.uniform(-2, 2, (20, 6))
    body = free_body(gravity=(0, 0, F(-981, 100)))
    problem = Hard(body, "forward_dynamics")
    for scale in (1 + 1e-6, 1 - 1e-6, 2.0, 2.0**-20, 2.0**20):
        some = {"q": np.hstack([place, scale * unit]), "v": v, "tau": tau}
        yield from bench.accurate(body, "forward_dynamics", some, f"length {scale:.8g}")
    high, low = problem.reference.over({"q": np.hstack([place, unit]), "v": v, "tau": tau})
    (compiled,) = compile_variant(problem.system, (problem.output,), Variant(), bench.place())
    for scale in (0.5, 2.0**40):
        found = compiled.call({"q": np.hstack([place, scale * unit]), "v": v, "tau": tau})
        error = float(np.max(relative(found, high, low))) / 2.0**-53
        yield bench.finding(
            f"length {scale:.3g} as length 1", "double", error, 64.0, "difference to the same rotation", "u"
        )
    nothing = compiled.call({"q": np.zeros((4, 7)), "v": v[:4], "tau": tau[:4]})
    yield bench.finding("quaternion 0 0 0 0", "double", float(np.isfinite(nothing[:, :3]).any()), 0.0, "NaN")


def fast_spin(bench: Bench) -> Iterator[Finding]:
    for rate in (1e3, 1e6, 1e9):
        omega = rate * np.array([[1.0, -2.0, 0.5], [0.3, 0.1, 1.0]])
        q = np.tile([0.0, 0, 0, 0.1, 0.2, 0.3, 0.9], (2, 1))
        some = states(q=q, v=np.hstack([np.zeros((2, 3)), omega]), tau=np.zeros((2, 6)))
        yield from bench.accurate(free_body(), "forward_dynamics", some, f"{rate:.0e} rad/s")
    # Euler's equations, with numbers that doubles hold: exact
    f = bench.loaded(free_body(), "forward_dynamics")
    a = f.forward_dynamics([0, 0, 0, 0, 0, 0, 1], [0, 0, 0, 1024, 512, 256], [0] * 6)
    right = np.array([(2 - 3) * 512 * 256 / 1, (3 - 1) * 256 * 1024 / 2, (1 - 2) * 1024 * 512 / 3])
    error = float(np.max(np.abs(a[3:] - right)) / np.max(np.abs(right)))
    yield bench.finding("Euler's equations for I = 1, 2, 3", "double", error / 2.0**-53, 4.0, "", "u")


def _sharp(bench: Bench, scene: Scene, row: str, some: States, variant: Variant, what: str, allowed: float) -> Finding:
    problem, compiled = bench.compiled(scene, row, variant)
    return _against(bench, problem, compiled, some, what, allowed)


def _against(bench: Bench, problem: Hard, compiled: Compiled, some: States, what: str, allowed: float) -> Finding:
    """The error in units of u: the state is exact, and no condition excuses anything."""
    given = rounded(some, compiled.variant.precision)
    high, low = problem.reference.over(given)
    error = float(np.max(relative(compiled.call(given), high, low))) / compiled.variant.unit
    return bench.finding(what, f"{compiled.variant.name}, {compiled.plan}", error, allowed, "", "u")


CASES = (
    Case(
        "gimbal lock",
        "Where the middle one of three axes brings the other two in line, nothing turns about the third "
        "direction: there the mass matrix is singular, and near it every plan loses digits with its "
        "condition, though the problem itself is good.",
        "near it the exact acceleration to the condition of the mass matrix; at it, where there is none, NaN",
        gimbal,
    ),
    Case(
        "universal joint",
        "Two axes that are almost in one line are two velocities that do almost the same.",
        "the exact acceleration at any angle between the axes but zero, which is refused",
        universal,
    ),
    Case(
        "huge angles",
        "To reduce an angle by multiples of π takes as many digits of π as the angle has before its point: "
        "308 for the largest doubles.",
        "the sine of the number that is given, to two units in the last place; NaN of inf and NaN",
        huge_angles,
    ),
    Case(
        "tiny numbers",
        "Near zero terms of one size cancel, and squares of small numbers vanish.",
        "relative accuracy: nothing is lost by cancellation near zero",
        tiny,
    ),
    Case(
        "top of a pendulum",
        "Beside π the sine is the difference to π, which no double is: every digit of it comes from the "
        "digits of π that the angle does not have.",
        "the sine of the double nearest π, 1.2e-16, to two units in its last place",
        top_of_pendulum,
    ),
    Case(
        "quaternions",
        "Integration leaves quaternions whose length is not one; squares of long and short ones are far apart.",
        "a quaternion of any length is the rotation of its direction; NaN of the zero one",
        quaternions,
    ),
    Case(
        "fast spin",
        "Gyroscopic moments grow with the square of the rate, and the rate of the velocity is what is left of them.",
        "the exact acceleration",
        fast_spin,
    ),
)
