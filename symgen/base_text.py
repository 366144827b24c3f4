"""Base parameters for reading: what ``symgen show --base-parameters`` prints."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from symgen.show import number

if TYPE_CHECKING:
    from symgen.system import System


def _combination(row: Mapping[int, Fraction], names: tuple[str, ...]) -> str:
    """``link2.Ixx - link2.Iyy + 0.1*link3.mcx``: the parameter it is named for first."""
    text = ""
    for k, value in row.items():
        factor = "" if abs(value) == 1 else f"{number(abs(value))}*"
        sign = ("" if value > 0 else "-") if not text else (" + " if value > 0 else " - ")
        text += f"{sign}{factor}{names[k]}"
    return text


def as_text(system: System) -> str:
    """One line per base parameter, then what no joint force depends on."""
    base = system.base_parameters
    lines = [f"{system.scene.name}: {len(base.rows)} base parameters of {len(base.names)} inertial parameters"]
    if base.rows:
        lines.append("")
    lines += [f"beta_{i} = {_combination(row, base.names)}" for i, row in enumerate(base.rows)]
    if base.unfelt:
        lines += ["", f"felt by no joint: {', '.join(base.unfelt)}"]
    return "\n".join(lines)


def as_json(system: System) -> dict[str, Any]:
    """The same as plain data, coefficients as exact fractions."""
    base = system.base_parameters
    return {
        "name": system.scene.name,
        "parameters": list(base.names),
        "base_parameters": [
            {"column": column, "combination": {base.names[k]: str(value) for k, value in row.items()}}
            for column, row in zip(base.independent, base.rows, strict=True)
        ],
        "unfelt": list(base.unfelt),
    }
