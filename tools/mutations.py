"""Damage to scene and model files: small random edits of good ones.

Everything is a function of a `random.Random`, so a seed gives the same bytes anywhere.
"""

# ruff: noqa: E501  (tables)

from __future__ import annotations

import random
import re
from collections.abc import Callable

NUMBERS = (
    "nan", "NaN", ".nan", "inf", "-inf", ".inf", "-.INF", "Infinity", "1e999", "-1e999", "1e-999", "1e308", "1e-308", "1e300",
    "-1e300", "1e-300", "4.9e-324", "0x1p3", "0x10", "0b1", "0o17", "017", "1_000", "1,5", "1.2.3", "--1", "+-1", "-0", "+0.0",
    "1e", "e1", ".", "-", "+", "", " ", "1d0", "1f", "½", "²", "٣", "１", "৪.৫", "−1", "1e٣", "∞", "1e+", "1e1e1", "190:20:30",
    "2026-01-01", "null", "~", "true", "9" * 399, "9" * 5000, "0." + "3" * 390, "1e" + "9" * 30, "1.5708", "3.14159265358979",
    "6.283185307179586", "1e16", "0.1", "-1", "1", "0", "2", "1e-9", "1e9",
)  # fmt: skip
"""What may stand where a number is wanted, or may not."""

NAMES = (
    "", " ", "ground", "main", "double", "template", "__x", "_X", "q", "v", "p", "tau", "NULL", "a b", "a\tb", "a\nb", "a\rb",
    "*/", "/*", "//", "a\\", "\\n", "??/", "??)", "'", '"', "`", "$(id)", "${x}", "%s%n", "%(x)s", "{{x}}", "{x}", "{% x %}",
    "#", "# define X", "&amp;", "&x;", "<b>", "</robot>", "]]>", "<![CDATA[", "<!--", "-->", "\x00", "\x07", "\x1b[31m", "\x85",
    "\u2028", "\u2029", "\u202e", "\u200b", "\ufeff", "\ufffe", "\ud800", "\U0001f600", "é", "e\u0301", "ﬀ", "Å", "名前",
    "..", "../../etc/passwd", "/etc/passwd", "C:\\x", "a/b", "con", "-o", "--help", "__proto__", "constructor", "x" * 10_000,
    "x" * 201, "é" * 200, "base", "link1", "world", "None", "nil", "0", "1", "b.mass", "gravity", "*", "?", "[a-z]*", "*.mass",
)  # fmt: skip
"""What may stand where a name is wanted, or may not."""

SNIPPETS = (
    b"\x00", b"\xff", b"\xc0\x80", b"\xed\xa0\x80", b"\xf4\x90\x80\x80", b"\xef\xbb\xbf", b"\xff\xfe", b"\x1a", b"\r", b"\r\n",
    b"\n", b"\t", b"\x0c", b"&a", b"*a", b"!!str ", b"!!python/object/apply:os.system ", b"<<: ", b"? ", b"- ", b"|\n", b">\n",
    b"---\n", b"...\n", b"%YAML 9.9\n", b"@", b"`", b"{", b"}", b"[", b"]", b"[[[[", b"{{{{", b": ", b", ", b"#", b"''", b'"',
    b"<a>", b"</a>", b"<a/>", b"<", b">", b"</", b"/>", b"<?x ?>", b"<!DOCTYPE x []>", b"&lt;", b"&#0;", b"&#x110000;", b"&x;",
    b"]]>", b"=", b"=\"\"", b" name=\"x\"", b" xmlns:x=\"y\"", b"x:", b"cut: true", b"null", b"true",
)  # fmt: skip

_NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9]*")
_TOKEN = re.compile(rb"[A-Za-z_][A-Za-z_0-9]*|[-+]?[\d.][\d.eE+-]*|\s+|[^\w\s]")
_ATTRIBUTE = re.compile(rb'[A-Za-z_:]+="[^"]*"|[A-Za-z_]+: *(?:\[[^\[\]]*\]|\{[^{}]*\}|[^,{}\[\]\n]+)')
_ELEMENT = re.compile(rb"<([A-Za-z_:]+)[^<>]*/>|<([A-Za-z_:]+)[^<>]*>(?:[^<]|<(?!/?\2\b))*</\2>|\{[^{}\n]*\}|[^\n]*\n")

Edit = Callable[[bytes, random.Random], bytes]


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", "surrogatepass")


