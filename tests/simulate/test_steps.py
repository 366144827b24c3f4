"""Steps: their orders, what they keep, their forms, and that their certificates can fail."""

from __future__ import annotations

import json
import re
import subprocess
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import casadi
import numpy as np
import pytest

from symgen.algebra.linear import mul
from symgen.certificate import Certifier
from symgen.errors import CertificateError, NotSupportedError, SceneError
from symgen.generate import generate_files, target_info
from symgen.integrators import methods, plan
from symgen.integrators.casadi import casadi_step, read_step
from symgen.integrators.certify import certify_step
from symgen.program.composed import ComposedProgram
from symgen.scene.model import Scene
from symgen.scene.outputs import STEPS, parse_outputs
from symgen.scene.request import request
from symgen.system import System, derive
from symgen.targets.c import emit_c, read_back
from tests.simulate.steps import ORDERS, asked, ball, motion, state, stepping


def test_the_catalogue_names_the_methods() -> None:
    assert tuple(methods.METHODS) == STEPS and set(ORDERS) == set(STEPS)


@pytest.mark.parametrize(
    "scene",
    [
        "double_pendulum",
        ball("world"),
        "gripper",
        pytest.param(ball("body"), marks=pytest.mark.slow),
        pytest.param(ball("mixed"), marks=pytest.mark.slow),
        pytest.param("payload", marks=pytest.mark.slow),
    ],
)
def test_orders(scene: Scene | str, tmp_path: Path) -> None:
    artifact = stepping(scene, tmp_path / "code", targets=("c",))
    f, start, end = artifact.load(), state(artifact.manifest), 0.125
    right = motion(f.step_rk4, start, end, 2048)
    for method, order in ORDERS.items():
        counts = (16, 32, 64) if order == 4 else (128, 256, 512)
        errors = [np.abs(motion(getattr(f, f"step_{method}"), start, end, n) - right).max() for n in counts]
        observed = [np.log2(coarse / fine) for coarse, fine in pairwise(errors)]
        assert abs(observed[-1] - order) < 0.35, (method, errors)


def test_the_lie_step_is_exact_where_runge_kutta_on_coordinates_is_not(tmp_path: Path) -> None:
    """A symmetric body turns steadily: the exponential is the motion."""
    from symgen.scene.builder import SceneBuilder

    scene = SceneBuilder("ball", gravity=(0, 0, 0)).body("ball", mass=1, inertia=(1, 1, 1, 0, 0, 0))
    artifact = stepping(scene.joint("j", "spherical", "ground", "ball").build(), tmp_path / "code", "rk4", "lie")
    f, omega, end = artifact.load(), np.array([0.8, -0.5, 1.1]), 2.0
    angle = 0.5 * end * np.linalg.norm(omega)
    right = np.append(np.sin(angle) * omega / np.linalg.norm(omega), np.cos(angle))
    start = (np.array([0.0, 0.0, 0.0, 1.0]), omega, np.zeros(3))
    assert np.abs(motion(f.step_lie, start, end, 4)[:4] - right).max() < 1e-14
    assert np.abs(motion(f.step_rk4, start, end, 4)[:4] - right).max() > 1e-6


def test_implicit_midpoint_keeps_energy_bounded_and_is_symmetric(tmp_path: Path) -> None:
    scene = asked("double_pendulum", "step:implicit_midpoint", "step:rk4", "kinetic_energy", "potential_energy")
    from symgen.generate import generate

    f = generate(scene, tmp_path / "code").load()
    tau = np.zeros(2)

    def drift(step: str, steps: int) -> list[float]:
        q, v, found = np.array([0.9, 0.4]), np.zeros(2), []
        first = f.potential_energy(q)
        for k in range(steps):
            q, v = getattr(f, step)(q, v, tau, 0.02)
            if k % 50 == 0:
                found.append(abs(float(f.kinetic_energy(q, v) + f.potential_energy(q) - first)))
        return found

    energies = drift("step_implicit_midpoint", 10_000)
    assert max(energies[-40:]) < 1.5 * max(energies[:40]) < 0.05
    assert drift("step_rk4", 10_000)[-1] > 20 * drift("step_rk4", 500)[-1]  # it leaks steadily
    q, v = np.array([0.9, 0.4]), np.array([0.3, -1.0])
    there = f.step_implicit_midpoint(q, v, tau, 0.01)
    back = f.step_implicit_midpoint(*there, tau, -0.01)
    assert np.abs(back[0] - q).max() < 1e-13 and np.abs(back[1] - v).max() < 1e-12


def test_implicit_midpoint_takes_stiff_springs_in_long_steps(tmp_path: Path) -> None:
    from symgen.scene.builder import SceneBuilder

    scene = SceneBuilder("stiff", gravity=(0, 0, 0)).body("mass", mass=1)
    scene.joint("slide", "prismatic", "ground", "mass", axis=(1, 0, 0), damping=1000).joint_spring(
        "slide", stiffness=1e6
    )
    f = stepping(scene.build(), tmp_path / "code", "implicit_midpoint", "rk4").load()
    start = (np.array([0.01]), np.zeros(1), np.array([1e4]))
    assert abs(motion(f.step_implicit_midpoint, start, 1.0, 200)[0] - 0.01) < 1e-6
    with np.errstate(all="ignore"):
        assert not abs(motion(f.step_rk4, (start[0] * 1.1, *start[1:]), 1.0, 200)[0]) < 1e3


