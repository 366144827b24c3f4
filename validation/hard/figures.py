"""Curves of the hard-case page: errors as chains grow, as places move away, as angles grow."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from symgen.accuracy.balls import relative
from symgen.accuracy.states import rounded
from symgen.accuracy.variants import Variant, compile_variant
from symgen.plans.families import Family
from symgen.validation.hard.case import Array, Hard, States
from symgen.validation.hard.masses import near_straight
from symgen.validation.hard.places import WORLD
from symgen.validation.hard.scenes import X, Y, chain, pendulum

Say = Callable[[str], None]
Curve = dict[str, Any]
"""``name`` and ``points``, pairs (x, largest error)."""
LINKS = (2, 3, 5, 7, 10, 14, 20)
MORE_LINKS = (50, 100, 200)
PLACES = (1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7)
DECADES = (-8, -6, -4, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 23, 26, 29, 32, 35, 38)
SINES = 100
"""Angles of each decade."""


def figures(say: Say) -> dict[str, list[Curve]]:
    """``chains``: error of forward dynamics over links; ``places``: of the mass matrix over distance from the origin;
    ``angles``: of a sine over its angle, in u."""
    with tempfile.TemporaryDirectory() as folder:
        made = []
        for name, curves in (("chains", _chains), ("places", _places), ("angles", _angles)):
            say(f"figure: {name}")
            made.append((name, list(curves(Path(folder, name)))))
    return dict(made)


def _error(problem: Hard, states: States, variant: Variant, folder: Path) -> float:
    given = rounded(states, variant.precision)
    (compiled,) = compile_variant(problem.system, (problem.output,), variant, folder)
    return float(np.max(relative(compiled.call(given), *problem.reference.over(given))))


def _chains(folder: Path) -> Iterator[Curve]:
    problems = {links: Hard(chain(links), "forward_dynamics") for links in (*LINKS, *MORE_LINKS)}
    plans = (("LᵀDL", Family()), ("articulated bodies", Family(articulated=True)))
    for number, (name, family) in enumerate(plans):
        points = [
            (
                links,
                _error(problems[links], near_straight(links, 6), Variant(family=family), folder / f"{number}_{links}"),
            )
            for links in LINKS
        ]
        if family.articulated:  # in loops, which is what is chosen there
            points += [
                (links, _error(problems[links], near_straight(links, 2), Variant(), folder / f"loops_{links}"))
                for links in MORE_LINKS
            ]
        yield {"name": name, "points": points}


def _places(folder: Path) -> Iterator[Curve]:
    rng = np.random.default_rng(5)
    some: dict[str, Array] = {name: rng.uniform(-2, 2, (50, 3)) for name in ("q", "v", "tau")}
    problems = {place: Hard(chain(3, (Y, X), at=int(place)), "mass_matrix") for place in PLACES}
    for name, variant in (("symgen", Variant()), ("the definition, in ground axes", WORLD)):
        yield {
            "name": name,
            "points": [
                (place, _error(problem, some, variant, folder / f"{name[:3]}_{place:.0f}"))
                for place, problem in problems.items()
            ],
        }


def _angles(folder: Path) -> Iterator[Curve]:
    problem = Hard(pendulum(), "gravity_force")
    rng = np.random.default_rng(6)
    decades = {k: 10.0**k * rng.uniform(1, 10, (SINES, 1)) for k in DECADES}
    for variant in (Variant(), Variant(trigonometry="libm"), Variant("float")):
        (compiled,) = compile_variant(
            problem.system, (problem.output,), variant, folder / variant.name.replace(" ", "_")
        )
        points = []
        for k, angles in decades.items():
            if variant.precision == "float" and k > 37:
                continue
            given = rounded({"q": angles}, variant.precision)
            error = relative(compiled.call(given), *problem.reference.over(given))
            points.append((10.0**k, float(np.max(error)) / variant.unit))
        yield {"name": variant.name, "points": points}
