"""The read-back sees every mutation: it refuses the text, or the literal check does, or the values differ."""

from __future__ import annotations

import random
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from symgen.algebra.field import MERSENNE_61, FieldNumbers, NotInField, Residue
from symgen.errors import CertificateError
from symgen.program.evaluate import evaluate, evaluate_all
from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port, Program
from symgen.targets.c import Emitted, emit_c, read_back
from tests.targets.programs import all_programs, arm, info, random_program, rotation, solver

OPTIONS = [{}, {"precision": "float"}, {"trigonometry": "libm", "status": True}]


def point(program: Program, seed: int = 0) -> tuple[FieldNumbers, dict[str, list[int]]]:
    """A point of GF(p) where the program has a value."""
    for attempt in range(100):
        rng = random.Random(f"{seed}:{attempt}")
        numbers = FieldNumbers(MERSENNE_61, rng.getrandbits(60))
        inputs = {port.name: [rng.randrange(1, numbers.p) for _ in range(port.size)] for port in program.inputs}
        try:
            expected(program, numbers, inputs)
        except NotInField:
            continue
        return numbers, inputs
    raise AssertionError("no point")


def expected(program: Program, numbers: FieldNumbers, inputs: dict[str, list[int]]) -> dict[str, list[int]]:
    values = evaluate(program, numbers, {k: [Residue(x, numbers.p) for x in row] for k, row in inputs.items()})
    return {name: [x.x for x in row] for name, row in values.items()}


def certify(emitted: Emitted) -> None:
    """What a certificate does; raises CertificateError."""
    read = read_back(emitted)
    read.check_literals()
    for function in emitted.functions:
        program = function.program
        numbers, inputs = point(program)
        try:
            found = read.functions[program.name].evaluate_mod(numbers.p, inputs, numbers.apply)
            guards = read.functions[program.name].guards_mod(numbers.p, inputs, numbers.apply)
        except NotInField:
            raise CertificateError("no value") from None
        every = evaluate_all(program, numbers, {k: [Residue(x, numbers.p) for x in row] for k, row in inputs.items()})
        if found != expected(program, numbers, inputs) or guards != [every[i].x for i in program.guards]:
            raise CertificateError(f"{program.name} differs")


def changed(emitted: Emitted, text: str, file: str = "demo.c") -> Emitted:
    assert text != emitted.files[file]
    return replace(emitted, files={**emitted.files, file: text})


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_what_is_emitted_passes(options: dict[str, Any]) -> None:
    emitted = emit_c("demo", all_programs(), info(**options))
    certify(emitted)
    read = read_back(emitted)
    assert read.check_literals() == len(emitted.constants) > 0
    for function in emitted.functions:
        assert read.functions[function.program.name].operations == function.counts


def code_start(text: str) -> int:
    """Where the file's own part begins, after the built-in functions."""
    return min(
        text.index("static const " + kind + " k") for kind in ("double", "float") if f"static const {kind} k" in text
    )


Mutation = Callable[[str], Iterator[str]]


def at_matches(pattern: str, change: Callable[[re.Match[str]], list[str]]) -> Mutation:
    """Apply ``change`` at every match in the code (not in comments)."""

    def mutate(text: str) -> Iterator[str]:
        start = code_start(text)
        comments = [match.span() for match in re.finditer(r"/\*.*?\*/", text, re.DOTALL)]
        for match in re.finditer(pattern, text):
            inside = any(a <= match.start() < b for a, b in comments)
            if match.start() >= start and not inside:
                for new in change(match):
                    yield text[: match.start()] + new + text[match.end() :]

    return mutate


def other_digit(match: re.Match[str]) -> list[str]:
    """The literal with one digit changed, in every place where that gives another number."""
    text = match[0]
    results = []
    for k, c in enumerate(text):
        if c.isdigit():
            new = text[:k] + str((int(c) + 1) % 10) + text[k + 1 :]
            precise = "f" in text
            if different(text, new, precise):
                results.append(new)
    return results


def different(old: str, new: str, single: bool) -> bool:
    """A named constant may end in another digit and still be its rational correctly rounded; such a change is none."""
    real = np.float32 if single else np.float64
    return bool(real(old.rstrip("f")) != real(new.rstrip("f")))


def drop(match: re.Match[str]) -> list[str]:
    return [""]


