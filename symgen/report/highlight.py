"""C with a little colour: comments, words of the language, numbers, calls; lines with their numbers.

Everything is escaped; links are put on what the caller says.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType

from markupsafe import Markup

from symgen.report.c_source import Source

_WORDS = (
    "auto break case char const continue default do double else enum extern float for if inline int long restrict "
    "return short signed sizeof static struct switch typedef union unsigned void volatile while bool size_t "
    "int32_t int64_t uint32_t uint64_t"
)
_TOKEN = re.compile(
    r"(?P<c>/\*.*?\*/|//[^\n]*)"
    r"|(?P<m>^[ \t]*\#(?:[^\n\\]|\\.)*)"
    r'|(?P<s>"(?:[^"\\\n]|\\.)*")'
    r"|(?P<n>\b(?:0x[0-9A-Fa-f]+u?|\d+\.?\d*(?:[eE][-+]?\d+)?f?u?)\b|(?<![\w)])\.\d+)"
    rf"|(?P<k>\b(?:{'|'.join(_WORDS.split())})\b)"
    r"|(?P<f>\b[A-Za-z_]\w*(?=\())"
    r"|(?P<v>\b[A-Za-z_]\w*(?:\[\d+\])?)",
    re.S | re.M,
)
Linker = Callable[[str], tuple[str, str]]
"""A name or an entry of an array → (address, title); empty strings where there is nothing to say."""


def nothing(_name: str) -> tuple[str, str]:
    return "", ""


def highlighted(
    source: Source, link: Linker = nothing, anchors: Mapping[int, tuple[str, str]] = MappingProxyType({})
) -> Markup:
    """A listing. ``anchors``: line of the piece → (its id, address of what it links to)."""
    lines = Markup("").join(_pieces(source.text, link)).split("\n")
    found = []
    for k, line in enumerate(lines):
        body = Markup(line)
        if k in anchors:
            own, address = anchors[k]
            if address:
                text = body.lstrip()
                body = body[: len(body) - len(text)] + Markup('<a class="phase" href="{}">{}</a>').format(address, text)
            found.append(Markup('<span class="l" id="{}">{}</span>').format(own, body))
        else:
            found.append(Markup('<span class="l">{}</span>').format(body))
    return Markup('<pre class="listing" tabindex="0" style="--from:{}"><code>{}</code></pre>').format(
        source.first - 1, Markup("\n").join(found)
    )


def _pieces(text: str, link: Linker) -> list[Markup]:
    found: list[Markup] = []
    at = 0
    for match in _TOKEN.finditer(text):
        found.append(Markup("{}").format(text[at : match.start()]))
        found.append(_piece(match, link))
        at = match.end()
    return [*found, Markup("{}").format(text[at:])]


def _piece(match: re.Match[str], link: Linker) -> Markup:
    kind, text = str(match.lastgroup), match[0]
    if kind in ("v", "f"):
        address, title = link(text)
        if address:
            return Markup('<a href="{}" title="{}">{}</a>').format(address, title, text)
        return Markup("{}").format(text) if kind == "v" else Markup('<b class="f">{}</b>').format(text)
    # A token over several lines is closed at the end of each.
    return Markup("\n").join(Markup('<b class="{}">{}</b>').format(kind, line) for line in text.split("\n"))
