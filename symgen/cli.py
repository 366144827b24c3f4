"""The command line: thin commands over `symgen.derive`, `symgen.generate`, `symgen.validation` and `symgen.bench`.

Exit status: 0 success; 1 a validation or bench criterion or a certificate failed; 2 bad input, wrong usage or a missing
tool; 130 interrupted, 143 or 129 ended by SIGTERM or SIGHUP; 141 the reader of the output went away. Every error is one
line on stderr, and with ``--json`` also an object with the key ``error`` on stdout. ``SYMGEN_DEBUG=1`` lets unexpected
exceptions show their traceback.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from symgen.console import emit_json, json_option, one_line, progress_bar, split_names
from symgen.errors import SymgenError
from symgen.simulate.options import named_by_flags, simulation_options
from symgen.site.command import report
from symgen.version import VERSION

if TYPE_CHECKING:
    from symgen.scene.model import Scene

HELP = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


def load_scene(path: str) -> Scene:
    from symgen.scene.load import load

    return load(path)


def requested(path: str, outputs: str | None, targets: tuple[str, ...] | None, precision: str | None) -> Scene:
    """The scene of a file, with what the command line asks for in place of what the file asks for."""
    from symgen.scene.outputs import parse_outputs
    from symgen.scene.request import request

    wanted = None if outputs is None else parse_outputs(outputs)
    return request(load_scene(path), wanted, precision, targets)


def _given(*parameters: str) -> bool:
    """Whether any of these is on the command line."""
    context = click.get_current_context()
    return any(context.get_parameter_source(name) is ParameterSource.COMMANDLINE for name in parameters)


scene_argument = click.argument("scene", metavar="SCENE")
outputs_option = click.option(
    "--outputs",
    metavar="a,b,…",
    help="Functions in place of the scene's; NAME=a+b puts several outputs into one function.",
)


@click.group(context_settings=HELP)
@click.version_option(VERSION, message="symgen %(version)s")
def cli() -> None:
    """Equations of motion of a multibody system, as certified C and CasADi functions.

    SCENE is a *.scene.yaml, a URDF or an MJCF file.
    """


@cli.command()
@click.argument("scene", metavar="SCENE", required=False)
@click.option(
    "--equations",
    metavar="[NAME,…]",
    is_flag=False,
    flag_value="",
    help="Print the equations: all that are short to read, or those named (R or velocity_transformation, M or …).",
)
@click.option("--format", "style", type=click.Choice(["text", "latex"]), default="text", show_default=True)
@click.option(
    "--symbols",
    type=click.Choice(["joint", "paper"]),
    default="joint",
    show_default=True,
    help="Write R and its rate in joint coordinates, or in blocks of the paper's d and u.",
)
@click.option(
    "--base-parameters",
    "base",
    is_flag=True,
    help="Print the combinations of inertial parameters that the joint forces depend on.",
)
@outputs_option
@json_option
def show(
    scene: str | None,
    equations: str | None,
    style: str,
    symbols: str,
    base: bool,
    outputs: str | None,
    as_json: bool,
) -> None:
    """What symgen understood: graph, joints, path matrices, sizes, natural coordinates, plans."""
    from symgen import show as view

    if scene is None and equations:  # `symgen show --equations SCENE`: the option took the argument
        scene, equations = equations, ""
    if scene is None:
        raise click.UsageError("Missing argument 'SCENE'.")
    if equations is None and _given("style", "symbols"):
        raise click.UsageError("--format and --symbols are about --equations")
    if base and equations is not None:
        raise click.UsageError("--base-parameters and --equations are two questions")
    loaded = requested(scene, outputs, None, None)
    if equations is not None:
        names = tuple(part.strip() for part in equations.split(",") if part.strip())
        printed = view.equations(loaded, names, symbols, style)
        if as_json:
            emit_json({"name": loaded.name, "format": style, "symbols": symbols, "equations": printed})
        else:
            click.echo("\n\n".join(printed.values()))
    elif base:
        from symgen import base_text
        from symgen.system import derive

        system = derive(loaded)
        if as_json:
            emit_json(base_text.as_json(system))
        else:
            click.echo(base_text.as_text(system))
    elif as_json:
        emit_json(view.as_json(loaded))
    else:
        click.echo(view.as_text(loaded))


@cli.command()
@scene_argument
@click.option("-o", "--output", "directory", required=True, metavar="DIR", help="Where the files go.")
@outputs_option
@click.option("--target", "targets", metavar="c,casadi,cuda", callback=split_names, help="What to generate.")
@click.option("--precision", type=click.Choice(["double", "float"]))
@json_option
def generate(
    scene: str,
    directory: str,
    outputs: str | None,
    targets: tuple[str, ...] | None,
    precision: str | None,
    as_json: bool,
) -> None:
    """Derive, certify and write the functions of a scene."""
    loaded = requested(scene, outputs, targets, precision)
    from symgen import show as view
    from symgen.generate import generate as run

    with progress_bar(as_json) as progress:
        artifact = run(loaded, Path(directory), progress=progress)
    if as_json:
        emit_json({"directory": directory, "manifest": artifact.manifest})
    else:
        click.echo(view.manifest_text(artifact.manifest, directory))


@cli.command()
@scene_argument
@click.option(
    "--against",
    metavar="pinocchio,exudyn,mujoco",
    default="pinocchio,exudyn",
    show_default=True,
    callback=split_names,
    help="Simulators to compare with.",
)
@click.option("--states", type=click.IntRange(1, 1_000_000), default=1000, show_default=True, help="Random states.")
@click.option("--report", metavar="FILE.html", help="Write the report of this scene; folders are made.")
@json_option
def validate(scene: str, against: tuple[str, ...], states: int, report: str | None, as_json: bool) -> int:
    """Compare the generated code with independent simulators, closed forms and first integrals."""
    loaded = load_scene(scene)
    from symgen.validation import validate as run

    with progress_bar(as_json) as progress:
        result = run(loaded, against=against, states=states, progress=progress)
    if report is not None:
        from symgen.report import write_report

        write_report(Path(report), loaded, result)
    if as_json:
        emit_json(result.to_json())
    else:
        click.echo(result.to_text(shutil.get_terminal_size().columns if sys.stdout.isatty() else 0))
    return 0 if result.passed else 1


@cli.command()
@scene_argument
@outputs_option
@click.option(
    "--peers",
    metavar="a,b,…",
    callback=split_names,
    help="Programs to measure beside ours, or none; all that are installed unless named.",
)
@click.option(
    "--variants",
    type=click.Choice(["none", "standard", "all"]),
    default="none",
    show_default=True,
    help="Measure other forms of ours too: float, libm, every plan, loops, clang.",
)
@click.option("--states", type=click.IntRange(1, 1_000_000), default=256, show_default=True, help="States per batch.")
@click.option("--rounds", type=click.IntRange(1, 1_000_000), default=101, show_default=True, help="Times in turn.")
@click.option("--ablation", is_flag=True, help="What each transformation saves, in place of peers.")
@click.option("-o", "--output", "directory", metavar="DIR", help="Keep generated and compiled files here.")
@click.option("--csv", "csv_file", metavar="FILE.csv", help="Write the rows as CSV.")
@click.option("--plots", metavar="DIR", help="Write the figures as SVG and PNG.")
@click.option("--report", metavar="FILE.html", help="Write tables and figures as a page.")
@json_option
def bench(
    scene: str,
    outputs: str | None,
    peers: tuple[str, ...] | None,
    variants: str,
    states: int,
    rounds: int,
    ablation: bool,
    directory: str | None,
    csv_file: str | None,
    plots: str | None,
    report: str | None,
    as_json: bool,
) -> int:
    """Speed and error of the generated C, beside the peers that are installed."""
    if ablation and _given("peers", "variants", "csv_file", "plots", "report"):
        raise click.UsageError("--ablation is about our own code: no --peers, and its tables are printed only")
    loaded = requested(scene, outputs, ("c",), None)
    from symgen import bench as bench_room

    names = () if peers == ("none",) else peers
    folder = Path(directory) if directory else None
    settings = bench_room.Settings(names, states, rounds, variants=variants, folder=folder)
    quiet = as_json or not sys.stderr.isatty()

    def say(what: str) -> None:
        if not quiet:
            click.echo(f"… {what}", err=True)

    if ablation:
        found = bench_room.ablation(loaded, settings, say)
        if as_json:
            emit_json(found.to_json())
        else:
            click.echo(found.to_text())
        return 0 if found.passed else 1
    result = bench_room.bench(loaded, settings, say)
    bench_room.write_files(
        result,
        csv_file=Path(csv_file) if csv_file else None,
        plots=Path(plots) if plots else None,
        report=Path(report) if report else None,
    )
    if as_json:
        emit_json(result.to_json())
    else:
        click.echo(result.to_text())
    return 0


@cli.command()
@scene_argument
@simulation_options
@click.option("-o", "--output", "file", metavar="FILE", help="Write the states as .csv or .json; folders are made.")
@json_option
def simulate(scene: str, as_json: bool, file: str | None, **settings: Any) -> None:
    """Carry the mechanism through time with its compiled functions."""
    from symgen.simulate import simulate as run
    from symgen.simulate.motion import check_ending

    if file is not None:
        check_ending(file)
    loaded = load_scene(scene)
    with named_by_flags(), progress_bar(as_json) as progress:
        motion = run(loaded, progress=progress, **settings)
    if file is not None:
        motion.write(Path(file))
    if as_json:
        emit_json(motion.to_json())
    else:
        click.echo(motion.to_text())


cli.add_command(report)


def _fail(message: str, status: int, as_json: bool) -> int:
    click.echo(f"symgen: {one_line(message)}", err=True)
    if as_json:
        emit_json({"error": one_line(message), "exit_status": status})
    return status


class Ended(BaseException):
    """A signal asks the process to end: scratch folders go and what is half written is undone on the way out."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def _end(number: int, _frame: object) -> None:
    raise Ended(number)


