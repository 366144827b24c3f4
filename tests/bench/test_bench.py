"""The bench on a double pendulum: ours, one peer that agrees and one that does not."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symgen import cli, derive
from symgen.bench import BenchResult, Settings, bench, write_files
from symgen.bench.floor import Angles, angles_of, cost_of_angles, floor, fused, probe
from symgen.bench.measure import comparable
from symgen.bench.peers import registry
from symgen.bench.peers.adam import rpy, urdf
from symgen.bench.variant import OURS, Found, Problem, Unit, Variant, upper_to_full
from symgen.bench.workshop import CompileError, Workshop, open_workshop
from symgen.errors import SceneError
from symgen.program.instructions import Instruction, Port, Program
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request
from symgen.validation.mechanism import build_mechanism, rotation_about

PENDULUM = "examples/double_pendulum.scene.yaml"
needs_compiler = pytest.mark.skipif(not shutil.which("cc"), reason="needs a C compiler")
needs_valgrind = pytest.mark.skipif(not shutil.which("valgrind"), reason="needs valgrind")


def asked(path: str, outputs: str) -> Scene:
    return request(load(path), outputs=parse_outputs(outputs), targets=("c",))


def by_hand(right: bool) -> registry.Peer:
    """A peer that computes the double pendulum's mass matrix by hand: right, or with one wrong constant."""
    name, constant = ("right", 0.6) if right else ("wrong", 0.60001)
    text = (
        f"#include <math.h>\nvoid {name}_M(const double *q, double *M)\n{{\n"
        f"    M[0] = 1.31 + {constant} * cos(q[1]); M[1] = M[2] = 0.16 + 0.3 * cos(q[1]); M[3] = 0.16;\n}}\n"
    )

    def build(problem: Problem, workshop: Workshop) -> Found:
        variant = Variant(
            name, "mass_matrix", f"void {name}_M(const double *q, double *M);", f"{name}_M({{q}}, {{out}});",
            {"q": problem.column("q")}, 4, lambda flat, state: [flat], (Unit(name, text),), operations=4,
        )  # fmt: skip
        return Found([variant])

    return registry.Peer(name, "by hand", lambda: True, build)


@pytest.fixture
def peers(monkeypatch: pytest.MonkeyPatch) -> None:
    absent = registry.Peer("absent", "not here", lambda: False, lambda problem, workshop: Found())
    monkeypatch.setattr(registry, "PEERS", (by_hand(True), by_hand(False), absent))


@needs_compiler
@pytest.mark.usefixtures("peers")
def test_peers_are_compared_then_timed_or_left_out(tmp_path: Path) -> None:
    settings = Settings(None, states=8, rounds=3, folder=tmp_path, counting=False)
    result = bench(asked(PENDULUM, "mass_matrix"), settings)
    assert [row.peer for row in result.rows] == [OURS, "symgen batch", "symgen soa", "right"]
    assert all(0 < row.ns_min <= row.ns_median for row in result.rows)
    assert all(row.error < 1e-15 for row in result.rows)
    left = {row.peer: row.why for row in result.left}
    assert left.keys() == {"wrong", "absent"}
    assert left["wrong"].startswith("disagrees: ")
    assert "pip install" in left["absent"]
    assert json.loads(json.dumps(result.to_json()))["scene"] == "double_pendulum"
    lines = list(csv.DictReader(io.StringIO(result.to_csv())))
    assert [line["peer"] for line in lines] == [row.peer for row in result.rows]
    assert float(lines[-1]["ns_ratio"]) == pytest.approx(result.rows[-1].ns_min / result.rows[0].ns_min, rel=1e-4)
    assert "wrong mass_matrix: disagrees" in result.to_text()


