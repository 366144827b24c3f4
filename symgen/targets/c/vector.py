"""A program as statements over vectors, one lane a state: the statements of the scalar function, spelled with macros.

scalar                          vector
``q[1]``, ``p[3]``, ``dt``      ``IN(q, 1)``, ``TILE(p, 3)``, ``TILE(dt, 0)``
``M[4] = x;``                   ``OUT(M, 4) = x;``
``const double t1 = x;``        ``const reals t1 = x;``
``M[4] = 0.22;``                ``OUT(M, 4) = SPLAT(0.22);`` (nothing in it is a vector)
``sqrt(x)``, ``cosine(x)``, …   ``SQRT(x)``, ``COS(x)``, …
``sine_cosine(x, &s, &c);`` …   ``SINES_COSINES_2(x, &s, &c, y, &t, &d);`` (up to `TOGETHER` angles, declared before)

`vector_body` goes from left to right, `scalar_text` back: what is read of a batch file is read as scalar C.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from symgen.errors import CertificateError
from symgen.program.instructions import Program
from symgen.targets.c.literals import ConstantTable
from symgen.targets.c.names import Names
from symgen.targets.c.statements import ENTIRE, Functions, write_body
from symgen.targets.c.vector_order import angles_first, spread_divisions

CALLS = {"sqrt": "SQRT", "cos": "COS", "sin": "SIN", **{name: name.upper() for name in ENTIRE}}
"""Operation → macro."""
PAIR = "SINE_COSINE"
TOGETHER = 6
"""Angles whose sines and cosines are taken in turn: fewer wait for each other, more need too many registers."""
GROUPS = {count: f"SINES_COSINES_{count}" for count in range(1, TOGETHER + 1)}
MACROS = frozenset([*CALLS.values(), PAIR, *GROUPS.values(), "IN", "OUT", "TILE", "SPLAT", "REQUIRE"])
_FRAME = """reals words lane_step slow_lanes lane first count status own_p stride tile state part n i"""
FRAME = frozenset(_FRAME.split()) | MACROS
"""Words of the batch file that no local name of a statement may hide."""

_LOOP = re.compile(r"(for \(int i = \d+; i < \d+; \+\+i\)) (\w+)\[i\] = 0;", re.ASCII)
_STATEMENT = re.compile(rf"{_LOOP.pattern}|[^;\s][^;]*;", re.ASCII)
_TYPED = re.compile(r"(?:const )?(?:double|float) \w+", re.ASCII)
_ENTRY = re.compile(r"([A-Za-z_]\w*)\[(\d+)\]", re.ASCII)
_WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*", re.ASCII)
_PAIR = re.compile(rf"{PAIR}\((.*), &(\w+), &(\w+)\);", re.ASCII)


@dataclass(frozen=True)
class VectorBody:
    """The inside of a function over vectors."""

    lines: tuple[tuple[str, str], ...]
    """("heading" | "code", text)."""
    requires: tuple[str, ...]
    """Expressions that must be positive; a lane where one is not is left to the scalar function."""
    unused: tuple[str, ...]
    called: frozenset[str]
    """Macros of `CALLS` and `GROUPS`."""
    words: frozenset[str]


def is_shared(name: str, shape: Sequence[int]) -> bool:
    """Inputs that come in a tile of their own: those that states share, or may share."""
    return name in ("dt", "p") or shape == ()


def vector_body(program: Program, table: ConstantTable, pairs: bool, taken: Iterable[str]) -> VectorBody:
    """The statements of ``program`` over vectors. ``pairs``: sine and cosine come from one call."""
    names = Names([*taken, *FRAME])
    ordered = spread_divisions(angles_first(program) if pairs else program)
    body = write_body(ordered, table, Functions(CALLS, PAIR if pairs else ""), names.taken)
    spell = _speller(program, {constant.name for constant in table})
    lines = _together([(kind, spell(text) if kind == "code" else text) for kind, text in body.lines])
    if ordered is not program:
        lines = [line for line in lines if line[0] == "code"]  # its phases are mixed
    requires = tuple(spell(f"{text};").removesuffix(";") for text in body.guards)
    called = body.called - {PAIR} | {name for name in GROUPS.values() if any(name in text for _, text in lines)}
    return VectorBody(tuple(lines), requires, body.unused, frozenset(called), body.words)


def _together(lines: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Runs of sines with cosines, each declared and called, as one declaration and one call for several angles."""
    found: list[tuple[str, str]] = []
    run: list[tuple[str, str, str]] = []

    def flush() -> None:
        parts = -(-len(run) // TOGETHER)
        for part in range(parts):
            angles = run[part * len(run) // parts : (part + 1) * len(run) // parts]
            found.append(("code", f"reals {', '.join(f'{sine}, {cosine}' for _, sine, cosine in angles)};"))
            arguments = ", ".join(f"{angle}, &{sine}, &{cosine}" for angle, sine, cosine in angles)
            found.append(("code", f"{GROUPS[len(angles)]}({arguments});"))
        run.clear()

    for k, (kind, text) in enumerate(lines):
        if match := _PAIR.fullmatch(text) if kind == "code" else None:
            run.append((match[1], match[2], match[3]))
        elif k + 1 == len(lines) or not (kind == "code" and _PAIR.fullmatch(lines[k + 1][1])):
            flush()
            found.append((kind, text))
    flush()
    return found


def _speller(program: Program, constants: set[str]) -> Callable[[str], str]:
    """Scalar statements → statements over vectors."""
    inputs = {port.name: "TILE" if is_shared(port.name, port.shape) else "IN" for port in program.inputs}
    scalars = [port.name for port in program.inputs if port.shape == ()]
    alone = re.compile(rf"\b({'|'.join(scalars)})\b(?![\[(])") if scalars else None

    def entry(match: re.Match[str]) -> str:
        return f"{inputs[match[1]]}({match[1]}, {match[2]})"

    def statement(text: str) -> str:
        if loop := _LOOP.fullmatch(text):
            return f"{loop[1]} OUT({loop[2]}, i) = SPLAT(0);"
        left, equals, right = text.rpartition(" = ")
        if equals and set(_WORD.findall(right)) <= constants:
            right = f"SPLAT({right.removesuffix(';')});"
        elif equals or "(" in right or "[" in right or right.removesuffix(";") in scalars:
            right = _ENTRY.sub(entry, right)
            right = alone.sub(r"TILE(\1, 0)", right) if alone else right
        if store := _ENTRY.fullmatch(left):
            left = f"OUT({store[1]}, {store[2]})"
        left, right = (_TYPED.sub(_retyped, side) for side in (left, right))
        return f"{left}{equals}{right}"

    return lambda text: " ".join(statement(match[0]) for match in _STATEMENT.finditer(text))


def _retyped(match: re.Match[str]) -> str:
    return match[0].replace("double ", "reals ").replace("float ", "reals ")


def scalar_text(place: str, text: str, program: Program, precision: str, trigonometry: str, status: bool) -> str:
    """The body of a scalar function that says what the vector statements ``text`` (without comments) say.

    Raises CertificateError for what a scalar body would be read from though the vector text means something else.
    """
    kinds = {port.name: "TILE" if is_shared(port.name, port.shape) else "IN" for port in program.inputs}
    kinds.update((port.name, "OUT") for port in program.outputs)
    scalars = {port.name for port in program.inputs if port.shape == ()}
    names = spelling(trigonometry, precision)

    def refuse(what: str) -> CertificateError:
        return CertificateError(f"{place}: {what}")

    def entry(match: re.Match[str]) -> str:
        macro, name, index = match.groups()
        if kinds.get(name) != macro:
            raise refuse(f"{match[0]} is not how {name} is reached")
        if name in scalars:
            if index != "0":
                raise refuse(f"{match[0]} is out of bounds")
            return name
        return f"{name}[{index}]"

    foreign = _FOREIGN.search(text)
    if foreign:
        raise refuse(f"{foreign[0]!r} is not part of statements over vectors")
    guards = [_REACH.sub(entry, guard) for guard in _REQUIRE.findall(text)]
    text = _REQUIRE.sub("", text)
    text = re.sub(r"\breals\b(?= [A-Za-z_])", precision, text)
    text = _SPLAT.sub(r"= \1;", text)
    text = _REACH.sub(entry, text)
    text = _CALL.sub(lambda match: f"{names[match[1]]}(", text)
    text = _GROUP.sub(lambda match: _apart(refuse, precision, match), text)
    left = _LEFT.search("\n".join([text, *guards]))
    if left:
        raise refuse(f"{left[0]} out of place")
    return text + _tail(program, guards, precision, status)


def _apart(refuse: Callable[[str], CertificateError], precision: str, match: re.Match[str]) -> str:
    """One call for several angles as calls for each."""
    declared = match[1].split(", ")
    items = " ".join(match[3].split()).split(", ")
    count = int(match[2])
    names = [item for k, item in enumerate(items) if k % 3]
    if len(items) != 3 * count or names != [f"&{name}" for name in declared]:
        raise refuse(f"sines and cosines of {count} angles are not what is declared")
    return "".join(
        f"    {precision} {names[2 * k][1:]}, {names[2 * k + 1][1:]};\n"
        f"    sine_cosine({items[3 * k]}, {names[2 * k]}, {names[2 * k + 1]});\n"
        for k in range(count)
    )


_FOREIGN = re.compile(
    r"[\[\]#\"']|\b(?:double|float|sqrtf?|sinf?|cosf?|sine|cosine|sine_cosine|cos_sqrt|sinc_sqrt|sinc3_sqrt)\b"
)
_REQUIRE = re.compile(r"^    REQUIRE\(([^;]*)\);\n", re.ASCII | re.MULTILINE)
_SPLAT = re.compile(r"= SPLAT\((-?[\w.+-]+)\);", re.ASCII)
_REACH = re.compile(r"\b(IN|OUT|TILE)\(([A-Za-z_]\w*), (\d+|i)\)", re.ASCII)
_CALL = re.compile(rf"\b({'|'.join(CALLS.values())})\(", re.ASCII)
_GROUP = re.compile(
    rf"^    (?:double|float) (\w+(?:, \w+)*);\n    SINES_COSINES_([1-{TOGETHER}])\(([^;]*)\);\n",
    re.ASCII | re.MULTILINE,
)
_LEFT = re.compile(rf"\b(?:{'|'.join(sorted(FRAME - {'i'}))})\b", re.ASCII)


@cache
def spelling(trigonometry: str, precision: str) -> Mapping[str, str]:
    """Macro → function of the scalar file."""
    f = "f" if precision == "float" else ""
    own = trigonometry == "polynomial"
    names = {"SQRT": f"sqrt{f}", "COS": "cosine" if own else f"cos{f}", "SIN": "sine" if own else f"sin{f}"}
    return names | {name.upper(): name for name in ENTIRE}


def _tail(program: Program, guards: Sequence[str], precision: str, status: bool) -> str:
    """The end of the scalar body with these guards."""
    if not guards:
        return "    return 0;\n" if status else ""
    zero, nan = ("0.0f", "NAN") if precision == "float" else ("0.0", "(double)NAN")
    lines = [f"    if (!({' && '.join(f'{text} > {zero}' for text in guards)})) {{"]
    for port in program.outputs:
        lines += [
            f"        for (int i = 0; i < {port.size}; ++i) {{",
            f"            {port.name}[i] = {nan};",
            "        }",
        ]
    lines += ["        return 1;"] if status else []
    lines += ["    }"] + (["    return 0;"] if status else [])
    return "\n".join(lines) + "\n"
