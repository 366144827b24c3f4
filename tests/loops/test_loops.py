"""Functions in loops: certified for every kind of joint, compiled without warnings, numbers as straight-line."""

from __future__ import annotations

from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

from symgen.errors import NotSupportedError
from symgen.generate import generate_files
from symgen.loops.classes import MOST
from symgen.loops.model import LoopProgram
from symgen.targets.c import read_back
from tests.loops.helpers import ROWS, asked, call, certify, chain, emitted, library, zoo

COMPILERS = [
    pytest.param(cc, marks=pytest.mark.skipif(which(cc) is None, reason=f"no {cc}")) for cc in ("gcc", "clang")
]


@pytest.mark.parametrize("name", ["pendulum", "fig1", "panda", "furuta", "slope_body", "spinning_top"])
def test_examples_are_certified(name: str) -> None:
    system = asked(name)
    for certificate in certify(system, emitted(system)).values():
        assert certificate.failure_probability < 1e-24


@pytest.mark.parametrize("velocity", ["world", "body", "mixed"])
def test_every_kind_of_joint_is_certified(velocity: str) -> None:
    system = asked(zoo(velocity))
    assert len(certify(system, emitted(system))) == 5


def test_rows_of_one_function_share_the_sweep_of_motions() -> None:
    system = asked(chain(4), "all=mass_matrix+bias_force+gravity_force+forward_dynamics")
    program = system.code("all").program
    assert isinstance(program, LoopProgram)
    names = [sweep.name for sweep in program.sweeps]
    assert names.count("motion_v") == 1 and "motion" in names
    certify(system, emitted(system))


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("precision", ["double", pytest.param("float", marks=pytest.mark.slow)])
def test_compiled_loops_give_the_numbers_of_straight_line_code(compiler: str, precision: str, tmp_path: Path) -> None:
    scene, rng = zoo(), np.random.default_rng(3)
    kind: type = np.float64 if precision == "double" else np.float32
    tolerance, suffix = (1e-12, "") if precision == "double" else (2e-4, "_f32")
    made = {
        code: library(emitted(asked(scene, code=code, precision=precision, status=True)), tmp_path / code, compiler)
        for code in ("loops", "straight")
    }
    size = asked(scene).sizes
    q, v, a = rng.normal(size=size.nq), rng.normal(size=size.nv), rng.normal(size=size.nv)
    inputs: dict[str, list[Any]] = {
        "inverse_dynamics": [q, v, a], "bias_force": [q, v], "gravity_force": [q], "mass_matrix": [q],
        "forward_dynamics": [q, v, a],
    }  # fmt: skip
    for row in ROWS.split(","):
        count = size.nv**2 if row == "mass_matrix" else size.nv
        found = {}
        for code, compiled in made.items():
            status, found[code] = call(getattr(compiled, f"zoo_{row}{suffix}"), inputs[row], count, kind)
            assert row != "forward_dynamics" or status == 0
        scale = np.abs(found["straight"]).max()
        assert np.abs(found["loops"] - found["straight"]).max() <= tolerance * scale, row


def test_a_singular_state_gives_nan_and_a_status(tmp_path: Path) -> None:
    """Two links in line, the second without inertia about the line when both turn about it."""
    from symgen.scene.builder import SceneBuilder

    builder = SceneBuilder("needle")
    builder.body("a", mass=1, com=["0.5", 0, 0], inertia=["0.1", "0.1", "0.1", 0, 0, 0])
    builder.body("b", mass=1, com=["0.5", 0, 0], inertia=[0, 0, 0, 0, 0, 0])
    builder.joint("j1", "revolute", "ground", "a", axis=[0, 0, 1])
    builder.joint("j2", "universal", "a", "b", axis=[1, 0, 0], axis2=[0, 0, 1], xyz=[1, 0, 0])
    system = asked(builder.build(), "forward_dynamics", status=True)
    compiled = library(emitted(system), tmp_path)
    q, v, tau = np.array([0.2, 0.3, 0.0]), np.zeros(3), np.ones(3)
    status, a = call(compiled.needle_forward_dynamics, [q, v, tau], 3)
    assert status == 1 and np.all(np.isnan(a))
    status, a = call(compiled.needle_forward_dynamics, [q + np.array([0, 0, 1]), v, tau], 3)
    assert status == 0 and np.all(np.isfinite(a))


