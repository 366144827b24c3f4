"""Our functions in other forms: which there are, that their names do not clash, that all give the same numbers."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from symgen.bench import Settings, bench, speed_data
from symgen.bench.measure import pose
from symgen.bench.peers import forms, ours
from symgen.bench.variant import OURS, Found, Problem
from symgen.errors import NotSupportedError
from symgen.scene.load import load
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request

PENDULUM = "examples/double_pendulum.scene.yaml"
needs_compiler = pytest.mark.skipif(not shutil.which("cc"), reason="needs a C compiler")


def posed(folder: Path, outputs: str, precision: str = "double") -> tuple[Problem, Found]:
    scene = request(load(PENDULUM), outputs=parse_outputs(outputs), targets=("c",), precision=precision)
    problem = pose(scene, Settings(states=4), folder)[0]
    return problem, ours.build(problem, batches=True)


def test_the_forms_of_a_function(tmp_path: Path) -> None:
    problem, found = posed(tmp_path, "mass_matrix,kinetic_energy")
    more = forms.build(problem, found, "standard")
    names = [variant.peer for variant in more.variants]
    assert {variant.function for variant in more.variants} == {"mass_matrix"}  # the other is none of the main ones
    assert names[:6] == [
        "symgen libm", "symgen float", "symgen float batch", "symgen float soa", "symgen float libm", "symgen loops",
    ]  # fmt: skip
    assert "symgen plan: composite, inertia as given" in names
    assert "symgen plan: literal" in names
    assert "symgen plan: composite" not in names  # that is the chosen one
    assert names[-1] == "symgen unfused"
    assert len(set(names)) == len(names)
    declared = [variant.declaration for variant in (*found.variants, *more.variants)]
    assert len(set(declared)) == len(declared)
    assert {variant.real for variant in more.variants if "float" in variant.peer} == {"float"}
    assert all(variant.own for variant in more.variants)
    assert not more.left


def test_all_forms_are_more(tmp_path: Path) -> None:
    problem, found = posed(tmp_path, "mass_matrix,kinetic_energy")
    more = forms.build(problem, found, "all")
    assert {variant.function for variant in more.variants} == {"mass_matrix", "kinetic_energy"}
    assert {"symgen libm soa", "symgen float plan: literal"} <= {variant.peer for variant in more.variants}
    assert [left.peer for left in more.left] == ["symgen loops"]  # of the kinetic energy


def test_functions_of_frames_keep_their_names(tmp_path: Path) -> None:
    problem, found = posed(tmp_path, "frame_pose:tip")
    found.variants += forms.build(problem, found, "all").variants
    assert {variant.function for variant in found.variants} == {"frame_pose:tip"}
    assert {"symgen", "symgen batch", "symgen soa", "symgen float"} <= {variant.peer for variant in found.variants}


def test_a_scene_in_float_is_measured_in_double_too(tmp_path: Path) -> None:
    problem, found = posed(tmp_path, "mass_matrix", "float")
    assert {variant.real for variant in found.variants} == {"float"}
    more = {variant.peer: variant.real for variant in forms.build(problem, found, "standard").variants}
    assert more["symgen double"] == "double"
    assert more["symgen libm"] == "float"


@needs_compiler
@pytest.mark.slow
def test_forms_agree_and_are_measured(tmp_path: Path) -> None:
    scene = request(load(PENDULUM), outputs=parse_outputs("forward_dynamics"), targets=("c",))
    settings = Settings((), states=8, rounds=2, variants="standard", folder=tmp_path, counting=False)
    result = bench(scene, settings)
    assert not result.left
    rows = {row.peer: row for row in result.rows}
    assert OURS in rows
    for name, row in rows.items():
        coarse = row.precision == "float"
        assert ("float" in name) == coarse
        assert 0 <= row.error_median <= row.error < (1e-5 if coarse else 1e-13), name
        assert row.units is None or row.units < 100
    assert (
        rows["symgen unfused"].error != rows[OURS].error or rows["symgen unfused"].text_bytes != rows[OURS].text_bytes
    )
    assert {row.peer for row, _, _ in result.frontier("forward_dynamics")} <= rows.keys()


@needs_compiler
def test_a_float_that_is_wrong_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symgen.bench.measure.FLOAT_TOLERANCE", 1e-12)
    monkeypatch.setattr(forms, "ways", lambda *_: iter([forms.Way("float", "float", forms.Form("float"))]))
    monkeypatch.setattr(forms, "compilers", lambda: ())
    scene = request(load(PENDULUM), outputs=parse_outputs("mass_matrix"), targets=("c",))
    settings = Settings((), states=4, rounds=1, batches=False, variants="standard", folder=tmp_path, counting=False)
    result = bench(scene, settings)
    assert [row.peer for row in result.rows] == [OURS]
    assert result.left[0].why.startswith("disagrees: ")


@needs_compiler
def test_data_of_the_section(tmp_path: Path) -> None:
    said: list[str] = []
    data = speed_data(
        load(PENDULUM), said.append, peers=(), variants="none", functions=("mass_matrix",), states=4, rounds=1,
        folder=tmp_path,
    )  # fmt: skip
    assert [facts["function"] for facts in data["functions"]] == ["mass_matrix"]
    assert data["frontier"]["mass_matrix"]
    assert "timing" in said


def test_closed_loops_have_no_data() -> None:
    with pytest.raises(NotSupportedError, match="closed loops"):
        speed_data(load("examples/four_bar.scene.yaml"), lambda _: None)
