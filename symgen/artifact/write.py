"""Putting files where the user wants them: all of them, or none."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath

from symgen.artifact.staging import (
    MANIFEST,
    NAMES,
    NEW,
    OLD,
    STAGING,
    move,
    parents,
    roll_back,
    staging,
    uninterrupted,
)
from symgen.errors import SceneError
from symgen.scene.document import clean

Files = Mapping[str, str | bytes]
"""Relative path with / → content."""


def write_artifact(out_dir: str | Path, files: Files) -> Path:
    """Write ``files`` (manifest.json among them) into the folder ``out_dir``.

    A folder that does not exist appears complete, by one rename. In an existing one, the files that its old
    manifest.json lists are replaced or removed, files of other origin are left alone, and a file of other origin
    in the way of a new one is an error. Everything is written beside first; whatever interrupts the moves (an
    error, Ctrl-C) puts the old files back, and after a kill the next run, or whoever loads the artifact, does.
    Runs that write to the same place wait for each other.

    Returns the folder. Raises SceneError naming the place that cannot be written.
    """
    target = Path(out_dir)
    paths = [_checked(name) for name in files]
    assert MANIFEST in paths, "an artifact has a manifest"
    check_target(target)
    try:
        with parents(target):
            if target.exists() or not _create(target, files):
                _replace_files(target, files)
    except (OSError, ValueError) as error:
        raise cannot_write(error, target) from None
    return target


def check_target(out_dir: str | Path) -> None:
    """Raise SceneError where an artifact cannot be written; known before anything is derived."""
    target = Path(out_dir)
    try:
        with contextlib.suppress(FileNotFoundError):
            os.lstat(target)  # refuses names that no file can have, and ways through files
        if target.is_symlink():
            raise SceneError("is a symbolic link; name the folder it stands for", _shown(target))
        if target.exists() and not target.is_dir():
            raise SceneError("is a file; a folder is needed", _shown(target))
        nearest = next(folder for folder in (target, *target.parents, Path()) if folder.exists())
        if not os.access(nearest, os.W_OK | os.X_OK):
            raise SceneError("this folder may not be written to", _shown(nearest))
    except (OSError, ValueError) as error:
        raise cannot_write(error, target) from None


def cannot_write(error: OSError | ValueError, target: Path) -> SceneError:
    """What is said of a folder that cannot be written."""
    reason = clean(getattr(error, "strerror", None) or str(error))
    if isinstance(error, FileNotFoundError):  # the folder is what was to be made
        reason = "no folder can be made there"
    return SceneError(f"cannot write here: {reason}", _shown(target))


def _shown(path: Path) -> str:
    return clean(str(path), 300)


def _checked(name: str) -> str:
    path = PurePosixPath(name)
    if not path.parts or path.is_absolute() or ".." in path.parts or "\\" in name or str(path) != name:
        raise ValueError(f"not a path inside an artifact: {name!r}")
    return name


def _write_all(folder: Path, files: Files) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)


def _create(target: Path, files: Files) -> bool:
    """False if another process was quicker to make the folder."""
    with staging(target.parent) as scratch:
        new = scratch / NEW
        new.mkdir()  # with the permissions of any new folder, not those of a temporary one
        _write_all(new, files)
        try:
            new.rename(target)
        except OSError:
            if target.is_dir():
                return False
            raise
    return True


def _replace_files(target: Path, files: Files) -> None:
    with staging(target) as scratch:
        own = {name for name in own_files(target) if _is_own(target, name)}
        _check_foreign(target, files, own)
        new, old = scratch / NEW, scratch / OLD
        _write_all(new, files)
        (scratch / NAMES).write_text(json.dumps(list(files)), encoding="utf-8")
        with uninterrupted():
            try:
                old.mkdir()
                for name in [MANIFEST, *sorted(own - {MANIFEST})]:
                    if (target / name).exists():
                        move(target / name, old / name)
                for name in [*sorted(set(files) - {MANIFEST}), MANIFEST]:
                    move(new / name, target / name)
            except BaseException:
                roll_back(scratch, target)
                raise
    for folder in {(target / name).parent for name in own if "/" in name}:
        with contextlib.suppress(OSError):
            folder.rmdir()  # only when nothing is left in it


def _is_own(target: Path, name: str) -> bool:
    """Not where somebody has put a folder, or a link to elsewhere, in the place of one of ours."""
    path = target / name
    linked = any((target / folder).is_symlink() for folder in PurePosixPath(name).parents if folder.parts)
    return not linked and (path.is_symlink() or not path.is_dir())


def _check_foreign(target: Path, files: Iterable[str], own: set[str]) -> None:
    """Raise SceneError when something of other origin is in the way of a file, or of a folder on the way to it."""
    for name in files:
        for folder in PurePosixPath(name).parents:
            path = target / folder
            if folder.parts and os.path.lexists(path) and (path.is_symlink() or not path.is_dir()):
                raise SceneError("is in the way of a folder; remove it or choose another place", _shown(path))
        if os.path.lexists(target / name) and name not in own:
            raise SceneError("exists and was not made by symgen; choose another folder", _shown(target / name))


def own_files(folder: Path) -> set[str]:
    """What the manifest in ``folder`` says symgen wrote there; empty where there is none."""
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        listed = [*manifest["sources"], *manifest["headers"]]
        listed += [function["casadi_file"] for function in manifest["functions"] if function["casadi_file"]]
        if manifest["format"] != 1:
            return set()
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return set()
    names = {MANIFEST, "CMakeLists.txt", "main.c"}
    for name in listed:
        with contextlib.suppress(ValueError):
            names.add(_checked(str(name)))
    return names


__all__ = ["MANIFEST", "STAGING", "check_target", "own_files", "write_artifact"]
