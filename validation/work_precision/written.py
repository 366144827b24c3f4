"""What the command leaves: data as JSON, points as CSV, a page; and lines for people."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

BARS = (1e-4, 1e-7, 1e-10)


def files(data: Mapping[str, Any]) -> dict[str, str]:
    """Name → text: NAME.json, NAME.csv, NAME.html."""
    from symgen.report.measured import precision
    from symgen.report.shell import page

    name = str(data["scene"])
    text = io.StringIO()
    writer = csv.DictWriter(text, [*data["points"][0]], lineterminator="\n")
    writer.writeheader()
    writer.writerows(data["points"])
    html = page("report/precision_page.html.j2", f"{name}: work and precision", scene=name, it=precision.values(data))
    return {f"{name}.json": json.dumps(data, indent=1) + "\n", f"{name}.csv": text.getvalue(), f"{name}.html": html}


def write(folder: Path, data: Mapping[str, Any]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files(data).items():
        beside = folder / f".{name}"
        beside.write_text(text, encoding="utf-8")
        beside.replace(folder / name)


def summary(data: Mapping[str, Any]) -> Iterator[str]:
    """Per method the least CPU time with an error up to 1e-4, 1e-7 and 1e-10, and what failed; orders; energies."""
    points, reference = data["points"], data["reference"]
    yield f"{data['scene']}: {data['seconds']:g} s; the reference is sure to {reference['uncertainty']:.1e}"
    yield f"  {'program':24}{'integrator':26}" + "".join(f"{f'ms to {bar:.0e}':>14}" for bar in BARS) + "  failed"
    for program, integrator in dict.fromkeys((p["program"], p["integrator"]) for p in points):
        mine = [p for p in points if (p["program"], p["integrator"]) == (program, integrator)]
        cells = []
        for bar in BARS:
            good = [p["cpu_seconds"] for p in mine if not p["failed"] and p["error"] <= bar]
            cells.append(f"{1e3 * min(good):14.3f}" if good else f"{'–':>14}")
        lost = [p for p in mine if p["failed"]]
        last = f"{len(lost)} ({lost[0]['knob']} {lost[0]['setting']:g} …: {lost[0]['failed']})" if lost else ""
        yield f"  {program:24}{integrator:26}{''.join(cells)}  {last}"
    for row in data["skipped"]:
        yield f"  {row['program']}: left out, {row['reason']}"
    for row in data["orders"]:
        seen = "exact to rounding" if row["observed"] is None else f"observed {row['observed']:.3f}"
        yield f"  order of {row['method']}: stated {row['stated']}, {seen}{'' if row['holds'] else '  FAILED'}"
    yield from _energies(data["energy"])


def _energies(data: Mapping[str, Any]) -> Iterator[str]:
    if "reason" in data:
        yield f"  energy over a long run: {data['reason']}"
        return
    less = f", without {' and '.join(data['without'])}" if data["without"] else ""
    yield f"  energy over {data['steps']:,} steps of {data['dt']:.3g} s{less}"
    for line in data["lines"]:
        ends = ", ".join("–" if x is None else f"{x:.1e}" for x in (line["first"], line["last"]))
        verdict = line["verdict"]
        yield f"    {line['method']:24}largest in the first tenth and in the rest {ends}: {verdict}"
