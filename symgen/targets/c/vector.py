"""A program as statements over vectors, one lane a state: the statements of the scalar function, spelled with macros.

scalar                          vector
``q[1]``, ``p[3]``, ``dt``      ``IN(q, 1)``, ``TILE(p, 3)``, ``TILE(dt, 0)``
``M[4] = x;``                   ``OUT(M, 4) = x;``
``const double t1 = x;``        ``const reals t1 = x;``
``M[4] = 0.22;``                ``OUT(M, 4) = SPLAT(0.22);`` (nothing in it is a vector)
``sqrt(x)``, ``cosine(x)``, …   ``SQRT(x)``, ``COS(x)``, …

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
from symgen.targets.c.vector_order import spread_divisions

CALLS = {"sqrt": "SQRT", "cos": "COS", "sin": "SIN", **{name: name.upper() for name in ENTIRE}}
"""Operation → macro."""
PAIR = "SINE_COSINE"
MACROS = frozenset([*CALLS.values(), PAIR, "IN", "OUT", "TILE", "SPLAT", "REQUIRE"])
_FRAME = """reals words lane_step slow_lanes lane first count status own_p stride tile state part n i"""
FRAME = frozenset(_FRAME.split()) | MACROS
"""Words of the batch file that no local name of a statement may hide."""

_LOOP = re.compile(r"(for \(int i = \d+; i < \d+; \+\+i\)) (\w+)\[i\] = 0;", re.ASCII)
_STATEMENT = re.compile(rf"{_LOOP.pattern}|[^;\s][^;]*;", re.ASCII)
_TYPED = re.compile(r"(?:const )?(?:double|float) \w+", re.ASCII)
_ENTRY = re.compile(r"([A-Za-z_]\w*)\[(\d+)\]", re.ASCII)
_WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*", re.ASCII)


@dataclass(frozen=True)
class VectorBody:
    """The inside of a function over vectors."""

    lines: tuple[tuple[str, str], ...]
    """("heading" | "code", text)."""
    requires: tuple[str, ...]
    """Expressions that must be positive; a lane where one is not is left to the scalar function."""
    unused: tuple[str, ...]
    called: frozenset[str]
    """Macros of `CALLS` and `PAIR`."""
    words: frozenset[str]


def is_shared(name: str, shape: Sequence[int]) -> bool:
    """Inputs that come in a tile of their own: those that states share, or may share."""
    return name in ("dt", "p") or shape == ()


def vector_body(program: Program, table: ConstantTable, pairs: bool, taken: Iterable[str]) -> VectorBody:
    """The statements of ``program`` over vectors. ``pairs``: sine and cosine come from one call."""
    names = Names([*taken, *FRAME])
    ordered = spread_divisions(program)
    body = write_body(ordered, table, Functions(CALLS, PAIR if pairs else ""), names.taken)
    spell = _speller(program, {constant.name for constant in table})
    lines = [(kind, spell(text) if kind == "code" else text) for kind, text in body.lines]
    if ordered is not program:
        lines = [line for line in lines if line[0] == "code"]  # its phases are mixed
    requires = tuple(spell(f"{text};").removesuffix(";") for text in body.guards)
    return VectorBody(tuple(lines), requires, body.unused, body.called, body.words)


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
    left = _LEFT.search("\n".join([text, *guards]))
    if left:
        raise refuse(f"{left[0]} out of place")
    return text + _tail(program, guards, precision, status)


_FOREIGN = re.compile(
    r"[\[\]#\"']|\b(?:double|float|sqrtf?|sinf?|cosf?|sine|cosine|sine_cosine|cos_sqrt|sinc_sqrt|sinc3_sqrt)\b"
)
_REQUIRE = re.compile(r"^    REQUIRE\(([^;]*)\);\n", re.ASCII | re.MULTILINE)
_SPLAT = re.compile(r"= SPLAT\((-?[\w.+-]+)\);", re.ASCII)
_REACH = re.compile(r"\b(IN|OUT|TILE)\(([A-Za-z_]\w*), (\d+|i)\)", re.ASCII)
_CALL = re.compile(rf"\b({'|'.join([*CALLS.values(), PAIR])})\(", re.ASCII)
_LEFT = re.compile(rf"\b(?:{'|'.join(sorted(FRAME - {'i'}))})\b", re.ASCII)


@cache
def spelling(trigonometry: str, precision: str) -> Mapping[str, str]:
    """Macro → function of the scalar file."""
    f = "f" if precision == "float" else ""
    own = trigonometry == "polynomial"
    names = {"SQRT": f"sqrt{f}", "COS": "cosine" if own else f"cos{f}", "SIN": "sine" if own else f"sin{f}"}
    return names | {name.upper(): name for name in ENTIRE} | {PAIR: "sine_cosine"}


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
