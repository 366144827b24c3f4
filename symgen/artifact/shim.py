"""The C between NumPy and the generated functions: one loop over states per function, from the manifest alone."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import Any

from symgen.targets.c.templates import render

SHIM = "symgen-shim.c"
FEW = 4
"""Fewer states are not worth a batch."""


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
                "batches": _batches(function),
            }
        )
    return render("c/shim.c.j2", headers=manifest["headers"], functions=rows)


def _batches(function: Mapping[str, Any]) -> list[dict[str, str]]:
    """(when, call) of the function's forms over states that lie one after the other, where it has them."""
    symbol = function["batch_symbol"]
    if not symbol:
        return []
    suffix = "_f32" if symbol.endswith("_f32") else ""
    forms = {symbol: False}
    if any(port["name"] == "p" for port in function["inputs"]):
        forms[f"{symbol.removesuffix(suffix)}_p{suffix}"] = True
    rows = []
    for name, own_parameters in forms.items():
        conditions, passed = [f"states >= {FEW}"], ["states"]
        for k, port in enumerate(function["inputs"]):
            shared = not port["shape"] or (port["name"] == "p" and not own_parameters)
            conditions.append(f"step_{k} == {0 if shared else prod(port['shape'])}u")
            passed.append(f"in_{k}" if port["shape"] else f"in_{k}[0]")
        passed += [f"out_{k}" for k in range(len(function["outputs"]))]
        rows.append({"when": " && ".join(conditions), "call": f"(void){name}({', '.join(passed)})"})
    return rows
