"""casadi.Functions: their names, and that nothing about them goes unread."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F
from typing import Any

import casadi
import pytest

from symgen.algebra.field import MERSENNE_61, FieldNumbers
from symgen.errors import CertificateError, NotSupportedError
from symgen.program.instructions import Instruction, Port, Program
from symgen.scene.load import load
from symgen.scene.model import Frame, Output
from symgen.system import System, derive
from symgen.targets.casadi import casadi_function, evaluate_mod
from symgen.targets.casadi.emit import casadi_name, casadi_names
from symgen.targets.casadi.numbers import CasadiNumbers


@pytest.fixture(scope="module")
def top() -> System:
    return derive(load("examples/free_body.scene.yaml"))


def check(function: casadi.Function, program: Program) -> None:
    inputs = {port.name: [3 * k + len(port.name) for k in range(port.size)] for port in program.inputs}
    evaluate_mod(function, program, FieldNumbers(MERSENNE_61, 1), inputs)


def test_names_that_casadi_does_not_take() -> None:
    names = ["mass_matrix", "tool__1", "_x", "null", "jac", "hess", "__", "_1"]
    assert [casadi_name(name) for name in names] == [
        "mass_matrix", "tool_1", "x", "f_null", "f_jac", "f_hess", "f_", "f_1",
    ]  # fmt: skip
    assert casadi_names([Port("a__b", ()), Port("a_b", ()), Port("a___b", ())]) == ["a_b", "a_b_2", "a_b_3"]


def test_frames_and_functions_with_such_names(top: System) -> None:
    frames = (Frame("tool__1", "nut"), Frame("tool_1", "nut"), Frame("_x", "ground"))
    outputs = (
        Output("null", ("kinetic_energy",)),
        Output("_both", ("frame_pose:tool__1", "frame_pose:tool_1", "frame_pose:_x")),
        Output("frame_pose:tool__1", ("frame_pose:tool__1",)),
    )
    system = derive(replace(top.scene, frames=frames, outputs=outputs))
    for output in outputs:
        function = system.casadi(output.name)
        check(function, system.program(output.name))
    assert system.casadi("_both").name_out() == ["pose_tool_1", "pose_tool_1_2", "pose_x"]


def test_series_and_comparisons_are_read(top: System, monkeypatch: pytest.MonkeyPatch) -> None:
    """The branch for small arguments is as certain as the other one."""
    program = top.program("integrate")
    check(casadi_function(program), program)
    series, guarded = CasadiNumbers.cos_sqrt, "symgen.targets.casadi.numbers._guarded"

    def wrong_series(self: CasadiNumbers, x: Any) -> Any:
        return series(self, x) + casadi.if_else(x < 1e-2, x, 0)

    with monkeypatch.context() as patched:
        patched.setattr(CasadiNumbers, "cos_sqrt", wrong_series)
        with pytest.raises(CertificateError, match="series"):
            check(casadi_function(program), program)
    for bound in (2.0, 1e-3):
        with monkeypatch.context() as patched:
            patched.setattr("symgen.targets.casadi.numbers.SERIES_BELOW", bound)
            with pytest.raises(CertificateError, match=r"compares|constant"):
                check(casadi_function(program), program)
    with monkeypatch.context() as patched:
        patched.setattr(guarded, lambda x: (x + 1 < 1e-2, casadi.sqrt(casadi.if_else(x + 1 < 1e-2, 1, x))))
        with pytest.raises(CertificateError, match="compares"):
            check(casadi_function(program), program)


def test_other_shapes_are_refused(top: System) -> None:
    program = top.program("velocity_transformation")
    port = program.outputs[0]
    turned = replace(program, outputs=(replace(port, shape=port.shape[::-1]),))
    renamed = replace(program, outputs=(replace(port, name="S"),))
    for mutant in (turned, renamed):
        with pytest.raises(CertificateError, match="other arguments or results"):
            check(casadi_function(mutant), program)


@pytest.mark.parametrize("value", [F(10) ** 400, F(1, 10**400)])
def test_constants_beyond_double_precision(value: F) -> None:
    program = Program("f", (), (Port("y", ()),), (Instruction("const", (), value),), ((0,),))
    with pytest.raises(NotSupportedError, match="double precision"):
        casadi_function(program)