@needs_compiler
@needs_valgrind
@pytest.mark.usefixtures("peers")
def test_instructions_repeat_and_stay_above_the_floor(tmp_path: Path) -> None:
    def run() -> BenchResult:
        settings = Settings(("right",), states=8, rounds=1, batches=False, folder=tmp_path)
        return bench(asked(PENDULUM, "mass_matrix"), settings)

    first, second = run(), run()
    counts = [row.instructions for row in first.rows]
    assert counts == [row.instructions for row in second.rows]
    own, floor_of_it = counts[0], first.functions[0].floor
    assert own is not None and floor_of_it is not None
    assert 10 < floor_of_it <= own < 300


def test_a_peer_of_an_unknown_name_is_bad_input(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SceneError, match="no peer 'nobody'"):
        registry.chosen(("nobody",))
    assert cli.run(["bench", PENDULUM, "--peers", "nobody"]) == 2
    assert cli.run(["bench", PENDULUM, "--variants", "some"]) == 2
    with pytest.raises(SceneError, match="no variants 'some'"):
        bench(load(PENDULUM), Settings((), variants="some"))
    assert cli.run(["bench", PENDULUM, "--ablation", "--peers", "nobody"]) == 2
    capsys.readouterr()


def test_a_peer_that_fails_is_said(tmp_path: Path) -> None:
    def explode(problem: Problem, workshop: Workshop) -> Found:
        raise RuntimeError("two\nlines")

    peer = registry.Peer("broken", "", lambda: True, explode)
    found = registry.build(peer, None, None)  # type: ignore[arg-type]
    assert [(row.peer, row.why) for row in found.left] == [("broken", "RuntimeError: two")]


@needs_compiler
def test_files_compile_once_and_failures_are_kept(tmp_path: Path) -> None:
    said: list[str] = []
    workshop = open_workshop(tmp_path, say=said.append)
    good, bad = Unit("good", "int good(void) { return 1; }\n"), Unit("bad", "int bad(void) { return x; }\n")
    assert workshop.compile(good, ("-O1",)) == workshop.compile(good, ("-O1",))
    assert workshop.compile(good, ("-O2",)).path != workshop.compile(good, ("-O1",)).path
    for _ in range(2):
        with pytest.raises(CompileError, match=r"does not compile: .*error"):
            workshop.compile(bad, ("-O1",))
    assert len(said) == 3


def test_floor_counts_reads_writes_and_arithmetic() -> None:
    """y = (a·b + c, a·b), z = c·a + b: one of the products has to be made, the other goes into its sum."""
    steps = (
        *(Instruction("input", value=("q", k)) for k in range(3)),
        Instruction("mul", (0, 1)),
        Instruction("add", (3, 2)),
        Instruction("mul", (2, 0)),
        Instruction("add", (5, 1)),
    )
    program = Program("f", (Port("q", (4,)),), (Port("y", (2,)), Port("z", (1,))), steps, ((4, 3), (6,)))
    assert fused(program) == 1
    assert floor(program, 10.0) == 3 + 3 + 4 - 1 + 10
    assert angles_of(program) == (0, False, False)
    for angles in (Angles(5, True, True), Angles(1, True, False), Angles(0, False, False)):
        again = probe(angles)
        assert angles_of(again) == angles
        assert floor(again, cost_of_angles(120.0, angles)) == 120.0


def test_what_peers_lack_is_taken_off_and_said() -> None:
    panda = load("examples/panda.scene.yaml")
    plain, notes = comparable(panda)
    assert any(joint.damping for joint in panda.joints)
    assert not any(joint.damping for joint in plain.joints)
    assert len(notes) == 1
    assert comparable(plain) == (plain, [])
    body, notes = comparable(load("examples/free_body.scene.yaml"))
    assert body.options.base_velocity == "body"
    assert notes


def test_upper_triangle() -> None:
    full = np.array([[1.0, 2, 3], [2, 4, 5], [3, 5, 6]])
    assert np.array_equal(upper_to_full(full[np.triu_indices(3)], 3), full.ravel())


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0, 0.8)])
@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, -np.pi / 2, 3.0])
def test_rpy(axis: tuple[float, ...], angle: float) -> None:
    R = rotation_about(np.array(axis), angle)
    x, y, z = np.eye(3)
    roll, pitch, yaw = rpy(R)
    assert np.allclose(rotation_about(z, yaw) @ rotation_about(y, pitch) @ rotation_about(x, roll), R, atol=1e-9)