@pytest.mark.parametrize("options", [{}, {"status": True, "batch": True}, {"precision": "float"}, {"code": "loops"}])
def test_forms_agree_and_compile_without_warning(options: dict[str, object], tmp_path: Path) -> None:
    """C of one state and of many, CasADi; a step is called in a program that a strict compiler takes."""
    artifact = stepping("double_pendulum", tmp_path / "code", targets=("c", "casadi"), **options)
    f, (q, v, tau) = artifact.load(), state(artifact.manifest)
    flags = [
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Wconversion",
        "-Wshadow",
        "-Werror",
        "-O1",
        "-c",
        "-o",
        "/dev/null",
    ]
    subprocess.run(["gcc", *flags, str(tmp_path / "code" / "double_pendulum.c")], check=True)
    tolerance = 1e-4 if options.get("precision") == "float" else 1e-12
    for method in STEPS:
        one = f.__getattr__(f"step_{method}")(q, v, tau, 0.01)
        many = f.__getattr__(f"step_{method}")(np.array([q] * 5), np.array([v] * 5), np.array([tau] * 5), 0.01)
        file = next(row["casadi_file"] for row in artifact.manifest["functions"] if row["name"] == f"step_{method}")
        other = casadi.Function.load(str(tmp_path / "code" / file))(q, v, tau, 0.01)
        for single, rows, symbolic in zip(one, many, other, strict=True):
            assert np.abs(rows - single).max() <= tolerance
            assert np.abs(np.array(symbolic).ravel() - single).max() <= tolerance


def test_parameters_reach_what_is_called(tmp_path: Path) -> None:
    from symgen.scene.builder import SceneBuilder

    scene = SceneBuilder("p").body("a", mass=1, com=(0, 0, -1), inertia=(1, 1, 1, 0, 0, 0))
    scene.joint("j", "spherical", "ground", "a").parameters("a.mass", "gravity")
    artifact = stepping(scene.build(), tmp_path / "code")
    f, (q, v, tau) = artifact.load(), state(artifact.manifest)
    for method in STEPS:
        step = f.__getattr__(f"step_{method}")
        light, heavy = (step(q, v, tau, 0.1, p=[mass, 0, 0, -9.81])[1] for mass in (1.0, 50.0))
        assert np.abs(light - heavy).max() > 1e-3
        assert np.array_equal(step(q, v, tau, 0.1)[1], light)


def test_called_functions_are_emitted_too_and_the_manifest_says_so(tmp_path: Path) -> None:
    artifact = stepping("spinning_top", tmp_path / "code", "lie")
    rows = {row["name"]: row for row in artifact.manifest["functions"]}
    assert list(rows) == ["step_lie", "forward_dynamics", "integrate"]
    assert "calls of forward_dynamics, integrate" in rows["step_lie"]["certificate"]["method"]
    assert "(C, CasADi)" in rows["step_lie"]["certificate"]["method"]
    calls = rows["step_lie"]["operations"]["mul"], rows["forward_dynamics"]["operations"]["mul"]
    assert calls[0] > 4 * calls[1]
    assert json.dumps(artifact.manifest)


def test_status_is_passed_on(tmp_path: Path) -> None:
    """The function returns an int, and NaN goes through."""
    artifact = stepping("double_pendulum", tmp_path / "code", "rk4", status=True)
    header = (tmp_path / "code" / "double_pendulum.h").read_text(encoding="utf-8")
    source = (tmp_path / "code" / "double_pendulum.c").read_text(encoding="utf-8")
    assert re.search(r"int double_pendulum_step_rk4\(", header)
    assert source.count("status |= double_pendulum_forward_dynamics(") == 4
    f = artifact.load()
    q, v = f.step_rk4(np.array([np.nan, 0.0]), np.zeros(2), np.zeros(2), 0.1)
    assert np.all(np.isnan(q)) and np.all(np.isnan(v))


# --- certificates ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def top() -> System:
    return derive(asked("spinning_top", *(f"step:{name}" for name in STEPS)))


def certified(system: System, change: tuple[str, str] | None = None) -> None:
    """Emit, change the text once, read back and certify every step."""
    codes = {output.name: system.code(output.name) for output in system.outputs}
    emitted = emit_c(system.scene.name, [code.program for code in codes.values()], target_info(system))
    if change is not None:
        text = emitted.files["spinning_top.c"]
        changed = re.sub(change[0], change[1], text, count=1)
        assert changed != text, change
        emitted = replace(emitted, files={**emitted.files, "spinning_top.c": changed})
    read, certifier = read_back(emitted), Certifier(system, "seed")
    straight = {code.program.name: code.straight for code in codes.values()}
    for name, code in codes.items():
        if isinstance(code.program, ComposedProgram):
            certify_step(certifier, system.output(name), code.program, read.functions, straight, None)


