"""Motions: solvers against closed forms and one another, monitors, dense output, files, and bad arguments."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

import symgen
from symgen.cli import run
from symgen.errors import SceneError, ToolError
from symgen.simulate import METHODS, Model, exact
from symgen.simulate.answers import Answer
from symgen.simulate.benchmark_systems import oscillators
from symgen.simulate.benchmarks import free_body, pendulum_scene
from tests.simulate.steps import ball

pytest.importorskip("scipy")
STEPS = ("rk4", "lie", "implicit_midpoint", "semi_implicit_euler", "variational")


@pytest.fixture(scope="module")
def pendulum() -> Model:
    return Model(pendulum_scene(), STEPS)


@pytest.fixture(scope="module")
def turning() -> Model:
    return Model(ball(), ("lie",))


TOLERANCES = {"semi_implicit_euler": 1e-2, "implicit_midpoint": 1e-5, "variational": 1e-5, "RK23": 1e-5, "BDF": 1e-5}


@pytest.mark.parametrize("method", METHODS)
def test_every_method_follows_the_pendulum(pendulum: Model, method: str) -> None:
    how = {"dt": 1e-3} if method in STEPS else {}
    motion = symgen.simulate(pendulum, [1.5], [0.0], 2.0, method=method, **how)
    right = np.array([exact.pendulum(float(t), 9.81, 1.0, 1.5) for t in motion.t[::20]])
    tolerance = TOLERANCES.get(method, 1e-7)
    assert np.abs(motion.q[::20, 0] - right[:, 0]).max() < tolerance
    assert np.abs(motion.v[::20, 0] - right[:, 1]).max() < 10 * tolerance
    assert motion.monitors.energy_drift < 10 * tolerance
    assert motion.method == method and motion.steps > 10 and motion.t[-1] == 2.0


@pytest.mark.parametrize("how", [{"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}, {"method": "lie", "dt": 1e-3}])
def test_between_the_states_kept(turning: Model, how: dict[str, object]) -> None:
    start = [0, 0, 0, 0.1, 0.2, 0.3, 0.9, 0.0, 0.5, 0.0, 0.5], np.linspace(-1, 1, 9)
    coarse = symgen.simulate(turning, *start, 1.0, samples=51, **how)  # type: ignore[arg-type]
    fine = symgen.simulate(turning, *start, 1.0, samples=1001, **how)  # type: ignore[arg-type]
    q, v = coarse.at(fine.t)
    assert np.abs(q - fine.q).max() < 1e-6 and np.abs(v - fine.v).max() < 1e-5
    assert np.allclose(coarse.at(0.5)[0], fine.at(0.5)[0], atol=1e-6) and coarse.at(0.5)[1].shape == (9,)
    for motion in (coarse, fine):
        assert np.allclose(np.linalg.norm(motion.q[:, 3:7], axis=1), 1.0, atol=1e-15)
        assert motion.monitors.quaternion_drift < 1e-9 > motion.monitors.energy_drift
    with pytest.raises(ValueError, match="from t = 0 to 1"):
        coarse.at(1.5)


def test_forces_as_constants_and_as_a_function(pendulum: Model) -> None:
    """A torque that balances gravity holds the pendulum; a feedback that is held over each step converges with it."""
    held = symgen.simulate(pendulum, [0.5], None, 1.0, tau=[9.81 * np.sin(0.5)])
    assert np.abs(held.q - 0.5).max() < 1e-9

    def damper(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return -2.0 * v

    smooth = symgen.simulate(pendulum, [0.5], None, 1.0, tau=damper)
    errors = []
    for dt in (2e-3, 1e-3):
        stepped = symgen.simulate(pendulum, [0.5], None, 1.0, tau=damper, method="rk4", dt=dt)
        errors.append(abs(stepped.q[-1, 0] - smooth.q[-1, 0]))
    assert errors[1] < 0.6 * errors[0] < 1e-3
    assert smooth.energy[-1] < smooth.energy[0] - 0.1


def test_samples_and_progress(pendulum: Model) -> None:
    motion = symgen.simulate(pendulum, [1.0], None, 1.0, samples=[0.25, 0.5])
    assert motion.t.tolist() == [0.25, 0.5] and motion.q.shape == (2, 1)
    told: list[tuple[int, int, str]] = []
    motion = symgen.simulate(
        pendulum, [1.0], None, 3.0, method="rk4", dt=1e-5, samples=4, progress=lambda *x: told.append(x)
    )
    assert np.allclose(motion.t, [0, 1, 2, 3]) and motion.steps == 300_000
    assert len(told) >= 3 and told[-1][:2] == (300_000, 300_000)
    symgen.simulate(pendulum, [1.0], None, 3.0, progress=lambda *x: told.append(x))
    assert told[-1][:2] == (1000, 1000)


def test_a_step_that_does_not_divide_the_time_is_shortened(pendulum: Model) -> None:
    motion = symgen.simulate(pendulum, [1.0], None, 1.0, method="rk4", dt=0.3)
    assert motion.steps == 4 and motion.t.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "rk5"}, "did you mean 'RK45'"),
        ({"method": "rk4"}, "needs a positive dt"),
        ({"method": "rk4", "dt": -1.0}, "needs a positive dt"),
        ({"dt": 0.1}, "chooses its steps"),
        ({"t_end": 0.0}, "must be positive"),
        ({"t_end": float("nan")}, "must be positive"),
        ({"q0": [1.0, 2.0]}, "one finite number is needed, not 2"),
        ({"q0": [float("inf")]}, "the one at 0 is inf"),
        ({"p": [1.0]}, "has its parameters already"),
        ({"rtol": 0.0}, "tolerance must be positive"),
        ({"atol": float("nan")}, "tolerance must be positive"),
        ({"tau": [1.0, 2.0]}, "one finite force is needed, not 2"),
        ({"tau": lambda t, q, v: [1.0, 2.0]}, "must return 1 forces"),
        ({"samples": [0.5, 0.2]}, "must rise"),
        ({"samples": [0.5], "method": "rk4", "dt": 0.1}, "give their number"),
    ],
)
def test_bad_arguments(pendulum: Model, arguments: dict[str, object], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        symgen.simulate(pendulum, **arguments)  # type: ignore[arg-type]


def test_a_zero_quaternion_and_an_unknown_step(turning: Model) -> None:
    with pytest.raises(SceneError, match="quaternion at q\\[3\\] is zero"):
        turning.start([0.0] * 11, None)
    with pytest.raises(SceneError, match="no step method"):
        Model(pendulum_scene(), ("rk5",))
    assert np.isclose(np.linalg.norm(turning.start([0, 0, 0, 3, 0, 0, 4, 0, 0, 0, 2], None)[3:7]), 1.0)


def test_a_motion_that_leaves_the_numbers_ends_in_one_line(pendulum: Model) -> None:
    with pytest.raises(ToolError, match="rk4 with dt = 1e\\+300"):
        symgen.simulate(pendulum, [1.0], [1e300], 1e301, method="rk4", dt=1e300)


def test_files(pendulum: Model, tmp_path: Path) -> None:
    motion = symgen.simulate(pendulum, [1.0], None, 1.0, samples=11)
    rows = list(csv.reader(io.StringIO(motion.to_csv(tmp_path / "m.csv"))))
    assert rows[0] == ["t", "q.hinge", "v.hinge", "kinetic", "potential"]
    assert np.array_equal(np.array(rows[1:], dtype=float), motion.table())
    assert (tmp_path / "m.csv").read_text(encoding="utf-8") == motion.to_csv()
    motion.write(tmp_path / "m.json")
    found = json.loads((tmp_path / "m.json").read_text(encoding="utf-8"))
    assert found["columns"] == rows[0] and np.array_equal(np.array(found["rows"]), motion.table())


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "m.csv"
    arguments = ["simulate", "examples/pendulum.scene.yaml", "--time", "1", "--q", "1", "--samples", "5"]
    assert run([*arguments, "-o", str(file)]) == 0
    assert "drift" in capsys.readouterr().out
    assert len(file.read_text(encoding="utf-8").splitlines()) == 6
    assert run([*arguments, "--method", "rk4", "--dt", "0.25", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["rows"]) == 5
    for wrong, message in (
        (["--method", "x"], "no method"),
        (["--q", "a"], "not numbers"),
        (["--q", "1,2"], "--q: one finite number is needed, not 2"),
        (["--time", "-1"], "--time: the time must be positive"),
        (["--method", "lie"], "--dt: lie needs"),
    ):
        assert run([*arguments, *wrong]) == 2
        captured = capsys.readouterr()
        assert message in captured.err and len(captured.err.splitlines()) == 1


def test_closed_forms_satisfy_their_equations() -> None:
    """Not only the compiled code is compared with them: their own derivatives are what the equations say."""
    h, t = 1e-4, 0.7
    angle = [exact.pendulum(t + k * h, 9.81, 1.0, 1.5)[0] for k in (-1, 0, 1)]
    assert abs((angle[0] - 2 * angle[1] + angle[2]) / h**2 + 9.81 * np.sin(angle[1])) < 1e-5
    assert abs((angle[2] - angle[0]) / (2 * h) - exact.pendulum(t, 9.81, 1.0, 1.5)[1]) < 1e-6
    moments, start = (1.0, 2.0, 3.0), (0.6, 0.1, -1.0)
    assert np.allclose(exact.free_body(0.0, moments, start), start, atol=1e-15)
    w = [np.array(exact.free_body(t + k * h, moments, start)) for k in (-1, 0, 1)]
    momentum = np.array(moments) * w[1]
    assert np.allclose(np.array(moments) * (w[2] - w[0]) / (2 * h), np.cross(momentum, w[1]), atol=1e-7)
    z = [exact.sleeping_top(t + k * h, 0.0056, 0.1, 0.5, 1e-3) for k in (-1, 0, 1)]
    rest = 0.0056 * (z[0] - 2 * z[1] + z[2]) / h**2 - 0.1j * (z[2] - z[0]) / (2 * h) - 0.5 * z[1]
    assert abs(rest) < 1e-8 and exact.sleeping_top(0.0, 0.0056, 0.1, 0.5, 1e-3) == pytest.approx(1e-3)
    x = [exact.oscillator(t + k * h, 5.0, 0.1, 0.3) for k in (-1, 0, 1)]
    assert abs((x[0] - 2 * x[1] + x[2]) / h**2 + 0.2 * (x[2] - x[0]) / (2 * h) + 25 * x[1]) < 1e-5


@pytest.mark.parametrize("problem", [oscillators, free_body])
def test_benchmark_problems(problem: object) -> None:
    found: list[Answer] = list(problem())  # type: ignore[operator]
    assert len(found) >= 2 and all(row.passed for row in found), found


@pytest.mark.slow
def test_all_benchmark_problems(capsys: pytest.CaptureFixture[str]) -> None:
    from symgen.validation.benchmarks import main

    assert main([]) == 0, capsys.readouterr().out


def test_an_answer_above_its_bar_fails() -> None:
    row = Answer("p", "q", "m", 2.0, 1.0, "x", 0.0, 0.0)
    assert not row.passed and not Answer("p", "q", "m", float("nan"), 1.0, "x", 0.0, 0.0).passed


def test_an_unknown_problem_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    from symgen.validation.benchmarks import main

    assert main(["oscilators"]) == 2 and main(["nosuch"]) == 2
    captured = capsys.readouterr()
    first, second = captured.err.splitlines()
    assert captured.out == "" and "did you mean 'oscillators'" in first and "no problem 'nosuch'" in second


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        (["--q", "nan,0"], "--q: numbers must be finite, and the one at 0 is nan"),
        (["--q", "2"], "--q: 2 finite numbers are needed, not 1"),
        (["--tau", "1,2,3"], "--tau: 2 finite forces are needed, not 3"),
        (["-o", "motion.txt"], "motion.txt: is neither .csv nor .json"),
        (["-o", "motion"], "motion: is neither .csv nor .json"),
    ],
)
def test_wrong_settings_are_one_line_that_says_why(
    flags: list[str], told: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Path("examples/double_pendulum.scene.yaml").resolve()
    monkeypatch.chdir(tmp_path)
    assert run(["simulate", str(scene), *flags]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(f"symgen: {told}") and captured.err.count("\n") == 1
    assert captured.out == "" and list(tmp_path.iterdir()) == []


def test_folders_of_a_motion_are_made(tmp_path: Path) -> None:
    motion = symgen.simulate("examples/double_pendulum.scene.yaml", t_end=0.01, samples=2)
    motion.write(tmp_path / "new" / "m.CSV")
    assert (tmp_path / "new" / "m.CSV").read_text(encoding="utf-8") == motion.to_csv()
    with pytest.raises(SceneError, match="neither"):
        motion.write(tmp_path / "m.txt")
