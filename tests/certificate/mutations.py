"""Mutations of emitted text, kind by kind, and whether the certificate refuses them.

``python -m tests.certificate.mutations [SCENE …]`` prints how many of each kind were made and refused.
"""

from __future__ import annotations

import random
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property

from symgen.certificate import Certifier
from symgen.errors import CertificateError
from symgen.generate import _c_candidate, target_info
from symgen.program.instructions import Program
from symgen.scene.load import load
from symgen.system import System, derive
from symgen.targets.c import Emitted, emit_c, read_back

Mutation = tuple[str, str]
"""(kind, text)."""

_BODY = re.compile(r"^(void|int) \w+\([^)]*\)\n\{\n", re.MULTILINE)


def _sites(text: str, pattern: str) -> Iterator[re.Match[str]]:
    """Places of a pattern in the bodies of the emitted functions, comments left out."""
    start = _BODY.search(text)
    assert start is not None
    comments = [match.span() for match in re.finditer(r"/\*.*?\*/", text, re.DOTALL)]
    for match in re.finditer(pattern, text[start.end() :]):
        place = match.start() + start.end()
        if not any(a <= place < b for a, b in comments):
            yield re.compile(pattern).match(text, place) or match


def _swap(text: str, match: re.Match[str], new: str) -> str:
    return text[: match.start()] + new + text[match.end() :]


def constant_digits(text: str) -> Iterator[Mutation]:
    """A digit of every constant: in the code, and in the table of constants the last one that a double holds."""
    for match in re.finditer(r"static const double \w+ = (-?\d[^;]*);", text):
        if (other := _neighbour(match[1])) is not None:
            yield "table constant, last digit", _swap(text, match, match[0].replace(match[1], other))
    for match in _sites(text, r"(?<![\w.])\d+\.\d+(?:e[-+]?\d+)?"):
        yield "inline constant, digit added", _swap(text, match, _more(match[0]))


def _neighbour(number: str) -> str | None:
    """The literal with its last digit changed so that the double changes; None where 17 digits say more than that."""
    mantissa, e, exponent = number.partition("e")
    others = (f"{mantissa[:-1]}{(int(mantissa[-1]) + step) % 10}{e}{exponent}" for step in (1, 5, 9))
    return next((other for other in others if float(other) != float(number)), None)


def _more(number: str) -> str:
    mantissa, e, exponent = number.partition("e")
    return mantissa + "1" + e + exponent


def signs(text: str) -> Iterator[Mutation]:
    for match in _sites(text, r"(?<= )[-+](?= )"):
        yield "sign", _swap(text, match, "-" if match[0] == "+" else "+")


def operators(text: str) -> Iterator[Mutation]:
    for match in _sites(text, r"(?<= )[*/](?= )"):
        yield "operator", _swap(text, match, "/" if match[0] == "*" else "*")


def input_indices(text: str) -> Iterator[Mutation]:
    for match in _sites(text, r"(?<![\w])(q|v|a|tau|p)\[(\d+)\](?! = )"):
        yield "input index", _swap(text, match, f"{match[1]}[{int(match[2]) ^ 1}]")


def output_indices(text: str) -> Iterator[Mutation]:
    for match in _sites(text, r"(?<=    )(\w+)\[(\d+)\](?= = )"):
        yield "output index", _swap(text, match, f"{match[1]}[{int(match[2]) ^ 1}]")


def temporaries(text: str) -> Iterator[Mutation]:
    for match in _sites(text, r"\bt([2-9]|\d\d+)\b(?! = )"):
        yield "temporary", _swap(text, match, f"t{int(match[1]) - 1}")


def statements(text: str) -> Iterator[Mutation]:
    for match in _sites(text, r"\n    (?:const double \w+|\w+\[\d+\]) = [^;]*;"):
        yield "statement dropped", _swap(text, match, "")


def trigonometry(text: str) -> Iterator[Mutation]:
    for match in _sites(text, r"sine_cosine\(([^,]+), &(\w+), &(\w+)\)"):
        yield "sine and cosine swapped", _swap(text, match, f"sine_cosine({match[1]}, &{match[3]}, &{match[2]})")


def guards(text: str) -> Iterator[Mutation]:
    for match in _sites(text, r"if \(!\(\w+ > 0\.0\)"):
        yield "guard weakened", _swap(text, match, match[0].replace("> 0.0", "> -1.0"))


KINDS: tuple[Callable[[str], Iterator[Mutation]], ...] = (
    constant_digits, signs, operators, input_indices, output_indices, temporaries, statements, trigonometry, guards,
)  # fmt: skip


class Bench:
    """One scene with its emitted C, ready to be judged again after a change."""

    def __init__(self, path: str, names: tuple[str, ...]) -> None:
        self.system: System = derive(load(path))
        self.outputs = [self.system.output(name) for name in names]
        self.programs: list[Program] = [self.system.program(name) for name in names]
        self.emitted: Emitted = emit_c(self.system.scene.name, self.programs, target_info(self.system))

    @property
    def source(self) -> str:
        return self.emitted.files[self.emitted.sources[0]]

    @cached_property
    def certifier(self) -> Certifier:
        return Certifier(self.system, self.source)

    def accepts(self, text: str) -> bool:
        """Whether the certificate holds for this text in place of the emitted one."""
        changed = replace(self.emitted, files={**self.emitted.files, self.emitted.sources[0]: text})
        try:
            read = read_back(changed)
            read.check_literals()
            for output, program in zip(self.outputs, self.programs, strict=True):
                self.certifier.certify(output, program, [_c_candidate(read.functions[program.name], program, "C")])
        except CertificateError:
            return False
        return True

    def survivors(self, most: int, seed: int = 0) -> tuple[Counter[str], list[Mutation]]:
        """Up to ``most`` mutations of each kind: how many were made, and those that were accepted."""
        made: Counter[str] = Counter()
        survived: list[Mutation] = []
        for kind in KINDS:
            mutations = [m for m in kind(self.source) if m[1] != self.source]
            for mutation in random.Random(seed).sample(mutations, min(most, len(mutations))):
                made[mutation[0]] += 1
                if self.accepts(mutation[1]):
                    survived.append(mutation)
        return made, survived


def main() -> None:
    rows = ("mass_matrix", "bias_force", "forward_dynamics", "velocity_transformation")
    for path in sys.argv[1:] or ["examples/fig1.scene.yaml"]:
        made, survived = Bench(path, rows).survivors(40)
        accepted = Counter(kind for kind, _ in survived)
        print(f"{path}: {sum(made.values())} mutations, {len(survived)} accepted")
        for kind, number in made.items():
            print(f"  {kind:28} {number:4} made, {number - accepted[kind]:4} refused")


if __name__ == "__main__":
    main()
