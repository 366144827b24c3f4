"""Text that may stand in a C comment, a header line or a string literal, whatever it came from."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable


def comment_text(text: str) -> str:
    """One line without control characters, comment marks, trigraphs and backslashes."""
    plain = "".join(c if c.isprintable() else " " for c in text)
    for mark, harmless in (("*/", "* /"), ("/*", "/ *"), ("//", "/ /"), ("??", "? ?"), ("\\", "/ ")):
        while mark in plain:
            plain = plain.replace(mark, harmless)
    return " ".join(plain.split())


def comment_lines(lines: Iterable[str], width: int = 96) -> list[str]:
    """Each line cleaned and wrapped; continuation lines are indented."""
    result: list[str] = []
    for line in lines:
        wrapped = textwrap.wrap(comment_text(line), width, subsequent_indent="  ", break_on_hyphens=False)
        result.extend(wrapped or [""])
    return result
