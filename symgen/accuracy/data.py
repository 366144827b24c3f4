"""What the section "Rounding error" of a scene's page shows, as plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from symgen.accuracy.bounds import Bound, bound
from symgen.accuracy.measure import ROWS, Problem, Row, Settings, measurable, measure
from symgen.errors import NotSupportedError
from symgen.program.instructions import count
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import Scene
from symgen.system import System, derive

Say = Callable[[str], None]
LONGEST = 1000
"""Operations times outputs up to which bounds are proven: a second or two."""
INTEGRATE = "integrate"


def rounding_data(
    scene: Scene, say: Say = lambda what: None, *, states: int = 1000, search: int = 100, boxes: int = 512
) -> dict[str, Any]:
    """Errors of every function, variant and plan at ``states`` sampled states and the worst that ``search`` evaluations
    find, and bounds proven by at most ``boxes`` boxes where functions are short.

    Raises NotSupportedError where nothing can be measured, ToolError without a C compiler, SciPy or python-flint.
    """
    wanted = (*ROWS, INTEGRATE) if any(body.nq > body.nv for body in derive(scene).tree.bodies) else ROWS
    rows = measurable(scene, wanted)
    if not rows:
        raise NotSupportedError("rounding errors: closed loops are not derived")
    settings = Settings(states, search=search, rows=rows)
    found = measure(scene, settings, say)
    say("proven bounds")
    return {
        "scene": scene.name,
        "states": states,
        "search": search,
        "box": box_words(derive(scene)),
        "rows": [row.to_json() for row in found],
        "bounds": list(bounds(scene, rows, found, boxes)),
    }


def bounds(scene: Scene, rows: tuple[str, ...], found: list[Row], boxes: int) -> Iterator[dict[str, Any]]:
    """Proven beside measured, of the functions that are short enough and whose box holds no singular state."""
    system = derive(scene)
    for name in rows:
        problem = Problem(system, system.output(name), Settings(1))
        program = problem.program
        entries = len({i for row in program.results for i in row})
        if not program.instructions or count(program).flops * entries > LONGEST:
            continue
        for precision in ("double", "float"):
            proven = bound(program, problem.box.intervals(), boxes, precision, problem.box.spheres())
            if np.isfinite(proven.error):
                yield {"function": name, "precision": precision, **_told(proven), **_beside(found, name, precision)}


def _told(proven: Bound) -> dict[str, Any]:
    return {"proven": proven.error, "largest": proven.largest, "boxes": proven.boxes}


def _beside(found: list[Row], name: str, precision: str) -> dict[str, Any]:
    own = [row.absolute for row in found if (row.function, row.variant, row.chosen) == (name, precision, True)]
    return {"measured": max(own, default=None)}


def box_words(system: System) -> str:
    """What `symgen.accuracy.states.Box` samples, in words, as far as the scene has it."""
    units = {unit for body in system.tree.bodies for unit in JOINT_TYPES[body.joint.type].q_units}
    parts = ["angles within ±π"] if "rad" in units else []
    parts += ["displacements within ±1 m"] if "m" in units else []
    parts += ["quaternions of unit length"] if any(body.nq > body.nv for body in system.tree.bodies) else []
    return ", ".join([*parts, "velocities within ±2, accelerations and forces within ±5"])
