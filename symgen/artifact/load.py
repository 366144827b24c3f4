"""An artifact on disk, and its functions compiled and callable."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

from symgen.artifact.compiler import RELEASE_FLAGS, cache_folder, find_compiler, shared_library
from symgen.artifact.function import CompiledFunction
from symgen.artifact.manifest import FORMAT
from symgen.artifact.shim import SHIM, shim_symbol, shim_text
from symgen.artifact.staging import MANIFEST, locked, recover
from symgen.errors import SceneError, SymgenError, ToolError
from symgen.scene.document import clean

NEEDED = frozenset({"name", "sources", "headers", "parameters", "functions"})


class Loaded:
    """The functions of an artifact, one attribute each: ``f.mass_matrix(q)``."""

    def __init__(self, functions: Mapping[str, CompiledFunction], library: Path) -> None:
        self._functions = dict(functions)
        self.library = library
        """The shared library they live in."""

    def __getattr__(self, name: str) -> CompiledFunction:
        try:
            return self.__dict__["_functions"][name]  # type: ignore[no-any-return]
        except KeyError:
            known = ", ".join(self.__dict__.get("_functions", ()))
            raise AttributeError(f"no function {name}; there are: {known}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._functions]

    def __iter__(self) -> Iterator[str]:
        return iter(self._functions)

    def __contains__(self, name: object) -> bool:
        return name in self._functions


class Artifact:
    """What `symgen.generate` leaves: a folder with a manifest. ``Artifact("out").load().mass_matrix(q)``."""

    def __init__(self, directory: str | Path) -> None:
        self.directory = Path(directory)

    def __repr__(self) -> str:
        return f"Artifact({str(self.directory)!r})"

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """manifest.json. Raises SceneError where there is none or it is not one of ours."""
        with self._whole():
            return self._manifest()

    @contextmanager
    def _whole(self) -> Iterator[None]:
        """No other process of symgen is amid writing the folder; one that was killed is made good first."""
        if not (self.directory / MANIFEST).exists():
            recover(self.directory)
        with locked(self.directory, shared=True):
            yield

    def _manifest(self) -> dict[str, Any]:
        path = self.directory / MANIFEST
        try:
            manifest = json.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise SceneError(f"no artifact here: {error.strerror}", str(path)) from None
        except (ValueError, RecursionError) as error:
            raise SceneError(f"not a manifest: {clean(str(error))}", str(path)) from None
        if not isinstance(manifest, dict) or manifest.get("format") != FORMAT or not manifest.keys() >= NEEDED:
            raise SceneError(f"not a manifest of format {FORMAT}", str(path))
        return manifest

    def load(
        self,
        cc: str | None = None,
        flags: Sequence[str] | None = None,
        cache: str | Path | None = None,
    ) -> Loaded:
        """Compile the C (once: libraries are kept by content) and return its functions on NumPy arrays.

        ``cc``: compiler (default $CC, cc, gcc, clang); ``flags``: instead of the release flags
        ``-O3 -ffp-contract=fast -fno-math-errno -march=native``; ``cache``: folder for compiled libraries (default
        $XDG_CACHE_HOME/symgen or ~/.cache/symgen). Raises ToolError without a compiler or when it fails, SceneError
        when files of the artifact are missing.
        """
        with self._whole():
            manifest = self._manifest()
            texts = {name: self._text(name) for name in [*manifest["sources"], *manifest["headers"]]}
        if not manifest["sources"]:
            raise SceneError("there is no C in this artifact (targets)", str(self.directory))
        texts[SHIM] = shim_text(manifest)
        library = _compile(
            str(manifest["name"]), texts, [*manifest["sources"], SHIM], find_compiler(cc), flags, cache_folder(cache)
        )
        try:
            handle = ctypes.CDLL(str(library))
        except OSError as error:
            raise ToolError(f"cannot load {library}: {error}") from None
        defaults = [value for parameter in manifest["parameters"] for value in parameter["default"]]
        functions = {
            row["name"]: CompiledFunction(row, getattr(handle, shim_symbol(row)), defaults)
            for row in manifest["functions"]
            if row["symbol"]
        }
        return Loaded(functions, library)

    def _text(self, name: str) -> str:
        if Path(name).name != name:
            raise SceneError(f"not a file of an artifact: {name}", str(self.directory / MANIFEST))
        try:
            return (self.directory / name).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            raise SceneError("listed in the manifest and not readable", str(self.directory / name)) from None


def _compile(
    name: str, texts: Mapping[str, str], sources: Sequence[str], cc: str, flags: Sequence[str] | None, cache: Path
) -> Path:
    if flags is not None:
        return shared_library(name, texts, sources, cc, flags, cache)
    try:
        return shared_library(name, texts, sources, cc, RELEASE_FLAGS, cache)
    except SymgenError:
        without = [flag for flag in RELEASE_FLAGS if flag != "-march=native"]  # not every compiler knows it
        try:
            return shared_library(name, texts, sources, cc, without, cache)
        except SymgenError:
            pass
        raise
