"""What ``symgen show`` prints: golden text for people, the same facts as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest

from symgen import cli, show
from symgen.scene.load import load
from symgen.system import derive

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = Path(__file__).parent / "golden"


def example(name: str) -> str:
    return str(ROOT / f"examples/{name}.scene.yaml")


@pytest.mark.parametrize("name", ["fig1", "fig2", "four_bar", "universal_shaft", "screw_drive"])
def test_text(name: str, golden: Callable[[Path, str], None], capsys: pytest.CaptureFixture[str]) -> None:
    """Everything but the plan table, whose counts may improve any day."""
    assert cli.run(["show", example(name), "--outputs", "mass_matrix"]) == 0
    text = capsys.readouterr().out
    before, _, after = text.partition("Plans (● chosen)")
    notes = after[after.index("Notes") :] if "Notes" in after else ""
    golden(GOLDEN / f"{name}.txt", before + notes)


def test_json_says_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["show", example("fig2"), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["secondary_path_matrix"] == [
        [-1, 0, 0, 0, 0],
        [-2, -1, 0, 0, 0],
        [-3, -2, -1, 0, 0],
        [-4, -3, -2, -1, 0],
        [-2, 0, 0, 0, -1],
    ]
    assert (answer["nq"], answer["nv"]) == (11, 10)
    assert answer["nn"] == sum(e["rows"][1] for e in answer["natural_coordinates"] if e["rows"])
    assert answer["nn"] - answer["nc"] <= answer["nv"]
    chosen = [plan for plan in answer["plans"] if plan["chosen"]]
    assert len(chosen) == len({plan["function"] for plan in answer["plans"]})


def test_the_cheapest_plan_is_marked(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["show", example("ur5"), "--outputs", "mass_matrix", "--json"]) == 0
    plans = json.loads(capsys.readouterr().out)["plans"]
    flops = {plan["plan"]: plan["flops"] for plan in plans}
    assert len(flops) > 1
    assert flops[next(plan["plan"] for plan in plans if plan["chosen"])] == min(flops.values())
    assert all(plan["why"] for plan in plans)


def test_a_closed_loop_is_shown_and_not_generated(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert cli.run(["show", example("four_bar")]) == 0
    assert "closed loops are not there yet" in capsys.readouterr().out
    assert cli.run(["generate", example("four_bar"), "-o", str(tmp_path / "out")]) == 2
    captured = capsys.readouterr()
    assert "closed loops are not there yet" in captured.err
    assert captured.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_wide_path_matrices_are_left_to_json(tmp_path: Path) -> None:
    n = show.MAX_MATRIX + 1
    bodies = "".join(f"  - {{name: b{k}, mass: 1}}\n" for k in range(n))
    joints = "".join(
        f"  - {{name: j{k}, type: revolute, parent: {f'b{k - 1}' if k else 'ground'}, child: b{k}, axis: [1, 0, 0]}}\n"
        for k in range(n)
    )
    path = tmp_path / "chain.scene.yaml"
    path.write_text(f"name: chain\nbodies:\n{bodies}joints:\n{joints}outputs: [integrate]\n")
    tree = derive(load(path)).tree
    assert show.labelled_matrix(tree.path_matrix.tolist(), tree) == f"{n} × {n}, too wide to print: see --json"


@pytest.mark.parametrize(
    ("value", "text"),
    [("0.5", "0.5"), ("2/3", "2/3"), ("1/101", "≈0.00990099"), ("-9.81", "-9.81"), ("123456789", "≈1.23457e+08")],
)
def test_numbers_for_reading(value: str, text: str) -> None:
    assert show.number(Fraction(value)) == text


def test_table_aligns_combining_and_wide_characters() -> None:
    assert show.table(("a", "b"), [("x\u0307", 1), ("日", 22)], right=(1,)).splitlines()[2:] == [
        "x\u0307    1",
        "日  22",
    ]


@pytest.mark.parametrize(
    ("wrong", "said"), [("Q", "unknown equation 'Q'; known: x, Mn, "), ("mass_matri", "did you mean 'mass_matrix'?")]
)
def test_an_unknown_equation_names_the_known(wrong: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["show", example("pendulum"), "--equations", wrong]) == 2
    assert said in capsys.readouterr().err


def test_a_system_derives_from_a_file_and_is_shown_in_a_line() -> None:
    system = derive(example("cart_pole"))
    assert repr(system) == "<System cart_pole: 2 moving bodies, nq = 2, nv = 2, nn = 6, nc = 4>"


def test_one_constraint_is_singular(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["show", example("pendulum")]) == 0
    assert capsys.readouterr().out.startswith(
        "pendulum: 1 moving body, nq = 1, nv = 1, nn = 2 natural coordinates (planar), nc = 1 constraint\n"
    )
