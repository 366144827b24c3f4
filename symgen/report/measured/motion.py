"""The section of a motion: curves of the coordinates and energies, and what the player is told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symgen.report.plots import SERIES, Series, line_plot
from symgen.report.tables import POSITIONS, VELOCITIES, scientific
from symgen.report.words import counted, minus
from symgen.scene.joints import JOINT_TYPES

TOGETHER = 4
"""Coordinates of one unit in one plot."""
MOST = 24
"""Coordinates that are plotted."""
LISTED = 14
"""Entries of a state that stand in the text; longer ones are folded."""
PLAYED = 5.0
"""Seconds that a short motion is stretched to, at least."""
SPEEDS = (2.0, 1.0, 0.5, 0.25, 0.1, 0.05)


def values(data: Mapping[str, Any]) -> dict[str, object]:
    """From what `symgen.simulate.motion_data` gives."""
    end = data["times"][-1]
    speed = next((x for x in SPEEDS if x <= 1 and end / x >= PLAYED), SPEEDS[-1])
    names = {1.0: "as it is", 2.0: "twice as fast"}
    curves = _curves(data)
    hidden = len(curves) - MOST
    return {
        "scene": data["scene"],
        "start": data["start"],
        "states": [_state("q", data["q0"]), _state("v", data["v0"])],
        "many": len(data["q0"]) > LISTED,
        "seconds": minus(f"{end:g}"),
        "end": end,
        "speed": speed,
        "speeds": [(x, names.get(x, f"{x:g} times as fast"), x == speed) for x in SPEEDS],
        "energy": _energy(data),
        "panels": [*_panels(data, curves[:MOST]), _energies(data)],
        "hidden": f"{counted(hidden, 'coordinate')} more {'is' if hidden == 1 else 'are'} not drawn"
        if hidden > 0
        else "",
    }


def _state(letter: str, numbers: Sequence[float]) -> tuple[str, str]:
    return letter, minus(", ".join(f"{x:.4g}" for x in numbers))


def _energy(data: Mapping[str, Any]) -> str:
    """In joules, whose zero anybody chooses, where dampers work; else how well the motion keeps it."""
    if data["conservative"]:
        drift = scientific(data["monitors"]["energy_drift"])
        text = "Nothing takes energy away: the computed motion keeps kinetic and potential energy together to"
        return f"{text} {drift} of their size (their sum at first, or the largest kinetic energy if that is more)."
    first, last = (data["kinetic"][k] + data["potential"][k] for k in (0, -1))
    text = f"Dampers take energy away: kinetic and potential energy together go from {first:.4g} J to {last:.4g} J"
    return minus(f"{text}.")


@dataclass(frozen=True)
class _Curve:
    name: str
    what: str
    unit: str
    values: tuple[float, ...]


def _curves(data: Mapping[str, Any]) -> list[_Curve]:
    """Positions of joints; of what turns any way the angular velocities, which are easier to read than quaternions."""
    found = []
    for joint in data["joints"]:
        kind, (q, nq), (v, nv) = JOINT_TYPES[joint["type"]], joint["q"], joint["v"]
        positions, velocities = POSITIONS.get(joint["type"], ("",)), VELOCITIES.get(joint["type"], ("",))
        for k in range(nq):
            if kind.q_units[k] != "1":
                what = "angles" if kind.q_units[k] == "rad" else "displacements"
                row = tuple(state[q + k] for state in data["q"])
                found.append(_Curve(f"{joint['name']} {positions[k]}".strip(), what, kind.q_units[k], row))
        for k in range(nv if nq > nv else 0):
            if kind.v_units[k] == "rad/s":
                row = tuple(state[v + k] for state in data["v"])
                found.append(_Curve(f"{joint['name']} {velocities[k]}", "angular velocities", "rad/s", row))
    return found


def _panels(data: Mapping[str, Any], curves: Sequence[_Curve]) -> list[dict[str, object]]:
    """Plots of what has one unit, a few curves in each."""
    groups: list[list[_Curve]] = []
    for what in dict.fromkeys(curve.what for curve in curves):
        members = [curve for curve in curves if curve.what == what]
        groups += [members[k : k + TOGETHER] for k in range(0, len(members), TOGETHER)]
    found = []
    for members in groups:
        series = [
            Series(curve.name, tuple(data["times"]), curve.values, style=place % SERIES)
            for place, curve in enumerate(members)
        ]
        name = members[0].what if len(members) > 1 else members[0].name
        found.append(_panel(series, name, members[0].unit))
    return found


def _energies(data: Mapping[str, Any]) -> dict[str, object]:
    total = [a + b for a, b in zip(data["kinetic"], data["potential"], strict=True)]
    rows = (("kinetic", data["kinetic"]), ("potential", data["potential"]), ("total", total))
    curves = [Series(name, tuple(data["times"]), tuple(row), style=k) for k, (name, row) in enumerate(rows)]
    return _panel(curves, "energies", "J")


def _panel(curves: Sequence[Series], name: str, unit: str) -> dict[str, object]:
    title = f"{name} over time: {', '.join(curve.name for curve in curves)}"
    plot = line_plot(curves, title, "time, s", name, unit, cursor=True)
    return {"plot": plot, "legend": [(curve.name, f"s{curve.style}") for curve in curves]}
