"""Formulas and equations of a page: well formed, numbered as the paper numbers them, broken without losing anything."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from defusedxml.ElementTree import fromstring

from symgen.catalogue import CATALOGUE, PRODUCTS
from symgen.report import derivation
from symgen.report.breaking import WIDEST, Breaking, width
from symgen.report.definitions import DEFINITIONS, PLANE, function_words
from symgen.report.equations import equations, paper_number
from symgen.report.mathml import math
from symgen.report.page import write_report
from symgen.report.phases import PHASES
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.load import load
from symgen.system import System, derive
from tests.report import pages

ROOT = Path(__file__).resolve().parents[2]
MATH = "{http://www.w3.org/1998/Math/MathML}"


def system(name: str) -> System:
    return derive(load(ROOT / f"examples/{name}.scene.yaml"))


def seen(text: str) -> str:
    """What a formula shows."""
    return "".join(fromstring(str(math(text))).itertext())


def test_a_formula_is_read_as_it_is_written() -> None:
    root = fromstring(str(math("M_n ẍ − Ψ_x^T λ = Q")))
    assert root.tag == f"{MATH}math" and root.get("alttext") == "M_n ẍ − Ψ_x^T λ = Q"
    row = root[0]
    assert [child.tag.removeprefix(MATH) for child in row] == ["msub", "mover", "mo", "msubsup", "mi", "mo", "mi"]
    assert "".join(row[1].itertext()) == "x¨" and "".join(row[3].itertext()) == "ΨxT"
    fraction = fromstring(str(math("{∂Ψ}/{∂x}")))[0]
    assert fraction.tag == f"{MATH}mfrac" and ["".join(part.itertext()) for part in fraction] == ["∂Ψ", "∂x"]
    assert seen('x  "with <b>"  12.5') == "xwith <b>12.5"
    assert seen("R^{−1} q̇_{i j}") == "R−1q˙ij"


@pytest.mark.parametrize("text", [d.formula for d in (*DEFINITIONS.values(), *PLANE.values())])
def test_definitions_are_well_formed(text: str) -> None:
    shown = seen(text)
    assert not re.search(r'[{}_^"]', shown), "part of the notation was not understood"


def test_every_row_has_a_definition() -> None:
    assert set(DEFINITIONS) == {*CATALOGUE, *PRODUCTS}


def test_formulas_of_phases_are_well_formed() -> None:
    for phase in PHASES.values():
        assert phase.sentence.endswith(".")
        assert not phase.formula or not re.search(r'[{}_^"]', seen(phase.formula)), phase.formula


def test_every_joint_type_has_its_block() -> None:
    """A page of every type; the paper's own types are its Table 1."""
    shown = set()
    for name in ("fig1", "fig2", "screw_drive", "universal_shaft", "slope_body", "spinning_top"):
        for row in derivation.blocks(system(name)).rows:
            shown.add(row[0].split()[0])
            assert (row[-1] == "Table 1") == (row[0].split()[0] in ("revolute", "prismatic", "floating", "universal"))
    assert shown == set(JOINT_TYPES) - {"fixed", "continuous", "cylindrical"}
    assert set(derivation.BLOCKS) >= set(JOINT_TYPES) - {"fixed", "continuous", "floating"}


def test_the_papers_systems_have_its_numbers() -> None:
    assert paper_number(system("fig1")) == "4.9" and paper_number(system("fig2")) == "4.13"
    assert paper_number(system("double_pendulum")) == "" and paper_number(system("ur5")) == ""


def test_numbers_run_on() -> None:
    found = list(equations(system("double_pendulum")))
    numbers = derivation.numbered(found)
    assert [numbers[equation.row] for equation in found] == [str(3 + k) for k in range(len(found))]
    functions = derivation.functions(system("double_pendulum"), 3 + len(found))
    assert [function.number for function in functions] == [str(3 + len(found) + k) for k in range(len(functions))]


def terms(count: int) -> list[tuple[bool, str]]:
    style = Breaking()
    return [
        (k % 3 == 1, style.product([style.number(str(k), 0), style.name(("x", 0, (str(k),)))])) for k in range(count)
    ]


