"""SymPy's KanesMethod on small scenes: derived as its documentation does, `cse`, printed as C."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import sympy
from sympy.physics import mechanics

from symgen.bench.variant import INPUTS, KANE, Array, Found, Problem, Unit, Variant
from symgen.bench.workshop import Workshop
from symgen.errors import NotSupportedError
from symgen.validation.mechanism import IDENTITY, Link, lump

LARGEST = 3
"""Velocities beyond which derivation takes minutes."""
HAS = ("mass_matrix", "bias_force")


def build(problem: Problem, workshop: Workshop) -> Found:
    """mass_matrix and bias_force by Kane's equations. Raises NotSupportedError for scenes that are too large for it."""
    if problem.nv > LARGEST:
        raise NotSupportedError(f"not derived for more than {LARGEST} velocities: takes minutes")
    started = time.process_time()
    q = mechanics.dynamicsymbols(f"q:{problem.nv}")
    v = mechanics.dynamicsymbols(f"v:{problem.nv}")
    M, h = equations(problem, q, v)
    derived = time.process_time() - started
    plain = {x: sympy.Symbol(f"{kind}[{k}]") for kind, row in (("q", q), ("v", v)) for k, x in enumerate(row)}
    found = Found()
    for name, value in (("mass_matrix", M), ("bias_force", h)):
        if name not in problem.wanted:
            continue
        before = time.process_time()
        text, operations = c_function(name, value.xreplace(plain))
        arguments = ", ".join(f"{{{key}}}" for key in INPUTS[name])
        found.variants.append(
            Variant(
                KANE, name, _prototype(name) + ";", f"kane_{name}({arguments}, {{out}});",
                {key: problem.column(key) for key in INPUTS[name]}, sum(problem.shapes(name)),
                lambda flat, state: [flat], (Unit(f"kane_{name}", text),),
                generate_s=derived + time.process_time() - before, operations=operations,
            )
        )  # fmt: skip
    return found


def _prototype(name: str) -> str:
    inputs = ", ".join(f"const double *{key}" for key in INPUTS[name])
    return f"void kane_{name}({inputs}, double *out)"


def c_function(name: str, value: Any) -> tuple[str, int]:
    """C of a matrix after common subexpression elimination, and its operations."""
    steps, (reduced,) = sympy.cse(value, symbols=sympy.numbered_symbols("x"), order="none")
    lines = [f"const double {symbol} = {sympy.ccode(step)};" for symbol, step in steps]
    lines += [f"out[{k}] = {sympy.ccode(entry)};" for k, entry in enumerate(reduced)]
    operations = int(sympy.count_ops([step for _, step in steps] + list(reduced), visual=False))
    body = "\n    ".join(lines)
    return f"#include <math.h>\n\n{_prototype(name)}\n{{\n    {body}\n}}\n", operations


def equations(problem: Problem, q: list[Any], v: list[Any]) -> tuple[Any, Any]:
    """M and the bias force, with M·v̇ + h = tau."""
    ground = mechanics.ReferenceFrame("N")
    root = mechanics.Point("O")
    root.set_vel(ground, 0)
    frames: list[Any] = []
    points: list[Any] = []
    bodies: list[Any] = []
    for index, link in enumerate(problem.mechanism.links):
        parent = (ground, root) if link.parent < 0 else (frames[link.parent], points[link.parent])
        frame, point = _place(index, link, parent, ground, q, v)
        frames.append(frame)
        points.append(point)
        bodies.append(_body(index, link, frame, point, ground))
    g = sum(
        (sympy.Rational(float(x)) * e for x, e in zip(problem.scene.gravity, ground, strict=True)), mechanics.Vector(0)
    )
    loads = [(body.masscenter, body.mass * g) for body in bodies if body.mass != 0]
    kinematic = [rate - x.diff() for rate, x in zip(v, q, strict=True)]
    kane = mechanics.KanesMethod(ground, q_ind=q, u_ind=v, kd_eqs=kinematic)
    kane.kanes_equations(bodies, loads)
    armature = sympy.diag(*(_number(float(link.joint.armature)) for link in problem.mechanism.links))
    rates = {x.diff(): rate for x, rate in zip(q, v, strict=True)}
    return kane.mass_matrix.xreplace(rates) + armature, -kane.forcing.xreplace(rates)


def _number(x: float) -> Any:
    return sympy.Float(x, 17) if x else sympy.Integer(0)


def _vector(frame: Any, values: Array) -> Any:
    return sum((_number(float(x)) * e for x, e in zip(values, frame, strict=True)), mechanics.Vector(0))


def _place(index: int, link: Link, parent: tuple[Any, Any], ground: Any, q: list[Any], v: list[Any]) -> tuple[Any, Any]:
    """Frame and origin of a link, with their velocities."""
    frame, origin = parent
    mount = mechanics.ReferenceFrame(f"K{index}")
    mount.orient_dcm(frame, sympy.Matrix(3, 3, [_number(float(x)) for x in np.ravel(link.origin.rotation.T)]))
    axis, position, rate = _vector(mount, link.axis), q[link.q.start], v[link.v.start]
    place = _vector(frame, link.origin.position)
    if link.joint.type in ("revolute", "continuous"):
        moving = mechanics.ReferenceFrame(f"B{index}")
        moving.orient_axis(mount, axis, position)
        moving.set_ang_vel(mount, rate * axis)
        mount.set_ang_vel(frame, 0)
        point = origin.locatenew(f"P{index}", place)
        point.v2pt_theory(origin, ground, frame)
        return moving, point
    if link.joint.type == "prismatic":
        mount.set_ang_vel(frame, 0)
        point = origin.locatenew(f"P{index}", place + position * axis)
        foot = origin.locatenew(f"F{index}", place + position * axis)
        foot.v2pt_theory(origin, ground, frame)
        point.set_vel(ground, foot.vel(ground) + rate * axis)
        return mount, point
    raise NotSupportedError(f"joint type {link.joint.type} is not measured with SymPy")


def _body(index: int, link: Link, frame: Any, point: Any, ground: Any) -> Any:
    mass, centre, inertia = lump(link, IDENTITY)
    com = point.locatenew(f"C{index}", _vector(frame, centre))
    com.v2pt_theory(point, ground, frame)
    I = [_number(float(x)) for x in inertia[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]]  # noqa: E741
    dyadic = mechanics.inertia(frame, *I)
    return mechanics.RigidBody(f"body{index}", com, frame, _number(float(mass)), (dyadic, com))
