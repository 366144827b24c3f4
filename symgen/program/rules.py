"""What the exact graph simplifies when a node is made: one table, read top to bottom, first match wins.

A rule takes the graph and the arguments and returns the simpler node, or None when it does not apply. Every rule
is an identity over the rationals (and hence over GF(p)); none depends on rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from symgen.program.instructions import OPERATIONS

if TYPE_CHECKING:
    from symgen.program.graph import Graph, Node

Rule = Callable[..., "Node | None"]


def _value(x: Node) -> Fraction | None:
    return x.value if x.op == "const" else None


def _coefficient(x: Node) -> Fraction | int:
    """The constant that x is its core times."""
    return 1 if x.core == x.number else x.args[0].value


def _core(x: Node) -> Node:
    return x if x.core == x.number else x.args[1]


def add_constants(g: Graph, x: Node, y: Node) -> Node | None:
    a, b = _value(x), _value(y)
    if a is not None and b is not None:
        return g.const(a + b)
    if a == 0:
        return y
    return x if b == 0 else None


def _offset(x: Node) -> tuple[Fraction, int, Node] | None:
    """x as (constant, sign, rest) where it is a constant plus or minus a rest."""
    if x.op == "add" and x.args[0].op == "const":
        return x.args[0].value, 1, x.args[1]
    if x.op == "sub" and x.args[0].op == "const":
        return x.args[0].value, -1, x.args[1]
    if x.op == "sub" and x.args[1].op == "const":
        return -x.args[1].value, 1, x.args[0]
    return None


def add_negative_constant(g: Graph, x: Node, y: Node) -> Node | None:
    a = _value(x)
    return g.sub(y, g.const(-a)) if a is not None and a < 0 else None


def add_nested_constant(g: Graph, x: Node, y: Node) -> Node | None:
    a, inner = _value(x), _offset(y)
    if a is None or inner is None:
        return None
    b, sign, rest = inner
    return g.add(g.const(a + b), rest) if sign > 0 else g.sub(g.const(a + b), rest)


def sub_negative_constant(g: Graph, x: Node, y: Node) -> Node | None:
    b = _value(y)
    return g.add(x, g.const(-b)) if b is not None and b < 0 else None


def sub_nested_constant(g: Graph, x: Node, y: Node) -> Node | None:
    a, inner = _value(x), _offset(y)
    if a is not None and inner is not None:
        b, sign, rest = inner
        return g.sub(g.const(a - b), rest) if sign > 0 else g.add(g.const(a - b), rest)
    a, inner = _value(y), _offset(x)
    if a is not None and inner is not None:
        b, sign, rest = inner
        return g.add(g.const(b - a), rest) if sign > 0 else g.sub(g.const(b - a), rest)
    return None


def add_negated(g: Graph, x: Node, y: Node) -> Node | None:
    if y.op == "neg":
        return g.sub(x, y.args[0])
    return g.sub(y, x.args[0]) if x.op == "neg" else None


def add_like_terms(g: Graph, x: Node, y: Node) -> Node | None:
    if x.core != y.core or x.op == "const":
        return None
    return g.mul(g.const(_coefficient(x) + _coefficient(y)), _core(x))


def add_undo_subtraction(g: Graph, x: Node, y: Node) -> Node | None:
    if x.op == "sub" and x.args[1] is y:
        return x.args[0]
    return y.args[0] if y.op == "sub" and y.args[1] is x else None


def add_cancel(g: Graph, x: Node, y: Node) -> Node | None:
    if x.op == "sub" and y.op == "add":
        x, y = y, x
    if x.op == "add" and y.op == "sub" and y.args[1] in x.args:
        return g.add(x.args[0] if x.args[1] is y.args[1] else x.args[1], y.args[0])
    return None


def sub_constants(g: Graph, x: Node, y: Node) -> Node | None:
    a, b = _value(x), _value(y)
    if a is not None and b is not None:
        return g.const(a - b)
    if b == 0:
        return x
    return g.neg(y) if a == 0 else None


def sub_negated(g: Graph, x: Node, y: Node) -> Node | None:
    if y.op == "neg":
        return g.add(x, y.args[0])
    return g.neg(g.add(x.args[0], y)) if x.op == "neg" else None


def sub_like_terms(g: Graph, x: Node, y: Node) -> Node | None:
    if x.core != y.core or x.op == "const":
        return None
    return g.mul(g.const(_coefficient(x) - _coefficient(y)), _core(x))


def sub_undo(g: Graph, x: Node, y: Node) -> Node | None:
    if x.op == "add":
        if x.args[0] is y:
            return x.args[1]
        if x.args[1] is y:
            return x.args[0]
    if x.op == "sub" and x.args[0] is y:
        return g.neg(x.args[1])
    return y.args[1] if y.op == "sub" and y.args[0] is x else None


def sub_cancel(g: Graph, x: Node, y: Node) -> Node | None:
    if x.op == y.op == "sub":
        if x.args[1] is y.args[1]:
            return g.sub(x.args[0], y.args[0])
        return g.sub(y.args[1], x.args[1]) if x.args[0] is y.args[0] else None
    if x.op == y.op == "add":
        for k in (0, 1):
            if x.args[k] in y.args:
                other = y.args[0] if y.args[1] is x.args[k] else y.args[1]
                return g.sub(x.args[1 - k], other)
    return None


def sub_reversed_exists(g: Graph, x: Node, y: Node) -> Node | None:
    known = g.find("sub", y, x)
    return g.neg(known) if known is not None else None


def mul_constants(g: Graph, x: Node, y: Node) -> Node | None:
    a, b = _value(x), _value(y)
    if a is not None and b is not None:
        return g.const(a * b)
    for value, other in ((a, y), (b, x)):
        if value == 0:
            return g.const(Fraction(0))
        if value == 1:
            return other
        if value is not None and value < 0:
            return g.neg(g.mul(g.const(-value), other))
    return None


def mul_negated(g: Graph, x: Node, y: Node) -> Node | None:
    if x.op == "neg":
        return g.neg(g.mul(x.args[0], y))
    return g.neg(g.mul(x, y.args[0])) if y.op == "neg" else None


def mul_nested_constant(g: Graph, x: Node, y: Node) -> Node | None:
    for constant, other in ((x, y), (y, x)):
        if constant.op == "const" and other.op == "mul" and other.args[0].op == "const":
            return g.mul(g.const(constant.value * other.args[0].value), other.args[1])
    return None


def neg_constant(g: Graph, x: Node) -> Node | None:
    return g.const(-x.value) if x.op == "const" else None


def neg_negated(g: Graph, x: Node) -> Node | None:
    return x.args[0] if x.op == "neg" else None


def neg_reversed_exists(g: Graph, x: Node) -> Node | None:
    return g.find("sub", x.args[1], x.args[0]) if x.op == "sub" else None


def div_constants(g: Graph, x: Node, y: Node) -> Node | None:
    b = _value(y)
    if b is not None:
        return g.mul(x, g.const(1 / b))
    return x if _value(x) == 0 else None


def div_negated(g: Graph, x: Node, y: Node) -> Node | None:
    if x.op == "neg":
        return g.neg(g.div(x.args[0], y))
    return g.neg(g.div(x, y.args[0])) if y.op == "neg" else None


def div_same(g: Graph, x: Node, y: Node) -> Node | None:
    return g.const(Fraction(1)) if x is y else None


def even_function(g: Graph, x: Node) -> Node | None:
    return g.unary("cos", x.args[0]) if x.op == "neg" else None


def odd_function(g: Graph, x: Node) -> Node | None:
    return g.neg(g.unary("sin", x.args[0])) if x.op == "neg" else None


def at_zero(value: Fraction) -> Rule:
    def rule(g: Graph, x: Node) -> Node | None:
        return g.const(value) if _value(x) == 0 else None

    return rule


@dataclass(frozen=True)
class Row:
    """One rule. ``may`` says for which operations of its arguments (one name each, "" where there is no second) it has
    to be tried at all."""

    says: str
    rule: Rule
    may: Callable[[str, str], bool]


def _either(*ops: str) -> Callable[[str, str], bool]:
    return lambda x, y: x in ops or y in ops


def _same(*ops: str) -> Callable[[str, str], bool]:
    return lambda x, y: x == y and (not ops or x in ops)


def _sum_and_constant(x: str, y: str) -> bool:
    return (x == "const" and y in SUMS) or (y == "const" and x in SUMS)


def _like(x: str, y: str) -> bool:
    return x == y or "mul" in (x, y)


SUMS = ("add", "sub")
_constant, _negated = _either("const"), _either("neg")

RULES: dict[str, tuple[Row, ...]] = {
    "add": (
        Row("a + b → constant; x + 0 → x", add_constants, _constant),
        Row("(−a) + x → x − a", add_negative_constant, _constant),
        Row("a + (b ± x) → (a + b) ± x", add_nested_constant, _sum_and_constant),
        Row("x + (−y) → x − y", add_negated, _negated),
        Row("a·x + b·x → (a+b)·x", add_like_terms, _like),
        Row("(x − y) + y → x", add_undo_subtraction, _either("sub")),
        Row("(x + z) + (y − z) → x + y", add_cancel, lambda x, y: {x, y} == set(SUMS)),
    ),
    "sub": (
        Row("a − b → constant; x − 0 → x; 0 − y → −y", sub_constants, _constant),
        Row("x − (−a) → x + a", sub_negative_constant, _constant),
        Row("a − (b ± x) → (a − b) ∓ x; (b ± x) − a → (b − a) ± x", sub_nested_constant, _sum_and_constant),
        Row("x − (−y) → x + y; (−x) − y → −(x + y)", sub_negated, _negated),
        Row("a·x − b·x → (a−b)·x; x − x → 0", sub_like_terms, _like),
        Row("(x + y) − y → x; (x − y) − x → −y; x − (x − y) → y", sub_undo, _either(*SUMS)),
        Row(
            "(x + z) − (y + z) → x − y; (x − z) − (y − z) → x − y; (z − x) − (z − y) → y − x", sub_cancel, _same(*SUMS)
        ),
        Row("x − y → −(y − x) where y − x exists", sub_reversed_exists, lambda x, y: True),
    ),
    "mul": (
        Row("a·b → constant; 0·x → 0; 1·x → x; (−a)·x → −(a·x)", mul_constants, _constant),
        Row("(−x)·y → −(x·y)", mul_negated, _negated),
        Row("a·(b·x) → (ab)·x", mul_nested_constant, lambda x, y: {x, y} == {"const", "mul"}),
    ),
    "neg": (
        Row("−a → constant", neg_constant, _constant),
        Row("−(−x) → x", neg_negated, _negated),
        Row("−(x − y) → y − x where y − x exists", neg_reversed_exists, _either("sub")),
    ),
    "div": (
        Row("x / a → (1/a)·x; 0 / x → 0", div_constants, _constant),
        Row("(−x) / y → −(x / y)", div_negated, _negated),
        Row("x / x → 1", div_same, _same()),
    ),
    "sqrt": (),  # a field may take the other root: √4 stays as it is
    "cos": (
        Row("cos 0 → 1", at_zero(Fraction(1)), _constant),
        Row("cos(−x) → cos x", even_function, _negated),
    ),
    "sin": (
        Row("sin 0 → 0", at_zero(Fraction(0)), _constant),
        Row("sin(−x) → −sin x", odd_function, _negated),
    ),
    "cos_sqrt": (Row("1 at 0", at_zero(Fraction(1)), _constant),),
    "sinc_sqrt": (Row("1 at 0", at_zero(Fraction(1)), _constant),),
    "sinc3_sqrt": (Row("1/6 at 0", at_zero(Fraction(1, 6)), _constant),),
}
COMMUTATIVE = frozenset({"add", "mul"})


def _to_try(op: str, x: str, y: str) -> tuple[Rule, ...]:
    return tuple(row.rule for row in RULES[op] if row.may(x, y))


BINARY = {
    op: {x: {y: _to_try(op, x, y) for y in OPERATIONS} for x in OPERATIONS} for op in RULES if OPERATIONS[op] == 2
}
"""Operation → those of its arguments → the rules to try, in their order."""
UNARY = {op: {x: _to_try(op, x, "") for x in OPERATIONS} for op in RULES if OPERATIONS[op] == 1}