def run(arguments: Sequence[str]) -> int:
    """Run one command line; returns the exit status and raises nothing (unless SYMGEN_DEBUG is set)."""
    try:
        return _dispatch(arguments)
    except (click.Abort, KeyboardInterrupt) as error:
        told = str(error.__cause__ or error)  # click's own exception stands for that of the command
        click.echo(f"symgen: interrupted{'; ' if told else ''}{one_line(told)}", err=True)
        return 130
    except Ended as error:
        click.echo("symgen: ended by a signal", err=True)
        return 128 + error.number
    except (BrokenPipeError, SystemExit):  # click turns the first into the second
        # Nobody reads any more; keep the interpreter from complaining when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141


def _dispatch(arguments: Sequence[str]) -> int:
    as_json = "--json" in arguments
    try:
        result: Any = cli.main(args=list(arguments), prog_name="symgen", standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.ctx.get_help() if error.ctx else "", err=True)
        return 2
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        hint = f" (try 'symgen {context.info_name} --help')" if context and context.parent else " (try 'symgen --help')"
        return _fail(error.format_message() + hint, 2, as_json)
    except (click.Abort, KeyboardInterrupt, BrokenPipeError):
        raise
    except SymgenError as error:
        return _fail(str(error), error.exit_status, as_json)
    except OSError as error:
        return _fail(f"{error.filename or 'input or output'}: {error.strerror or error}", 2, as_json)
    except Exception as error:
        if os.environ.get("SYMGEN_DEBUG"):
            raise
        kind = f"{type(error).__name__}: {error}"
        advice = "this is a bug in symgen; please report it with the scene (SYMGEN_DEBUG=1 shows the traceback)"
        return _fail(f"unexpected {kind}; {advice}", 2, as_json)
    return result if isinstance(result, int) else 0


def main() -> None:
    """Entry point of the command ``symgen``."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a terminal that cannot show π still gets the rest
            stream.reconfigure(errors="backslashreplace")
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:  # nohup stays what it is
            signal.signal(number, _end)
    sys.exit(run(sys.argv[1:]))
