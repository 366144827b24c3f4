"""Numbers through SymPy results: arguments, values, and what printed text and MathML evaluate to."""

from __future__ import annotations

import math
import random
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from symgen.algebra.numbers import FloatNumbers, State
from symgen.system import System
from symgen.targets.sympy import Equation, Symbols, system_symbols

Array = NDArray[np.float64]


def random_state(system: System, seed: int) -> State:
    """Quaternions are not of unit norm."""
    rng = random.Random(seed)

    def draw(count: int) -> tuple[float, ...]:
        return tuple(rng.uniform(-1.0, 1.0) for _ in range(count))

    tree = system.tree
    p = tuple(float(x) + 0.1 for parameter in system.scene.parameters for x in parameter.default)
    return State(draw(tree.nq), draw(tree.nv), draw(tree.nv), draw(tree.nv), 0.3, p)


def bindings(system: System, state: State) -> dict[sympy.Symbol, float]:
    symbols: Symbols = system_symbols(system.scene, system.tree)
    found: dict[sympy.Symbol, float] = {symbols.dt: state.dt}
    for name in ("q", "v", "a", "tau", "p"):
        found.update(zip(getattr(symbols, name), getattr(state, name), strict=True))
    return found


def literal(system: System, row: str, state: State) -> Array:
    (value,) = system.evaluate(row, FloatNumbers(), state).values()
    return np.array(value, dtype=np.float64).ravel()


def value_of(expression: Any, known: Mapping[sympy.Symbol, float]) -> Array:
    """lambdify, as a user would."""
    function = sympy.lambdify(list(known), expression, modules="numpy", cse=True)
    return np.array(function(*known.values()), dtype=np.float64).ravel()


def value_by_definitions(equation: Equation, known: Mapping[sympy.Symbol, float]) -> Array:
    """The definitions one after the other, then the result."""
    return np.array(equation.lambdify(list(known))(*known.values()), dtype=np.float64).ravel()


SUPERSCRIPT = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")


def value_of_text(text: str, names: Mapping[str, float]) -> float:
    """A printed right-hand side, read as arithmetic."""
    for name in sorted(names, key=len, reverse=True):
        text = text.replace(name, f"({names[name]!r})")
    text = re.sub(r"(cos|sin)([⁰¹²³⁴⁵⁶⁷⁸⁹]+)\(", lambda m: f"Power({m[2].translate(SUPERSCRIPT)},{m[1]})(", text)
    text = re.sub(r"[⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda m: "**" + m[0].translate(SUPERSCRIPT), text)
    text = text.replace("·", "*").replace("√", "sqrt")

    def power(exponent: int, function: Any) -> Any:
        return lambda x: function(x) ** exponent

    return float(eval(text, {"cos": math.cos, "sin": math.sin, "sqrt": math.sqrt, "Power": power}))


def value_of_mathml(node: ET.Element, names: Mapping[str, float]) -> float:
    """A MathML right-hand side, read as arithmetic; ``names`` by the text of their element."""
    return float(eval(_python(node, names), {"cos": math.cos, "sin": math.sin, "sqrt": math.sqrt}))


def _python(node: ET.Element, names: Mapping[str, float]) -> str:
    tag = node.tag.split("}")[-1]
    text = "".join(node.itertext())
    children = list(node)
    if tag in ("mi", "msub", "msubsup", "mover") and text in names:
        return f"({names[text]!r})"
    if tag == "mo":
        return {"−": "-", "\u2062": "*", "·": "*", "\u2061": ""}.get(text, text)
    if tag == "mfrac":
        return f"(({_python(children[0], names)})/({_python(children[1], names)}))"
    if tag == "msqrt":
        return f"sqrt({''.join(_python(child, names) for child in children)})"
    if tag == "mrow" and len(children) == 3 and "".join(children[1].itertext()) == "\u2061":
        head, argument = children[0], _python(children[2], names)
        if head.tag.split("}")[-1] == "msup":
            return f"({_python(head[0], names)}({argument})**{_python(head[1], names)})"
        return f"{_python(head, names)}({argument})"
    if tag == "msup":
        # what a reader sees: the exponent belongs to the base as it stands
        return f"{_python(children[0], names)}**{_python(children[1], names)}"
    if children:
        return "".join(_python(child, names) for child in children)
    return text
