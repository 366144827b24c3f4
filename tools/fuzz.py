"""Feed symgen damaged and hostile files: whatever is in one, it ends in a Scene or in one line, soon.

``python tools/fuzz.py [--inputs N] [--seed S] [--limit SECONDS] [--generate N] [--keep DIR] [SEED_FILE …]``

Without seed files: the example scenes, files of the tools themselves, and the robots of example-robot-data if it is
installed. Of every input it is asked that `symgen.load` returns a Scene or raises a SymgenError whose message is one
printable line that begins with the file's name, within the limit. Of some that are accepted, that ``symgen generate``
writes everything or nothing; of some that are refused, that the command line says one line, ends with status 2 and
writes nothing. The same seed gives the same inputs. Exit status 1 if anything else happened; ``--keep`` keeps the files
that did it.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from symgen.cli import run
from symgen.errors import NotSupportedError, SymgenError
from symgen.scene.load import load
from symgen.scene.model import Scene
from tools.hostile import hostile_documents
from tools.mutations import mutate
from tools.seeds import SEEDS

ROOT = Path(__file__).parent.parent
KINDS = {".yaml": 1.0, ".urdf": 1.0, ".xml": 4.0}
"""Kinds of file, and how many times the limit they may take: MuJoCo's reader has a process of its own to start."""
HANGING = 20
"""Times the limit, on the clock: what is not done then hangs."""
LONGEST = 600
"""Characters of a message."""
LARGEST_SEED = 60_000
SMALL = 6
"""Bodies up to which an accepted scene is generated."""


class TooSlow(BaseException):
    """Raised by the alarm; no code of symgen may catch it."""


@contextlib.contextmanager
def alarm(seconds: float) -> Iterator[None]:
    """Ends whatever runs longer on the clock. Pure C code is not interrupted, but its time is measured all the same."""

    def ring(_signal: int, _frame: object) -> None:
        raise TooSlow

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@dataclass
class Result:
    """What became of one input: ``accepted``, ``refused``, ``not supported``, or a ``finding`` in words."""

    verdict: str
    seconds: float
    finding: str = ""
    scene: Scene | None = None


def cpu_seconds() -> float:
    """Of this process and of those it has waited for: other work on the machine does not count."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def check(path: Path, limit: float) -> Result:
    """Load one file and judge what happens."""
    begun = cpu_seconds()
    scene, verdict, finding = None, "accepted", ""
    try:
        with alarm(HANGING * limit):
            scene = load(path)
    except SymgenError as error:
        verdict = "not supported" if isinstance(error, NotSupportedError) else "refused"
        finding = judge_message(str(error), path.name)
    except TooSlow:
        finding = f"stopped after {HANGING * limit:g} s"
    except BaseException as error:
        finding = where(error)
    seconds = cpu_seconds() - begun
    if not finding and seconds > limit:
        finding = f"took {seconds:.1f} s"
    return Result("finding" if finding else verdict, seconds, finding, scene)


def judge_message(message: str, name: str) -> str:
    """What is wrong with a message to the user; empty if nothing."""
    if not message.isprintable():
        return f"message is not one printable line: {message!r:.300}"
    if not message.startswith(name):
        return f"message does not begin with the file's name: {message:.300}"
    return f"message has {len(message)} characters: {message:.200}" if len(message) > LONGEST else ""


def where(error: BaseException) -> str:
    """Kind, text and innermost place of an exception."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error!s:.200} ({Path(last.filename).name}:{last.lineno})"


def check_command(path: Path, accepted: bool, limit: float) -> Result:
    """``symgen generate`` on one file: everything or nothing is written, and what is said is one line."""
    out, before = path.parent / "out", set(path.parent.iterdir())
    said = io.StringIO()
    begun = cpu_seconds()
    finding = ""
    status = -1
    try:
        with alarm(HANGING * limit), contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            status = run(
                ["generate", str(path), "-o", str(out), "--outputs", "mass_matrix,bias_force", "--target", "c"]
            )
    except TooSlow:
        finding = f"generate stopped after {HANGING * limit:g} s"
    except BaseException as error:
        finding = where(error)
    line = said.getvalue()
    if not finding and status != 0:
        if line.count("\n") != 1 or not line[:-1].isprintable() or len(line) > LONGEST + 20:
            finding = f"not one printable line on stderr: {line!r:.300}"
        elif status != 2 or "bug in symgen" in line:
            finding = f"status {status}: {line.strip():.300}"
    if not finding and out.exists() != (status == 0):
        finding = "a folder without success" if out.exists() else "success without a folder"
    if not finding and status == 0 and not accepted:
        finding = "the command line takes what load refuses"
    for left in sorted(path.parent.rglob("*"), reverse=True):
        if left not in before:
            left.rmdir() if left.is_dir() else left.unlink()
    return Result("finding" if finding else f"generate {status}", cpu_seconds() - begun, finding)


