"""`make demo`: every example scene generated, certified, compiled, validated and reported, two at a time."""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from symgen.errors import NotSupportedError, SymgenError
from symgen.generate import generate
from symgen.report import IndexEntry, write_index, write_report
from symgen.scene.load import load
from symgen.validation import validate

ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Line:
    """What the demonstration says of one scene."""

    scene: str
    text: str
    ok: bool
    entry: IndexEntry
    """Its card of the index."""


def demonstrate(path: Path, out: Path) -> Line:
    """One scene through the whole house. Errors become a line, not a traceback."""
    name = path.name.removesuffix(".scene.yaml")
    started = time.perf_counter()
    entry: IndexEntry | None = None
    try:
        text, ok, entry = run(path, out / name)
    except SymgenError as error:
        text, ok = f"FAILED: {error}", False
    except Exception as error:
        text, ok = f"FAILED: {type(error).__name__}: {error}", False
    if entry is None:
        entry = IndexEntry(name, None, "It could not be made.", text, False)
    return Line(name, f"{text} ({time.perf_counter() - started:.1f} s)", ok, entry)


def run(path: Path, out: Path) -> tuple[str, bool, IndexEntry]:
    """Generate, validate, report. A closed loop gets its report only."""
    scene = load(path)
    page = out / "report.html"
    try:
        artifact = generate(scene, out)
        artifact.load()
    except NotSupportedError:
        return "closed loops: shown, not derived yet", True, write_report(page, scene)
    result = validate(scene)
    entry = write_report(page, scene, result, artifact)
    functions = len(artifact.manifest["functions"])
    failures = [row.quantity for row in result.failures()]
    verdict = f"{len(result.rows)} checks passed" if result.passed else f"FAILED: {'; '.join(failures)}"
    return f"{functions} functions certified and compiled, {verdict}", result.passed, entry


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/demo"))
    arguments = parser.parse_args()
    scenes = arguments.scenes or list(ROOT.glob("examples/*.scene.yaml"))
    scenes.sort(key=lambda path: (-path.stat().st_size, path.name))  # the long ones first
    started = time.perf_counter()
    lines: list[Line] = []
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for future in as_completed([pool.submit(demonstrate, scene, arguments.out) for scene in scenes]):
            lines.append(future.result())
            print(f"{lines[-1].scene:18s} {lines[-1].text}", flush=True)
    index = write_index(arguments.out, [line.entry for line in lines])
    bad = [line.scene for line in lines if not line.ok]
    verdict = f"FAILED: {', '.join(sorted(bad))}" if bad else "all passed"
    print(f"\n{len(lines)} scenes in {time.perf_counter() - started:.0f} s: {verdict}")
    print(f"report: {index}")
    return 1 if bad or not lines else 0


if __name__ == "__main__":
    sys.exit(main())
