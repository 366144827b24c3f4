"""Printed equations: the numbers they say, the files people read, and that they are the same on every run."""

from __future__ import annotations

import math
import os
import random
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from fractions import Fraction as F
from pathlib import Path

import pytest
import sympy

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.load import load
from symgen.system import System, derive
from symgen.targets.sympy import equations
from symgen.targets.sympy.numbers import rational
from symgen.targets.sympy.setting import Setter, decimal
from symgen.targets.sympy.styles import STYLES, parsed
from tests.conftest import Golden
from tests.sympy.evaluate import value_of_mathml, value_of_text
from tests.validation.scenes import sprung_pendulum

ROOT = Path(__file__).parents[2]
GOLDEN = Path(__file__).parent / "golden"
CORE = {
    "math", "mrow", "mi", "mn", "mo", "mtext", "mfrac", "msqrt", "msup", "msub", "msubsup", "mover", "mtable", "mtr",
    "mtd",
}  # fmt: skip


def example(name: str) -> System:
    return derive(load(ROOT / "examples" / f"{name}.scene.yaml"))


TEXTBOOK = {
    "pendulum": ("mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics", "kinetic_energy",
                 "potential_energy"),
    "double_pendulum": ("natural_coordinates", "velocity_transformation", "mass_matrix", "coriolis_matrix",
                        "bias_force", "inverse_dynamics", "kinetic_energy"),
    "cart_pole": ("mass_matrix", "bias_force", "forward_dynamics"),
    "furuta": ("mass_matrix", "bias_force"),
    "spinning_top": ("mass_matrix", "bias_force"),
    "ur5": ("mass_matrix", "gravity_force"),
}  # fmt: skip


@pytest.mark.parametrize("name", TEXTBOOK)
def test_text_of_textbook_systems(name: str, golden: Golden) -> None:
    golden(GOLDEN / f"{name}.txt", equations(example(name), TEXTBOOK[name]) + "\n")


@pytest.mark.parametrize("style", ["latex", "mathml"])
def test_latex_and_mathml(style: str, golden: Golden) -> None:
    found = equations(example("cart_pole"), TEXTBOOK["cart_pole"], format=style)
    golden(GOLDEN / f"cart_pole.{'tex' if style == 'latex' else 'mathml'}", found + "\n")


PAPER = ("natural_coordinates", "velocity_transformation", "velocity_transformation_rate", "mass_matrix", "bias_force")


@pytest.mark.parametrize("name", ["fig1", "fig2", "universal_shaft", "screw_drive", "slope_body", "spinning_top"])
def test_text_in_the_papers_symbols(name: str, golden: Golden) -> None:
    golden(GOLDEN / f"{name}_paper.txt", equations(example(name), PAPER, symbols="paper") + "\n")


def test_latex_in_the_papers_symbols(golden: Golden) -> None:
    golden(GOLDEN / "fig2_paper.tex", equations(example("fig2"), PAPER, "paper", "latex") + "\n")


@pytest.mark.parametrize("symbols", ["joint", "paper"])
def test_mathml_is_well_formed_and_core(symbols: str) -> None:
    rows = ("velocity_transformation", "mass_matrix", "bias_force")
    for name in ("double_pendulum", "spinning_top", "fig1"):
        page = equations(example(name), rows, symbols, "mathml")
        tags = {node.tag.split("}")[-1] for node in ET.fromstring(f"<page>{page}</page>").iter()}
        assert tags - CORE <= {"page", "p"}
        assert "&" not in page.replace("&amp;", "").replace("&lt;", "")


def test_definitions_carry_a_large_row() -> None:
    text = equations(example("fig1"), ("bias_force",))
    lines = text.splitlines()
    assert len(lines) > 60 and lines[-1].startswith("(numbers rounded")
    assert any(line.startswith("t") and " = " in line for line in lines)
    assert max(len(line) for line in lines) < 2000


def test_symmetric_matrices_list_half() -> None:
    text = equations(example("ur5"), ("mass_matrix",))
    assert "[1,2]" in text and "[2,1]" not in text and "symmetric" in text


def test_nothing_is_said_of_entries_left_out_where_there_are_none() -> None:
    printed = equations(derive(sprung_pendulum()), ["bias_force"])
    assert printed.startswith("h[1] = ")
    assert "not listed" not in printed


def test_what_cannot_be_printed_is_said() -> None:
    pendulum = example("pendulum")
    with pytest.raises(SceneError, match="no form in the paper's symbols"):
        equations(pendulum, ("kinetic_energy",), symbols="paper")
    with pytest.raises(SceneError):
        equations(pendulum, ("nonsense",))
    with pytest.raises(NotSupportedError):
        equations(example("four_bar"), ("mass_matrix",))
    with pytest.raises(ValueError, match="format"):
        equations(pendulum, ("mass_matrix",), format="word")


