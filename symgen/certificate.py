"""Exact certificates: what was emitted is, as an identity, the literal definition (verification, §1).

At random points of GF(p), for p = 2⁶¹ − 1 and a second random prime, the emitted text (C read back, CasADi
instructions read back) is evaluated and compared with the literal form run in the same field. The points are drawn
from a hash of the emitted text, so the same input gives the same certificate, and no text can be made to suit its
points.
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from symgen import derivative_checks, kinematic_checks
from symgen.algebra.field import MERSENNE_61, FieldNumbers, NotInField, Residue, random_prime
from symgen.algebra.numbers import State
from symgen.catalogue import output_ports, row_of, sizes, split_row
from symgen.emitted import Check, Emitted, Pairs, residues
from symgen.errors import CertificateError, SceneError, SymgenError
from symgen.integrators import literal as literal_steps
from symgen.literal.equations import Literal
from symgen.loops.degree import formal_degree
from symgen.loops.model import LoopProgram, loop_counts
from symgen.plans.build import flatten
from symgen.program.angles import register_sums
from symgen.program.composed import ComposedProgram, composed_counts
from symgen.program.evaluate import evaluate_residues
from symgen.program.instructions import Counts, Program, count
from symgen.scene.model import Output
from symgen.system import System

Inputs = Mapping[str, Sequence[int]]
Outputs = Mapping[str, Sequence[int]]
ATTEMPTS = 200
"""Points that are drawn before giving up on one where every division and root exists."""


MOST_POINTS = 4
SURE = 1e-25
"""Points are added, each in another field, until the probability of an error is below this, up to `MOST_POINTS`."""
ENOUGH = 1e-20
"""With a probability above this nothing is certified."""


@dataclass(frozen=True)
class Candidate:
    """Something emitted: where it stands, and how it is evaluated in GF(p)."""

    what: str
    evaluate: Callable[[FieldNumbers, Inputs], Outputs]
    emitted: bool = True
    """False for another derivation of the same function, which is held to the definition beside what is emitted."""


@dataclass(frozen=True)
class Certificate:
    """Stands in the manifest beside its function."""

    method: str
    checked_against: str
    points: int
    failure_probability: float

    def to_json(self) -> dict[str, object]:
        return {
            "method": self.method,
            "checked_against": self.checked_against,
            "points": self.points,
            "failure_probability": self.failure_probability,
        }


def _vector_check(times: str, port: str) -> Check:
    """A matrix against its literal product with a random vector: Rᵀ(M(R x))."""

    def check(literal: Literal, emitted: Emitted) -> Pairs:
        x = emitted.random(literal.tree.nv)
        yield from zip(getattr(literal, times)(x), emitted.times(port, x), strict=True)

    return check


def _equation_of_motion(literal: Literal, emitted: Emitted) -> Pairs:
    """M a + h = τ with the literal M and h: a is what forward dynamics is, whatever solved for it."""
    a = emitted.values["a"]
    for left, bias, tau in zip(literal.mass_matrix_times(a), literal.bias_force(), literal.state.tau, strict=True):
        yield left + bias, tau


def _inverse(literal: Literal, emitted: Emitted) -> Pairs:
    """M (Minv x) = x with the literal M."""
    x = emitted.random(literal.tree.nv)
    yield from zip(literal.mass_matrix_times(emitted.times("Minv", x)), x, strict=True)


CHECKS: dict[str, tuple[str, Check]] = {
    "mass_matrix": ("literal R^T(M(R x)), x random", _vector_check("mass_matrix_times", "M")),
    "coriolis_matrix": ("literal R^T(M(dR/dt x)), x random", _vector_check("coriolis_times", "C")),
    "forward_dynamics": ("equation of motion with literal R^T M R and bias", _equation_of_motion),
    "mass_matrix_inverse": ("literal R^T(M(R Minv x)) = x, x random", _inverse),
    **derivative_checks.CHECKS,
    **kinematic_checks.CHECKS,
    **literal_steps.CHECKS,
}
"""Rows that are not compared entry by entry."""


def _pairs(literal: Literal, output: Output, emitted: Emitted) -> Iterator[tuple[str, Any, Any]]:
    """(row, what the literal form says, what was emitted)."""
    size = sizes(literal.values.scene, literal.tree, literal.natural)
    ports = iter(output_ports(output.of, size))
    for row in output.of:
        name, frame = split_row(row)
        mine = [next(ports) for _ in row_of(row).outputs]
        if name in CHECKS:
            of_row = emitted.of(row, tuple(port.name for port in mine))
            for expected, found in CHECKS[name][1](literal, of_row):
                yield row, expected, found
            continue
        definition = row_of(row).literal
        assert definition is not None
        for port, value in zip(mine, definition(literal, frame), strict=True):
            for expected, found in zip(flatten(value), emitted.values.get(port.name, []), strict=True):
                yield row, expected, found


@dataclass(frozen=True)
class Certifier:
    """Certifies the functions of one system at points that all of them share, so that the literal kinematics is
    evaluated once a point. ``text`` is everything emitted: what the points are drawn from."""

    system: System
    text: str
    _literals: dict[tuple[int, int], Literal] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def seed(self) -> int:
        digest = hashlib.sha256(f"{self.system.scene.sha256}:{self.text}".encode()).digest()
        return int.from_bytes(digest, "big")

    @cached_property
    def primes(self) -> tuple[int, ...]:
        """2⁶¹ − 1 and random ones: two always, more where degrees are high."""
        return MERSENNE_61, *(random_prime(self.seed + k) for k in range(MOST_POINTS - 1))

    def _point(self, p: int, attempt: int) -> tuple[FieldNumbers, dict[str, list[int]], Literal]:
        rng = random.Random(f"{self.seed}:{p}:{attempt}")
        numbers = FieldNumbers(p, rng.getrandbits(64))
        size = self.system.sizes
        lengths = {"q": size.nq, "v": size.nv, "a": size.nv, "tau": size.nv, "dt": 1, "p": size.np}
        inputs = {name: [rng.randrange(1, p) for _ in range(n)] for name, n in lengths.items()}
        key = (p, attempt)
        if key not in self._literals:
            self._literals[key] = self.system.literal(numbers, _state(inputs, p))
        literal = self._literals[key]
        numbers = literal.values.numbers  # type: ignore[assignment]
        return numbers, inputs, literal

    def certify(
        self, output: Output, program: Program, candidates: Sequence[Candidate], straight: Program | None = None
    ) -> Certificate:
        """Certify every candidate for a function. ``straight``: its straight-line form, where ``program`` is in loops
        and other candidates are not.

        Raises CertificateError naming the function, the candidate and the catalogue row that differs, and where there
        is no candidate.
        """
        if not candidates:
            raise CertificateError(f"{output.name}: nothing was emitted")
        degree, assumption = _degree(program, self.system)
        if straight is not None and straight is not program:
            degree, assumption = max((degree, assumption), _degree(straight, self.system))
            program = straight
        probability, points = 1.0, 0
        for p in self.primes:
            self._check(output, program, candidates, p)
            points, probability = points + 1, probability * min(1.0, degree / p)
            if points > 1 and probability < SURE:
                break
        if probability > ENOUGH:
            raise CertificateError(f"{output.name}: too large to be certain of (degree {degree:.1e})")
        held = ", ".join(candidate.what for candidate in candidates if candidate.emitted)
        beside = "".join(f" and of {candidate.what}" for candidate in candidates if not candidate.emitted)
        method = f"identity in GF(p), p = 2^61 - 1 and random 61-bit primes, of what was emitted ({held}){beside}"
        rows = [split_row(row)[0] for row in output.of]
        against = dict.fromkeys(CHECKS[row][0] if row in CHECKS else f"literal {row}" for row in rows)
        return Certificate(method + assumption, "; ".join(against), points, float(f"{probability:.1e}"))

    def _further(self, program: Program, known: Inputs, p: int) -> dict[str, list[int]]:
        """Random directions and weights for the inputs that only this function has."""
        rng = random.Random(f"{self.seed}:{p}:{program.name}")
        further = [port for port in program.inputs if port.name not in known]
        return {port.name: [rng.randrange(1, p) for _ in range(port.size)] for port in further}

    def _check(self, output: Output, program: Program, candidates: Sequence[Candidate], p: int) -> None:
        for attempt in range(ATTEMPTS):
            numbers, inputs, literal = self._point(p, attempt)
            inputs = inputs | self._further(program, inputs, p)
            _ = literal.at  # the angles of the joints come first: the sums that the program takes are made of them
            try:
                register_sums(program, numbers, inputs)
                results = [(candidate, candidate.evaluate(numbers, inputs)) for candidate in candidates]
                at, lowered = residues(inputs, p), self.system.lowered
                held: list[Outputs] = []
                for candidate, values in results:
                    if values not in held:  # what has the values of another candidate stands or falls with it
                        found = Emitted(values, at, lowered, random.Random(self.seed), p)
                        _compare(literal, output, candidate, found)
                        held.append(values)
            except NotInField:
                continue
            return
        raise self._nowhere(output, program, p)

    def _nowhere(self, output: Output, program: Program, p: int) -> SymgenError:
        """Why there is no point: the scene, where what was derived has no value anywhere either, else the text."""
        for attempt in range(0 if isinstance(program, LoopProgram | ComposedProgram) else ATTEMPTS):
            numbers, inputs, _ = self._point(p, attempt)
            try:
                evaluate_residues(program, numbers, inputs | self._further(program, inputs, p))
            except NotInField:
                continue
            return CertificateError(f"{output.name}: what was emitted has a value at no point of GF(p)")
        scene = self.system.scene
        return SceneError(
            f"{output.name} has no value at any configuration: the mass matrix is singular (a point mass or a massless "
            "body that nothing else holds), or a spring's length is zero",
            scene.source or scene.name,
        )


def _compare(literal: Literal, output: Output, candidate: Candidate, emitted: Emitted) -> None:
    for row, expected, found in _pairs(literal, output, emitted):
        if not found == expected:
            raise CertificateError(
                f"{output.name}: the emitted {candidate.what} is not {row} as defined (they differ in GF({emitted.p}))"
            )


def _state(inputs: Inputs, p: int) -> State:
    fields: dict[str, Any] = {name: tuple(Residue(x, p) for x in values) for name, values in inputs.items()}
    fields["dt"] = fields["dt"][0]
    return State(**fields)


LARGE = 1 << 40
"""Degrees from here on are too high for `MOST_POINTS` points of 61 bits to be sure."""


def _degree(program: Program, system: System) -> tuple[int, str]:
    """A bound of the degree of (emitted − literal), cleared of denominators, in the coordinates of the random points,
    and what the bound assumes.

    A joint's (cos, sin) or quaternion entries count 4. Formal degrees double with every elimination; where they outgrow
    the field, each operation is counted as one random residue instead, and the method says so.
    """
    literal = 16 * system.tree.nv + 64
    if isinstance(program, ComposedProgram):
        bound, operations = LARGE, max(1, composed_counts(program, _counted(program)).flops)
    elif isinstance(program, LoopProgram):
        bound, operations = formal_degree(program, LARGE), program.performed
    else:
        bound, operations = _formal_degree(program), len(program.instructions)
    assumption = ""
    if bound >= LARGE:
        bound, assumption = operations, "; operations counted as random residues"
    return max(bound, literal) + literal, assumption


def _counted(program: ComposedProgram) -> dict[str, Counts]:
    """Operations of what a step calls."""
    called = program.callees.items()
    return {name: loop_counts(own) if isinstance(own, LoopProgram) else count(own) for name, own in called}


def _formal_degree(program: Program) -> int:
    """Degree of numerator and denominator of the outputs as the operations build them, nothing cancelled."""
    over: list[int] = []
    under: list[int] = []
    for op, args, _, _, _ in program.instructions:
        if op == "mul":
            x, y = args
            above, below = over[x] + over[y], under[x] + under[y]
        elif op in ("add", "sub"):
            x, y = args
            above, below = max(over[x] + under[y], over[y] + under[x]), under[x] + under[y]
            if x == y:
                above, below = over[x], under[x]
        elif op == "neg":
            above, below = over[args[0]], under[args[0]]
        elif op == "div":
            x, y = args
            above, below = over[x] + under[y], under[x] + over[y]
        else:
            above, below = {"const": 0, "input": 1}.get(op, 4), 0
        over.append(above if above < LARGE else LARGE)
        under.append(below if below < LARGE else LARGE)
    return max((over[i] + under[i] for row in program.results for i in row), default=0)
