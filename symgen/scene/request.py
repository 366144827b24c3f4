"""Asking something else of a scene that is loaded already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symgen.errors import SceneError
from symgen.scene.canonical import with_hash
from symgen.scene.document import clean
from symgen.scene.model import Output, Scene
from symgen.scene.outputs import check_outputs, frame_names
from symgen.scene.schema import did_you_mean

TARGETS = ("c", "casadi", "cuda")
"""What can be generated."""


def request(
    scene: Scene,
    outputs: Sequence[Output] | None = None,
    precision: str | None = None,
    targets: tuple[str, ...] | None = None,
) -> Scene:
    """``scene`` with other outputs (checked against the catalogue), precision or targets; rehashed.

    What is None stays as it is. Raises SceneError for an unknown output or target, NotSupportedError for an output that
    is not available yet.
    """
    if outputs is not None:
        check_outputs(outputs, frame_names(scene), [f"output {output.name!r}" for output in outputs])
        scene = replace(scene, outputs=tuple(outputs))
    options = scene.options
    if precision is not None:
        options = replace(options, precision=precision)
    if targets is not None:
        for target in targets:
            if target not in TARGETS:
                raise SceneError(f"unknown target {clean(target)!r}{did_you_mean(target, TARGETS)}", "--target")
        if not targets:
            raise SceneError("no target is asked for", "--target")
        options = replace(options, targets=targets)
    return with_hash(replace(scene, options=options))