def test_same_bytes_under_any_hash_seed() -> None:
    code = (
        "from symgen.scene.load import load\nfrom symgen.system import derive\n"
        "from symgen.targets.sympy import equations\n"
        "for name in ('double_pendulum', 'fig2', 'furuta'):\n"
        "    system = derive(load(f'examples/{name}.scene.yaml'))\n"
        "    for style in ('text', 'latex', 'mathml'):\n"
        "        print(equations(system, ('mass_matrix', 'gravity_force'), format=style))\n"
    )
    found = set()
    for seed in ("0", "4242"):
        env = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
        done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=env, capture_output=True, check=True)
        found.add(done.stdout)
    assert len(found) == 1 and found.pop()


# -- what is printed is what was meant ---------------------------------------------------------------------------------

X, Y, Z = sympy.symbols("theta_a thetadot_b q_c")
VALUES = {X: 0.7, Y: -1.3, Z: 0.45}


def random_expression(rng: random.Random, depth: int) -> sympy.Expr:
    if depth == 0:
        number = rational(F(rng.randint(-20, 20), rng.choice((1, 2, 3, 7, 10, 1000))))
        return rng.choice((X, Y, Z, number, sympy.cos(X), sympy.sin(X + Z)))
    a, b = random_expression(rng, depth - 1), random_expression(rng, depth - 1)
    kind = rng.randrange(7)
    if kind < 2:
        return a + b
    if kind == 2:
        return -sympy.Mul(a + b, 1, evaluate=False)
    if kind == 3:
        return a * b
    if kind == 4:
        return sympy.Mul(a, b, evaluate=False)
    return a / (b**2 + 1) if kind == 5 else a**2 + sympy.sqrt(b**2 + 2)


@pytest.mark.parametrize("seed", range(40))
def test_printed_expressions_evaluate_to_their_value(seed: int) -> None:
    expression = random_expression(random.Random(seed), 3)
    wanted = float(expression.subs(VALUES))
    for style in ("text", "mathml"):
        setter = Setter(STYLES[style])
        printed = setter.set(expression)
        names = {setter.set(symbol): value for symbol, value in VALUES.items()}
        if style == "text":
            found = value_of_text(printed, names)
        else:
            by_text = {"".join(ET.fromstring(text).itertext()): value for text, value in names.items()}
            found = value_of_mathml(ET.fromstring(printed), by_text)
        assert math.isclose(found, wanted, rel_tol=1e-4 if setter.rounded else 1e-12, abs_tol=1e-9), printed


def test_a_negated_sum_keeps_its_parentheses() -> None:
    expression = sympy.Mul(-1, X + Y, evaluate=False)
    assert Setter(STYLES["text"]).set(expression) == "-(θ_a + θ̇_b)"
    assert "<mo>−</mo><mrow><mo>(</mo>" in Setter(STYLES["mathml"]).set(expression)


@pytest.mark.parametrize(
    ("value", "printed"),
    [
        (F(3, 10), ("0.3", 0, True)),
        (F(12), ("12", 0, True)),
        (F(1500000), ("1500000", 0, True)),
        (F(1, 3), ("0.333333", 0, False)),
        (F(1, 10**7), ("1", -7, True)),
        (F(123456789, 10**6), ("123.457", 0, False)),
        (F(10) ** 30 / 7, ("1.42857", 29, False)),
    ],
)
def test_numbers(value: F, printed: tuple[str, int, bool]) -> None:
    mantissa, exponent, exact = decimal(value)
    assert (mantissa, exponent, exact) == printed
    assert (F(mantissa) * F(10) ** exponent == value) == exact


@pytest.mark.parametrize(
    ("name", "text", "latex"),
    [
        ("theta_elbow", "θ_elbow", r"\theta_{\mathrm{elbow}}"),
        ("thetadot_j1", "θ̇_j1", r"\dot{\theta}_{\mathrm{j1}}"),
        ("thetaddot_j1", "θ̈_j1", r"\ddot{\theta}_{\mathrm{j1}}"),
        ("omega_base_x", "ω_base_x", r"\omega_{\mathrm{base},x}"),
        ("theta_cross_1", "θ_cross_1", r"\theta_{\mathrm{cross},1}"),
        ("theta_shoulder_pan_joint", "θ_shoulder_pan_joint", r"\theta_{\mathrm{shoulder\_pan\_joint}}"),
        ("w_link3_x", "ω_link3_x", r"\omega_{\mathrm{link3},x}"),
        ("t12", "t₁₂", r"t_{12}"),
        ("dt", "dt", r"\mathrm{dt}"),
    ],
)
def test_names(name: str, text: str, latex: str) -> None:
    assert STYLES["text"].name(parsed(name)) == text
    assert STYLES["latex"].name(parsed(name)) == latex


def test_latex_braces_balance() -> None:
    for symbols in ("joint", "paper"):
        text = equations(example("fig1"), ("velocity_transformation", "mass_matrix"), symbols, "latex")
        assert text.count("{") == text.count("}")
        assert len(re.findall(r"\\left", text)) == len(re.findall(r"\\right", text))
