"""How long generating takes: derive, emit with read-back, CasADi, certify; per scene and for chains of revolutes.

``python tools/generation_time.py [SCENE … | N …]``: scene files, or numbers of links of a chain. CPU seconds, the
minimum of a few runs; everything is done as `symgen.generate` does it, except that nothing is written.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from symgen import Scene, SceneBuilder, derive, load
from symgen.generate import generate_files
from symgen.program.instructions import count

EXAMPLES = Path(__file__).parent.parent / "examples"
DEFAULT = [*(str(EXAMPLES / f"{name}.scene.yaml") for name in ("fig1", "fig2", "ur5", "panda")), "10", "50", "100"]
AXES = ((0, 0, 1), (0, 1, 0))


def chain(links: int) -> Scene:
    """A chain of revolutes about z and y in turn, with generic centres of mass and inertias."""
    builder = SceneBuilder(f"chain_{links}")
    parent = "ground"
    for k in range(links):
        name = f"link{k}"
        builder.body(
            name,
            mass="1.2",
            com=("0.1", "0.05", "0.14"),
            inertia=("0.03", "0.04", "0.05", "0.002", "0.0015", "-0.003"),
        )
        builder.joint(f"j{k}", "revolute", parent, name, axis=AXES[k % 2], xyz=("0.2", "0.1", "0.3"))
        parent = name
    return builder.outputs("mass_matrix", "bias_force", "forward_dynamics").build()


def measure(scene: Scene, runs: int) -> tuple[list[float], int, int]:
    """(CPU seconds to derive, emit and read back, certify, and in all; the functions' flops; functions)."""
    best: list[float] = []
    flops = functions = 0
    for _ in range(runs):
        marks: dict[str, float] = {}

        def progress(done: int, total: int, what: str, marks: dict[str, float] = marks) -> None:
            marks.setdefault(what.split(" ", maxsplit=1)[0] if done else "start", time.process_time())

        begun = time.process_time()
        system = derive(scene)
        generate_files(system, progress)
        ended = time.process_time()
        times = [marks["emit"] - begun, marks["certify"] - marks["emit"], ended - marks["certify"], ended - begun]
        best = times if not best or times[-1] < best[-1] else best
        functions = len(system.outputs)
        flops = sum(count(system.program(output.name)).flops for output in system.outputs)
    return best, flops, functions


def main() -> None:
    measure(load(EXAMPLES / "pendulum.scene.yaml"), 1)  # imports
    print(f"{'scene':24}{'functions':>10}{'flops':>10}{'derive':>9}{'emit':>9}{'certify':>9}{'all':>9}  us/flop")
    for argument in sys.argv[1:] or DEFAULT:
        scene = chain(int(argument)) if argument.isdigit() else load(argument)
        times, flops, functions = measure(scene, 1 if argument.isdigit() and int(argument) > 40 else 3)
        row = "".join(f"{seconds:9.2f}" for seconds in times)
        print(f"{scene.name:24}{functions:10}{flops:10}{row}{1e6 * times[-1] / flops:9.0f}")


if __name__ == "__main__":
    main()
