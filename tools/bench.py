"""`make bench`: `symgen bench` on a few examples, one after the other."""

from __future__ import annotations

import sys
from pathlib import Path

from symgen.cli import run

ROOT = Path(__file__).resolve().parent.parent
SCENES = ("fig1", "fig2", "ur5", "panda")


def main() -> int:
    scenes = sys.argv[1:] or [str(ROOT / f"examples/{name}.scene.yaml") for name in SCENES]
    status = 0
    for scene in scenes:
        status = max(status, run(["bench", scene]))
        print(flush=True)
    return status


if __name__ == "__main__":
    sys.exit(main())
