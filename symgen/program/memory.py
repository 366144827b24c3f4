"""Garbage collection put off while large graphs are built."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """No search for garbage inside: millions of objects that all are needed are looked through again and again
    otherwise, a third of the whole time. Graphs are let go of by hand (`Graph.forget`). Also a decorator."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            if not gc.get_freeze_count():  # what is left is old: it is not looked through at once
                gc.freeze()
                gc.unfreeze()
            gc.enable()
