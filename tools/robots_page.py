"""docs/robots.md from what tools/robots.py left: ``python -m tools.robots_page out/robots > docs/robots.md``."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from tools.robots import Record, label, text, worst

COUNTED = (
    "mass_matrix", "inverse_dynamics", "forward_dynamics", "mass_matrix_inverse", "coriolis_matrix",
    "inverse_dynamics_derivatives", "forward_dynamics_derivatives", "inverse_dynamics_second_derivatives",
    "vjp:inverse_dynamics", "vjp:forward_dynamics", "momentum_matrix", "frame_jacobian:FRAME", "regressor",
    "base_regressor", "joint_wrenches", "constraint_forces",
)  # fmt: skip
SHORT = {
    "mass_matrix": "M", "inverse_dynamics": "ID", "forward_dynamics": "FD", "mass_matrix_inverse": "M⁻¹",
    "coriolis_matrix": "C", "inverse_dynamics_derivatives": "∂ID", "forward_dynamics_derivatives": "∂FD",
    "inverse_dynamics_second_derivatives": "∂²ID", "vjp:inverse_dynamics": "vjp ID", "vjp:forward_dynamics": "vjp FD",
    "momentum_matrix": "A", "frame_jacobian:FRAME": "J", "regressor": "Y", "base_regressor": "Y base",
    "joint_wrenches": "W", "constraint_forces": "λ",
}  # fmt: skip
COMPARED = tuple(name for name in COUNTED if name not in ("coriolis_matrix", "constraint_forces"))

TEXT = """# Robots

Made by `make robots`: every function of the catalogue for robots of PyPI's `example-robot-data` (iiwa: `robosuite`'s
MJCF; Cassie: the spanning tree of its SDF). Walking robots stand on a floating base; frame rows are for the last body.

Differences are to Pinocchio, ‖x − x̂‖∞/‖x̂‖∞, the worst of a few random states, of compiled C. Those of second
derivatives are about the accuracy of the differences they are compared with. Seconds are CPU seconds: derive, emit and
certify all functions, one by one (every one is certified against its literal definition, or it would not be here), and
gcc -O2 of those that it compiles within the limit of the run (long functions without branches take it long; the others
are compared at -O0). A dash: not made, or not compared, within the limits. Rows were measured with versions that differ
by a few commits.
"""


def rows(head: list[str], body: list[list[str]]) -> list[str]:
    return ["", *("| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *body))]


def find(robot: Record, name: str) -> dict[str, Any]:
    return next((f for f in robot["functions"] if label(f["output"]) == name), {})


def overview(robot: Record) -> list[str]:
    functions = robot["functions"]
    made = sum(f.get(key) or 0 for f in functions for key in ("derive_s", "emit_s", "certify_s"))
    compiled = sum(f.get("compile_O2_s") or 0 for f in functions)
    slow = sorted(f["note"] for f in functions if "note" in f and "flops" in f and f.get("compile_O2_s") is None)[::-1]
    failed = [f"{f['output']}: {f['error']}" for f in functions if "error" in f]
    conditions = [f["remark"] for f in functions if (f.get("difference") or 0) > 1e-12 and "condition" in f["remark"]]
    notes = [robot.get("note") or "", robot["error"], *failed]
    notes += [f"{slow[0].replace('-O0', '-O2')} for {len(slow)} functions"] if slow else []
    notes += (
        [f"{conditions[0][conditions[0].index('condition') :]} where the differences are largest"] if conditions else []
    )
    over = [f["output"] for f in functions if f.get("difference") is not None and not f["difference"] <= f["criterion"]]
    notes += [f"over the criterion: {', '.join(over)}"] if over else []
    good = sum("error" not in f for f in functions)
    return [
        robot["robot"], robot["what"], str(robot.get("nq", "–")), str(robot.get("nv", "–")),
        f"{good} of {len(functions)}", text(worst(functions, False), ".1e"), text(worst(functions, True), ".1e"),
        f"{made:.1f}", f"{compiled:.1f}", "; ".join(note for note in notes if note),
    ]  # fmt: skip


def page(robots: list[Record], trees: list[Record]) -> str:
    lines = [TEXT.rstrip("\n")]
    head = ["robot", "", "nq", "nv", "functions", "worst difference", "of derivatives", "made, s", "gcc -O2, s", "note"]
    lines += rows(head, [overview(robot) for robot in robots])
    key = ", ".join(f"{short} {name}" for name, short in SHORT.items())
    lines += ["", "## Operations", "", f"Additions, multiplications, divisions and roots. {key}."]
    counted = [[robot["robot"], *(text(find(robot, name).get("flops"), ",") for name in COUNTED)] for robot in robots]
    lines += rows(["", *(SHORT[name] for name in COUNTED)], counted)
    lines += ["", "## Differences to Pinocchio"]
    compared = [
        [robot["robot"], *(text(find(robot, name).get("difference"), ".0e") for name in COMPARED)] for robot in robots
    ]
    lines += rows(["", *(SHORT[name] for name in COMPARED)], compared)
    if trees:
        lines += ["", "## Random trees", "", "CPU seconds to derive and emit, and to certify; operations."]
        names = ("mass_matrix", "inverse_dynamics", "forward_dynamics")
        lines += rows(["bodies", "nv", *names], [tree_row(tree, names) for tree in trees])
    return "\n".join(lines) + "\n"


def tree_row(tree: Record, names: tuple[str, ...]) -> list[str]:
    found = [find(tree, name) for name in names]
    cells = [
        f"{f['derive_s'] + f['emit_s']:.2f} + {f['certify_s']:.2f} s; {f['flops']:,}" if "derive_s" in f else "–"
        for f in found
    ]
    return [tree["robot"].removeprefix("tree_"), str(tree.get("nv", "–")), *cells]


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/robots")
    robots = json.loads((folder / "robots.json").read_text(encoding="utf-8"))
    scaling = folder / "scaling.json"
    trees = json.loads(scaling.read_text(encoding="utf-8")) if scaling.exists() else []
    print(page(robots, trees), end="")


if __name__ == "__main__":
    main()