def test_the_c_librarys_sines(tmp_path: Path) -> None:
    system = asked(chain(5), trigonometry="libm")
    text = emitted(system)
    certify(system, text)
    library(text, tmp_path)


def test_a_long_chain_has_few_classes_and_states_in_few_places() -> None:
    system = asked(chain(60), "inverse_dynamics,forward_dynamics")
    for name in ("inverse_dynamics", "forward_dynamics"):
        program = system.code(name).program
        assert isinstance(program, LoopProgram)
        assert all(len(sweep.steps) <= MOST for sweep in program.sweeps)
        assert all(size <= 2 * 27 for array, size in program.locals.items() if array.endswith("_state"))
    certify(system, emitted(system))


@pytest.mark.parametrize("n", [7, 16, 19])
def test_the_lower_half_of_a_matrix_in_tiles(n: int) -> None:
    system = asked(chain(n), "mass_matrix")
    certify(system, emitted(system))


def test_batches_of_loops_run_state_by_state(tmp_path: Path) -> None:
    system = asked(chain(3), "inverse_dynamics", batch=True)
    text = emitted(system)
    assert not read_back(text).vectors
    compiled = library(text, tmp_path)
    rng = np.random.default_rng(1)
    q, v, a = rng.normal(size=(3, 2, 3))
    out = np.zeros((2, 3))
    import ctypes

    pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (q, v, a, out)]
    compiled.chain_inverse_dynamics_batch(ctypes.c_size_t(2), *pointers)
    for k in range(2):
        assert np.array_equal(out[k], call(compiled.chain_inverse_dynamics, [q[k], v[k], a[k]], 3)[1])


class TestChoice:
    def test_small_scenes_stay_straight_and_long_ones_do_not(self) -> None:
        assert not isinstance(asked(chain(8), code=None).code("mass_matrix").program, LoopProgram)
        code = asked(chain(60), "forward_dynamics", code=None).code("forward_dynamics")
        assert isinstance(code.program, LoopProgram) and "loops are faster" in code.why

    def test_what_has_no_loops_says_so(self) -> None:
        system = asked("panda", "mass_matrix_inverse,mass_matrix")
        code = system.code("mass_matrix_inverse")
        assert not isinstance(code.program, LoopProgram) and "straight-line" in code.note
        generated = generate_files(system, lambda done, total, what: None)
        assert "Note: mass_matrix_inverse is straight-line code, not loops" in " ".join(
            str(generated.files["panda.h"]).replace("\n *", " ").split()
        )

    def test_loops_that_were_asked_for_come_with_casadi_while_affordable(self) -> None:
        system = asked("pendulum", "forward_dynamics", targets=("c", "casadi"))
        generated = generate_files(system, lambda done, total, what: None)
        assert "pendulum.casadi/forward_dynamics.casadi" in generated.files
        assert "C in loops, CasADi" in generated.certificates["forward_dynamics"].method

    def test_what_casadi_does_not_get_is_said(self) -> None:
        system = asked(chain(160), "forward_dynamics", code=None, targets=("c", "casadi"))
        code = system.code("forward_dynamics")
        assert code.straight is None and "left out of casadi" in code.note

    def test_plans_say_which(self) -> None:
        (plan,) = asked("pendulum", "bias_force").plans("bias_force")
        assert plan.plan == "recursive, in loops" and plan.counts is not None and plan.counts.sincos == 1

    def test_springs_and_parameters_are_straight_line(self) -> None:
        code = asked("fig2", "bias_force").code("bias_force")
        assert not isinstance(code.program, LoopProgram) or not asked("fig2").scene.forces

    def test_steps_are_no_programs_of_their_own(self) -> None:
        with pytest.raises(NotSupportedError):
            asked("four_bar", "mass_matrix").code("mass_matrix")
