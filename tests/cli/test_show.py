"""What ``symgen show`` prints: golden text for people, the same facts as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from symgen import cli, savings, show
from symgen.scene import restrictions
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


# -- couplings and restrictions ------------------------------------------------------------------------------------

ARM = """\
name: arm
bodies:
  - {name: upper, mass: 2, com: [0, 0, -0.5], inertia: [0.17, 0.17, 0.002, 0, 0, 0]}
  - {name: lower, mass: 1, com: [0, 0, -0.4], inertia: [0.06, 0.06, 0.001, 0, 0, 0]}
  - {name: hand, mass: 0.5, com: [0.1, 0, 0], inertia: [0.01, 0.01, 0.01, 0, 0, 0]}
joints:
  - {name: shoulder, type: revolute, parent: ground, child: upper, axis: [0, 1, 0]}
  - {name: elbow, type: revolute, parent: upper, child: lower, axis: [1, 0, 0], origin: {xyz: [0, 0, -1]}}
  - {name: wrist, type: revolute, parent: lower, child: hand, axis: [1, 0, 0], origin: {xyz: [0, 0, -1]}%s}
outputs: [mass_matrix, inverse_dynamics]
%s"""


def answer(text: str, folder: Path, capsys: pytest.CaptureFixture[str], *more: str) -> Any:
    path = folder / "arm.scene.yaml"
    path.write_text(text, encoding="utf-8")
    assert cli.run(["show", str(path), *more]) == 0
    out = capsys.readouterr().out
    return json.loads(out) if "--json" in more else out


def test_a_coupled_joint_shows_its_masters_coordinate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = ARM % (", mimic: {joint: elbow, multiplier: -2, offset: 0.5}", "")
    rows = {
        line.split()[1]: line.split("  ")[-2:] for line in answer(text, tmp_path, capsys).splitlines() if "→" in line
    }
    assert [cell.strip() for cell in rows["wrist"]] == ["-2·q1 + 0.5", "-2·v1"]
    couplings = [joint["coupling"] for joint in answer(text, tmp_path, capsys, "--json")["joints"]]
    assert couplings == [None, None, {"multiplier": -2.0, "offset": 0.5}]


def test_what_restrictions_save(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    free = answer(ARM % ("", ""), tmp_path, capsys, "--json")
    held = answer(ARM % ("", "lock: {elbow: 0.5}"), tmp_path, capsys, "--json")
    flops = [sum(row["flops"] for row in each["plans"] if row["chosen"]) for each in (free, held)]
    lock, constant = held["restrictions"]
    assert lock == {"restriction": "lock elbow = 0.5", "flops": flops[1], "without": flops[0],
                    "saved": flops[0] - flops[1], "why": None}  # fmt: skip
    assert flops[0] > flops[1]
    assert constant["restriction"] == "30 inertial parameters constant" and constant["saved"] > 0
    everything = ARM % ("", "parameters: ['*.mass', '*.com', '*.inertia']")
    assert answer(everything, tmp_path, capsys, "--json")["restrictions"] == []
    printed = answer(ARM % ("", "lock: {elbow: 0.5}"), tmp_path, capsys).splitlines()
    numbers = [str(n) for n in (flops[1], flops[0], flops[0] - flops[1])]
    assert ["lock", "elbow", "=", "0.5", *numbers] in [line.split() for line in printed]


def test_outputs_of_the_command_line_are_those_that_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = ARM % ("", "lock: {elbow: 0.5}")
    mass = answer(text, tmp_path, capsys, "--json", "--outputs", "mass_matrix")
    assert mass["restrictions"][0]["flops"] == next(row["flops"] for row in mass["plans"] if row["chosen"])


def test_what_is_too_large_is_not_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "arm.scene.yaml"
    path.write_text(ARM % ("", "lock: {elbow: 0.5}"))
    system = derive(load(path))
    monkeypatch.setattr(savings, "MAX_VELOCITIES", 2)
    first, second = savings.savings(system)
    assert (first.saved, first.why) == (None, "not counted: 3 velocities, more than 2")
    assert second.saved is not None
    monkeypatch.setattr(savings, "MAX_VELOCITIES", 1)
    assert {row.why for row in savings.savings(system)} == {"not counted: 2 velocities, more than 1"}
    monkeypatch.setattr(savings, "MAX_VELOCITIES", 40)
    monkeypatch.setattr(savings, "MAX_FLOPS", 10)
    assert all("flops as they are" in row.why for row in savings.savings(system))


def test_many_restrictions_are_counted_together(tmp_path: Path) -> None:
    n = restrictions.ONE_BY_ONE + 2
    links = "".join(f'<link name="b{k}"><inertial><mass value="1"/>{ROUND}</inertial></link>' for k in range(n + 1))
    turns = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="b{k}"/><child link="b{k + 1}"/></joint>' for k in range(n)
    )
    (tmp_path / "chain.urdf").write_text(f'<robot name="chain">{links}{turns}</robot>')
    locked = ", ".join(f"j{k}: 0" for k in range(1, n))
    path = tmp_path / "chain.scene.yaml"
    path.write_text(f"name: chain\nmodel: chain.urdf\nlock: {{{locked}}}\nremove: [b{n}]\noutputs: [mass_matrix]\n")
    labels = [row.label for row in restrictions.restrictions(load(path))]
    assert labels == [f"{n - 1} joints locked", f"remove b{n}", f"{10 * (n - 1)} inertial parameters constant"]


ROUND = '<inertia ixx="1" iyy="1" izz="1"/>'
