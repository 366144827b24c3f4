"""`make generated`: the C, headers and manifests of the example scenes, as they stand in generated/."""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def regenerate(path: Path, out: Path) -> str:
    """Generate one scene's C into ``out``/NAME; returns what to tell about it."""
    from symgen.errors import NotSupportedError
    from symgen.generate import generate
    from symgen.scene.load import load

    scene = load(path)
    name = path.name.removesuffix(".scene.yaml")
    try:
        generate(replace(scene, options=replace(scene.options, targets=("c",))), out / name)
    except NotSupportedError as error:
        return f"{name}: left out ({error})"
    return name


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    scenes = sorted(ROOT.glob("examples/*.scene.yaml"))
    with tempfile.TemporaryDirectory() as scratch:
        fresh = Path(scratch)
        with ProcessPoolExecutor(arguments.jobs) as pool:
            for told in pool.map(regenerate, scenes, [fresh] * len(scenes)):
                print(told, flush=True)
        # Only when everything worked: a scene that is gone leaves no files behind, a failure leaves all as it was.
        arguments.out.mkdir(parents=True, exist_ok=True)
        for old in arguments.out.iterdir():
            if old.is_dir():
                shutil.rmtree(old)
        for new in sorted(fresh.iterdir()):
            shutil.copytree(new, arguments.out / new.name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
