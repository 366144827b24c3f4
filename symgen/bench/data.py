"""Speed against error of a scene's main functions, as the data of a report's section."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from symgen.bench.measure import ROUNDS, STATES, Settings, bench
from symgen.bench.peers.forms import MAIN
from symgen.errors import NotSupportedError, SymgenError
from symgen.scene.model import Output, Scene
from symgen.scene.request import request
from symgen.system import derive


def speed_data(
    scene: Scene,
    say: Callable[[str], None],
    *,
    peers: Sequence[str] | None = None,
    variants: str = "standard",
    functions: Sequence[str] = MAIN,
    states: int = STATES,
    rounds: int = ROUNDS,
    folder: Path | None = None,
) -> dict[str, Any]:
    """What `BenchResult.to_json` gives of those of the functions that the scene can have.

    ``peers``: None for all that are installed; ``variants``: ``none``, ``standard`` or ``all`` (see
    `symgen.bench.peers.forms`). Raises NotSupportedError where the scene has none of the functions, ToolError without a
    C compiler.
    """
    wanted = possible(scene, functions)
    asked = request(scene, outputs=wanted, targets=("c",))
    settings = Settings(None if peers is None else tuple(peers), states, rounds, variants=variants, folder=folder)
    return bench(asked, settings, say).to_json()


def possible(scene: Scene, functions: Sequence[str]) -> tuple[Output, ...]:
    """Those of the functions that can be derived. Raises NotSupportedError with the reason where none can."""
    system = derive(scene)
    system.require_tree()
    found, why = [], "no functions are asked for"
    for name in functions:
        try:
            output = Output(name, (name,))
            system.require(output)
            system.code(name)
        except SymgenError as error:
            why = str(error)
        else:
            found.append(output)
    if not found:
        raise NotSupportedError(why)
    return tuple(found)
