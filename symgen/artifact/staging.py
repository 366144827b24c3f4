"""A scratch folder in which files are made complete before they move; its left-overs undo what a kill cut short.

Layout of a scratch folder: ``new/`` the files to come, ``names`` their list (JSON), ``old/`` the files they replace.
``old`` exists from the first move on, and manifest.json is the last file to leave ``new``: so the folder alone tells
whether nothing, something or everything has moved.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path

MANIFEST = "manifest.json"
STAGING = ".symgen-"
"""How scratch folders begin; left-overs of a killed run are undone and removed by the next one."""
NEW, OLD, NAMES = "new", "old", "names"


@contextlib.contextmanager
def locked(folder: Path, shared: bool = False) -> Iterator[bool]:
    """Waits for other processes of symgen at this folder (``shared``: for those that write).

    Yields False, without waiting, where folders cannot be locked. A lock ends with its process and leaves no file.
    """
    with contextlib.ExitStack() as stack:
        try:
            import fcntl

            handle = os.open(folder, os.O_RDONLY)
            stack.callback(os.close, handle)
            fcntl.flock(handle, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
        except (ImportError, OSError):
            yield False
        else:
            yield True


@contextlib.contextmanager
def staging(parent: Path) -> Iterator[Path]:
    """A scratch folder in ``parent``, where no other process of symgen writes meanwhile."""
    with locked(parent) as alone:
        if alone:
            tidy(parent)
        folder = Path(tempfile.mkdtemp(prefix=STAGING, dir=parent))
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def recover(folder: Path) -> None:
    """Put back what a run that was killed amid its moves had moved, unless a run is at it now."""
    if any(folder.glob(f"{STAGING}*")):
        with locked(folder) as alone:
            if alone:
                tidy(folder)


def tidy(folder: Path) -> None:
    """Undo and remove the scratch folders of dead runs. The caller holds the lock of ``folder``."""
    for left in folder.glob(f"{STAGING}*"):
        with contextlib.suppress(OSError):  # not ours to read or to remove
            if not left.is_symlink() and {path.name for path in left.iterdir()} <= {NEW, OLD, NAMES}:
                roll_back(left, folder)
                shutil.rmtree(left)


def roll_back(scratch: Path, target: Path) -> None:
    """Undo the moves into ``target``, however far they came; all of them or (when they were finished) none."""
    new, old = scratch / NEW, scratch / OLD
    if not old.is_dir() or not (new / MANIFEST).exists():
        return
    for name in json.loads((scratch / NAMES).read_text(encoding="utf-8")):
        if not (new / name).exists() and (target / name).exists():
            move(target / name, new / name)
    for source in [path for path in old.rglob("*") if path.is_symlink() or not path.is_dir()]:
        move(source, target / source.relative_to(old))


def move(source: Path, destination: Path) -> None:
    destination.parent.mkdir(parents=True, exist_ok=True)
    source.rename(destination)


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Ctrl-C and the signals that ask a process to end wait until the few renames are done."""
    wanted = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, wanted)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def parents(target: Path) -> Iterator[None]:
    """The folders above ``target`` exist; those made here go again when writing fails."""
    missing = [folder for folder in target.parents if not folder.exists()]
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for folder in missing:
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise
