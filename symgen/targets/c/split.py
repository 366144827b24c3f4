"""Long functions in parts: compilers take a time that grows faster than the length of a function.

A function of more than `LONGEST` statements is written as static functions of `PART_LENGTH` at most, called one after
the other. What a later part reads of an earlier one goes through an array ``w``: stored at the end of the part that
makes it, and read back under the same name where it is used. `joined` undoes it, strictly: what is read back is the
one body that was written.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from symgen.errors import CertificateError
from symgen.targets.c.statements import Body

LONGEST = 8000
"""Statements that a function may have in one piece. Measured with gcc -O3: 6,000 take 8 s, 30,000 more than 400 s."""
PART_LENGTH = 1000
"""Statements of a part. Measured with gcc -O3 on 32,000 statements (derivatives of Talos' forward dynamics): parts of
2,500 take 44 s, of 1,000 33 s and of 500 29 s, the loads and stores at the cuts 0, 4 and 10 % more instructions."""

_DEFINED = re.compile(r"const (?:double|float) ([A-Za-z_]\w*) = |(?:double|float) (\w+), (\w+);", re.ASCII)
_WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*", re.ASCII)
Line = tuple[str, str]
"""("heading" | "code", text)."""


@dataclass(frozen=True)
class Part:
    """A static function: its declaration and its statements, loads first and stores last."""

    declaration: str
    call: str
    lines: tuple[Line, ...]


def split(body: Body, real: str, symbol: str, arguments: Sequence[str]) -> tuple[tuple[Part, ...], Body]:
    """The parts of a long body and what is left for the function itself: calls, and loads for its guards. No parts of
    one that is short enough. ``arguments``: the function's, as declared."""
    if sum(1 for kind, _ in body.lines if kind == "code") <= LONGEST:
        return (), body
    chunks = _chunks(body.lines)
    defined = [_names_defined(chunk) for chunk in chunks]
    used = [_words(chunk) for chunk in chunks]
    used.append({word for guard in body.guards for word in _WORD.findall(guard)})
    crossing = [
        sorted(name for name in names if any(name in later for later in used[k + 1 :]))
        for k, names in enumerate(defined)
    ]
    place = {name: index for index, name in enumerate(name for names in crossing for name in names)}

    def loads(k: int) -> list[Line]:
        here = defined[k] if k < len(chunks) else set()
        needed = sorted((name for name in used[k] if name in place and name not in here), key=place.__getitem__)
        return [("code", f"const {real} {name} = w[{place[name]}];") for name in needed]

    parts = []
    for k, chunk in enumerate(chunks):
        stores = [("code", f"w[{place[name]}] = {name};") for name in crossing[k]]
        own = [item for item in arguments if argument_name(item) in used[k]]
        own += [f"{real} *w"] if stores or loads(k) else []
        name = part_symbol(symbol, k)
        call = f"{name}({', '.join(argument_name(item) for item in own)});"
        parts.append(Part(f"{name}({', '.join(own)})", call, (*loads(k), *chunk, *stores)))
    calls = [("code", f"{real} w[{len(place) or 1}];"), *(("code", part.call) for part in parts)]
    return tuple(parts), replace(body, lines=(*calls, *loads(len(chunks))))


def argument_name(declared: str) -> str:
    """``const double q[7]`` → ``q``."""
    return declared.partition("[")[0].split()[-1].lstrip("*")


def _chunks(lines: Sequence[Line]) -> list[list[Line]]:
    """Runs of PART_LENGTH statements at most, of one length; a heading stays with what it heads, and the tables of
    sines and cosines with the statements that read them."""
    statements = [k for k, (kind, _) in enumerate(lines) if kind == "code"]
    first = max((k for k in statements if _of_tables(lines[k][1])), default=-1) + 1
    count = -(-len(statements) // PART_LENGTH)
    cuts = [0]
    for k in range(1, count):
        cut = max(first, statements[k * len(statements) // count])
        if lines[cut - 1][0] == "heading":
            cut -= 1
        if cut > cuts[-1]:
            cuts.append(cut)
    return [list(lines[a:b]) for a, b in zip(cuts, [*cuts[1:], len(lines)], strict=True)]


def _of_tables(text: str) -> bool:
    return ("angles" in text or "sines" in text) and bool(re.search(r"\b(angles|sines|cosines)\b", text))


def _names_defined(chunk: Sequence[Line]) -> set[str]:
    text = "\n".join(text for kind, text in chunk if kind == "code")
    return {name for match in _DEFINED.finditer(text) for name in match.groups() if name}


def _words(chunk: Sequence[Line]) -> set[str]:
    return set(_WORD.findall("\n".join(text for kind, text in chunk if kind == "code")))


def part_symbol(symbol: str, number: int) -> str:
    return f"{symbol}_part{number}"


PART = re.compile(r"\s*SYMGEN_PART void (\w+)\(([^()]*)\)\n\{\n(.*?)\n\}\n", re.ASCII | re.DOTALL)
_CALL = re.compile(r"\s*(\w+)\(([^()]*)\);", re.ASCII)
_LOAD = re.compile(r"\s*const (?:double|float) (\w+) = w\[(\d{1,6})\];", re.ASCII)
_STORE = re.compile(r"\s*w\[(\d{1,6})\] = (\w+);\s*", re.ASCII)


def joined(place: str, symbol: str, real: str, arguments: str, parts: Sequence[tuple[str, str, str]], body: str) -> str:
    """The one body that parts, as (name, declared arguments, body), and the function that calls them amount to.

    Raises CertificateError where a part is not called as it is declared, in order and once, or where what one stores
    is not what others read under its name.
    """
    items = [" ".join(item.split()) for item in arguments.split(",")]
    allowed = {argument_name(item): item for item in items} | {"w": f"{real} *w"}
    declared = re.match(rf"\s*{real} w\[(\d{{1,6}})\];", body)
    if declared is None:
        raise CertificateError(f"{place}: its parts have no w")
    position, traffic, text = declared.end(), _Traffic(int(declared[1])), list[str]()
    for number, (name, own, inside) in enumerate(parts):
        taken = [" ".join(item.split()) for item in own.split(",")]
        call = _CALL.match(body, position)
        if name != part_symbol(symbol, number) or any(allowed.get(argument_name(item)) != item for item in taken):
            raise CertificateError(f"{place}: {name} is not declared as it should be")
        wanted = [argument_name(item) for item in taken]
        if call is None or call[1] != name or [item.strip() for item in call[2].split(",")] != wanted:
            raise CertificateError(f"{place}: {name} is not called where it should be")
        text.append(traffic.without(f"{place}: {name}", inside))
        position = call.end()
    text.append(traffic.without(place, body[position:]).removeprefix("\n"))
    if traffic.size != max(1, len(traffic.slots)):
        raise CertificateError(f"{place}: w has another size than what is stored in it")
    return "\n".join(text).removesuffix("\n")


class _Traffic:
    """What parts have stored in w so far, and what they have defined."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.slots: dict[int, str] = {}
        self.defined: set[str] = set()

    def without(self, place: str, body: str) -> str:
        """A part's own statements: loads at its beginning and stores at its end taken out and checked. A slot is stored
        once, so a load under the same name is the value that was stored; what is not loaded is not known."""
        position, loaded = 0, set[str]()
        while match := _LOAD.match(body, position):
            if self.slots.get(int(match[2])) != match[1] or match[1] in loaded:
                raise CertificateError(f"{place}: w[{match[2]}] is not {match[1]}")
            loaded.add(match[1])
            position = match.end()
        lines = body[position:].rstrip().split("\n")
        while match := _STORE.fullmatch(lines[-1]):
            if int(match[1]) in self.slots or not int(match[1]) < self.size:
                raise CertificateError(f"{place}: w[{match[1]}] is stored twice, or there is none")
            self.slots[int(match[1])] = match[2]
            lines.pop()
        kept = "\n".join(lines) + "\n"
        words = set(_WORD.findall(kept))
        if "w" in words or words & (self.defined - loaded):
            raise CertificateError(f"{place}: reads what is not there")
        self.defined |= {name for found in _DEFINED.finditer(kept) for name in found.groups() if name}
        return kept
