"""What `symgen simulate` takes on the command line, under the names of `symgen.simulate`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

from symgen.errors import SceneError

FLAGS = {
    "t_end": "--time",
    "q0": "--q",
    "v0": "--v",
    **{name: f"--{name}" for name in ("method", "dt", "tau", "samples", "rtol", "atol")},
}
"""Argument of `symgen.simulate` → what it is called on the command line."""


def split_numbers(_context: click.Context, _parameter: click.Parameter, value: str | None) -> list[float] | None:
    """``1,2.5`` → [1.0, 2.5]."""
    try:
        return None if value is None else [float(part) for part in value.split(",")]
    except ValueError:
        raise click.BadParameter("not numbers with commas between") from None


_NUMBERS: dict[str, Any] = {"metavar": "a,b,…", "callback": split_numbers}
_OPTIONS = (
    click.option("--time", "t_end", type=float, default=1.0, show_default=True, help="Seconds."),
    click.option("--method", default="DOP853", show_default=True, help="DOP853, RK45, LSODA, Radau, …, or rk4, lie, …"),
    click.option("--dt", type=float, help="Step of rk4, lie, variational, …, in seconds."),
    click.option("--rtol", type=float, default=1e-9, show_default=True),
    click.option("--atol", type=float, default=1e-11, show_default=True),
    click.option("--q", "q0", help="Where it starts.", **_NUMBERS),
    click.option("--v", "v0", help="How fast it starts.", **_NUMBERS),
    click.option("--tau", help="Constant joint forces.", **_NUMBERS),
    click.option("--samples", type=click.IntRange(2, 1_000_000), default=201, show_default=True, help="States kept."),
)


@contextmanager
def named_by_flags() -> Iterator[None]:
    """Errors about an argument name its flag."""
    try:
        yield
    except SceneError as error:
        if error.place not in FLAGS:
            raise
        raise SceneError(error.message, FLAGS[error.place]) from None


def simulation_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """All of them."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command
