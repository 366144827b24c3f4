"""Hard cases of place and size: far from the origin, tiny and huge units, mounts that are nearly singular."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction as F

import numpy as np

from symgen.accuracy.variants import Variant, compile_variant
from symgen.plans.families import Family
from symgen.scene.builder import SceneBuilder
from symgen.system import derive
from symgen.validation.hard.case import Bench, Case, Finding, Hard
from symgen.validation.hard.scenes import X, Y, Z, chain, free_body

WORLD = Variant(family=Family(literal=True, regrouped=False))
"""The definition itself, RᵀMR and so on in ground axes."""


def far_away(bench: Bench) -> Iterator[Finding]:
    rng = np.random.default_rng(5)
    for at in (0, 10**3, 10**6):
        scene, what = chain(3, (Y, X), at=at), f"chain at {at:.0e} m"
        some = {name: rng.uniform(-2, 2, (50, 3)) for name in ("q", "v", "tau")}
        for row in ("mass_matrix", "bias_force", "forward_dynamics"):
            yield from bench.accurate(scene, row, some, f"{row}, {what}")
            problem = Hard(scene, row)
            for compiled in compile_variant(problem.system, (problem.output,), WORLD, bench.place()):
                found = bench.judged(problem, compiled, some, f"{row}, {what}", None)
                yield found
    for place in (1e3, 1e6):
        q = np.hstack([np.full((20, 3), place), rng.normal(size=(20, 4))])
        some = {"q": q, "v": rng.uniform(-2, 2, (20, 6)), "tau": rng.uniform(-2, 2, (20, 6))}
        body = free_body(gravity=(0, 0, F(-981, 100)))
        yield from bench.accurate(body, "forward_dynamics", some, f"floating base at {place:.0e} m")


def units(bench: Bench) -> Iterator[Finding]:
    rng = np.random.default_rng(6)
    for length, mass in ((F(1, 10**9), F(1, 10**12)), (F(10**9), F(10**24)), (F(1, 10**9), F(10**12))):
        made = SceneBuilder("units")
        for k in range(3):
            i = mass * length**2 / 12
            made.body(f"b{k}", mass, (0, 0, -length / 2), (i, i, i / 50, 0, 0, 0))
            made.joint(
                f"j{k}", "revolute", f"b{k - 1}" if k else "ground", f"b{k}", axis=(Y, X, Y)[k],
                xyz=(0, 0, -length if k else 0),
            )  # fmt: skip
        some = {name: rng.uniform(-2, 2, (20, 3)) for name in ("q", "v")}
        some["tau"] = rng.uniform(-1, 1, (20, 3)) * float(mass * length**2)
        what = f"links of {float(length):.0e} m and {float(mass):.0e} kg"
        # i² and the like leave the range of a float
        within = 1e-30 < float(mass * length**2) < 1e30
        variants = (Variant(), Variant("float")) if within else (Variant(),)
        yield from bench.accurate(made.build(), "forward_dynamics", some, what, variants=variants)


def mounts(bench: Bench) -> Iterator[Finding]:
    rng = np.random.default_rng(7)
    some = {name: rng.uniform(-2, 2, (20, 2)) for name in ("q", "v", "tau")}
    for angle in (F(1, 10**6) * 2, F(1, 10**4), F(15708, 10**4)):
        made = SceneBuilder("mount")
        for k in range(2):
            made.body(f"b{k}", 1, (F(1, 10), 0, F(1, 2)), (F(1, 10), F(1, 12), F(1, 30), 0, 0, 0))
            made.joint(f"j{k}", "revolute", f"b{k - 1}" if k else "ground", f"b{k}", axis=Z, rpy=(angle, 0, 0))
        yield from bench.accurate(
            made.build(), "forward_dynamics", some, f"axes {float(angle):.4g} rad apart", plans=True
        )
    for what, axes, place in (
        ("coaxial joints", (Z, Z), (0, 0, 1)), ("intersecting axes, zero-length link", (Z, X), (0, 0, 0)),
        ("parallel axes", (Y, Y), (1, 0, 0)),
    ):  # fmt: skip
        made = SceneBuilder("mount")
        for k in range(2):
            made.body(f"b{k}", 1, (F(1, 10), F(1, 5), F(1, 2)), (F(1, 10), F(1, 12), F(1, 30), 0, 0, 0))
            made.joint(f"j{k}", "revolute", f"b{k - 1}" if k else "ground", f"b{k}", axis=axes[k], xyz=place)
        scene = made.build()
        yield from bench.accurate(scene, "forward_dynamics", some, what, plans=True)
        worst = max(derive(scene).natural.conditions)
        note = "of the points and vectors that carry the mass of a body"
        yield bench.finding(what, "", worst, 100.0, note, "condition of W")


def loops(bench: Bench) -> Iterator[Finding]:
    def four_bar() -> object:
        made = SceneBuilder("four_bar")
        for name in ("crank", "coupler", "rocker"):
            made.body(name, 1, (F(1, 2), 0, 0), (0, F(1, 12), F(1, 12), 0, 0, 0))
        made.joint("a", "revolute", "ground", "crank", axis=Y).joint("b", "revolute", "crank", "coupler", axis=Y, xyz=X)
        made.joint("d", "revolute", "ground", "rocker", axis=Y, xyz=X)
        made.joint("c", "revolute", "rocker", "coupler", axis=Y, xyz=X)
        return derive(made.build()).program("forward_dynamics")

    def bricard() -> object:
        """Six hinges at right angles to their neighbours, all links of one length."""
        made = SceneBuilder("bricard")
        for k in range(5):
            made.body(f"b{k}", 1, (F(1, 2), 0, 0), (0, F(1, 12), F(1, 12), 0, 0, 0))
            before = f"b{k - 1}" if k else "ground"
            made.joint(f"j{k}", "revolute", before, f"b{k}", axis=(Z, Y)[k % 2], xyz=X if k else (0, 0, 0))
        made.joint("j5", "revolute", "ground", "b4", axis=Y, xyz=X)
        return derive(made.build()).program("forward_dynamics")

    yield bench.refused("four-bar at its change point", four_bar, "closed loops are not there yet")
    yield bench.refused("Bricard's loop", bricard, "closed loops are not there yet")


CASES = (
    Case(
        "far from the origin",
        "Formulas in ground axes take differences of places: a thousand kilometres away a double knows a "
        "place to 1e-10 m.",
        "the error at the origin: a place shifts nothing. The world-frame form (literal) loses digits, for comparison",
        far_away,
    ),
    Case(
        "units",
        "Molecules and planets: the same formulas with inertias from 1e-30 to 1e42 kg m².",
        "the exact acceleration, whatever the units",
        units,
    ),
    Case(
        "mounts",
        "Axes nearly parallel, in one line or crossing, and links of length zero: constraints and the choice "
        "of points that carry the mass may degenerate.",
        "the exact acceleration with axes nearly parallel, coaxial or intersecting",
        mounts,
    ),
    Case(
        "closed loops",
        "A four-bar at its change point can go two ways; Bricard's loop moves though a count of its "
        "constraints says that it cannot.",
        "refused by name: they are not derived",
        loops,
    ),
)
