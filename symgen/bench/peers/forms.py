"""Our functions in other forms: the C library's trigonometry, float, other plans, loops, another compiler.

Each is generated with its certificate, under a name of its own, so that all link into one program.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from symgen.accuracy.variants import Variant as Form
from symgen.accuracy.variants import chosen, plans_of, with_options
from symgen.bench.peers import ours
from symgen.bench.variant import OURS, Found, Left, Problem, Variant
from symgen.errors import NotSupportedError, SymgenError
from symgen.loops.model import LoopProgram
from symgen.plans.choose import Choice
from symgen.plans.families import Family
from symgen.scene.model import Output, Scene
from symgen.system import System

MAIN = ("mass_matrix", "bias_force", "inverse_dynamics", "forward_dynamics")
"""Functions that are measured in other forms unless all are asked for."""
CHOICES = ("none", "standard", "all")
"""What ``--variants`` may ask for."""
CLANG = "clang"


@dataclass(frozen=True)
class Way:
    """A form and what it is called: ``name`` behind ``symgen``, ``letters`` in the names of its functions."""

    name: str
    letters: str
    form: Form


@dataclass(frozen=True)
class Remade:
    """The C that is there, compiled in another way."""

    name: str
    letters: str
    flags: tuple[str, ...] = ()
    compiler: str = ""


UNFUSED = Remade("unfused", "unfused", flags=("-ffp-contract=off",))


def build(problem: Problem, found: Found, which: str) -> Found:
    """Further variants of the functions in ``found``, which are ours as they come. ``which``: ``standard`` or
    ``all``."""
    more = Found()
    for own in (variant for variant in found.variants if variant.peer == OURS):
        if which != "all" and own.function not in MAIN:
            continue
        for way in ways(problem, own, which):
            try:
                more.variants += generated(problem, own.function, way)
            except SymgenError as error:
                more.left.append(Left(f"{OURS} {way.name}", own.function, str(error)))
        more.variants += [remade(own, how) for how in compilers()]
    return more


def ways(problem: Problem, own: Variant, which: str) -> Iterator[Way]:
    """The forms of a function beside the one that its scene asks for."""
    options = problem.scene.options
    precision, trigonometry = options.precision, options.trigonometry
    other = "float" if precision == "double" else "double"
    apart = "libm" if trigonometry == "polynomial" else "polynomial"
    yield Way(apart, apart, Form(precision, apart, batch=which == "all"))
    yield Way(other, other, Form(other, trigonometry, batch=True))
    yield Way(f"{other} {apart}", f"{other}_{apart}", Form(other, apart, batch=which == "all"))
    output = problem.system.output(own.function)
    if own.plan != problem.programs[own.function].plan:
        return  # it is loops, and straight-line code is longer than a compiler likes
    yield Way("loops", "loops", Form(precision, trigonometry, loops=True))
    for number, family in enumerate(other_plans(problem, output)):
        plan = family.plan(output)
        yield Way(f"plan: {plan}", f"plan{number}", Form(precision, trigonometry, family=family))
        if which == "all":
            yield Way(f"{other} plan: {plan}", f"{other}_plan{number}", Form(other, trigonometry, family=family))


def other_plans(problem: Problem, output: Output) -> list[Family]:
    """Every family of plans but the one that was chosen, each name once."""
    families = {family.plan(output): family for family in plans_of(problem.system, output)}
    return [family for plan, family in families.items() if plan != problem.programs[output.name].plan]


def generated(problem: Problem, name: str, way: Way) -> list[Variant]:
    """A function in one form, and its batches where these are asked for."""
    output = problem.system.output(name)
    scene = with_options(problem.scene, (output,), way.form)
    scene = replace(scene, name=f"{scene.name}_{way.letters}", options=replace(scene.options, status=False))
    this = ours.made(problem, output, scene, system_of(problem, scene, output, way.form))
    scalar = ours.scalar_variant(problem, this, f"{OURS} {way.name}")
    if not way.form.batch:
        return [scalar]
    names = (f"{OURS} {way.name} batch", f"{OURS} {way.name} soa")
    return [scalar, *ours.batch_variants(problem, this, names)]


def system_of(problem: Problem, scene: Scene, output: Output, form: Form) -> System:
    """The problem's system for another form of a function. Raises NotSupportedError where loops are not written."""
    system = problem.system
    plans = chosen(system, (output,), form.family)
    if not plans and not form.loops:
        plans = {(output, every): Choice(problem.programs[output.name], ()) for every in (False, True)}
    fresh = System(scene, system.tree, system.natural, plans)
    if form.loops and not isinstance(fresh.code(output.name).program, LoopProgram):
        raise NotSupportedError(fresh.code(output.name).why)
    return fresh


def compilers() -> Sequence[Remade]:
    """Other ways to compile, as far as they are there."""
    there = [Remade(CLANG, CLANG, compiler=CLANG)] if shutil.which(CLANG) else []
    return (*there, UNFUSED)


def remade(variant: Variant, how: Remade) -> Variant:
    """A variant compiled in another way; its function is renamed, the C stays what it is."""
    symbol, other = variant.symbol, f"{variant.symbol}_{how.letters}"
    units = tuple(
        replace(unit, flags=(*unit.flags, *how.flags, f"-D{symbol}={other}"), compiler=how.compiler)
        for unit in variant.units
    )
    return replace(
        variant, peer=f"{variant.peer} {how.name}", symbol=other, units=units, generate_s=None,
        declaration=variant.declaration.replace(f"{symbol}(", f"{other}("),
        call=variant.call.replace(f"{symbol}(", f"{other}("),
    )  # fmt: skip
