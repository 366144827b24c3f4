"""Error tables of compiled functions against ball arithmetic: the examples and five robots (or `make accuracy`).

    python -m tools.accuracy [--states N] [--search N] [--no-plans] [--variants a,b] [--rows a,b] [-o DIR] [SCENE …]
    python -m tools.accuracy --choices [SCENE …]   # plans that accuracy chose, of all robots and random chains too
    python -m tools.accuracy --bounds [SCENE …]    # proven bounds of the examples beside the errors measured

Prints a table per scene as it is made and leaves NAME.csv, NAME.json and summary.md in the folder (out/accuracy).
Robots need example-robot-data; what cannot be measured is said. Compiled files are kept in the user's cache.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from symgen.accuracy.choices import Changed, changed, random_chain
from symgen.accuracy.data import bounds
from symgen.accuracy.measure import ROWS, Row, Settings, measurable, measure
from symgen.accuracy.table import as_csv, as_json, as_markdown, as_text
from symgen.accuracy.variants import STANDARD
from symgen.errors import SymgenError
from symgen.program.rounding import UNITS
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.system import derive
from tools.bench import robot
from tools.robot_list import ROBOTS

ROOT = Path(__file__).resolve().parent.parent
FIVE = ("kinova", "xarm7", "solo12", "hyq", "tiago")


def subjects(names: Sequence[str], folder: Path) -> Iterator[tuple[str, Path]]:
    """Name and file of every scene that is asked for. Raises FileNotFoundError where there is none."""
    examples = {
        path.name.removesuffix(".scene.yaml"): path for path in sorted((ROOT / "examples").glob("*.scene.yaml"))
    }
    robots = {row.name for row in ROBOTS}
    for name in names or (*examples, *FIVE):
        if name in examples:
            yield name, examples[name]
        elif name in robots:
            yield name, robot(name, folder)
        elif Path(name).exists():
            yield Path(name).name.split(".")[0], Path(name)
        else:
            raise FileNotFoundError(f"{name} is no example, robot or file")


def measured(scene: Scene, settings: Settings) -> list[Row]:
    """Rows of a scene: those functions that it can have."""
    rows = measurable(scene, settings.rows)
    return measure(scene, replace(settings, rows=rows), progress) if rows else []


def progress(what: str) -> None:
    if sys.stderr.isatty():
        print(f"… {what}", file=sys.stderr)


CHAINS = 100


def choices(names: Sequence[str], folder: Path) -> Iterator[Changed]:
    """Functions whose plan accuracy decided: of the examples, all robots and random chains, or of what is named."""
    everything = sorted(path.name.removesuffix(".scene.yaml") for path in (ROOT / "examples").glob("*.scene.yaml"))
    for asked in names or (*everything, *(row.name for row in ROBOTS)):
        progress(asked)
        try:
            for name, path in subjects([asked], folder):
                system = derive(load(path))
                system.require_tree()
                yield from changed(system, name)
        except (FileNotFoundError, SymgenError) as error:
            print(f"{asked}: {error}", file=sys.stderr)
    for seed in range(0 if names else CHAINS):
        yield from changed(derive(random_chain(seed)))


def print_choices(rows: Sequence[Changed]) -> None:
    print("| scene | function | cheapest plan | its estimated error, times the best | chosen | times the cost |")
    print("| --- | --- | --- | --- | --- | --- |")
    for row in rows:
        print(f"| {row.scene} | {row.function} | {row.cheapest} | {row.error} | {row.chosen} | {row.dearer:.2f} |")


BOXES = 2048


def print_bounds(names: Sequence[str], settings: Settings, folder: Path) -> None:
    """Of functions short enough, over boxes without a singular state."""
    print("| scene | function | largest entry | double: proven | measured | float: proven | measured |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    pair = tuple(variant for variant in STANDARD if variant.name in ("double", "float"))
    examples = sorted(path.name.removesuffix(".scene.yaml") for path in (ROOT / "examples").glob("*.scene.yaml"))
    for name, path in subjects(names or examples, folder):
        progress(name)
        scene = load(path)
        rows = measurable(scene, (*ROWS, "integrate"))
        found = measure(scene, replace(settings, rows=rows, search=0, plans=False, variants=pair)) if rows else []
        proven: dict[str, dict[str, dict[str, float]]] = {}
        for row in bounds(scene, rows, found, BOXES):
            proven.setdefault(row["function"], {})[row["precision"]] = row
        for function, own in proven.items():
            cells = [f"{own[p][what]:.1e}" if p in own else "–" for p in UNITS for what in ("proven", "measured")]
            print(f"| {name} | {function} | {own['double']['largest']:.3g} | {' | '.join(cells)} |", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools.accuracy", description=__doc__.split("\n")[0])
    parser.add_argument("--states", type=int, default=10000, help="sampled states (default 10000)")
    parser.add_argument("--search", type=int, default=1000, help="evaluations of a search for the worst (0: none)")
    parser.add_argument("--no-plans", action="store_true", help="the chosen plans only")
    parser.add_argument("--rows", default=",".join(ROWS), help="functions")
    parser.add_argument("--variants", help="some of: " + ", ".join(variant.name for variant in STANDARD))
    parser.add_argument("--bounds", action="store_true", help="proven bounds beside measured errors")
    parser.add_argument("--choices", action="store_true", help="list plans that were chosen because of accuracy")
    parser.add_argument("-o", dest="folder", default="out/accuracy")
    parser.add_argument("names", nargs="*")
    asked = parser.parse_args()
    folder = Path(asked.folder)
    folder.mkdir(parents=True, exist_ok=True)
    settings = Settings(asked.states, search=asked.search, plans=not asked.no_plans, rows=tuple(asked.rows.split(",")))
    if asked.variants:
        wanted = {name.strip() for name in asked.variants.split(",")}
        settings = replace(settings, variants=tuple(variant for variant in STANDARD if variant.name in wanted))
    everything: list[Row] = []
    try:
        if asked.choices:
            print_choices(list(choices(asked.names, folder / "scenes")))
            return 0
        if asked.bounds:
            print_bounds(asked.names, settings, folder / "scenes")
            return 0
        for name, path in subjects(asked.names, folder / "scenes"):
            try:
                rows = measured(load(path), settings)
            except SymgenError as error:
                print(f"{name}: {error}\n", flush=True)
                continue
            print(f"{name}, {asked.states} states" if rows else f"{name}: closed loops are not derived", flush=True)
            print(as_text(rows) + "\n" if rows else "", flush=True)
            (folder / f"{name}.csv").write_text(as_csv(rows), encoding="utf-8")
            (folder / f"{name}.json").write_text(as_json(rows), encoding="utf-8")
            everything += rows
    except (FileNotFoundError, SymgenError) as error:
        print(f"symgen: {error}", file=sys.stderr)
        return 2
    (folder / "summary.md").write_text(as_markdown(everything), encoding="utf-8")
    return 1 if any(row.wrong for row in everything) else 0


if __name__ == "__main__":
    sys.exit(main())
