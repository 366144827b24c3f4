"""Hard cases of mass and inertia: long chains, extreme ratios, needles, massless links, stiff springs."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction as F

import numpy as np

from symgen.accuracy.variants import Variant
from symgen.scene.builder import Number, SceneBuilder
from symgen.scene.model import Scene
from symgen.system import derive
from symgen.validation.hard.case import Bench, Case, Finding, states
from symgen.validation.hard.scenes import Y, Z, chain, elbow

BOTH = (Variant(), Variant("float"))


def near_straight(links: int, count: int = 4) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(links)
    q, v, tau = 1e-3 * rng.uniform(-1, 1, (count, links)), rng.uniform(-1, 1, (count, links)), np.zeros((count, links))
    tau[:, 0] = 1
    return states(q=q, v=v, tau=tau)


def long_chains(bench: Bench) -> Iterator[Finding]:
    for links in (10, 20):
        yield from bench.accurate(
            chain(links), "forward_dynamics", near_straight(links), f"{links} links", plans=links == 10
        )
    for links in (50, 100, 200):
        yield from bench.accurate(
            chain(links), "forward_dynamics", near_straight(links, 2), f"{links} links", units=2 * links
        )


def mass_ratios(bench: Bench) -> Iterator[Finding]:
    rng = np.random.default_rng(3)
    for ratio, what in ((10**6, "last link 1e6 times heavier"), (F(1, 10**6), "last link 1e6 times lighter")):
        for links in (2, 4):
            scene = chain(links, mass=lambda k, n=links, r=ratio: r if k == n - 1 else 1)  # type: ignore[misc]
            some = {name: rng.uniform(-3, 3, (20, links)) for name in ("q", "v", "tau")}
            yield from bench.accurate(
                scene, "forward_dynamics", some, f"{links} links, {what}", units=256, plans=True, refusing="float"
            )


def thin_bodies(bench: Bench) -> Iterator[Finding]:
    rng = np.random.default_rng(4)
    for what, inertia in (
        ("needle", (F(1, 12), F(1, 12), F(1, 10**12))), ("plate", (F(1, 12), F(1, 12), F(1, 6))), ("point", (0, 0, 0)),
    ):  # fmt: skip
        made = SceneBuilder(what)
        for k in range(3):
            made.body(f"b{k}", 1, (F(1, 10), 0, F(-1, 2)), (*inertia, 0, 0, 0))
            made.joint(f"j{k}", "revolute", f"b{k - 1}" if k else "ground", f"b{k}", axis=(Y, Z, Y)[k], xyz=(0, 0, -1))
        some = {name: rng.uniform(-2, 2, (20, 3)) for name in ("q", "v", "tau")}
        yield from bench.accurate(made.build(), "forward_dynamics", some, what, plans=True)


def massless(bench: Bench) -> Iterator[Finding]:
    lengths: tuple[tuple[Number, Number], ...] = ((1, 1), ("0.3", "0.7"))
    inline = states(q=[[0.2, 0.0], [0.2, np.pi], [0.2, 1e-9]], v=[[1, 1]] * 3, tau=[[1, 0]] * 3)
    for upper, lower in lengths:
        for row in ("forward_dynamics", "mass_matrix_inverse", "forward_dynamics_derivatives"):
            for precision in ("double", "float"):
                what = f"{row}, links of {upper} and {lower} m in line"
                yield from bench.none(elbow(upper, lower), row, inline, what, precision)
    bent = states(q=[[0.2, 1.0]], v=[[1, 1]], tau=[[1, 0]])
    yield from bench.accurate(elbow(1, 1), "forward_dynamics", bent, "bent by 1 rad", plans=True)
    nearly, what = states(q=[[0.2, 1e-3]], v=[[1, 1]], tau=[[1, 0]]), "bent by 1e-3 rad, a mass matrix of condition 4e6"
    yield from bench.accurate(
        elbow(1, 1), "forward_dynamics", nearly, what, units=4e6, plans=True, variants=BOTH[:1]
    )  # fmt: skip
    yield from bench.none(elbow(1, 1), "forward_dynamics", nearly, what, "float")
    inline = states(q=[[0.2, 0.0]], v=[[1, 1]], tau=[[1, 0]])
    yield from bench.accurate(elbow(1, 1, F(1, 10)), "forward_dynamics", inline, "in line, with armature")

    def leaf() -> object:
        scene = SceneBuilder("leaf").body("a", 1).body("b").joint("j", "revolute", "ground", "a", axis=Y)
        return derive(scene.joint("k", "revolute", "a", "b", axis=Z).build()).program("forward_dynamics")

    yield bench.refused("a massless last link", leaf, "the mass matrix is singular: no inertia moves")


def stiff(bench: Bench) -> Iterator[Finding]:
    for stiffness in (10**6, 10**12):
        yield from bench.accurate(
            _sprung(stiffness), "forward_dynamics",
            states(q=[[0.1, -0.2], [1e-6, 1e-7]], v=[[1, 2], [0, 1]], tau=[[0, 0], [1, 0]]),
            f"joint spring of {stiffness:.0e} N m/rad",
        )  # fmt: skip
    made = SceneBuilder("slack").body("b", 1, inertia=(1, 1, 1, 0, 0, 0)).joint("j", "floating", "ground", "b")
    scene = made.spring(("ground", "b"), ((0, 0, 0), (0, 0, 0)), stiffness=1, length=1).build()
    f = bench.loaded(scene, "passive_force")
    found = f.passive_force([0, 0, 0, 0, 0, 0, 1], [0] * 6)
    yield bench.finding("spring with both ends at one point", "double", float(np.isfinite(found[:3]).any()), 0.0, "NaN")


def _sprung(stiffness: int) -> Scene:
    made = SceneBuilder("sprung")
    for k in range(2):
        made.body(f"l{k}", 1, (0, 0, F(-1, 2)), (F(1, 12), F(1, 12), F(1, 1000), 0, 0, 0))
        made.joint(f"j{k}", "revolute", f"l{k - 1}" if k else "ground", f"l{k}", axis=Y, xyz=(0, 0, -k))
        made.joint_spring(f"j{k}", stiffness=stiffness)
    return made.build()


CASES = (
    Case(
        "long chains",
        "The mass matrix of a straight chain of n equal links has a condition of about 4 n⁴, 6e9 at 200 "
        "links: a plan that forms and factors it loses as many digits.",
        "the exact acceleration to the condition of the problem, for 10 to 200 links",
        long_chains,
    ),
    Case(
        "mass ratios",
        "A link that carries a million times its own mass: what it does is a small difference of large forces.",
        "the exact acceleration to the condition of the problem, for masses 1e6 apart; in float NaN where rounding "
        "errors are as large as pivots",
        mass_ratios,
    ),
    Case(
        "thin bodies",
        "A needle has no inertia about its axis, a point none at all, and that of a plate is at the limit of "
        "what a body can have: natural mass matrices are singular.",
        "the exact acceleration to the condition of the problem, for needles, plates and points",
        thin_bodies,
    ),
    Case(
        "massless links",
        "Joints in one place are drawn with massless bodies between them; then the mass matrix is regular "
        "only where what is beyond them can feel every velocity.",
        "where the mass matrix is singular to working precision: NaN and status 1; where it is regular, or with "
        "armature, the exact acceleration; a massless last link is refused",
        massless,
    ),
    Case(
        "stiff springs",
        "Spring forces a million million times larger than weights; and a spring whose ends meet has no direction.",
        "the exact acceleration; NaN where a spring has no direction",
        stiff,
    ),
)
