"""The bench as one self-contained page."""

from __future__ import annotations

from html import escape
from pathlib import Path

from symgen.bench.result import BenchResult
from symgen.report.page import write_text

STYLE = "body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:72rem}pre{overflow-x:auto;line-height:1.35}"


def write_report(path: Path, result: BenchResult) -> None:
    """Write the tables of ``result.to_text()`` as HTML."""
    title = escape(f"{result.scene}: speed and error")
    write_text(
        path,
        f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>\n'
        f"<h1>{title}</h1>\n<pre>{escape(result.to_text())}</pre>\n</html>\n",
    )
