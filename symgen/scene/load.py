"""From a file to a Scene."""

from __future__ import annotations

import os
from pathlib import Path

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.assemble import assemble, model_scene
from symgen.scene.document import clean, decode, parse_yaml, read_bytes
from symgen.scene.model import Scene


def load(path: str | os.PathLike[str]) -> Scene:
    """Read a scene (``.yaml``), or a model (URDF or MJCF), as a validated Scene with exact numbers.

    The kind is taken from the content: XML is a model, the rest is YAML. Raises SceneError with one
    line that names file and place; NotSupportedError for what is right but cannot be done yet.
    """
    path = Path(path)
    data = read_bytes(path)
    name = clean(path.name, 120)
    if data.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"<"):
        return model_scene(data, path)
    if path.suffix in (".urdf", ".xml", ".xacro", ".mjcf"):
        raise SceneError("is not XML", name)
    if path.suffix in (".sdf", ".usd", ".usda"):
        raise NotSupportedError(f"{name}: {path.suffix} files are not read; give a scene (.yaml), URDF or MJCF")
    return assemble(parse_yaml(decode(data, name), name), path.parent)
