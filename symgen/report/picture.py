"""The mechanism drawing as a file of its own, for READMEs and slides."""

from __future__ import annotations

from pathlib import Path

from markupsafe import Markup

from symgen.report.camera import render
from symgen.report.environment import asset
from symgen.report.mechanism import draw
from symgen.report.page import write_text
from symgen.report.svg import tag
from symgen.scene.model import Scene
from symgen.system import derive


def write_drawing(path: str | Path, scene: Scene) -> Path:
    """Write the drawing of a scene as SVG that follows light and dark. Raises SceneError when it cannot be written."""
    picture = render(draw(derive(scene)))
    head, _, rest = picture.partition(">")
    style = tag("style", Markup(asset("drawing.css")))
    write_text(Path(path), f"{head}>{style}{rest}\n")
    return Path(path)
