"""Products of derivatives, base parameters and constraint forces: right ones pass, spoilt ones fail."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction as F
from functools import cache
from typing import Any

import numpy as np
import pytest

from symgen.scene.model import Mimic, Output, Parameter, Scene
from symgen.scene.outputs import function_name
from symgen.validation.compare import compare_with_pinocchio
from symgen.validation.compare_products import asked_products, compare_products
from symgen.validation.compare_rows import compare_rows
from symgen.validation.differences import Context, constraint_force_rows
from symgen.validation.functions import Bound, bind, vary_parameters
from symgen.validation.mechanism import build_mechanism
from symgen.validation.result import Row
from tests.validation.changed import Changed
from tests.validation.derived_functions import DerivedFunctions
from tests.validation.scenes import chain, sprung

pytest.importorskip("pinocchio")

ASKED = (
    "jvp:inverse_dynamics", "vjp:forward_dynamics", "jvp:center_of_mass", "vjp:frame_pose:b2",
    "parameter_jacobian:inverse_dynamics", "base_regressor", "base_parameters", "constraint_forces",
)  # fmt: skip


@cache
def scene() -> Scene:
    """A ball and a damped revolute, one mass a parameter."""
    plain = chain("arm", ("spherical", "revolute"))
    joints = (plain.joints[0], replace(plain.joints[1], damping=F(1, 5), armature=F(1, 10)))
    outputs = tuple(Output(function_name(row), (row,)) for row in ASKED)
    parameter = Parameter("b2.mass", (plain.bodies[1].mass,), "kg", 0)
    return replace(plain, joints=joints, outputs=outputs, parameters=(parameter,))


@cache
def functions() -> DerivedFunctions:
    return DerivedFunctions(scene())


def rows_of(spoilt: Any, *asked: str) -> dict[str, Row]:
    """Only what ``asked`` needs is checked."""
    some = replace(scene(), outputs=tuple(output for output in scene().outputs if output.of[0] in asked))
    bound = bind(spoilt, some)
    rows, skipped = compare_products(some, bound, 1)
    assert not skipped
    if "base_regressor" in asked:
        rows += compare_rows(some, bound, 2, 1)
    if "constraint_forces" in asked:
        rows += constraint_force_rows(Context(build_mechanism(some), bound, 7))
    return {row.quantity: row for row in rows}


def test_products_are_found() -> None:
    assert asked_products(scene())[3] == ("vjp", "frame_pose", "b2")
    assert len(asked_products(scene())) == 5


def test_right_functions_pass() -> None:
    rows = rows_of(functions(), *ASKED)
    assert {row for row in ASKED if ":" in row} <= set(rows)
    assert [row for row in rows.values() if not row.passed] == []


SPOILT = (
    *((function_name(row), row) for row in ASKED if ":" in row),
    ("base_regressor", "base_regressor · base_parameters"),
    ("base_parameters", "base_regressor · base_parameters"),
    ("constraint_forces", "Ψ_x(M ẍ − Q − Ψ_xᵀλ) = 0"),
)


@pytest.mark.parametrize(("name", "seen"), SPOILT, ids=[f"{name}-{seen}" for name, seen in SPOILT])
def test_spoilt_functions_fail(name: str, seen: str) -> None:
    def change(result: Any, *arguments: Any) -> Any:
        parts = list(result) if isinstance(result, tuple) else [result]
        factor = 1 + 1e-7 * (1 + float(np.sum(np.abs(arguments[-1]))) if arguments else 1)
        parts[0] = np.asarray(parts[0]) * factor
        return tuple(parts) if isinstance(result, tuple) else parts[0]

    asked = seen if ":" in seen else "constraint_forces" if name == "constraint_forces" else "base_regressor"
    assert not rows_of(Changed(functions(), name, change), asked)[seen].passed


def geared() -> Scene:
    """Springs, and a revolute that follows another; everything that may be one is a parameter."""
    plain = sprung()
    follower = replace(chain("more", ("revolute",) * 4).joints[3], name="j4", parent="b1", child="b4")
    body = chain("more", ("revolute",) * 4).bodies[3]
    joints = (*plain.joints, replace(follower, mimic=Mimic("j1", F(-3, 2), F(1, 5))))
    forces = tuple(replace(force, name=f"f{k}") for k, force in enumerate(plain.forces))
    return replace(plain, bodies=(*plain.bodies, body), joints=joints, forces=forces)


def test_every_parameter_is_put_where_it_belongs() -> None:
    """Joint origins, offsets and spring points too, with a mimic joint: the derived functions at other values of p
    against Pinocchio's model of the changed scene."""
    from symgen.scene.parameters import available_parameters
    from symgen.system import derive

    scene, found = geared(), []
    for name, (default, unit) in available_parameters(scene).items():
        found.append(Parameter(name, default, unit, sum(parameter.size for parameter in found)))
    assert {"j2.offset", "j3.rpy", "j4.xyz", "f0.point1"} <= {parameter.name for parameter in found}
    scene = replace(scene, parameters=tuple(found))
    changed, p = vary_parameters(scene, np.random.default_rng(3))

    class Few:
        def __init__(self) -> None:
            system = derive(scene)
            for name in ("mass_matrix", "inverse_dynamics"):
                function = system.casadi(name)
                shape = system.program(name).outputs[0].shape
                setattr(self, name, DerivedFunctions._wrap(function, [shape]))

    few = Few()
    for values, passes in ((p, True), (p * (1 + 1e-9), False)):
        rows, _skipped = compare_with_pinocchio(changed, Bound(few, values), 3, 1)
        compared = [row for row in rows if row.quantity in ("mass_matrix", "inverse_dynamics")]
        assert len(compared) == 2
        assert all(row.passed is passes for row in compared)
