"""The paper's symbols as exact values: r_k, u_k, their rates, ω_i and θ̇_j of a system at a random point of GF(p).

Positions and rates come from the derived natural coordinates (x and R θ̇), angular velocities from the bodies' twists.
Printed expressions (``-D31 u1``, dots as ``'``) are evaluated here and nowhere else.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from symgen.algebra.field import FieldNumbers, Residue
from symgen.algebra.linear import Mat, Vec, cross, dot, matmul, matvec, scale, skew, vadd, vneg, vsub
from symgen.algebra.numbers import State
from symgen.literal.equations import Literal
from symgen.scene.load import load
from symgen.system import System, derive
from symgen.targets.sympy.paper import Block

EXAMPLES = Path(__file__).parents[2] / "examples"


def example(name: str) -> System:
    return derive(load(EXAMPLES / f"{name}.scene.yaml"))


def same(a: Any, b: Any) -> bool:
    """Equality of scalars, vectors and matrices whose zeros may be the int 0."""
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return bool(a - b == 0)


@dataclass(frozen=True)
class World:
    system: System
    seed: int = 1

    @cached_property
    def literal(self) -> Literal:
        numbers, tree = FieldNumbers(seed=self.seed), self.system.tree

        def draw(name: str, count: int) -> tuple[Residue, ...]:
            return tuple(Residue(numbers.random(name, k), numbers.p) for k in range(count))

        state = State(draw("q", tree.nq), draw("v", tree.nv), draw("a", tree.nv), draw("tau", tree.nv))
        return self.system.literal(numbers, state)

    @cached_property
    def x(self) -> Vec:
        return self.literal.natural_coordinates()

    @cached_property
    def x_rate(self) -> Vec:
        """q̇ = R θ̇, paper (3.4)."""
        return matvec(self.literal.velocity_transformation(), tuple(self.literal.state.v))

    def vector(self, label: str) -> Vec:
        """A basic point or unit vector: ``r3``, ``u3``, ``u2_1``; those of the ground are constants."""
        for entity in self.system.natural.entities:
            if entity.label == label:
                if entity.start is None:
                    return self.literal.values.vector(entity.local[-1])
                return self.x[entity.start : entity.start + 3]
        raise KeyError(label)

    def rate(self, label: str) -> Vec:
        for entity in self.system.natural.entities:
            if entity.label == label:
                return (0, 0, 0) if entity.start is None else self.x_rate[entity.start : entity.start + 3]
        raise KeyError(label)

    def omega(self, body: int) -> Vec:
        """ω of a body, numbered from one as in the paper."""
        return self.literal.twists[body - 1].angular

    @cached_property
    def joint_rates(self) -> dict[str, Residue]:
        """θ̇ of the one-degree joints by number: the examples' joints are named j1, j2, … like the paper's."""
        return {body.joint.name[1:]: self.literal.state.v[body.v] for body in self.system.tree.bodies if body.nv == 1}

    def evaluate(self, text: str) -> Any:
        """A printed block: ``0``, ``1``, ``u3``, ``-D31 u1``, ``-D'31 u1 -D31 u'1``."""
        if text == "0":
            return 0
        total: Any = None
        for sign, product in re.findall(r"(-?)((?:[DUu1]'?[\d_]* ?)+)", text):
            value: Any = None
            for token in product.split():
                factor = self.token(token)
                value = factor if value is None else multiply(value, factor)
            if sign:
                value = negative(value)
            total = value if total is None else plus(total, value)
        return total

    def token(self, token: str) -> Any:
        if token == "1":
            return 1
        letter, dotted, indices = token[0], token[1] == "'", token.lstrip("DUu'")
        find = self.rate if dotted else self.vector
        if letter == "D":
            i, j = indices.split("_") if "_" in indices else (indices[0], indices[1])
            return skew(vsub(find(f"r{i}"), find(f"r{j}")))
        return skew(find(f"u{indices}")) if letter == "U" else find(f"u{indices}")

    def row(self, text: list[str], columns: list[str]) -> Vec:
        """Σ block · velocity: a printed row of R times the vector of joint velocities."""
        total: Vec = (0, 0, 0)
        for block, column in zip(text, columns, strict=True):
            value = self.evaluate(block)
            if isinstance(value, int) and value == 0:
                continue
            velocity = self.velocity(column)
            if isinstance(velocity, tuple):
                part = velocity if isinstance(value, int) else matvec(value, velocity)
            else:
                part = scale(velocity, value)
            total = vadd(total, part)
        return total

    def velocity(self, column: str) -> Any:
        """``theta2``, ``r1`` (ṙ₁) or ``omega1``."""
        if column.startswith("theta"):
            return self.joint_rates[column[5:]]
        return self.rate(column) if column.startswith("r") else self.omega(int(column[5:]))


def multiply(a: Any, b: Any) -> Any:
    return matmul(a, b) if isinstance(b[0], tuple) else matvec(a, b)


def negative(a: Any) -> Any:
    if not isinstance(a, tuple):
        return -a
    return tuple(vneg(row) for row in a) if isinstance(a[0], tuple) else vneg(a)


def plus(a: Any, b: Any) -> Any:
    return tuple(vadd(x, y) for x, y in zip(a, b, strict=True)) if isinstance(a[0], tuple) else vadd(a, b)


def notation(block: Block) -> str:
    """A block as `World.evaluate` reads it."""
    terms = []
    for term in block:
        shown = [f for f in term.factors if f.letter != "1"] or list(term.factors)
        names = []
        for f in shown:
            apart = "_" if f.letter != "D" or any(len(index) > 1 for index in f.indices) else ""
            names.append(f.letter + "'" * f.dots + apart.join(f.indices))
        terms.append(("-" if term.negative else "") + " ".join(names))
    return " ".join(terms) or "0"


__all__ = ["Mat", "Vec", "World", "cross", "dot", "example", "matvec", "notation", "same", "scale", "vadd", "vsub"]