def test_the_urdf_that_peers_get_is_the_scene(tmp_path: Path) -> None:
    """Read back by our own reader, the written URDF has the same operations' values: the mass matrix at one state."""
    scene = load("examples/ur5.scene.yaml")
    path = tmp_path / "scene.urdf"
    path.write_text(urdf(build_mechanism(scene)))
    ours, again = (derive(s).casadi("mass_matrix") for s in (scene, load(str(path))))
    q = np.linspace(-1, 1, 6)
    assert np.allclose(np.array(ours(q)), np.array(again(q)), rtol=0, atol=1e-9)


@needs_compiler
@pytest.mark.skipif(importlib.util.find_spec("mujoco") is None, reason="needs MuJoCo")
def test_mujoco_agrees_on_a_floating_base(tmp_path: Path) -> None:
    """Its velocities are other ones (mixed), which the bench has to turn."""
    scene = asked("examples/free_body.scene.yaml", "mass_matrix,bias_force,inverse_dynamics,forward_dynamics")
    settings = Settings(("mujoco",), states=6, rounds=2, batches=False, folder=tmp_path, counting=False)
    result = bench(scene, settings)
    assert [row.function for row in result.rows if row.peer == "mujoco"] == [
        "mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics",
    ]  # fmt: skip
    assert not result.left


@needs_compiler
@pytest.mark.skipif(importlib.util.find_spec("pinocchio") is None, reason="needs Pinocchio")
def test_the_model_that_pinocchio_gets() -> None:
    from symgen.bench.peers.pinocchio import model_text
    from symgen.validation.pinocchio_model import build_pinocchio

    text = model_text(build_pinocchio(load("examples/ur5.scene.yaml")))
    lines = [line.split() for line in text.splitlines()]
    assert lines[0] == ["6", "0.0", "0.0", "-9.81"]
    assert [line[0] for line in lines[1:]] == ["RZ", "RY", "RY", "RY", "RZ", "RY"]
    assert [int(line[1]) for line in lines[1:]] == [0, 1, 2, 3, 4, 5]
    assert all(len(line) == 2 + 3 + 3 * 3 + 2 * 9 for line in lines[1:])


@needs_compiler
def test_ablation_of_the_double_pendulum(tmp_path: Path) -> None:
    from symgen.bench import ablation

    found = ablation(asked(PENDULUM, "inverse_dynamics"), Settings(folder=tmp_path, states=1, counting=False))
    by_name = {row.switched_off: row for row in found.rows}
    assert found.passed
    assert by_name["as chosen"].flops < by_name["plain recursion"].flops
    assert "sine and cosine by libm" in by_name
    growth = found.growth("inverse_dynamics")
    assert growth is not None and growth <= 4
    worse = replace(found.rows[0], error=1.0)
    assert not replace(found, rows=(worse, *found.rows[1:])).passed
    assert re.search(r"plain recursion +\d+ +\+\d+ %", found.to_text())


@needs_compiler
@pytest.mark.usefixtures("peers")
def test_page_and_figures(tmp_path: Path) -> None:
    settings = Settings((), states=4, rounds=2, batches=False, folder=tmp_path, counting=False)
    result = bench(asked(PENDULUM, "mass_matrix"), settings)
    write_files(result, tmp_path / "b.csv", None, tmp_path / "b.html")
    page = (tmp_path / "b.html").read_text()
    assert page.lstrip().lower().startswith("<!doctype html>")
    assert "Time against error of mass_matrix" in page
    if importlib.util.find_spec("matplotlib"):
        write_files(result, plots=tmp_path / "figures")
        names = {path.name for path in (tmp_path / "figures").iterdir()}
        assert names >= {"double_pendulum-time.svg", "double_pendulum-time.png", "double_pendulum-error.svg"}