def swapped_inputs(text: str) -> Iterator[str]:
    """Two inputs of one name exchanged within a function, or two arguments of a signature."""
    start = code_start(text)
    head, tail = text[:start], text[start:]
    for first, second in (
        ("q[0]", "q[1]"),
        ("v[0]", "v[1]"),
        ("p[0]", "p[1]"),
        ("const double q[2]", "const double p[4]"),
    ):
        for function in re.split(r"(?=\n(?:void|int) )", tail)[1:]:
            exchanged = function.replace(first, "@").replace(second, first).replace("@", second)
            if exchanged != function:
                yield head + tail.replace(function, exchanged)


def duplicated(match: re.Match[str]) -> list[str]:
    return [match[0] + match[0]]


OPERATORS = {"+": ["-", "*", "/"], "-": ["+", "*"], "*": ["+", "/", "**"], "/": ["*", "-", "//"]}
MUTATIONS: dict[str, Mutation] = {
    "constant": at_matches(r"(?<![\w.])\d+\.\d+(?:e-?\d+)?f?", other_digit),
    "integer": at_matches(r"(?<![\w.])(\d+)\.0f?(?= [*+/-])", lambda m: [m[1]]),
    "sign": at_matches(r"(?<== )(?=[\w(])(?!0\.0;)", lambda m: ["-"]),
    "negation": at_matches(r"(?<=[(=] )-|(?<=\()-", lambda m: [""]),
    "operator": at_matches(r"(?<= )[-+*/](?= )", lambda m: OPERATORS[m[0]]),
    "index": at_matches(r"(?<=\[)\d(?=\])", lambda m: [str(int(m[0]) + 1), str((int(m[0]) + 1) % 2)]),
    "constant name": at_matches(r"\bk1\b(?! =)", lambda m: ["k2"]),
    "local name": at_matches(r"(?<= )t1\b(?! =)", lambda m: ["t2", "t77", "k1"]),
    "pair": at_matches(r"&(\w+), &(\w+)", lambda m: [f"&{m[2]}, &{m[1]}"]),
    "table": at_matches(
        r"\b(?:co)?sines(?=\[\d\];)", lambda m: ["sines" if m[0] == "cosines" else "cosines", "angles"]
    ),
    "call": at_matches(r"(?<=sines_cosines\(angles, sines, cosines, )\d+", lambda m: ["0", "3", "8"]),
    "dropped": at_matches(r"\n    (?!\(void\)|return|double \w+, |float \w+, )[^\n]*;(?=\n)", drop),
    "repeated": at_matches(r"\n    (?!\(void\))[^\n]*;(?=\n)", duplicated),
    "inputs": swapped_inputs,
    "guard": at_matches(
        r"(?<=if \(!\()\w+ > 0\.0", lambda m: ["p[0] > 0.0", m[0].replace(">", ">="), m[0].replace("0.0", "0")]
    ),
    "loop": at_matches(r"(?<=i < )\d+|(?<=\(double\))NAN", lambda m: ["1", "0.0", "99"]),
    "status": at_matches(r"(?<=return )\d", lambda m: [str(1 - int(m[0]))]),
    "function": at_matches(r"\b(sine|cosine|cos_sqrt|sinc_sqrt|sqrt)\(", lambda m: ["sinc3_sqrt(", "fabs(", "("]),
    "parentheses": at_matches(r"(?<=[*/-] )\(([^()]* [+-] [^()]*)\)", lambda m: [m[1]]),
    "type": at_matches(r"(?<=const )double(?= \w+ =)", lambda m: ["float", "int"]),
}


@pytest.mark.parametrize("kind", MUTATIONS)
@pytest.mark.parametrize("options", [{}, {"status": True}], ids=str)
def test_mutations_are_caught(kind: str, options: dict[str, Any]) -> None:
    """Every single change of every kind, in every function."""
    emitted = emit_c("demo", all_programs(), info(**options))
    text = emitted.files["demo.c"]
    count = 0
    for mutant in MUTATIONS[kind](text):
        if mutant == text:
            continue
        with pytest.raises(CertificateError):
            certify(changed(emitted, mutant))
            where = next(k for k, (a, b) in enumerate(zip(text, mutant, strict=False)) if a != b)
            raise AssertionError(f"not caught: {mutant[max(0, where - 80) : where + 80]!r}")
        count += 1
    assert count or (kind == "status" and not options)


