"""The bench on paper: CSV, figures, and one self-contained page."""

from __future__ import annotations

from html import escape
from pathlib import Path

from symgen.bench.result import BenchResult
from symgen.report.page import write_text

STYLE = "body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:80rem}pre{overflow-x:auto;line-height:1.35}"


def write_files(
    result: BenchResult,
    csv_file: Path | None = None,
    plots: Path | None = None,
    report: Path | None = None,
    figures_needed: bool = True,
) -> None:
    """Whatever is asked for. SceneError where a file cannot be written, ToolError for figures without matplotlib (with
    ``figures_needed``; else they are left out then)."""
    if csv_file is not None:
        write_text(csv_file, result.to_csv())
    if plots is not None:
        from symgen.bench.plots import has_matplotlib, write_plots

        if figures_needed or has_matplotlib():
            write_plots(result, plots)
    if report is not None:
        write_report(report, result)


def write_report(path: Path, result: BenchResult) -> None:
    """Write the tables of ``result.to_text()``, and the figures where matplotlib is installed, as HTML."""
    from symgen.bench.plots import figures

    title = escape(f"{result.scene}: speed and error")
    pictures = "\n".join(figures(result).values())
    write_text(
        path,
        f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>\n'
        f"<h1>{title}</h1>\n{pictures}\n<pre>{escape(result.to_text())}</pre>\n</html>\n",
    )
