"""Statements in another order: what needs no quotient is computed while quotients are waited for.

A chain of divisions (a factorisation) takes many cycles and few operations. Written as plans write it, after all the
rest, it leaves a processor idle even when eight states run side by side.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from symgen.program.instructions import Instruction, Program

CHAIN = 3
"""Fewer divisions are no chain."""
TURNING = ("cos", "sin", "cos_sqrt", "sinc_sqrt", "sinc3_sqrt")


def spread_divisions(program: Program) -> Program:
    """The same program: first what divisions need, then they and what has nothing to do with them in turn, then what
    follows from both."""
    code = program.instructions
    if sum(instruction.op == "div" for instruction in code) < CHAIN:
        return program
    after = _after(code)
    needed = _needed(code)
    slow = [i for i in range(len(code)) if i in needed and i in after]
    free = [i for i in range(len(code)) if i not in needed and i not in after]
    order = [i for i in range(len(code)) if i in needed and i not in after]
    order += _merged(slow, free)
    order += [i for i in range(len(code)) if i not in needed and i in after]
    return _reordered(program, order)


def angles_first(program: Program) -> Program:
    """The same program: sines and cosines of angles that depend on no others come first, so that they can be taken
    together."""
    code = program.instructions
    plain: list[bool] = []
    turned: dict[int, list[int]] = {}
    for index, instruction in enumerate(code):
        turning = instruction.op in TURNING
        plain.append(not turning and all(plain[k] for k in instruction.args))
        if instruction.op in ("cos", "sin") and plain[instruction.args[0]]:
            turned.setdefault(instruction.args[0], []).append(index)
    if len(turned) < 2:
        return program
    first = sorted(_cone(code, turned))
    first += [index for row in turned.values() for index in row]
    known = set(first)
    return _reordered(program, [*first, *(k for k in range(len(code)) if k not in known)])


def _cone(code: Sequence[Instruction], roots: Iterable[int]) -> set[int]:
    found: set[int] = set()
    stack = list(roots)
    while stack:
        index = stack.pop()
        if index not in found:
            found.add(index)
            stack.extend(code[index].args)
    return found


def _after(code: Sequence[Instruction]) -> set[int]:
    """Divisions, and what depends on one."""
    found: set[int] = set()
    for index, instruction in enumerate(code):
        if instruction.op == "div" or any(k in found for k in instruction.args):
            found.add(index)
    return found


def _needed(code: Sequence[Instruction]) -> set[int]:
    """Divisions, and what one depends on."""
    found: set[int] = set()
    for index in reversed(range(len(code))):
        if code[index].op == "div" or index in found:
            found.update((index, *code[index].args))
    return found


def _merged(few: Sequence[int], many: Sequence[int]) -> list[int]:
    """Both in their order, the first spread evenly among the second."""
    keyed = [((k + 0.5) / len(few), 0, i) for k, i in enumerate(few)]
    keyed += [((k + 0.5) / len(many), 1, i) for k, i in enumerate(many)]
    return [i for _, _, i in sorted(keyed)]


def _reordered(program: Program, order: Sequence[int]) -> Program:
    place = {old: new for new, old in enumerate(order)}
    code = program.instructions
    return replace(
        program,
        instructions=tuple(code[old]._replace(args=tuple(place[k] for k in code[old].args)) for old in order),
        results=tuple(tuple(place[i] for i in row) for row in program.results),
        guards=tuple(place[i] for i in program.guards),
    )
