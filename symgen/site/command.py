"""`symgen report` on the command line."""

from __future__ import annotations

from pathlib import Path

import click

from symgen.console import emit_json, json_option, progress_bar, split_names


@click.command()
@click.argument("scenes", metavar="SCENE…", nargs=-1, required=True)
@click.option("-o", "--output", "directory", required=True, metavar="DIR", help="Where the site goes, or is already.")
@click.option(
    "--with",
    "measures",
    metavar="a,b,…",
    callback=split_names,
    default="validation,motion",
    show_default=True,
    help="What is measured: validation, motion, rounding, precision, speed, hard, benchmarks; all; none.",
)
@click.option(
    "--effort", type=click.Choice(["quick", "full"]), default="quick", show_default=True, help="How hard is measured."
)
@click.option("--pdf", is_flag=True, help="Print every page to DIR/pdf by headless Chromium.")
@click.option("--jobs", type=click.IntRange(1, 256), default=1, show_default=True, help="Processes at once.")
@click.option("--fresh", is_flag=True, help="Measure again what is stored in DIR/data.")
@json_option
def report(
    scenes: tuple[str, ...],
    directory: str,
    measures: tuple[str, ...],
    effort: str,
    pdf: bool,
    jobs: int,
    fresh: bool,
    as_json: bool,
) -> int:
    """A site of reports: a textbook page and a code page per scene, what was measured, an index.

    What is stored in DIR from earlier runs is used again and stays in the site.
    """
    from symgen.site.build import Settings, build_site
    from symgen.site.measures import chosen

    settings = Settings(chosen(measures), effort, jobs, fresh, pdf)
    out = Path(directory)
    try:
        with progress_bar(as_json) as progress:
            result = build_site(scenes, out, settings, progress)
    except KeyboardInterrupt:
        index = out / "index.html"
        raise KeyboardInterrupt(f"pages of what there is: {index}" if index.is_file() else "") from None
    if as_json:
        emit_json(result.to_json())
    else:
        click.echo(result.to_text())
    return 0 if result.passed else 1
