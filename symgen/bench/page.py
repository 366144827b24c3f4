"""The bench on paper: CSV, figures, and one self-contained page."""

from __future__ import annotations

from pathlib import Path

from symgen.bench.result import BenchResult

SECTIONS = (
    ("speed", "Speed against error"),
    ("frontier", "Programs worth having"),
    ("peers", "Beside other programs"),
    ("rows", "Every row"),
    ("left", "What was not measured"),
    ("how", "How it was measured"),
)


def write_files(
    result: BenchResult,
    csv_file: Path | None = None,
    plots: Path | None = None,
    report: Path | None = None,
    figures_needed: bool = True,
) -> None:
    """Whatever is asked for. SceneError where a file cannot be written, ToolError for figures without matplotlib (with
    ``figures_needed``; else they are left out then)."""
    from symgen.report.page import write_text

    if csv_file is not None:
        write_text(csv_file, result.to_csv())
    if plots is not None:
        from symgen.bench.plots import has_matplotlib, write_plots

        if figures_needed or has_matplotlib():
            write_plots(result, plots)
    if report is not None:
        write_text(report, bench_page(result))


def bench_page(result: BenchResult) -> str:
    """The page of a result: the same bytes for the same result."""
    from symgen.report.measured.speed import values
    from symgen.report.shell import page

    title = f"{result.scene}: speed and error"
    return page("report/bench.html.j2", title, SECTIONS, it=values(result.to_json()))
