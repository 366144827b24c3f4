"""Certificates can fail: every kind of mutation of what is emitted is refused, and wrong plans are."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path
from typing import Any

import casadi
import pytest

from symgen.algebra.linear import mul
from symgen.certificate import Candidate, Certificate, Certifier
from symgen.errors import CertificateError
from symgen.generate import _casadi_candidate, generate, generate_files
from symgen.plans import recursive
from symgen.plans.inertia import Inertia
from symgen.program.instructions import Program
from symgen.scene.load import load
from symgen.system import System, derive
from symgen.targets.casadi import casadi_function
from tests.certificate.mutations import Bench

EXAMPLES = sorted(Path("examples").glob("*.scene.yaml"))
ROWS = ("mass_matrix", "bias_force", "forward_dynamics", "velocity_transformation")


@pytest.mark.parametrize("scene", ["double_pendulum", "fig1", "spinning_top"])
def test_mutations_of_emitted_c_are_refused(scene: str) -> None:
    bench = Bench(f"examples/{scene}.scene.yaml", ROWS)
    assert bench.accepts(bench.source)
    made, survived = bench.survivors(12)
    assert len(made) >= 7 and sum(made.values()) > 60
    assert [kind for kind, _ in survived] == []


@pytest.fixture(scope="module")
def fig2() -> System:
    return derive(load("examples/fig2.scene.yaml"))


@pytest.mark.parametrize("place", range(0, 40, 3))
def test_mutations_of_casadi_functions_are_refused(fig2: System, place: int) -> None:
    """One instruction of the program changed before it becomes a casadi.Function."""
    program = fig2.program("bias_force")
    arithmetic = [i for i, instruction in enumerate(program.instructions) if instruction.op in ("add", "sub", "mul")]
    index = arithmetic[place * len(arithmetic) // 40]
    old = program.instructions[index]
    new = old._replace(op={"add": "sub", "sub": "add", "mul": "add"}[old.op])
    mutant = replace(program, instructions=(*program.instructions[:index], new, *program.instructions[index + 1 :]))
    with pytest.raises(CertificateError):
        certify_casadi(fig2, program, casadi_function(mutant))


def certify_casadi(system: System, program: Program, function: casadi.Function) -> Certificate:
    certifier = Certifier(system, "text")
    return certifier.certify(system.output(program.name), program, [_casadi_candidate(function, program)])


def test_a_casadi_function_as_emitted_is_accepted_and_a_changed_constant_is_not(fig2: System) -> None:
    program = fig2.program("gravity_force")
    assert certify_casadi(fig2, program, casadi_function(program)).failure_probability < 1e-25
    places = [i for i, instruction in enumerate(program.instructions) if instruction.op == "const"]
    for i in places[:5]:
        value = program.instructions[i].value
        assert isinstance(value, F)
        new = program.instructions[i]._replace(value=value * (1 + F(1, 2**50)))
        mutant = replace(program, instructions=(*program.instructions[:i], new, *program.instructions[i + 1 :]))
        with pytest.raises(CertificateError):
            certify_casadi(fig2, program, casadi_function(mutant))


def test_nothing_is_no_candidate(fig2: System) -> None:
    with pytest.raises(CertificateError, match="nothing was emitted"):
        Certifier(fig2, "").certify(fig2.output("gravity_force"), fig2.program("gravity_force"), [])


def test_a_wrong_plan_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A sign in the recursion: generation fails, names the function, and leaves nothing behind."""
    right = recursive.wrench

    def wrong(inertia: Inertia, motion: recursive.Motion) -> tuple[Any, Any]:
        force, moment = right(inertia, motion)
        return force, (mul(-1, moment[0]), *moment[1:])

    monkeypatch.setattr(recursive, "wrench", wrong)
    with pytest.raises(CertificateError, match=r"inverse_dynamics|bias_force|forward_dynamics"):
        generate("examples/fig1.scene.yaml", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_wrong_literal_form_is_no_excuse(fig2: System) -> None:
    """A candidate that returns the right numbers in the wrong order is refused."""
    program = fig2.program("gravity_force")
    inner = _casadi_candidate(casadi_function(program), program)

    def shuffled(numbers: Any, inputs: Any) -> Any:
        values = inner.evaluate(numbers, inputs)
        return {name: list(reversed(entries)) for name, entries in values.items()}

    with pytest.raises(CertificateError):
        Certifier(fig2, "").certify(fig2.output("gravity_force"), program, [Candidate("shuffled", shuffled)])


@pytest.mark.parametrize("path", [path for path in EXAMPLES if "four_bar" not in path.name], ids=lambda path: path.stem)
def test_every_function_of_every_example_is_certified(path: Path) -> None:
    system = derive(load(path))
    generated = generate_files(system, lambda done, total, what: None)
    assert generated.certificates.keys() == {system.program(output.name).name for output in system.outputs}
    for name, certificate in generated.certificates.items():
        assert 2 <= certificate.points <= 4, name
        assert certificate.failure_probability < 1e-20, (name, certificate)
        assert "C, CasADi" in certificate.method