def test_mutated_built_in_functions_are_caught() -> None:
    """Any digit or operator of them; they are certified as a whole."""
    emitted = emit_c("demo", all_programs(), info())
    text = emitted.files["demo.c"]
    start = code_start(text)
    rng = random.Random(1)
    places = [k for k, c in enumerate(text[:start]) if c in "0123456789+-*<>" and k > text.index("two_over_pi")]
    for k in rng.sample(places, 60):
        line = text.rfind("\n", 0, k) + 1
        if text.rfind("/*", 0, k) > text.rfind("*/", 0, k) or "/*" in text[line:k] or text[k : k + 2] in ("*/", "/*"):
            continue
        new = "1" if text[k] != "1" else "2"
        with pytest.raises(CertificateError):
            certify(changed(emitted, text[:k] + new + text[k + 1 :]))


@pytest.mark.parametrize(
    "statement",
    [
        "const double z = q[0] ** q[1];",
        "const double z = q[0] // q[1];",
        "const double z = q[0]--q[1];",
        "const double z = q[0]; M[0] = z",
        "const double z = (q)[0];",
        "const double z = (1.0)(q[0]);",
        "const double z = *q;",
        "const double z = sqrt(*q);",
        "const double z = q[0] + 1;",
        "const double z = 1 / 2 * q[0];",
        "const double z = q[0], y = q[1];",
        "const double z = q[q[0]];",
        "const double z = q[-1];",
        "const double z = q[0x1];",
        "const double z = 0[q];",
        "const double z = q[0] ? q[1] : q[0];",
        "const double z = q[0] > q[1];",
        "const double z = (double)q[0];",
        "const double z = sizeof(q);",
        "const double z = fabs(q[0]);",
        "const double z = M[0];",
        "const double z = z;",
        "const double z = lambda;",
        "const double z = 0x1.0p3;",
        "const double z = 1.0e400;",
        "const double z = 1.5f;",
        "const double z = 1e3;",
        "const double z = 1_0.0;",
        "const double z = ();",
        "const double z = __import__(q[0]);",
        "const double z = q[0] if q[1] else q[0];",
        "const double sqrt = q[0];",
        "const double q = 1.0;",
        "const double k1 = 1.0;",
        "const float z = q[0];",
        "double z = q[0];",
        "static double z = 1.0;",
        "M[4] = q[0];",
        "M[0] = q[0];",
        "M[0] += q[0];",
        "q[0] = 1.0;",
        "double s, c;",
        "sine_cosine(q[0], &cos_q0, &sin_q0);",
        "sine_cosine(q[0], &s, &c);",
        "(void)M;",
        "return;",
        ";",
        "{ }",
        "goto end;",
        "#define q p",
        "for (;;) { }",
        'printf("x");',
        "const double z = q[0] \\\n * 2.0;",
        "const double z = q[0] ??/ 2.0;",
        "// M[0] = 1.0;",
        "const double ż = 1.0;",
    ],
)
def test_what_is_not_emitted_is_refused(statement: str) -> None:
    emitted = emit_c("demo", [arm()], info())
    text = emitted.files["demo.c"].replace("    /* mass matrix */\n", f"    {statement}\n")
    with pytest.raises(CertificateError) as caught:
        certify(changed(emitted, text))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("#include <math.h>", "#include <evil.h>"),
        ("#include <math.h>\n", ""),
        ('#include "demo.h"', '#include "other.h"'),
        ("static const double k1 =", "static double k1 ="),
        ("static const double k1 = 0.3", "static const double k1 = -0.3"),
        ("static const double k1 =", "static const double k99 ="),
        ("void demo_mass_matrix(", "static void demo_mass_matrix("),
        ("void demo_mass_matrix(", "int demo_mass_matrix("),
        ("const double q[2]", "double q[2]"),
        ("const double q[2]", "const double q[3]"),
        ("const double q[2]", "const float q[2]"),
        ("const double q[2], const double p[4]", "const double p[4], const double q[2]"),
    ],
)
def test_frames_are_checked(old: str, new: str) -> None:
    emitted = emit_c("demo", [arm()], info())
    text = emitted.files["demo.c"]
    assert text.count(old) >= 1
    with pytest.raises(CertificateError):
        certify(changed(emitted, text.replace(old, new, 1)))


def test_text_after_the_last_function_is_refused() -> None:
    emitted = emit_c("demo", [arm()], info())
    with pytest.raises(CertificateError, match="after the last"):
        certify(changed(emitted, emitted.files["demo.c"] + "int x;\n"))


