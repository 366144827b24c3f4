"""manifest.json: what an artifact holds, for whoever builds, loads or checks it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symgen.program.instructions import Counts, Port, Program, count
from symgen.targets.c.emit import LICENCE, Emitted
from symgen.targets.c.info import Info, JointRow

FORMAT = 1


@dataclass(frozen=True)
class FunctionRecord:
    """What the manifest says of one function beyond its program."""

    program: Program
    certificate: Mapping[str, object]
    """``method``, ``checked_against``, ``points``, ``failure_probability``."""
    casadi_file: str | None = None
    """Path inside the artifact."""


def build_manifest(
    name: str, info: Info, functions: Sequence[FunctionRecord], emitted: Emitted | None = None
) -> dict[str, Any]:
    """The manifest as JSON values. ``emitted``: the C files, if C is among the targets; a function it left out
    (no outputs) is left out here unless there is a CasADi file of it."""
    in_c = {row.program.name: row for row in emitted.functions} if emitted else {}
    rows = []
    for record in functions:
        row = in_c.get(record.program.name)
        if row is None and record.casadi_file is None:
            continue
        rows.append(
            _function(
                row.program if row else record.program,
                record,
                row.counts if row else count(record.program),
                row.symbols.scalar if row else None,
                (row.symbols.batch or None) if row else None,
                info.options.precision if row else "double",
            )
        )
    return {
        "format": FORMAT,
        "name": name,
        "scene_sha256": info.scene_sha256,
        "symgen": info.version,
        "options": _options(info),
        "licence": LICENCE,
        "sources": list(emitted.sources) if emitted else [],
        "headers": list(emitted.headers) if emitted else [],
        "nq": info.nq,
        "nv": info.nv,
        "joints": [_joint(joint) for joint in info.joints],
        "parameters": [
            {
                "name": p.name,
                "unit": p.unit,
                "default": [float(value) for value in p.default],
                "start": p.start,
                "size": p.size,
            }
            for p in info.parameters
        ],
        "functions": rows,
    }


def _function(
    program: Program,
    record: FunctionRecord,
    counts: Counts,
    symbol: str | None,
    batch_symbol: str | None,
    precision: str,
) -> dict[str, Any]:
    return {
        "name": program.name,
        "symbol": symbol,
        "batch_symbol": batch_symbol,
        "precision": precision,
        "casadi_file": record.casadi_file,
        "inputs": [_port(port) for port in program.inputs],
        "outputs": [_port(port) for port in program.outputs],
        "operations": {
            "add": counts.add,
            "mul": counts.mul,
            "div": counts.div,
            "sqrt": counts.sqrt,
            "sincos": counts.sincos,
        },
        "plan": program.plan,
        "certificate": dict(record.certificate),
    }


def _joint(joint: JointRow) -> dict[str, Any]:
    """``limits`` and ``mimic`` only where there are any."""
    row: dict[str, Any] = {"name": joint.name, "type": joint.type, "q": list(joint.q), "v": list(joint.v)}
    if joint.limits:
        row["limits"] = dict(joint.limits)
    if joint.mimic:
        coupling = joint.mimic
        numbers = {"multiplier": float(coupling.multiplier), "offset": float(coupling.offset)}
        row["mimic"] = {"joint": coupling.joint, **numbers}
    return row


def _port(port: Port) -> dict[str, Any]:
    return {"name": port.name, "shape": list(port.shape), "unit": port.unit}


def _options(info: Info) -> dict[str, Any]:
    options = info.options
    values = {key: getattr(options, key) for key in sorted(options.__dataclass_fields__)}
    return {key: _json(value) for key, value in values.items()}


def _json(value: object) -> object:
    if isinstance(value, Fraction):
        return float(value)
    return list(value) if isinstance(value, tuple) else value


def manifest_text(manifest: Mapping[str, Any]) -> str:
    """Deterministic bytes: the order of the keys is that of the interface."""
    return json.dumps(manifest, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