@dataclass
class Tally:
    """Counts by kind and verdict, the slowest input of each kind, and what went wrong (each text once)."""

    counts: dict[str, dict[str, int]] = field(default_factory=dict)
    slowest: dict[str, tuple[float, str]] = field(default_factory=dict)
    findings: dict[str, str] = field(default_factory=dict)

    def add(self, kind: str, label: str, result: Result) -> bool:
        """True for a finding not seen before."""
        row = self.counts.setdefault(kind, {})
        row[result.verdict] = row.get(result.verdict, 0) + 1
        self.slowest[kind] = max(self.slowest.get(kind, (0.0, "")), (result.seconds, label))
        new = bool(result.finding) and result.finding not in self.findings
        if new:
            self.findings[result.finding] = label
        return new

    def text(self) -> str:
        lines = []
        for kind, row in sorted(self.counts.items()):
            seconds, label = self.slowest[kind]
            what = ", ".join(f"{n} {verdict}" for verdict, n in sorted(row.items()))
            lines.append(f"{kind:18} {sum(row.values()):7} inputs: {what}; slowest {seconds:.2f} s ({label})")
        lines += [f"FINDING {label}: {finding}" for finding, label in self.findings.items()]
        return "\n".join([*lines, f"{len(self.findings)} findings"])


def corpus(files: list[Path]) -> dict[str, list[tuple[str, bytes]]]:
    """Seed files by kind."""
    found: dict[str, list[tuple[str, bytes]]] = {kind: [] for kind in KINDS}
    if not files:
        for name, text in SEEDS.items():
            found[Path(name).suffix].append((name, text.encode()))
        files = [*sorted((ROOT / "examples").glob("*.yaml")), *installed_robots()]
    for path in files:
        if path.suffix in found and path.stat().st_size <= LARGEST_SEED:
            found[path.suffix].append((path.name, path.read_bytes()))
    return {kind: seeds for kind, seeds in found.items() if seeds}


def installed_robots() -> list[Path]:
    """URDF files of example-robot-data."""
    try:
        files = distribution("example-robot-data").files or []
    except PackageNotFoundError:
        return []
    return sorted({Path(str(file.locate())).resolve() for file in files if str(file).endswith(".urdf")})


def fuzz(
    inputs: int,
    seed: int,
    limit: float,
    generate: int,
    files: Sequence[Path] = (),
    keep: Path | None = None,
    size: int = 0,
    kinds: Sequence[str] = tuple(KINDS),
) -> Tally:
    """``inputs`` mutated files of every kind, and (``size`` > 0) the hostile documents of about ``size`` bytes.

    Every ``generate``-th file goes to the command line too; files that make trouble are copied into ``keep``.
    """
    tally = Tally()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "robot.urdf").write_text(SEEDS["good.urdf"], encoding="utf-8")

        def one(kind: str, label: str, data: bytes, command: bool) -> None:
            path = folder / f"input{kind}"
            path.write_bytes(data)
            result = check(path, KINDS[kind] * limit)
            new = tally.add(kind[1:], label, result)
            small = result.scene is not None and len(result.scene.bodies) <= SMALL
            if command and (result.scene is None or small):
                new = tally.add(f"{kind[1:]} generate", label, check_command(path, small, KINDS[kind] * limit)) or new
            if new and keep:
                keep.mkdir(parents=True, exist_ok=True)
                (keep / f"{label.replace(' ', '_').replace('/', '_')}{kind}").write_bytes(data)

        if size:
            for name, data in hostile_documents(size).items():
                if Path(name).suffix in kinds:
                    one(Path(name).suffix, f"hostile {name} {size}", data, generate > 0)
        for kind, seeds in corpus(list(files)).items():
            for k in range(inputs if kind in kinds else 0):
                rng = random.Random(f"{seed} {kind} {k}")
                name, data = rng.choice(seeds)
                one(kind, f"{seed} {k} {name}", mutate(data, rng), generate > 0 and k % generate == 0)
    return tally


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, metavar="SEED_FILE")
    parser.add_argument("--inputs", type=int, default=1000, help="mutated files of every kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--limit", type=float, default=5.0, help="CPU seconds that one file may take")
    parser.add_argument(
        "--generate", type=int, default=50, help="give every N-th file to 'symgen generate' too (0: none)"
    )
    parser.add_argument("--size", type=int, default=1_000_000, help="bytes of the long hostile documents (0: none)")
    parser.add_argument("--keep", type=Path, help="folder for the files that make trouble")
    parser.add_argument("--kind", action="append", choices=list(KINDS), help="only this kind of file (more than once)")
    given = parser.parse_args()
    os.environ.pop("SYMGEN_DEBUG", None)
    tally = fuzz(
        given.inputs,
        given.seed,
        given.limit,
        given.generate,
        given.files,
        given.keep,
        given.size,
        given.kind or tuple(KINDS),
    )
    print(tally.text())
    return 1 if tally.findings else 0


if __name__ == "__main__":
    sys.exit(main())
