"""Statements that were read back, compiled as Python: over any numbers, or on ints modulo a prime."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from types import CodeType
from typing import Any

Statement = tuple[str, str]
"""(target, expression) as Python."""
CHUNK = 200
"""Statements compiled at once: Python's compiler takes a time that grows faster than the length of what it is given."""
WHOLE = 1000
"""Up to so many statements are one Python function, which runs fastest."""


def compiled(name: str, arguments: Sequence[str], statements: Sequence[Statement], guards: Sequence[str], modulo: bool,
             literals: int) -> Callable[..., list[Any]]:  # fmt: skip
    """The function of ``arguments``, of which the one called ``literals`` holds the values of l0, l1, … It fills its
    outputs and returns what the guards ask. ``modulo``: everything modulo the argument p, with a * inverse(b) for
    a / b."""
    lines = [f"{', '.join(f'l{i}' for i in range(literals))}, = literals"] if literals else []
    if modulo:
        lines += [f"{target} = {_modulo(text)}" for target, text in statements]
        result = f"[{', '.join(_modulo(text) for text in guards)}]"
    else:
        lines += [f"{target} = {text}" for target, text in statements]
        result = f"[{', '.join(guards)}]"
    file = f"<{name} as read back>"
    if len(lines) > WHOLE:
        return _in_chunks(file, arguments, [*lines, f"guards = {result}"])
    head = f"def function({', '.join(arguments)}):\n  "
    namespace: dict[str, Any] = {}
    text = head + "\n  ".join([*lines, f"return {result}"])
    exec(compile(text, file, "exec"), {"__builtins__": {}}, namespace)
    found: Callable[..., list[Any]] = namespace["function"]
    return found


def _in_chunks(file: str, arguments: Sequence[str], lines: Sequence[str]) -> Callable[..., list[Any]]:
    """What the lines of a function do, compiled a few at a time."""
    starts = range(0, len(lines), CHUNK)
    codes: list[CodeType] = [compile("\n".join(lines[k : k + CHUNK]), file, "exec") for k in starts]

    def function(*values: Any) -> list[Any]:
        variables: dict[str, Any] = {"__builtins__": {}, **dict(zip(arguments, values, strict=True))}
        for code in codes:
            exec(code, variables)
        guards: list[Any] = variables["guards"]
        return guards

    return function


def zeros(name: str, start: int, end: int) -> Statement:
    """The statement that sets a run of entries to zero."""
    return f"v_{name}[{start}:{end}]", f"[0] * {end - start}"


def _modulo(text: str) -> str:
    if text.startswith("[0] * "):  # see `zeros`; what is read of C never begins so
        return text
    return f"({_without_division(text)}) % p"


class _Inverse(ast.NodeTransformer):
    """a / b → a * inverse(b)."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.Div):
            call = ast.Call(ast.Name("inverse", ast.Load()), [node.right], [])
            return ast.BinOp(node.left, ast.Mult(), call)
        return node


def _without_division(text: str) -> str:
    return ast.unparse(_Inverse().visit(ast.parse(text, mode="eval"))) if "/" in text else text