def test_header_is_checked() -> None:
    emitted = emit_c("demo", [arm(), solver()], info())
    header = emitted.files["demo.h"]
    for old, new in (("q[2]", "q[3]"), ("double M[4]", "float M[4]"), ("void demo_mass", "int demo_mass")):
        with pytest.raises(CertificateError, match="not declared as"):
            read_back(changed(emitted, header.replace(old, new, 1), "demo.h"))
    size = next(line for line in header.splitlines() if "_NQ" in line)
    for old, new in ((size, f"{size}0"), (size, ""), (size, f"{size}\n#define sine cosine"), (size, f"{size}\n{size}")):
        with pytest.raises(CertificateError, match="macros"):
            read_back(changed(emitted, header.replace(old, new, 1), "demo.h"))


def sparse() -> Program:
    """A 6 by 6 output with two entries that are not zero."""
    graph = Graph()
    q = graph.inputs("q", 2)
    entries: list[Any] = [0] * 36
    entries[7], entries[20] = q[0] * q[1], Fraction(1, 2)
    return extract(graph, "sparse", (Port("q", (2,)),), (Port("M", (6, 6)),), [entries])


def test_zeros_of_a_sparse_output_are_set_by_a_loop() -> None:
    emitted = emit_c("demo", [sparse()], info())
    loop = "for (int i = 8; i < 20; ++i) M[i] = 0;"
    text = emitted.files["demo.c"]
    assert text.count(loop) == 1 and text.count("M[i] = 0") == 2  # and seven zeros before the first entry
    certify(emitted)
    for wrong in (loop.replace("20", "19"), loop.replace("20", "21"), loop.replace("i = 8", "i = 9"),
                  loop.replace("= 0;", "= 1;"), loop.replace("M[i]", "q[i]"), f"{loop} {loop}", "",
                  "M[9] = 0.0; " + loop):  # fmt: skip
        with pytest.raises(CertificateError):
            certify(changed(emitted, text.replace(loop, wrong)))


def test_unused_constant_is_refused() -> None:
    emitted = emit_c("demo", [arm()], info())
    line = "static const double k1 ="
    text = emitted.files["demo.c"].replace(line, f"static const double k9 = 0.125;\n{line}")
    extra = replace(emitted, constants={**emitted.constants, "k9": Fraction(1, 8)})
    with pytest.raises(CertificateError, match="never used"):
        read_back(changed(extra, text))


def test_wrong_constant_table_is_caught() -> None:
    """A literal that is not its rational correctly rounded."""
    emitted = emit_c("demo", [arm()], info())
    for wrong in (Fraction(1, 3) + Fraction(1, 10**15), Fraction(-1, 3)):
        with pytest.raises(CertificateError, match="correctly rounded"):
            read_back(replace(emitted, constants={**emitted.constants, "k1": wrong})).check_literals()


def test_reading_takes_a_time_in_proportion_to_the_text() -> None:
    """Four times the statements, not much more than four times the processor time."""

    def seconds(size: int) -> float:
        program = random_program(1, size, ("add", "sub", "mul", "mul"), more=size // 20)
        emitted = emit_c("demo", [program], info())
        started = time.process_time()
        read = read_back(emitted)
        numbers, inputs = FieldNumbers(), {"x": [3, 5, 7, 11], "dt": [13]}
        found = read.functions["f"].evaluate_mod(numbers.p, inputs, numbers.apply)
        taken = time.process_time() - started
        assert found == expected(program, numbers, inputs)
        return taken

    assert seconds(60000) < 10 * seconds(15000)


def test_float_constants_of_a_double_table_are_refused() -> None:
    emitted = emit_c("demo", [arm()], info(precision="float"))
    text = emitted.files["demo.c"]
    literal = re.search(r"static const float k1 = (\S+)f;", text)
    assert literal is not None
    with pytest.raises(CertificateError):
        certify(changed(emitted, text.replace(literal[0], f"static const float k1 = {literal[1]};")))


def test_evaluation_wants_whole_inputs() -> None:
    read = read_back(emit_c("demo", [rotation()], info()))
    numbers = FieldNumbers()
    with pytest.raises(ValueError, match="q has 2 values, not 1"):
        read.functions["integrate"].evaluate_mod(
            numbers.p, {"q": [1], "v": [1, 2], "dt": [1], "p": [1, 2, 3, 4]}, numbers.apply
        )
