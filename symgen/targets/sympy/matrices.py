"""Catalogue rows as SymPy: closed forms where they can be read, definitions and a result where they are long."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import TYPE_CHECKING, Any

import sympy

from symgen.catalogue import CATALOGUE, PRODUCTS, output_ports, row_of, split_row
from symgen.errors import SceneError
from symgen.literal.equations import Literal
from symgen.program.instructions import Port
from symgen.targets.sympy.angles import merge_angles
from symgen.targets.sympy.definitions import define, nested
from symgen.targets.sympy.numbers import PolynomialState, polynomial_state
from symgen.targets.sympy.polynomials import Polynomial, TooLargeError
from symgen.targets.sympy.readable import Writer
from symgen.targets.sympy.symbols import Symbols, system_symbols

if TYPE_CHECKING:
    from symgen.system import System

BUDGET = 150_000
"""Products of terms that a closed form may take to derive: less than a second."""
LONGEST = 400
"""Terms of one entry beyond which a closed form is not given."""
READABLE = 40
"""Terms of one entry beyond which definitions are printed instead."""
SOLVED = 3
"""Accelerations are given in closed form for up to so many."""

Given = Mapping[str, Sequence[Any]]


@dataclass(frozen=True)
class Equation:
    """One output of a catalogue row. ``value`` is a Matrix (a column for a vector) or an expression (a scalar), in the
    symbols of the arguments and of ``definitions``, which are in order."""

    row: str
    port: Port
    value: sympy.Matrix | sympy.Expr
    definitions: tuple[tuple[sympy.Symbol, sympy.Expr], ...] = ()

    def lambdify(self, arguments: Sequence[Any], modules: str = "numpy") -> Callable[..., Any]:
        """`sympy.lambdify` of the value, the definitions computed on the way."""
        return sympy.lambdify(arguments, self.value, modules, cse=lambda x: (list(self.definitions), [x]))  # type: ignore[no-any-return]


def sympy_matrix(system: System, name: str, given: Given | None = None) -> Any:
    """A catalogue row (``mass_matrix``, ``frame_pose:tool``) or a function of the scene as SymPy.

    Matrices are Matrix, vectors column Matrix, scalars expressions; a function with several outputs gives a dict by
    output name. The free symbols are those of `system_symbols`, numbers are exact. Closed forms are factored; where one
    would have hundreds of terms the expression is nested as the cheapest plan computes it, its parts shared. ``given``
    puts values in place of parameters: {"link.com": (0, 0, -l)}. Raises SceneError for names the catalogue has not.
    """
    output = system.output(name)
    symbols = system_symbols(system.scene, system.tree)
    ports = iter(output_ports(output.of, system.sizes))
    found: dict[str, Any] = {}
    for row in output.of:
        require_no_product(row)
        entries = closed_form(system, row, symbols, LONGEST, given) if len(row_of(row).outputs) == 1 else None
        several = [entries] if entries is not None else nested(system.program(row), arguments(symbols, given, system))
        for part in several:
            port = next(ports)
            found[port.name] = shaped(port, part)
    return found if len(found) > 1 else next(iter(found.values()))


def require_no_product(row: str) -> None:
    """Raises SceneError for products of derivatives, whose directions and weights have no symbols."""
    if split_row(row)[0] in PRODUCTS:
        raise SceneError(f"{row} has no form in SymPy; the function itself can be generated", "--equations")


def row_equation(system: System, row: str, longest: int = READABLE) -> Equation:
    """A catalogue row for reading: a closed form of at most ``longest`` terms an entry, or definitions and a result."""
    symbols = system_symbols(system.scene, system.tree)
    (port,) = output_ports((row,), system.sizes)
    entries = closed_form(system, row, symbols, longest)
    if entries is not None:
        return Equation(row, port, shaped(port, entries))
    found = define(system.program(row), arguments(symbols, None, system))
    return Equation(row, port, shaped(port, found.results[0]), found.steps)


def arguments(symbols: Symbols, given: Given | None, system: System) -> dict[str, tuple[sympy.Expr, ...]]:
    """Every argument, flat, by name."""
    p: list[sympy.Expr] = list(symbols.p)
    for parameter in system.scene.parameters:
        if given and parameter.name in given:
            p[parameter.start : parameter.start + parameter.size] = [sympy.sympify(x) for x in given[parameter.name]]
    return {"q": symbols.q, "v": symbols.v, "a": symbols.a, "tau": symbols.tau, "dt": (symbols.dt,), "p": tuple(p)}


def shaped(port: Port, entries: Sequence[sympy.Expr]) -> sympy.Matrix | sympy.Expr:
    if not port.shape:
        return entries[0]
    if len(port.shape) > 2:
        return sympy.ImmutableDenseNDimArray(list(entries), port.shape)
    rows, columns = (*port.shape, 1)[:2]
    return sympy.Matrix(rows, columns, list(entries))


# -- closed forms ----------------------------------------------------------------------------------------------------


def closed_form(
    system: System, row: str, symbols: Symbols, longest: int, given: Given | None = None
) -> tuple[sympy.Expr, ...] | None:
    """The entries of a row, row-major, from the literal definition in polynomials; None when they are too long."""
    try:
        at = polynomial_state(system.scene, system.tree, symbols, BUDGET, given)
        literal = system.literal(at.numbers, at.state)
        name, frame = split_row(row)
        definition = CATALOGUE[name].literal
        if definition is None:
            return _accelerations(literal, at, symbols, longest) if name == "forward_dynamics" else None
        (found,) = definition(literal, frame)
        entries = _flat(found)
        if any(isinstance(entry, Polynomial) and len(entry.terms) > longest for entry in entries):
            return None
        writer = Writer((*symbols.a, *(symbols.v if name == "kinetic_energy" else ())))
        return tuple(writer.write(entry) for entry in entries)
    except TooLargeError:
        return None


def _flat(found: Any) -> list[Any]:
    if not isinstance(found, tuple):
        return [found]
    return [entry for part in found for entry in _flat(part)]


def _accelerations(
    literal: Literal, at: PolynomialState, symbols: Symbols, longest: int
) -> tuple[sympy.Expr, ...] | None:
    """M⁻¹(τ − h) as quotients, by Cramer's rule."""
    n = literal.tree.nv
    if n > SOLVED:
        return None
    mass = [_polynomial(at, entry) for row in literal.mass_matrix() for entry in row]
    rest = [tau - _polynomial(at, h) for tau, h in zip(at.state.tau, literal.bias_force(), strict=True)]
    short = merge_angles([*mass, *rest])  # cos θ₂ as one generator, not as cos θ₁ cos(θ₁+θ₂) + sin θ₁ sin(θ₁+θ₂)
    m, b = [short[k * n : (k + 1) * n] for k in range(n)], short[n * n :]
    determinant = _determinant(m)
    if not determinant.terms:
        scene = literal.values.scene
        raise SceneError("the mass matrix is singular in every configuration", scene.source or scene.name)
    numerators = [_determinant([[b[i] if j == k else m[i][j] for j in range(n)] for i in range(n)]) for k in range(n)]
    if max(len(x.terms) for x in (determinant, *numerators)) > longest:
        return None
    writer = Writer(symbols.tau)
    return tuple(_quotient(writer, numerator, determinant) for numerator in numerators)


def _polynomial(at: PolynomialState, x: Any) -> Polynomial:
    return x if isinstance(x, Polynomial) else at.numbers.const(x)


def _determinant(m: list[list[Polynomial]]) -> Polynomial:
    if len(m) == 1:
        return m[0][0]
    minors = [_determinant([row[:k] + row[k + 1 :] for row in m[1:]]) for k in range(len(m))]
    found = m[0][0] * minors[0]
    for k in range(1, len(m)):
        found = found + (m[0][k] * minors[k] if k % 2 == 0 else -(m[0][k] * minors[k]))
    return found


LARGE = 100_000


def _quotient(writer: Writer, numerator: Polynomial, denominator: Polynomial) -> sympy.Expr:
    """In integers, where none of them is large."""
    values = [*numerator.coefficients.values(), *denominator.coefficients.values()]
    content = Fraction(gcd(*(x.numerator for x in values)), lcm(*(x.denominator for x in values)))
    if len(denominator.terms) == 1:
        (content,) = denominator.coefficients.values()
    elif max(abs(x / content) for x in values) > LARGE:
        content = Fraction(1)
    return writer.write(numerator / content) / writer.write(denominator / content)
