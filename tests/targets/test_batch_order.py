"""The order of statements over vectors."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from typing import Any

from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port
from symgen.targets.c import emit_c
from symgen.targets.c.vector import TOGETHER
from symgen.targets.c.vector_order import angles_first, spread_divisions
from tests.targets.batches import certify, wide
from tests.targets.programs import info
from tests.targets.test_read_back import expected, point


def test_divisions_are_spread() -> None:
    """What needs no quotient stands between them; the program stays the same function."""
    g = Graph()
    q, tau = g.inputs("q", 4), g.inputs("tau", 4)
    free: Any = 0
    for k in range(40):
        free = (free + tau[k % 4]) * tau[(k + 1) % 4]
    x: Any = q[0]
    for k in range(1, 4):
        x = q[k] + g.const(Fraction(1)) / (x * x + 1)
    program = extract(g, "chain", (Port("q", (4,)), Port("tau", (4,))), (Port("y", ()),), [[x + free]])
    moved = spread_divisions(program)
    places = [k for k, instruction in enumerate(moved.instructions) if instruction.op == "div"]
    assert len(places) == 3 and min(b - a for a, b in pairwise(places)) > 15
    assert sorted(i.op for i in moved.instructions) == sorted(i.op for i in program.instructions)
    assert all(k < n for n, instruction in enumerate(moved.instructions) for k in instruction.args)
    numbers, inputs = point(program)
    assert expected(moved, numbers, inputs) == expected(program, numbers, inputs)
    assert spread_divisions(wide()) == wide()


def test_angles_come_first_and_are_turned_together() -> None:
    """Angles of inputs, and their sums; one that needs another's sine keeps its place."""
    g = Graph()
    q = g.inputs("q", 9)
    late = g.sin(g.cos(q[0]) + q[1])
    rows: list[Any] = [late * g.cos(late), g.sin(q[1] + q[2]) * g.cos(q[1] + q[2])]
    rows += [g.sin(x) + g.cos(x) for x in q]
    program = extract(g, "turns", (Port("q", (9,)),), (Port("y", (len(rows),)),), [rows])
    moved = angles_first(program)
    turned = [k for k, i in enumerate(moved.instructions) if i.op in ("cos", "sin")]
    assert len(turned) == 22  # eleven angles, ten of them of inputs
    assert {i.op for i in moved.instructions[: turned[19] + 1]} == {"input", "add", "cos", "sin"}
    assert [i.op for i in moved.instructions[: turned[19] + 1]].count("add") == 1
    numbers, inputs = point(program)
    assert expected(moved, numbers, inputs) == expected(program, numbers, inputs)
    emitted = emit_c("demo", [program], info(batch=True))
    certify(emitted)
    text = emitted.files["demo_batch.c"]
    assert text.count(" SINES_COSINES_5(IN(q, ") == 2 and TOGETHER == 6
    assert angles_first(moved) == moved