def test_what_is_emitted_is_accepted(top: System) -> None:
    certified(top)


CALL = r"spinning_top_forward_dynamics\(q3, v3, tau, a3\);"


@pytest.mark.parametrize(
    "change",
    [
        (CALL, "spinning_top_forward_dynamics(q2, v3, tau, a3);"),
        (CALL, "spinning_top_forward_dynamics(q3, v3, v3, a3);"),
        (CALL, "spinning_top_forward_dynamics(q3, v3, tau, a2);"),
        (CALL, "spinning_top_forward_dynamics(q4, v3, tau, a3);"),
        (CALL, "spinning_top_forward_dynamics(q3, v3, tau);"),
        (CALL, "spinning_top_integrate(q3, v3, dt, a3);"),
        (CALL, "q3[0] = 0.0;"),
        (CALL, ""),
        (CALL, "spinning_top_step_rk4_stage3(q3, v3, tau, a3);"),
        (r"double q3\[4\];", "double q3[5];"),
        (r"double q3\[4\];", "float q3[4];"),
        (r"double q3\[4\];", ""),
        (r"0\.5 \* dt", "0.25 * dt"),
        (r"integrate\(q, v_next, dt, q_next\)", "integrate(q, v, dt, q_next)"),
        (r"(step_implicit_midpoint_correct\(J, f2, tau, )a2", r"\1a1"),
        (r"(step_variational_correct\(J, )P2, P_rate2", r"\1P_rate2, P2"),
        (r"(step_variational_solve\(M_next, )P_next", r"\1P0"),
        (r"0\.25 \* dt", "0.5 * dt"),
    ],
)
def test_changed_steps_are_refused(top: System, change: tuple[str, str]) -> None:
    with pytest.raises(CertificateError):
        certified(top, change)


def test_a_wrong_pattern_of_zeros_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The definition solves with all entries: what is left out because branches do not meet is checked."""
    from symgen.integrators import geometry

    true = geometry.related
    wrong = lambda place: [[i == j for j in range(len(row))] for i, row in enumerate(true(place))]  # noqa: E731
    monkeypatch.setattr(geometry, "related", lambda place: wrong(place) if place.sparse else true(place))
    with pytest.raises(CertificateError, match="implicit_midpoint"):
        generate_files(derive(asked("double_pendulum", "step:implicit_midpoint")), lambda done, total, what: None)


def test_a_casadi_step_that_calls_otherwise_is_refused(top: System) -> None:
    code = top.code("step:rk4").program
    assert isinstance(code, ComposedProgram)
    callees = {row: top.program(row) for row in code.callees}
    calls = list(code.calls)
    second = next(k for k, call in enumerate(calls) if call.function == "forward_dynamics" and k > 0)
    calls[second] = replace(calls[second], inputs={**calls[second].inputs, "v": "v"})
    wrong = casadi_step(replace(code, calls=tuple(calls)), callees)
    straight = {name: top.code(name).straight for name in callees}
    right = casadi_step(code, callees)
    certify_step(Certifier(top, "s"), top.output("step:rk4"), code, {}, straight, right)
    with pytest.raises(CertificateError, match="CasADi"):
        certify_step(Certifier(top, "s"), top.output("step:rk4"), code, {}, straight, wrong)
    with pytest.raises(CertificateError, match="other things than calling"):
        x = casadi.MX.sym("q", 4)
        inputs = [x, casadi.MX.sym("v", 3), casadi.MX.sym("tau", 3), casadi.MX.sym("dt")]
        other = casadi.Function("step_rk4", inputs, [2 * x, inputs[1]], ["q", "v", "tau", "dt"], ["q_next", "v_next"])
        read_step(other, code, callees)


def test_an_update_that_is_derived_wrongly_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A plan whose update is not the method's."""
    build = plan._Maker.program

    def wrong(self: plan._Maker, update: plan.Update) -> object:
        if update.name != "finish":
            return build(self, update)
        changed = replace(update, function=lambda place, x: tuple(
            tuple(mul(2, y) for y in row) for row in update.function(place, x)
        ))  # fmt: skip
        return build(self, changed)

    monkeypatch.setattr(plan._Maker, "program", wrong)
    with pytest.raises(CertificateError, match="step:rk4"):
        generate_files(derive(asked("double_pendulum", "step:rk4")), lambda done, total, what: None)


# --- what cannot be asked for ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        ("step", "step needs a method"),
        ("step:rk5", "did you mean 'rk4'"),
        ("a=step:rk4+mass_matrix", "a function of its own"),
        ("jvp:step:rk4", "not available"),
    ],
)
def test_what_cannot_be_asked_for(outputs: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        request(asked("pendulum"), parse_outputs(outputs))


def test_steps_have_no_straight_line_program() -> None:
    system = derive(asked("pendulum", "step:rk4"))
    with pytest.raises(NotSupportedError, match="calls other functions"):
        system.program("step:rk4")
    assert system.casadi("step:rk4").n_out() == 2
    assert system.plans("step:rk4")[0].counts is not None
