"""What commands share: JSON and progress on the terminal, text made fit for one line."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

Progress = Callable[[int, int, str], None]
"""``progress(done, total, what)``."""


def one_line(text: str) -> str:
    """Text from anywhere as one printable line: no terminal escapes, no line breaks."""
    flat = " ".join(text.split())
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in flat)


def emit_json(value: object) -> None:
    click.echo(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


@contextmanager
def progress_bar(quiet: bool) -> Iterator[Progress | None]:
    """A progress bar on stderr when a person is looking at it, else nothing."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    with click.progressbar(length=1, file=sys.stderr, item_show_func=lambda what: what or "") as bar:

        def progress(done: int, total: int, what: str) -> None:
            bar.length = max(total, 1)
            bar.update(max(done - bar.pos, 0), what)
            bar.render_progress()  # news without a step too

        yield progress


def split_names(_context: click.Context, _parameter: click.Parameter, value: str | None) -> tuple[str, ...] | None:
    """``a,b`` → ("a", "b"); an empty list is wrong usage."""
    if value is None:
        return None
    names = tuple(part.strip() for part in value.split(",") if part.strip())
    if not names:
        raise click.BadParameter("the list is empty")
    return names


json_option = click.option("--json", "as_json", is_flag=True, help="Print a machine-readable result.")
