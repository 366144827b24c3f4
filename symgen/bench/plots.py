"""Figures of a bench: instructions and time beside the peers', and time against error."""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

from symgen.bench.result import BenchResult
from symgen.bench.variant import OURS
from symgen.errors import SceneError, ToolError

METADATA = {"Date": None}


def has_matplotlib() -> bool:
    return importlib.util.find_spec("matplotlib") is not None


def _pyplot() -> Any:
    try:
        import matplotlib
    except ImportError as error:
        raise ToolError("matplotlib is not installed: pip install 'symgen[bench]'") from error
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams["svg.hashsalt"] = "symgen"
    return plt


def bars(result: BenchResult, plt: Any, what: str, label: str) -> Any:
    """One group of bars a function, one bar a program; logarithmic."""
    functions = [facts.function for facts in result.functions if result.row(OURS, facts.function)]
    peers = [peer for peer in result.peers if any(getattr(row, what) for row in result.rows if row.peer == peer)]
    figure, axes = plt.subplots(figsize=(max(6.0, 1.6 * len(functions)), 4.2), layout="constrained")
    width = 0.85 / max(1, len(peers))
    for k, peer in enumerate(peers):
        places, heights = [], []
        for i, function in enumerate(functions):
            row = result.row(peer, function)
            value = getattr(row, what) if row else None
            if value:
                places.append(i + (k - (len(peers) - 1) / 2) * width)
                heights.append(value)
        axes.bar(places, heights, width, label=peer)
    axes.set_yscale("log")
    axes.set_ylabel(label)
    axes.set_xticks(range(len(functions)), [name.replace("_", "\n") for name in functions], fontsize=8)
    axes.grid(axis="y", alpha=0.3)
    axes.set_title(result.scene)
    axes.legend(fontsize=7, ncols=2)
    return figure


def speed_and_error(result: BenchResult, plt: Any) -> Any:
    """One point a row: time against error, both logarithmic."""
    figure, axes = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
    for peer in result.peers:
        rows = [row for row in result.rows if row.peer == peer]
        axes.scatter([row.ns_min for row in rows], [max(row.error, 1e-17) for row in rows], s=18, label=peer)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("ns a call, minimum")
    axes.set_ylabel("largest relative error")
    axes.grid(alpha=0.3)
    axes.set_title(result.scene)
    axes.legend(fontsize=7)
    return figure


FIGURES: dict[str, Callable[[BenchResult, Any], Any]] = {
    "instructions": lambda result, plt: bars(result, plt, "instructions", "instructions a call"),
    "time": lambda result, plt: bars(result, plt, "ns_min", "ns a call, minimum"),
    "error": speed_and_error,
}


def drawable(result: BenchResult) -> dict[str, Callable[[BenchResult, Any], Any]]:
    """The figures there is something for."""
    counted = any(row.instructions is not None for row in result.rows)
    return {name: draw for name, draw in FIGURES.items() if name != "instructions" or counted}


def figures(result: BenchResult) -> dict[str, str]:
    """Name → SVG to stand in a page; none without matplotlib."""
    try:
        plt = _pyplot()
    except ToolError:
        return {}
    found = {}
    for name, draw in drawable(result).items():
        text = io.StringIO()
        figure = draw(result, plt)
        figure.savefig(text, format="svg", metadata=METADATA)
        plt.close(figure)
        found[name] = text.getvalue()[text.getvalue().index("<svg") :]
    return found


def write_plots(result: BenchResult, folder: Path) -> None:
    """SCENE-NAME.svg and .png of every figure. ToolError without matplotlib, SceneError where nothing can be
    written."""
    plt = _pyplot()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, draw in drawable(result).items():
            figure = draw(result, plt)
            figure.savefig(folder / f"{result.scene}-{name}.svg", metadata=METADATA)
            figure.savefig(folder / f"{result.scene}-{name}.png", dpi=120)
            plt.close(figure)
    except OSError as error:
        raise SceneError(f"cannot write figures: {error.strerror}", str(folder)) from None
