"""The C between NumPy and the generated functions: one loop over states per function, from the manifest alone."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import Any

from symgen.targets.c.templates import render

SHIM = "symgen-shim.c"


def shim_symbol(function: Mapping[str, Any]) -> str:
    return f"shim_{function['symbol']}"


def shim_text(manifest: Mapping[str, Any]) -> str:
    """C with ``shim_SYMBOL(states, in_0, step_0, …, out_0, …)`` for every function; steps in numbers, not bytes."""
    rows = []
    for function in manifest["functions"]:
        if not function["symbol"]:
            continue
        real = function["precision"]
        arguments, passed = ["size_t states"], []
        for k, port in enumerate(function["inputs"]):
            arguments += [f"const {real} *in_{k}", f"size_t step_{k}"]
            passed.append(f"in_{k} + i * step_{k}" if port["shape"] else f"in_{k}[i * step_{k}]")
        for k, port in enumerate(function["outputs"]):
            arguments.append(f"{real} *out_{k}")
            passed.append(f"out_{k} + i * {prod(port['shape'])}u")
        rows.append(
            {
                "prototype": f"void {shim_symbol(function)}({', '.join(arguments)})",
                "call": f"(void){function['symbol']}({', '.join(passed)})",
            }
        )
    return render("c/shim.c.j2", headers=manifest["headers"], functions=rows)
