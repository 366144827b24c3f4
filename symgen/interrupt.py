"""Ctrl-C while a command is still being imported: one line and status 130, as it is later."""

from __future__ import annotations

import os
import sys
from types import TracebackType


def guard() -> None:
    """Where a command of symgen is starting, keep an interrupt that nothing catches from printing a traceback."""
    if not _is_command():
        return
    usual = sys.excepthook

    def told(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if not issubclass(kind, KeyboardInterrupt):
            usual(kind, error, trace)
            return
        sys.stdout.flush()
        print("symgen: interrupted", file=sys.stderr, flush=True)
        os._exit(130)  # else the interpreter ends by the signal

    sys.excepthook = told


def _is_command() -> bool:
    """``symgen …``, ``python -m symgen …`` or ``python -m symgen.validation.…``."""
    name = os.path.basename(sys.argv[0]) if getattr(sys, "argv", None) else ""
    if name in ("symgen", "symgen.exe"):
        return True
    words = sys.orig_argv
    if name != "-m" or "-m" not in words[:-1]:
        return False
    module = words[words.index("-m") + 1]
    return module == "symgen" or module.startswith("symgen.")
