"""Our own functions: the scalar ones, and the batches from contiguous states and from a structure of arrays.

The same in other forms are `symgen.bench.peers.forms`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from symgen.bench.variant import OURS, USUAL, Array, Found, Left, Problem, Unit, Variant, split
from symgen.errors import NotSupportedError
from symgen.generate import generate
from symgen.scene.model import Output, Scene
from symgen.scene.outputs import function_name
from symgen.scene.request import request
from symgen.system import System

SHARED = ("dt", "p")
"""Inputs that a batch has once."""
_, BATCH, SOA = USUAL


@dataclass(frozen=True)
class Made:
    """One function as it was written: its files, and what the manifest says of it."""

    name: str
    """The output that it is."""
    scene: str
    function: dict[str, Any]
    header: str
    units: tuple[Unit, ...]
    seconds: float
    """CPU seconds that it took, certificate and all."""

    @property
    def sizes(self) -> list[int]:
        return [prod(port["shape"]) for port in self.function["outputs"]]

    @property
    def scalar_units(self) -> tuple[Unit, ...]:
        return tuple(unit for unit in self.units if unit.name != f"{self.scene}_batch")

    @property
    def batch_units(self) -> tuple[Unit, ...]:
        return tuple(unit for unit in self.units if unit.name == f"{self.scene}_batch")


def build(problem: Problem, batches: bool) -> Found:
    """Every function, generated alone (so that its size and times are its own), with its certificates."""
    found = Found()
    for name, program in problem.programs.items():
        if not any(port.size for port in program.outputs):
            found.left.append(Left(OURS, name, "has no outputs"))
            continue
        output = problem.system.output(name)
        found.variants.append(scalar_variant(problem, made(problem, output, asked(problem, output, False)), OURS))
        if batches and {port.name for port in program.inputs} & {"q", "v"}:
            try:
                found.variants += batch_variants(problem, made(problem, output, asked(problem, output, True)))
            except NotSupportedError as error:
                found.left.append(Left(BATCH, name, str(error)))
    return found


def asked(problem: Problem, output: Output, batch: bool) -> Scene:
    scene = request(problem.scene, outputs=(output,), targets=("c",))
    return replace(scene, options=replace(scene.options, batch=batch, status=False))


def made(problem: Problem, output: Output, scene: Scene, system: System | None = None) -> Made:
    """Generate a function of a scene that asks for nothing else. Raises SymgenError where that cannot be done."""
    beside = f"{scene.name}{'-batch' if scene.options.batch else ''}"
    folder = problem.folder / "ours" / beside / function_name(output.name)
    started = time.process_time()
    artifact = generate(scene, folder, system=system)
    seconds = time.process_time() - started
    manifest = artifact.manifest
    headers = tuple((name, (folder / name).read_text()) for name in manifest["headers"])
    units = tuple(Unit(Path(name).stem, (folder / name).read_text(), headers=headers) for name in manifest["sources"])
    return Made(output.name, scene.name, manifest["functions"][0], headers[0][1], units, seconds)


def scalar_variant(problem: Problem, this: Made, peer: str) -> Variant:
    """The function for one state."""
    function, sizes = this.function, this.sizes
    operations = sum(function["operations"][kind] for kind in ("add", "mul", "div", "sqrt"))
    outs = [f"{{out}} + {offset}" for offset in starts(sizes)]
    return Variant(
        peer, this.name, prototype(this.header, function["symbol"]),
        f"{function['symbol']}({', '.join([*words(problem, function), *outs])});", arrays(problem, function),
        sum(sizes), lambda flat, _state: split(flat, sizes), this.scalar_units, generate_s=this.seconds,
        operations=operations, real=function["precision"], plan=function["plan"], symbol=function["symbol"],
    )  # fmt: skip


def batch_variants(problem: Problem, this: Made, peers: tuple[str, str] = (BATCH, SOA)) -> list[Variant]:
    """All states in one call, as rows and as a structure of arrays; ``peers`` are their names. None where there is no
    batch of the function."""
    function, sizes, states = this.function, this.sizes, len(problem.states)
    symbol = function["batch_symbol"]
    if symbol is None:
        return []
    given, inputs = words(problem, function), arrays(problem, function)
    outs = [f"{{out}} + {states * start}" for start in starts(sizes)]
    rows = Variant(
        peers[0], this.name, prototype(this.header, symbol), f"{symbol}({', '.join(['n', *given, *outs])});", inputs,
        sum(sizes), lambda flat, _state: split(flat, sizes), this.batch_units, batch=True, real=function["precision"],
        generate_s=this.seconds, operations=None, plan=function["plan"],
    )  # fmt: skip
    soa = symbol.replace("_batch", "_soa")
    if soa not in this.header:
        return [rows]
    columns = {k: v if k in SHARED else np.ascontiguousarray(v.T) for k, v in inputs.items()}
    call = f"{soa}({', '.join(['n', f'{states}', *given, *outs])});"
    declaration = prototype(this.header, soa)
    return [rows, replace(rows, peer=peers[1], declaration=declaration, call=call, arrays=columns, columns=True)]


def starts(sizes: Sequence[int]) -> list[int]:
    """Where each output begins."""
    return [0, *np.cumsum(sizes)[:-1].tolist()]


def arrays(problem: Problem, function: dict[str, Any]) -> dict[str, Array]:
    return {port["name"]: _column(problem, port["name"]) for port in function["inputs"] if port["name"] != "dt"}


def words(problem: Problem, function: dict[str, Any]) -> list[str]:
    """Inputs as the call names them."""
    names = [port["name"] for port in function["inputs"]]
    return [float(problem.states[0]["dt"]).hex() if name == "dt" else f"{{{name}}}" for name in names]


def _column(problem: Problem, name: str) -> Array:
    return problem.column(name)[0] if name in SHARED else problem.column(name)


def prototype(header: str, symbol: str) -> str:
    """The prototype of one function out of its header (the whole header would bring the names of all)."""
    start = header.index(f"{symbol}(")
    line = header.rfind("\n", 0, start) + 1
    return " ".join(header[line : header.index(";", start) + 1].split())