def test_long_sums_are_broken_and_nothing_is_lost() -> None:
    style = Breaking()
    inner = style.parentheses(style.sum(terms(90)))
    whole = style.sum([(False, style.product([inner, style.name(("y", 0, ()))])), *terms(5)])
    lines = style.lines(whole)
    assert len(lines) > 3 and all(width(line) <= WIDEST + 12 for line in lines)
    assert re.sub(r"<[^>]*>", "", "".join(lines)) == re.sub(r"<[^>]*>", "", whole)
    for line in lines:
        fromstring(f"<mrow>{line}</mrow>")
    short = style.sum(terms(3))
    assert style.lines(short) == [short]


@pytest.mark.parametrize("name", ["double_pendulum", "gripper", "screw_drive"])
def test_equations_fit_a_page(name: str) -> None:
    for equation in equations(system(name)):
        for line in equation.lines:
            fromstring(str(line))
            assert 'alttext="' in line
        assert equation.lines or equation.note
        assert equation.wide < 160


@pytest.mark.parametrize("name", ["spherical_pendulum", pytest.param("payload", marks=pytest.mark.slow)])
def test_every_link_of_a_page_leads_somewhere(name: str, tmp_path: Path) -> None:
    write_report(tmp_path / "page.html", load(ROOT / f"examples/{name}.scene.yaml"))
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    page = pages.read_html(text)
    links = {value for tag, attribute, value in page.attributes if (tag, attribute) == ("a", "href")}
    assert {link.removeprefix("#") for link in links} <= set(page.ids)
    assert page.wrong == [] and len(page.ids) == len(set(page.ids))
    numbers = re.findall(r'class="number"[^>]*>\(([\d.]+)\)', text)
    assert len(numbers) == len(set(numbers)) and {"3.1", "3.4", "3.7", "2"} <= set(numbers)


def test_the_plane_is_complex(tmp_path: Path) -> None:
    """In the plane M_n is not a Kronecker product with the unit matrix of space."""
    for name, planar in (("pendulum", True), ("free_body", False)):
        write_report(tmp_path / "page.html", load(ROOT / f"examples/{name}.scene.yaml"))
        text = (tmp_path / "page.html").read_text(encoding="utf-8")
        assert ("⊗ 1_3" in text) is not planar and ("In the plane the mass of body" in text) is planar


def text_of(name: str, folder: Path) -> str:
    write_report(folder / "page.html", load(ROOT / f"examples/{name}.scene.yaml"))
    return " ".join("".join(pages.read_html((folder / "page.html").read_text(encoding="utf-8")).text).split())


def test_joints_that_follow_others_are_counted(tmp_path: Path) -> None:
    """36 coordinates, 32 conditions of the tree and 2 couplings leave 2 degrees of freedom; the armature is in M."""
    of = system("gripper")
    assert of.natural.nn == 36 and of.natural.nc == 32
    text = text_of("gripper", tmp_path)
    assert "right = left, fold = 20·left − 0.2" in text and "2 conditions more beside (3.1)" in text
    assert "36 differential and 34 algebraic" in text and "in place of 70" in text
    formulas = {row: d.formula for output in of.outputs for row, d in function_words(output, of).rows}
    assert formulas["mass_matrix"] == "M = R^T M_n R + J_a" and formulas["bias_force"].endswith("+ b θ̇")
    assert "J_a" in formulas["kinetic_energy"]
    plain = system("double_pendulum")
    formulas = {row: d.formula for output in plain.outputs for row, d in function_words(output, plain).rows}
    assert formulas["mass_matrix"] == "M = R^T M_n R"


def test_letters_of_a_ball_joint_are_in_the_table() -> None:
    rows = {re.sub(r"<[^>]*>", "", row[0]): row[-1] for row in derivation.letters(system("spinning_top")).rows}
    assert "quaternion" in rows["q"] and "angle" not in rows["q"]
    assert "in the child’s axes" in rows["ωj"] and "rotation to ground axes" in rows["Aj"]
    assert "ωj" not in {re.sub(r"<[^>]*>", "", row[0]) for row in derivation.letters(system("gripper")).rows}


def test_in_the_plane_r_has_the_rows_of_the_function() -> None:
    """Two for each point, as in x and in the C, and no vectors that the page does not define."""
    of = system("double_pendulum")
    found = next(one for one in equations(of) if one.row == "velocity_transformation")
    rows = fromstring(str(found.lines[-1])).findall(f".//{MATH}mtable[@class='brackets']/{MATH}mtr")
    assert len(rows) == of.natural.nn == 4 and not re.search(r">[UDu]<", "".join(found.lines))
