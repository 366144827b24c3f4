"""What is wrong in emitted loops is refused: constants, places, classes, signs, bounds, calls, guards, tile by tile."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import pytest

from symgen.algebra.field import MERSENNE_61, FieldNumbers
from symgen.errors import CertificateError
from symgen.loops.model import LoopProgram
from symgen.scene.builder import SceneBuilder
from symgen.scene.model import Scene
from symgen.system import System
from symgen.targets.c import Emitted, read_back
from tests.loops.helpers import asked, certify, emitted

ROWS = ("inverse_dynamics", "mass_matrix", "forward_dynamics")
FEW, MANY = 3, 25
"""So many of the places where one kind of mistake can be made are tried."""


def scene() -> Scene:
    """Two branches, turns and a slide, one rotation kept as a whole, armature and damping, links that look alike."""
    builder = SceneBuilder("tree")
    x, y, z = [1, 0, 0], [0, 1, 0], [0, 0, 1]
    facts = [("ground", z), ("b0", x), ("b1", y), ("b2", x), ("b3", y), ("b4", x), ("b0", y), ("b6", [1, 2, 2])]
    for k, (parent, axis) in enumerate(facts):
        builder.body(
            f"b{k}", mass=f"{k + 1}.3", com=[f"0.{k + 1}", "-0.2", "0.07"],
            inertia=[f"1.{k + 1}", "1.2", "1.3", "0.1", "-0.05", "0.02"],
        )  # fmt: skip
        kind = "prismatic" if k == 6 else "revolute"
        builder.joint(
            f"j{k}", kind, parent, f"b{k}", axis=axis, xyz=["0.1", f"-0.{k + 1}", "0.3"], armature="0.3", damping="0.2",
            rpy=["0.3", "0.2", "-0.4"] if k == 7 else [0, 0, 0],
        )  # fmt: skip
    return builder.build()


@cache
def made(row: str) -> tuple[System, Emitted]:
    system = asked(scene(), row)
    return system, emitted(system)


def refused(row: str, text: str) -> bool:
    """Whether a text is refused. One that is not must compute the same as the right one: some places are never read."""
    system, right = made(row)
    mutated = replace(right, files={**right.files, "tree.c": text})
    try:
        certify(system, mutated)
    except CertificateError:
        return True
    assert values(row, text) == values(row, source(row)), difference(source(row), text)
    return False


@cache
def values(row: str, text: str) -> dict[str, list[int]]:
    """Outputs of a text at a random point."""
    system, right = made(row)
    function = read_back(replace(right, files={**right.files, "tree.c": text})).functions[row]
    rng, p = random.Random(5), MERSENNE_61
    inputs = {name: [rng.randrange(p) for _ in range(system.tree.nv)] for name in ("q", "v", "a", "tau")}
    return dict(function.evaluate_mod(p, inputs, FieldNumbers(p, 5).apply))


def source(row: str) -> str:
    return made(row)[1].files["tree.c"]


def numbers(row: str) -> Iterator[str]:
    """The last digit of every constant in a table."""
    text = source(row)
    for table in re.finditer(r"static const double \w+_k\[\d+\] = \{(.*?)\};", text, re.DOTALL):
        for match in re.finditer(r"\d+\.\d+(?:e-?\d+)?", table[1]):
            mantissa, e, exponent = match[0].partition("e")
            other = f"{mantissa[:-1]}{(int(mantissa[-1]) + 5) % 10}{e}{exponent}"
            start = table.start(1) + match.start()
            if float(other) != float(match[0]):
                yield text[:start] + other + text[start + len(match[0]) :]


def places(row: str) -> Iterator[str]:
    """Every offset that is used, one further."""
    system, right = made(row)
    program = system.code(row).program
    assert isinstance(program, LoopProgram)
    text = right.files["tree.c"]
    for sweep in program.sweeps:
        table = re.search(rf"tree_{row}_{sweep.name}_at\S* = \{{\n(.*?)\n\}};", text, re.DOTALL)
        assert table is not None
        entries = list(re.finditer(r"\d+", table[1]))
        for number, cells in enumerate(sweep.table):
            step = sweep.steps[cells[0]]
            used = {sweep.offsets[port.name] for port in (*step.inputs, *step.outputs) if port.name in sweep.offsets}
            for column in sorted(used):
                match = entries[number * sweep.width + column]
                start = table.start(1) + match.start()
                yield text[:start] + str(int(match[0]) + 1) + text[start + len(match[0]) :]


def classes(row: str) -> Iterator[str]:
    """The steps of two classes, swapped where they are called."""
    text = source(row)
    for match in re.finditer(
        r"case 0:\n +(tree_\w+_)0\((.*?)\);\n +break;\n +(?:case 1|default):\n +\1(\d+)\(", text, re.DOTALL
    ):
        yield text.replace(match[0], match[0].replace(f"{match[1]}0(", f"{match[1]}{match[3]}(", 1))


def signs(row: str) -> Iterator[str]:
    """A plus or minus in a step."""
    text = source(row)
    for step in re.finditer(r"SYMGEN_STEP void \w+\([^)]*\)\n\{\n(.*?)\n\}\n", text, re.DOTALL):
        for match in re.finditer(r" ([+-]) (?=[\w(])", step[1]):
            start = step.start(1) + match.start()
            yield f"{text[:start]} {'-' if match[1] == '+' else '+'} {text[start + 3 :]}"


def loops(row: str) -> Iterator[str]:
    """Bounds of loops, and entries of rows in calls and joins."""
    text = source(row)
    body = text.index(f"void tree_{row}(")
    for match in re.finditer(r"< (\d+); \+\+|= (\d); \w <|at\[(\d)\]", text[body:]):
        start = body + match.start()
        digits = next(group for group in match.groups() if group)
        other = match[0].replace(digits, str(int(digits) + 1))
        yield text[:start] + other + text[start + len(match[0]) :]


def statements(row: str) -> Iterator[str]:
    """A statement that is not there."""
    text = source(row)
    body = text.index("SYMGEN_STEP void tree")
    for match in re.finditer(r"\n +[^\n{}]+;(?=\n)", text[body:]):
        start = body + match.start()
        if "const unsigned short *at" not in match[0] and "(void)" not in match[0]:
            yield text[:start] + text[start + len(match[0]) :]


def arguments(row: str) -> Iterator[str]:
    """Sine for cosine, and one array for another."""
    text = source(row)
    for a, b in (("cosines +", "sines +"), ("motion_v_wrench +", "kept +"), ("sent);", "angles);")):
        for match in re.finditer(rf"\b{re.escape(a)}", text):
            yield text[: match.start()] + b + text[match.end() :]


KINDS = {f.__name__: f for f in (numbers, places, classes, signs, loops, statements, arguments)}


def tried(kind: str, row: str, most: int) -> None:
    texts = list(KINDS[kind](row))
    assert texts or kind == "arguments", f"no {kind} in {row}"
    chosen = random.Random(row).sample(texts, min(len(texts), most))
    caught = sum(refused(row, text) for text in chosen)
    assert 3 * caught >= len(chosen), f"{caught} of {len(chosen)}"


@pytest.mark.parametrize("row", ROWS)
@pytest.mark.parametrize("kind", KINDS)
def test_mistakes_are_refused(kind: str, row: str) -> None:
    tried(kind, row, FEW)


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS)
@pytest.mark.parametrize("kind", KINDS)
def test_many_mistakes_are_refused(kind: str, row: str) -> None:
    tried(kind, row, MANY)


def difference(a: str, b: str) -> str:
    """The first line that differs."""
    pairs = zip(a.splitlines(), b.splitlines(), strict=False)
    return next((f"{x.strip()} → {y.strip()}" for x, y in pairs if x != y), "at the end")


@pytest.mark.parametrize("row", ROWS)
def test_what_is_right_is_certified(row: str) -> None:
    assert not refused(row, source(row))


def test_guards_are_those_of_the_pivots() -> None:
    text = source("forward_dynamics")
    assert refused("forward_dynamics", text.replace("if (!(pivots[i] > 0.0))", "if (!(kept[i] > 0.0))"))
    assert refused("forward_dynamics", text.replace("if (!(pivots[i] > 0.0))", "if (!(pivots[i] < 0.0))"))
    assert refused("forward_dynamics", text.replace("a[j] = (double)NAN;", "a[j] = 0.0;"))
