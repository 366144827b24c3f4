"""Real robots through the whole house: operations, times and differences to Pinocchio, as a table.

    python -m tools.robots [ROBOT | FILE …] [--outputs ROW,ROW…] [--out FOLDER]     (or `make robots`)
    python -m tools.robots --scaling [N …]                                          random trees of N bodies

Each robot runs in a process of its own, within limits of time and memory; what fails says why in its row. Writes
robots.json, robots.csv and robots.md (or scaling.*) into the folder. Seconds are CPU seconds; gcc -O2 makes the
library that is compared, gcc -O3 is timed beside it. Differences are ‖x − x̂‖∞/‖x̂‖∞, the worst of the states tried.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from symgen.errors import SceneError
from tools.robot_list import ROBOTS, Robot

ROOT = Path(__file__).resolve().parent.parent
SCALING = (5, 10, 20, 50, 100, 200)
SCALED = "mass_matrix,inverse_dynamics,forward_dynamics"
Record = dict[str, Any]
_print = threading.Lock()


def run_worker(subject: Any, options: Sequence[str], seconds: float) -> tuple[list[Record], str]:
    """The lines that the worker said, and what became of it where that is worth saying."""
    command = [sys.executable, "-m", "tools.robot_measure", json.dumps(subject), *options]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as worker:
        timer = threading.Timer(seconds, worker.kill)
        timer.start()
        try:
            out, errors = worker.communicate()
        finally:
            timer.cancel()
    lines = [json.loads(line) for line in out.splitlines() if line.startswith("{") and line.endswith("}")]
    if worker.returncode == 0:
        return lines, ""
    if not timer.is_alive() and worker.returncode < 0:
        return lines, f"stopped after {seconds:g} s"
    last = errors.strip().splitlines()
    return lines, (last[-1] if last else f"exit status {worker.returncode}")[:300]


def measure_robot(robot: Robot, options: Sequence[str], seconds: float) -> Record:
    begun = time.perf_counter()
    lines, error = run_worker(asdict(robot), options, seconds)
    head = next((line for line in lines if "nq" in line), {})
    functions = [line for line in lines if "output" in line]
    record = {"robot": robot.name, "what": robot.what, **head, "functions": functions, "error": error}
    record["wall_s"] = time.perf_counter() - begun
    bad = [line["output"] for line in functions if "error" in line]
    with _print:
        size = f"nq {head['nq']:3} nv {head['nv']:3}" if head else "not loaded"
        said = f"; failed: {', '.join(bad)}" if bad else ""
        print(
            f"{robot.name:16} {size}  {len(functions):3} functions  {record['wall_s']:6.0f} s  "
            f"{summary(record)}{said}{'; ' + error if error else ''}",
            flush=True,
        )
    return record


def worst(functions: Iterable[Record], derivatives: bool) -> float | None:
    compared = [f for f in functions if f.get("difference") is not None and is_derivative(f["output"]) is derivatives]
    found = [f["difference"] for f in compared]
    return max(found) if found else None


def is_derivative(output: str) -> bool:
    return "derivatives" in output or output.startswith(("jvp:", "vjp:", "parameter_jacobian:"))


def summary(record: Record) -> str:
    plain, derived = worst(record["functions"], False), worst(record["functions"], True)
    return f"worst {text(plain, '.1e')}, derivatives {text(derived, '.1e')}"


def text(value: Any, form: str) -> str:
    return "–" if value is None else format(value, form)


def label(output: str) -> str:
    """Frame rows of different robots stand in one row of the table."""
    kind, _, rest = output.partition(":")
    return output if kind in ("jvp", "vjp", "parameter_jacobian") or not rest else f"{kind}:FRAME"


def cell(robot: Record, output: str, show: Callable[[Record], str]) -> str:
    found = next((f for f in robot["functions"] if label(f["output"]) == output), None)
    return "" if found is None else show(found)


def shown_flops(f: Record) -> str:
    if "flops" in f:
        return f"{f['flops']:,}"
    return f"– ({f['error']})" if "error" in f else "–"


def shown_seconds(f: Record) -> str:
    if "derive_s" not in f:
        return f"– ({f['error']})" if "error" in f else "–"
    made = " + ".join(f"{f[key]:.2f}" for key in ("derive_s", "emit_s", "certify_s"))
    return f"{made} / {text(f.get('compile_O2_s'), '.1f')} / {text(f.get('compile_O3_s'), '.1f')}"


def shown_difference(f: Record) -> str:
    if f.get("difference") is None:
        return f"– ({f['error']})" if "error" in f else ""
    over = " **over**" if not f["difference"] <= f["criterion"] else ""
    ill = f" ({f['remark'][f['remark'].index('condition') :]})" if "condition" in f["remark"] else ""
    return f"{f['difference']:.1e}{over}{ill if f['difference'] > 1e-12 else ''}"


def table(title: str, robots: list[Record], show: Callable[[Record], str]) -> list[str]:
    """Outputs down, robots across."""
    outputs = list(dict.fromkeys(label(f["output"]) for robot in robots for f in robot["functions"]))
    rows = [[output, *(cell(robot, output, show) for robot in robots)] for output in outputs]
    rows = [row for row in rows if any(row[1:])]
    head = ["", *(robot["robot"] for robot in robots)]
    lines = ["", f"## {title}", "", "| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]


def markdown(title: str, robots: list[Record]) -> str:
    head = ("robot", "what", "nq", "nv", "functions", "worst difference", "of derivatives",
            "derive + emit + certify, s", "gcc -O2, s", "gcc -O3, s", "note")  # fmt: skip
    lines = [title, "", "| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for robot in robots:
        functions = robot["functions"]
        made = sum(f.get(key) or 0 for f in functions for key in ("derive_s", "emit_s", "certify_s"))
        compiled = [sum(f.get(key) or 0 for f in functions) for key in ("compile_O2_s", "compile_O3_s")]
        good = sum("error" not in f for f in functions)
        notes = [robot.get("note") or "", robot["error"]]
        notes += [f"{f['output']}: {f.get('error') or f['note']}" for f in functions if "error" in f or "note" in f]
        lines.append(
            f"| {robot['robot']} | {robot['what']} | {robot.get('nq', '–')} | {robot.get('nv', '–')} "
            f"| {good} of {len(functions)} | {text(worst(functions, False), '.1e')} "
            f"| {text(worst(functions, True), '.1e')} | {made:.1f} | {compiled[0]:.1f} | {compiled[1]:.1f} "
            f"| {'; '.join(note for note in notes if note)} |"
        )
    lines += table("Operations (additions, multiplications, divisions, roots)", robots, shown_flops)
    lines += table("Seconds: derive + emit + certify / gcc -O2 / gcc -O3", robots, shown_seconds)
    lines += table("Worst difference to Pinocchio", robots, shown_difference)
    return "\n".join(lines) + "\n"


FIELDS = ("robot", "nq", "nv", "output", "flops", "sincos", "derive_s", "emit_s", "certify_s", "compile_O2_s",
          "compile_O3_s", "difference", "criterion", "failure_probability", "remark", "note", "error")  # fmt: skip


def write(out: Path, name: str, robots: list[Record]) -> None:
    out.mkdir(parents=True, exist_ok=True)
    (out / f"{name}.json").write_text(json.dumps(robots, indent=1) + "\n", encoding="utf-8")
    with (out / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, FIELDS, extrasaction="ignore")
        writer.writeheader()
        for robot in robots:
            common = {"robot": robot["robot"], "nq": robot.get("nq"), "nv": robot.get("nv")}
            for function in robot["functions"] or [{"error": robot["error"]}]:
                writer.writerow({**common, **function})
    title = "# Random trees" if name == "scaling" else "# Robots"
    (out / f"{name}.md").write_text(markdown(title, robots), encoding="utf-8")


def earlier(path: Path) -> list[Record]:
    """What an earlier run left."""
    found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    return found if isinstance(found, list) else []


def in_order(robots: list[Record]) -> list[Record]:
    """As the list has them, others by their size."""
    places = {robot.name: k for k, robot in enumerate(ROBOTS)}
    return sorted(robots, key=lambda robot: (places.get(robot["robot"], len(places)), robot.get("nv", sys.maxsize)))


def chosen(names: list[str]) -> list[Robot]:
    """Robots by name, and files (`FILE` or `floating:FILE`) as robots of their own."""
    known = {robot.name: robot for robot in ROBOTS}
    found = []
    for name in names:
        floating, path = name.startswith("floating:"), Path(name.removeprefix("floating:"))
        if name in known:
            found.append(known[name])
        elif path.is_file():
            stem = "".join(c if c.isalnum() else "_" for c in path.name.split(".")[0])
            found.append(Robot(stem, str(path.resolve()), "floating" if floating else "fixed"))
        else:
            raise SceneError(f"no robot and no file {name!r}; robots: {', '.join(known)}", "robots")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robots", nargs="*", help="names, or URDF, MJCF and scene files (floating:FILE); all if none")
    parser.add_argument("--outputs", default="", help="rows of the catalogue, with commas; all if none")
    parser.add_argument("--out", type=Path, default=Path("out/robots"))
    parser.add_argument("--jobs", type=int, default=1, help="robots at a time; times are honest with 1")
    parser.add_argument("--limit", type=float, default=1200, help="seconds (of the clock) for a robot")
    parser.add_argument(
        "--function-limit", type=float, default=120, help="CPU seconds to make, or to compare, a function"
    )
    parser.add_argument("--compile-limit", type=float, default=60, help="CPU seconds for one run of the compiler")
    parser.add_argument("--only-O2", action="store_true", help="do not time gcc -O3 beside -O2")
    parser.add_argument(
        "--add", action="store_true", help="keep the robots of an earlier run that are not measured now"
    )
    parser.add_argument("--states", type=int, default=10)
    parser.add_argument("--scaling", action="store_true", help="random trees instead of robots")
    arguments = parser.parse_args()
    options = [f"--function-limit={arguments.function_limit}", f"--compile-limit={arguments.compile_limit}"]
    options += [f"--states={arguments.states}", *(["--only-O2"] if arguments.only_O2 else [])]
    if arguments.scaling:
        wanted = [int(n) for n in arguments.robots] or SCALING
        options += [f"--outputs={arguments.outputs or SCALED}"]
        subjects = [Robot(f"tree_{n}", str(n), what="random tree") for n in wanted]
    else:
        options += [f"--outputs={arguments.outputs}"]
        try:
            subjects = chosen(arguments.robots) or list(ROBOTS)
        except SceneError as error:
            print(error, file=sys.stderr)
            return 2
    name = "scaling" if arguments.scaling else "robots"
    kept = earlier(arguments.out / f"{name}.json") if arguments.add else []
    found: list[Record] = []
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for record in pool.map(lambda robot: measure_robot(robot, options, arguments.limit), subjects):
            found.append(record)
            kept = [robot for robot in kept if robot["robot"] != record["robot"]] + [record]
            write(arguments.out, name, in_order(kept))
    print(f"{arguments.out / name}.md, .csv, .json")
    return 1 if any(robot["error"] or any("error" in f for f in robot["functions"]) for robot in found) else 0


if __name__ == "__main__":
    sys.exit(main())
