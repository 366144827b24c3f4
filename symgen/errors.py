"""The errors a user may see: one clear message each, no traceback.

The command line prints ``str(error)`` on one line and exits with ``error.exit_status``.
"""

from __future__ import annotations


class SymgenError(Exception):
    """Base of every error that is the user's to read."""

    exit_status = 2


class SceneError(SymgenError):
    """The input is wrong. ``place`` names the file and the line or element."""

    def __init__(self, message: str, place: str = "") -> None:
        self.message = message
        self.place = place
        super().__init__(f"{place}: {message}" if place else message)


class ToolError(SymgenError):
    """Something needed outside symgen (a compiler, a simulator) is missing or failed."""


class NotSupportedError(SymgenError):
    """The input is right, but asks for what symgen does not do (yet)."""


class CertificateError(SymgenError):
    """A generated function is not the function it should be. Nothing was written."""

    exit_status = 1
