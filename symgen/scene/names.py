"""The one way from a name in a file to an identifier in generated code."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

MAX_LENGTH = 60
"""Identifiers are cut to this many characters: C99 compares 63, and prefixes and suffixes are added."""

_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while _Bool _Complex
_Imaginary _Alignas _Alignof _Atomic _Generic _Noreturn _Static_assert _Thread_local alignas alignof bool constexpr
false nullptr static_assert thread_local true typeof typeof_unqual and and_eq asm atomic_cancel atomic_commit
atomic_noexcept bitand bitor catch char8_t char16_t char32_t class co_await co_return co_yield compl concept
const_cast consteval constinit decltype delete dynamic_cast explicit export friend mutable namespace new noexcept
not not_eq operator or or_eq private protected public reflexpr reinterpret_cast requires static_cast synchronized
template this throw try typeid typename using virtual wchar_t xor xor_eq None True False as assert async await def
del elif except finally from global import in is lambda nonlocal pass raise with yield main errno NULL EOF NAN
INFINITY I M_PI M_E linux unix acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2
expm1 fabs fdim floor fma fmax fmin fmod frexp hypot isfinite isinf isnan isnormal ldexp lgamma log log10 log1p log2
logb lrint lround modf nan nearbyint nextafter pow remainder rint round scalbn signbit sin sincos sinh sqrt tan tanh
tgamma trunc j0 j1 jn y0 y1 yn gamma index abs div exit free malloc memcpy memset printf size_t
"""

RESERVED = frozenset(_WORDS.split())
"""Words of C, C++ and Python, and library names that compilers know: none may be an identifier of ours."""

_FOREIGN = re.compile(r"[^A-Za-z0-9_]+")


def identifier(name: str, longest: int = MAX_LENGTH) -> str:
    """A C identifier for ``name`` taken alone: ASCII letters, digits and _; no reserved word; deterministic.

    Accents are dropped (``é`` → ``e``), every other foreign run becomes one ``_``.
    """
    plain = unicodedata.normalize("NFKD", name)
    plain = "".join(c for c in plain if not unicodedata.combining(c))
    text = _FOREIGN.sub("_", plain)[:longest]
    if not text.strip("_"):
        text = "x"
    if text[0].isdigit():
        text = "_" + text
    if text[0] == "_" and (len(text) == 1 or text[1] == "_" or text[1].isupper()):
        text = "x" + text  # _X and __ belong to the implementation
    while "__" in text:
        text = text.replace("__", "_")  # reserved in C++ anywhere in a name
    return text + "_" if text in RESERVED else text


def sanitise(names: Iterable[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """Name → identifier, no two alike (compared without case) and none of ``taken``.

    Names that are good identifiers already keep them; of the rest, a clash is numbered
    (``a_b``, ``a_b_2``, …) in the order given. The same names give the same identifiers anywhere.
    """
    wanted = list(dict.fromkeys(names))
    used = {word.lower() for word in taken}
    result: dict[str, str] = {}
    for name in sorted(wanted, key=lambda n: identifier(n) != n):
        base = identifier(name)
        text, count = base, 1
        while text.lower() in used:
            count += 1
            text = f"{base[: MAX_LENGTH - 6].rstrip('_')}_{count}"
        used.add(text.lower())
        result[name] = text
    return {name: result[name] for name in wanted}
