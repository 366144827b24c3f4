"""main.c: every function called once, at one state, its outputs printed."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import prod

from symgen.program.instructions import Port, Program
from symgen.targets.c.info import Info
from symgen.targets.c.literals import Precision, inline_literal, rounded_literal
from symgen.targets.c.signatures import Symbols, returns_status
from symgen.targets.c.templates import render

_QUATERNION = (Fraction(1, 10), Fraction(1, 2), Fraction(7, 10), Fraction(1, 2))
"""x y z w; its norm is exactly one."""
_QUATERNION_AT = {"spherical": 0, "floating": 3}


def example_state(info: Info) -> dict[str, tuple[Fraction, ...]]:
    """A state in general position: quaternions of norm one, nothing zero; parameters at their defaults."""
    q = [Fraction(i + 1, 10) for i in range(info.nq)]
    for joint in info.joints:
        if joint.type in _QUATERNION_AT:
            start = joint.q[0] + _QUATERNION_AT[joint.type]
            q[start : start + 4] = _QUATERNION
    return {
        "q": tuple(q),
        "v": tuple(Fraction(i + 1, 5) for i in range(info.nv)),
        "a": tuple(Fraction(1 - 2 * (i % 2), 2) for i in range(info.nv)),
        "tau": tuple(Fraction(2 * (i % 2) - 1, 4) for i in range(info.nv)),
        "dt": (Fraction(1, 100),),
        "p": tuple(value for parameter in info.parameters for value in parameter.default),
    }


def example_file(
    name: str,
    programs: Sequence[Program],
    symbols: Sequence[Symbols],
    info: Info,
    precision: Precision,
    banner: Sequence[str],
) -> str:
    """The text of main.c."""

    def variables(program: Program) -> list[str]:
        return [f"{program.name}_{port.name}" for port in program.outputs]

    needed: dict[str, Port] = {port.name: port for program in programs for port in program.inputs}
    state = example_state(info)
    further = {key: (Fraction(1, 4),) * port.size for key, port in needed.items() if key not in state}
    inputs = []
    for key, numbers in {**state, **further}.items():
        if key in needed:
            port = needed[key]
            values = [_literal(value, precision) for value in (*numbers, *[Fraction(0)] * port.size)[: port.size]]
            scalar = port.shape == ()
            declaration = port.name if scalar else f"{port.name}[{port.size}]"
            inputs.append({"declaration": declaration, "value": values[0] if scalar else f"{{{', '.join(values)}}}"})
    return render(
        "c/main.c.j2",
        banner=banner,
        header=f"{name}.h",
        real=precision.c_type,
        digits=precision.digits,
        inputs=inputs,
        functions=[
            {
                "name": program.name,
                "call": f"{'(void)' if returns_status(program, info.options.status) else ''}{row.scalar}"
                f"({', '.join([*(port.name for port in program.inputs), *variables(program)])})",
                "outputs": [
                    {
                        "name": port.name,
                        "variable": variable,
                        "size": port.size,
                        "rows": prod(port.shape[:-1]),
                        "columns": port.shape[-1] if port.shape else 1,
                    }
                    for port, variable in zip(program.outputs, variables(program), strict=True)
                ],
            }
            for program, row in zip(programs, symbols, strict=True)
        ],
    )


def _literal(value: Fraction, precision: Precision) -> str:
    text = inline_literal(abs(value), precision) or rounded_literal(abs(value), precision)
    return f"-{text}" if value < 0 else text
