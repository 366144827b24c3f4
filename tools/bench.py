"""`make bench`: our functions beside every peer that is installed, for seven mechanisms from 2 to 38 velocities.

    python -m tools.bench [--peers a,b] [--variants standard] [--limit SECONDS] [--ablation] [-o DIR] [NAME or SCENE …]

Leaves NAME.json, NAME.csv, NAME.html, figures, peers.html and summary.md in the folder (out/bench). Compiled files are
kept there, so a second run only measures.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import yaml

from symgen.bench import BenchResult, Settings, ablation, bench, write_files
from symgen.bench.peers.forms import CHOICES
from symgen.bench.variant import FUNCTIONS
from symgen.errors import SymgenError
from symgen.report.peers import peers_page
from symgen.scene.load import load
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request
from tools.robot_list import ROBOTS, find_robot

ROOT = Path(__file__).resolve().parent.parent
NAMES = ("double_pendulum", "ur5", "panda", "arm7", "hyq", "chain20", "talos")
LIMIT_S = 300.0


def robot(name: str, folder: Path) -> Path:
    """A scene over a robot of example-robot-data. Raises FileNotFoundError without that package."""
    found = next(robot for robot in ROBOTS if robot.name == name)
    scene = {"name": name, "model": str(find_robot(found)), "options": {"base_velocity": "body"}}
    return written(name, scene | ({"base": "floating"} if found.base == "floating" else {}), folder)


def chain(links: int, folder: Path) -> Path:
    """Equal links of one metre that hang from one another and turn about x and y in turn."""
    bodies = [
        {"name": f"l{k}", "mass": 1, "com": [0, 0, -0.5], "inertia": [0.09, 0.08, 0.01, 0, 0, 0]} for k in range(links)
    ]
    joints = [
        {
            "name": f"j{k}", "type": "revolute", "parent": f"l{k - 1}" if k else "ground", "child": f"l{k}",
            "axis": [0, 1, 0] if k % 2 else [1, 0, 0], "origin": {"xyz": [0, 0, -1 if k else 0]},
        }
        for k in range(links)
    ]  # fmt: skip
    return written(f"chain{links}", {"name": f"chain{links}", "bodies": bodies, "joints": joints}, folder)


def written(name: str, scene: object, folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.scene.yaml"
    path.write_text(yaml.safe_dump(scene, sort_keys=False))
    return path


MADE: dict[str, Callable[[Path], Path]] = {
    "hyq": lambda folder: robot("hyq", folder),
    "talos": lambda folder: robot("talos", folder),
    "chain20": lambda folder: chain(20, folder),
}
"""Scenes that are made when asked for."""


def scene_file(name: str, folder: Path) -> Path:
    """The scene of a name in `NAMES`, or the file itself."""
    if name in MADE:
        return MADE[name](folder)
    for place in ("examples/bench", "examples"):
        path = ROOT / place / f"{name}.scene.yaml"
        if path.exists():
            return path
    return Path(name)


def measured(name: str, settings: Settings, folder: Path, outputs: str) -> BenchResult:
    scene = request(load(str(scene_file(name, folder / "scenes"))), outputs=parse_outputs(outputs), targets=("c",))
    result = bench(scene, settings, lambda what: print(f"  {scene.name}: {what}", file=sys.stderr, flush=True))
    (folder / f"{result.scene}.json").write_text(json.dumps(result.to_json(), indent=1, ensure_ascii=False) + "\n")
    write_files(
        result,
        folder / f"{result.scene}.csv",
        folder / "figures",
        folder / f"{result.scene}.html",
        figures_needed=False,
    )
    print(result.to_text(), flush=True)
    print(flush=True)
    return result


def summary(results: Sequence[BenchResult]) -> str:
    """One Markdown table a scene: instructions and nanoseconds of every program, with the ratio to ours."""
    parts = []
    for result in results:
        parts.append(f"### {result.scene} (nv = {result.nv})")
        parts += [f"{title}\n\n{result.markdown(what)}" for title, what in TABLES]
        parts.append(f"Programs worth having (a star: only noise keeps them here):\n\n{result.frontier_markdown()}")
    return "\n\n".join(parts) + "\n"


TABLES = (
    ("Instructions a call (times ours):", "instructions"),
    ("Nanoseconds a call, minimum (times ours):", "ns_min"),
)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=list(NAMES), metavar="NAME or SCENE")
    parser.add_argument("--peers", help="programs to measure beside ours; all that are installed unless named")
    parser.add_argument("--variants", choices=CHOICES, default="none", help="our functions in other forms, too")
    parser.add_argument("--outputs", default=",".join(FUNCTIONS))
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="CPU seconds that one file may take to compile")
    parser.add_argument("--ablation", action="store_true", help="what each transformation saves, in place of peers")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "bench")
    return parser.parse_args()


def main() -> int:
    options = arguments()
    peers = None if options.peers is None else tuple(x for x in options.peers.split(",") if x not in ("", "none"))
    settings = Settings(peers, variants=options.variants, folder=options.output, limit_s=options.limit)
    options.output.mkdir(parents=True, exist_ok=True)
    results, status = [], 0
    for name in options.scenes:
        try:
            if options.ablation:
                scene = load(str(scene_file(name, options.output / "scenes")))
                wanted = request(scene, outputs=parse_outputs(options.outputs), targets=("c",))
                found = ablation(wanted, settings)
                (options.output / f"{wanted.name}-ablation.txt").write_text(found.to_text() + "\n")
                print(found.to_text(), end="\n\n", flush=True)
                status = max(status, int(not found.passed))
            else:
                results.append(measured(name, settings, options.output, options.outputs))
        except (SymgenError, FileNotFoundError) as error:
            print(f"{name}: {error}", file=sys.stderr, flush=True)
            status = max(status, 2)
    if results:
        (options.output / "summary.md").write_text(summary(results))
        (options.output / "peers.html").write_text(peers_page([result.to_json() for result in results]))
    return status


if __name__ == "__main__":
    sys.exit(main())
