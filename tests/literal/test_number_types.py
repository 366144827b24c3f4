"""One derivation, many number types: the literal definition gives the same numbers in all of them."""

from __future__ import annotations

import math
import random
from typing import Any

import casadi
import pytest

from symgen.algebra.numbers import FloatNumbers, State
from symgen.plans.build import flatten
from symgen.program.evaluate import evaluate, evaluate_all
from symgen.program.graph import Graph, extract
from symgen.scene.load import load
from symgen.system import System, derive
from symgen.targets.casadi import CasadiNumbers

INPUTS = ("q", "v", "a", "tau", "dt")


@pytest.fixture(scope="module", params=["fig1", "fig2", "universal_shaft", "screw_drive"])
def system(request: pytest.FixtureRequest) -> System:
    return derive(load(f"examples/{request.param}.scene.yaml"))


def sizes(system: System) -> dict[str, int]:
    size = system.sizes
    return {"q": size.nq, "v": size.nv, "a": size.nv, "tau": size.nv, "dt": 1}


def floats(system: System) -> dict[str, list[float]]:
    rng = random.Random(3)
    return {name: [rng.uniform(-1, 1) for _ in range(n)] for name, n in sizes(system).items()}


def state(values: dict[str, Any]) -> State:
    return State(values["q"], values["v"], values["a"], values["tau"], values["dt"][0])


def close(found: list[float], expected: list[float]) -> bool:
    scale = max(1.0, *(abs(x) for x in expected))
    return all(math.isclose(x, y, rel_tol=0, abs_tol=1e-12 * scale) for x, y in zip(found, expected, strict=True))


def literal(system: System, name: str, numbers: Any, values: dict[str, Any]) -> list[Any]:
    (value,) = system.evaluate(name, numbers, state(values)).values()
    return flatten(value)


def test_casadi_and_the_exact_graph_agree_with_floats(system: System) -> None:
    numeric = floats(system)
    symbols = {name: casadi.SX.sym(name, n) for name, n in sizes(system).items()}
    symbolic = {name: [symbol[i] for i in range(symbol.numel())] for name, symbol in symbols.items()}
    for output in system.outputs:
        expected = [float(x) for x in literal(system, output.name, FloatNumbers(), numeric)]
        if not expected:
            continue
        column = casadi.vertcat(*(casadi.SX(x) for x in literal(system, output.name, CasadiNumbers(), symbolic)))
        function = casadi.Function("f", [symbols[name] for name in INPUTS], [column])
        assert close(function(*(numeric[name] for name in INPUTS)).full().ravel().tolist(), expected), output.name
        graph = Graph()
        nodes = {name: graph.inputs(name, n) for name, n in sizes(system).items()}
        program = extract(graph, "f", (), (), [literal(system, output.name, graph, nodes)])
        values = evaluate_all(program, FloatNumbers(), numeric)
        assert close([float(values[i]) for i in program.results[0]], expected), output.name


def test_emitted_programs_agree_with_the_literal_form_in_floats(system: System) -> None:
    numeric = floats(system)
    for output in system.outputs:
        expected = [float(x) for x in literal(system, output.name, FloatNumbers(), numeric)]
        (found,) = evaluate(system.program(output.name), FloatNumbers(), numeric).values()
        assert close([float(x) for x in found], expected), output.name
