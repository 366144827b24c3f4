"""manifest.json: what an artifact holds, for whoever builds, loads or checks it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symgen.loops.model import LoopProgram
from symgen.program.instructions import Counts, Port, Program, count
from symgen.targets.c.emit import LICENCE, Emitted
from symgen.targets.c.info import Info, JointRow
from symgen.targets.c.signatures import Symbols, returns_status
from symgen.targets.cuda.emit import CudaFunction, EmittedCuda

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
    name: str,
    info: Info,
    functions: Sequence[FunctionRecord],
    emitted: Emitted | None = None,
    cuda: EmittedCuda | None = None,
) -> dict[str, Any]:
    """The manifest as JSON values. ``emitted``, ``cuda``: the files of these targets, where asked for; a function that
    is in none of them (no outputs) is left out here unless there is a CasADi file of it."""
    in_c = {row.program.name: row for row in emitted.functions} if emitted else {}
    in_cuda = {row.program.name: row for row in cuda.functions} if cuda else {}
    rows = []
    for record in functions:
        row, device = in_c.get(record.program.name), in_cuda.get(record.program.name)
        first = row or device
        if first is None and record.casadi_file is None:
            continue
        rows.append(
            _function(
                first.program if first else record.program,
                record,
                first.counts if first else count(record.program),
                _symbols(row.symbols if row else None) | _launches(device, info),
                info.options.precision if first else "double",
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
        **({"cuda": {"sources": list(cuda.sources), "headers": list(cuda.headers)}} if cuda else {}),
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
    symbols: Mapping[str, object],
    precision: str,
) -> dict[str, Any]:
    return {
        "name": program.name,
        **symbols,
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
        **({"code": "loops"} if isinstance(program, LoopProgram) else {}),
        "certificate": dict(record.certificate),
    }


def _symbols(symbols: Symbols | None) -> dict[str, object]:
    """The C functions: ``symbol`` and ``batch_symbol`` always, the others where there are any."""
    if symbols is None:
        return {"symbol": None, "batch_symbol": None}
    more = {"batch_p_symbol": symbols.batch_p, "soa_symbol": symbols.soa, "soa_p_symbol": symbols.soa_p}
    found: dict[str, object] = {"symbol": symbols.scalar, "batch_symbol": symbols.batch or None}
    return found | {key: symbol for key, symbol in more.items() if symbol}


def _launches(device: CudaFunction | None, info: Info) -> dict[str, object]:
    """``launch``: form → host function; ``failed``: whether these take a place for a status."""
    if device is None:
        return {}
    return {"cuda": {"launch": dict(device.launches), "failed": returns_status(device.program, info.options.status)}}


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
