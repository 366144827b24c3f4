"""`make demo`: every example scene generated, certified, compiled, validated and reported, two at a time."""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Line:
    """What the demonstration says of one scene."""

    scene: str
    text: str
    ok: bool


def demonstrate(path: Path, out: Path) -> Line:
    """One scene through the whole house. Errors become a line, not a traceback."""
    from symgen.errors import NotSupportedError, SymgenError

    name = path.name.removesuffix(".scene.yaml")
    started = time.perf_counter()
    try:
        text, ok = run(path, out / name)
    except NotSupportedError as error:
        text, ok = f"shown only: {error}", True
    except SymgenError as error:
        text, ok = f"FAILED: {error}", False
    except Exception as error:
        text, ok = f"FAILED: {type(error).__name__}: {error}", False
    return Line(name, f"{text} ({time.perf_counter() - started:.1f} s)", ok)


def run(path: Path, out: Path) -> tuple[str, bool]:
    from symgen.generate import generate
    from symgen.report import write_report
    from symgen.scene.load import load
    from symgen.validation import validate

    scene = load(path)
    artifact = generate(scene, out)
    result = validate(scene)
    write_report(out / "report.html", scene, result, artifact)
    functions = len(artifact.manifest["functions"])
    worst = "all within bounds" if result.passed else "OUT OF BOUNDS"
    return f"{functions} functions certified, {len(result.rows)} checks {worst}", result.passed


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/demo"))
    arguments = parser.parse_args()
    scenes = arguments.scenes or sorted(ROOT.glob("examples/*.scene.yaml"))
    arguments.out.mkdir(parents=True, exist_ok=True)
    lines = []
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for future in as_completed([pool.submit(demonstrate, scene, arguments.out) for scene in scenes]):
            line = future.result()
            lines.append(line)
            print(f"{line.scene:18s} {line.text}", flush=True)
    from symgen.report import write_index

    index = write_index(arguments.out)
    print(f"report: {index}")
    return 0 if lines and all(line.ok for line in lines) else 1


if __name__ == "__main__":
    sys.exit(main())
