"""Our own functions: the scalar ones, and the batches from contiguous states and from a structure of arrays."""

from __future__ import annotations

import time
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from symgen.artifact import Artifact
from symgen.bench.variant import OURS, Array, Found, Left, Problem, Unit, Variant, split
from symgen.errors import NotSupportedError
from symgen.generate import generate
from symgen.scene.model import Output
from symgen.scene.outputs import function_name
from symgen.scene.request import request

SHARED = ("dt", "p")
"""Inputs that a batch has once."""
BATCH, SOA = "symgen batch", "symgen soa"
SOA_MULTIPLE = 8


def build(problem: Problem, batches: bool) -> Found:
    """Every function, generated alone (so that its size and times are its own), with its certificates."""
    found = Found()
    for name, program in problem.programs.items():
        if not any(port.size for port in program.outputs):
            found.left.append(Left(OURS, name, "has no outputs"))
            continue
        output = problem.system.output(name)
        found.variants.extend(_variants(problem, output, False))
        if batches and {port.name for port in program.inputs} & {"q", "v"}:
            try:
                found.variants.extend(_variants(problem, output, True))
            except NotSupportedError as error:
                found.left.append(Left(BATCH, name, str(error)))
    return found


def _variants(problem: Problem, output: Output, batch: bool) -> list[Variant]:
    """The scalar function, or its two batches."""
    scene = request(problem.scene, outputs=(output,), targets=("c",))
    scene = replace(scene, options=replace(scene.options, batch=batch, status=False))
    folder = problem.folder / ("batch" if batch else "scalar") / function_name(output.name)
    started = time.process_time()
    artifact = generate(scene, folder)
    seconds = time.process_time() - started
    function = artifact.manifest["functions"][0]
    header = artifact.manifest["headers"][0]
    headers = tuple((h, (folder / h).read_text()) for h in artifact.manifest["headers"])
    alone = () if not batch else _scalar_sources(folder)  # what the scalar variant links already
    units = tuple(
        Unit(Path(name).stem, (folder / name).read_text(), headers=headers)
        for name in artifact.manifest["sources"]
        if name not in alone
    )
    text = headers[0][1] if headers[0][0] == header else ""
    sizes = [prod(port["shape"]) for port in function["outputs"]]
    operations = sum(function["operations"][kind] for kind in ("add", "mul", "div", "sqrt"))
    real = function["precision"]

    def plain(flat: Array, _state: Any) -> list[Array]:
        return split(flat, sizes)

    arrays = {port["name"]: _column(problem, port["name"]) for port in function["inputs"]}
    outs = [f"{{out}} + {offset}" for offset in np.cumsum([0, *sizes])[:-1]]
    words = [_argument(port["name"], problem) for port in function["inputs"]]
    if not batch:
        call = f"{function['symbol']}({', '.join([*words, *outs])});"
        base = {k: v for k, v in arrays.items() if k != "dt"}
        return [
            Variant(
                OURS, output.name, _prototypes(text, function["symbol"]), call, base, sum(sizes), plain, units,
                generate_s=seconds, operations=operations, real=real, plan=function["plan"],
            )
        ]  # fmt: skip
    if function["batch_symbol"] is None:
        return []
    return _batches(problem, function, text, arrays, words, sizes, units, seconds)


def _batches(
    problem: Problem, function: dict[str, Any], text: str, arrays: dict[str, Array], words: list[str],
    sizes: list[int], units: tuple[Unit, ...], seconds: float,
) -> list[Variant]:  # fmt: skip
    symbol, name, real = function["batch_symbol"], function["name"], function["precision"]
    states, starts = len(problem.states), np.cumsum([0, *sizes])[:-1]
    outs = [f"{{out}} + {states * start}" for start in starts]
    base = {k: v for k, v in arrays.items() if k != "dt"}
    rows = Variant(
        BATCH, name, _prototypes(text, symbol), f"{symbol}({', '.join(['n', *words, *outs])});", base, sum(sizes),
        lambda flat, state: split(flat, sizes), units, batch=True, real=real, generate_s=seconds,
        operations=None,
    )  # fmt: skip
    soa = symbol.replace("_batch", "_soa")
    if soa not in text:
        return [rows]
    columns = {k: v if k in SHARED else np.ascontiguousarray(v.T) for k, v in base.items()}
    call = f"{soa}({', '.join(['n', f'{states}', *words, *outs])});"
    return [rows, replace(rows, peer=SOA, declaration=_prototypes(text, soa), call=call, arrays=columns)]


def _scalar_sources(folder: Path) -> list[str]:
    beside: list[str] = Artifact(folder.parent.parent / "scalar" / folder.name).manifest["sources"]
    return beside


def _column(problem: Problem, name: str) -> Array:
    return problem.column(name)[0] if name in SHARED else problem.column(name)


def _argument(name: str, problem: Problem) -> str:
    return float(problem.states[0]["dt"]).hex() if name == "dt" else f"{{{name}}}"


def _prototypes(header: str, symbol: str) -> str:
    """The prototype of one function out of its header (the whole header would bring the names of all)."""
    start = header.index(f"{symbol}(")
    line = header.rfind("\n", 0, start) + 1
    return " ".join(header[line : header.index(";", start) + 1].split())