def _span(pattern: re.Pattern[bytes], data: bytes, rng: random.Random) -> tuple[int, int]:
    """Where a random match near a random place is; an empty span without one."""
    start = rng.randrange(len(data) + 1)
    match = pattern.search(data, start) or pattern.search(data)
    return match.span() if match else (start, start)


def _replaced(data: bytes, span: tuple[int, int], text: bytes) -> bytes:
    return data[: span[0]] + text + data[span[1] :]


def _byte(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return _replaced(data, (at, min(len(data), at + rng.randrange(2))), bytes([rng.randrange(256)]))


def _chunk(data: bytes, rng: random.Random) -> bytes:
    """Removed, doubled or moved."""
    start = rng.randrange(len(data) + 1)
    end = min(len(data), start + rng.choice((1, 3, 10, 40, 200)))
    return _rearranged(data, (start, end), rng)


def _rearranged(data: bytes, span: tuple[int, int], rng: random.Random) -> bytes:
    piece = data[slice(*span)]
    rest = _replaced(data, span, b"")
    match rng.randrange(4):
        case 0:
            return rest
        case 1:
            return _replaced(data, (span[1], span[1]), piece * rng.choice((1, 1, 1, 3, 30)))
        case 2:
            at = rng.randrange(len(rest) + 1)
        case _:
            at = _span(_ELEMENT, rest, rng)[rng.randrange(2)]
    return _replaced(rest, (at, at), piece)


def _snippet(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return _replaced(data, (at, min(len(data), at + rng.randrange(6))), rng.choice(SNIPPETS))


def _number(data: bytes, rng: random.Random) -> bytes:
    return _replaced(data, _span(_NUMBER, data, rng), _encoded(rng.choice(NUMBERS)))


def _word(data: bytes, rng: random.Random) -> bytes:
    """A word becomes a hostile name, or another word of the file."""
    span = _span(_WORD, data, rng)
    other = data[slice(*_span(_WORD, data, rng))] if rng.randrange(2) else _encoded(rng.choice(NAMES))
    return _replaced(data, span, other)


def _tokens(data: bytes, rng: random.Random) -> bytes:
    """Two tokens change places."""
    first, second = sorted((_span(_TOKEN, data, rng), _span(_TOKEN, data, rng)))
    if first[1] > second[0]:
        return data
    middle = data[first[1] : second[0]]
    return data[: first[0]] + data[slice(*second)] + middle + data[slice(*first)] + data[second[1] :]


def _attribute(data: bytes, rng: random.Random) -> bytes:
    return _rearranged(data, _span(_ATTRIBUTE, data, rng), rng)


def _element(data: bytes, rng: random.Random) -> bytes:
    return _rearranged(data, _span(_ELEMENT, data, rng), rng)


def _nested(data: bytes, rng: random.Random) -> bytes:
    """An element deep inside others like it."""
    span = _span(_ELEMENT, data, rng)
    depth = rng.choice((2, 10, 100, 5000))
    first, last = rng.choice(((b"<link>", b"</link>"), (b"[", b"]"), (b"{a: ", b"}"), (b"<a>", b""), (b"- ", b"")))
    return _replaced(data, span, first * depth + data[slice(*span)] + last * depth)


def _cut_short(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _recoded(data: bytes, rng: random.Random) -> bytes:
    text = data.decode("utf-8", "replace")
    code = rng.choice(("utf-16", "utf-16-le", "utf-32", "utf-8-sig", "latin-1", "cp037", "utf-7"))
    if rng.randrange(2):
        text = re.sub(r"^<\?xml.*?\?>", "", text)
        text = f'<?xml version="1.0" encoding="{rng.choice((code, "utf-8", "euc-jp", "x", "idna", "rot13", "base64"))}"?>{text}'
    return text.encode(code, "replace")


EDITS: tuple[Edit, ...] = (
    _byte, _chunk, _snippet, _number, _number, _number, _word, _word, _word, _tokens, _attribute, _attribute, _element, _element,
)  # fmt: skip
RARE: tuple[Edit, ...] = (_nested, _cut_short, _recoded)


def mutate(data: bytes, rng: random.Random) -> bytes:
    """``data`` with one to six random edits."""
    for _ in range(rng.choice((1, 1, 1, 1, 1, 2, 2, 3, 6))):
        data = rng.choice(RARE if rng.randrange(25) == 0 else EDITS)(data, rng)
    return data
