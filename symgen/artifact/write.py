"""Putting files where the user wants them: all of them, or none."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath

from symgen.errors import SceneError

MANIFEST = "manifest.json"
STAGING = ".symgen-"
"""How temporary folders begin; left-overs of a killed run are removed by the next one."""


def write_artifact(out_dir: str | Path, files: Mapping[str, str | bytes]) -> Path:
    """Write ``files`` (relative path with / → content, manifest.json among them) into the folder ``out_dir``.

    A folder that does not exist appears complete, by one rename. In an existing one, the files that its old
    manifest.json lists are replaced or removed, files of other origin are left alone, and a file of other origin
    in the way of a new one is an error. Everything is written beside first; whatever interrupts the moves (an
    error, Ctrl-C) puts the old files back.

    Returns the folder. Raises SceneError naming the place that cannot be written.
    """
    target = Path(out_dir)
    paths = [_checked(name) for name in files]
    assert MANIFEST in paths, "an artifact has a manifest"
    _check_target(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists():
            _replace_files(target, files)
        else:
            _create(target, files)
    except OSError as error:
        raise SceneError(f"cannot write here: {error.strerror or error}", str(out_dir)) from None
    return target


def _checked(name: str) -> str:
    path = PurePosixPath(name)
    if not name or path.is_absolute() or ".." in path.parts or "\\" in name or str(path) != name:
        raise ValueError(f"not a path inside an artifact: {name!r}")
    return name


def _check_target(target: Path) -> None:
    if target.is_symlink():
        raise SceneError("is a symbolic link; name the folder it stands for", str(target))
    if target.exists() and not target.is_dir():
        raise SceneError("is a file; a folder is needed", str(target))
    if target.is_dir() and not os.access(target, os.W_OK | os.X_OK):
        raise SceneError("this folder may not be written to", str(target))


def _write_all(folder: Path, files: Mapping[str, str | bytes]) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)


@contextlib.contextmanager
def _staging(parent: Path) -> Iterator[Path]:
    folder = Path(tempfile.mkdtemp(prefix=STAGING, dir=parent))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _create(target: Path, files: Mapping[str, str | bytes]) -> None:
    with _staging(target.parent) as staging:
        whole = staging / "new"
        whole.mkdir()  # with the permissions of any new folder, not those of a temporary one
        _write_all(whole, files)
        whole.rename(target)


def _replace_files(target: Path, files: Mapping[str, str | bytes]) -> None:
    for left in target.glob(f"{STAGING}*"):
        shutil.rmtree(left, ignore_errors=True)
    own = own_files(target)
    for name in files:
        if (target / name).exists() and name not in own:
            raise SceneError("exists and was not made by symgen; choose another folder", str(target / name))
    with _staging(target) as staging:
        new, old = staging / "new", staging / "old"
        _write_all(new, files)
        moved: list[tuple[Path, Path]] = []
        try:
            for name in [MANIFEST, *sorted(own - {MANIFEST})]:
                if (target / name).exists():
                    _move(target / name, old / name, moved)
            for name in [*sorted(set(files) - {MANIFEST}), MANIFEST]:
                _move(new / name, target / name, moved)
        except BaseException:
            for source, destination in reversed(moved):
                source.parent.mkdir(parents=True, exist_ok=True)
                destination.rename(source)
            raise
    for folder in {(target / name).parent for name in own if "/" in name}:
        with contextlib.suppress(OSError):
            folder.rmdir()  # only when nothing is left in it


def _move(source: Path, destination: Path, moved: list[tuple[Path, Path]]) -> None:
    destination.parent.mkdir(parents=True, exist_ok=True)
    moved.append((source, destination))
    try:
        source.rename(destination)
    except BaseException:
        if not destination.exists():
            moved.pop()
        raise


def own_files(folder: Path) -> set[str]:
    """What the manifest in ``folder`` says symgen wrote there; empty where there is none."""
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        listed = [*manifest["sources"], *manifest["headers"]]
        listed += [function["casadi_file"] for function in manifest["functions"] if function["casadi_file"]]
        if manifest["format"] != 1:
            return set()
    except (OSError, ValueError, KeyError, TypeError):
        return set()
    names = {MANIFEST, "CMakeLists.txt", "main.c"}
    for name in listed:
        with contextlib.suppress(ValueError):
            names.add(_checked(str(name)))
    return names
