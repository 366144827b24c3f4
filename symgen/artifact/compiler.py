"""Finding a C compiler and making shared libraries, each compiled once."""

from __future__ import annotations

import atexit
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from symgen.errors import ToolError

RELEASE_FLAGS = ("-O3", "-ffp-contract=fast", "-fno-math-errno", "-march=native")
"""What every figure of symgen is measured with."""
ALWAYS = ("-std=c99", "-fPIC", "-shared")
CANDIDATES = ("cc", "gcc", "clang")
MADE = "made.so"


def find_compiler(cc: str | None = None) -> str:
    """The C compiler: ``cc`` if given, else $CC, else the first of cc, gcc, clang on the PATH.

    Raises ToolError saying what to install.
    """
    for source, wanted in (("", cc), ("$CC: ", os.environ.get("CC"))):
        if wanted:
            words = shlex.split(wanted)
            if words and shutil.which(words[0]):
                return wanted
            raise ToolError(f"{source}no C compiler {wanted!r} on the PATH")
    for name in CANDIDATES:
        if shutil.which(name):
            return name
    raise ToolError("no C compiler found (cc, gcc, clang): install one, on Debian: apt install gcc libc6-dev")


def cache_folder(cache: str | Path | None = None) -> Path:
    """Where compiled libraries are kept: ``cache``, else $XDG_CACHE_HOME/symgen, else ~/.cache/symgen; where that
    cannot be written, a folder under the system's temporary one that goes when the process ends."""
    if cache is not None:
        folder = Path(cache)
    else:
        root = os.environ.get("XDG_CACHE_HOME", "")
        try:
            folder = (Path(root) if os.path.isabs(root) else Path.home() / ".cache") / "symgen"
        except RuntimeError:  # no home
            return _passing_folder()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        if cache is not None:
            raise ToolError(f"cannot keep compiled code in {folder}: {error.strerror}") from None
        return _passing_folder()


@cache
def _passing_folder() -> Path:
    """One folder for this process, gone when it ends."""
    folder = Path(tempfile.mkdtemp(prefix="symgen-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def _identity(cc: str) -> str:
    """Compiler and processor: what -march=native and code generation depend on."""
    ran = subprocess.run([*shlex.split(cc), "--version"], capture_output=True, text=True, check=False)
    features = ""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        features = next((line for line in lines if line.startswith(("flags", "Features"))), "")
    except OSError:
        pass
    return "\n".join([cc, ran.stdout, platform.machine(), platform.processor(), features])


def shared_library(
    name: str, texts: Mapping[str, str], sources: Sequence[str], cc: str, flags: Sequence[str], cache: Path
) -> Path:
    """The library made of ``sources`` among the files ``texts``; compiled unless the cache has it.

    Safe with parallel processes: each compiles in a folder of its own and renames into place.
    Raises ToolError with the compiler's first complaint.
    """
    digest = hashlib.sha256()
    for part in (_identity(cc), *flags, *ALWAYS, *(word for item in sorted(texts.items()) for word in item), *sources):
        digest.update(f"{len(part)}:{part}".encode())
    library = cache / f"{name}-{digest.hexdigest()[:32]}.so"
    if library.exists():
        return library
    try:
        with tempfile.TemporaryDirectory(prefix="build-", dir=cache) as scratch:
            _compile(name, texts, sources, cc, flags, Path(scratch))
            os.replace(Path(scratch, MADE), library)
    except OSError as error:
        raise ToolError(f"cannot keep compiled code in {cache}: {error.strerror}") from None
    return library


def _compile(
    name: str, texts: Mapping[str, str], sources: Sequence[str], cc: str, flags: Sequence[str], scratch: Path
) -> None:
    for file, text in texts.items():
        (scratch / file).write_text(text, encoding="utf-8")
    command = [*shlex.split(cc), *ALWAYS, *flags, "-o", MADE, *sources, "-lm"]
    try:
        ran = subprocess.run(command, cwd=scratch, capture_output=True, text=True, errors="replace", check=False)
    except OSError as error:
        raise ToolError(f"cannot run the C compiler {cc}: {error.strerror}") from None
    if ran.returncode:
        lines = [line for line in ran.stderr.splitlines() if "error" in line] or ran.stderr.splitlines()
        raise ToolError(f"{cc} could not compile {name}: {lines[0] if lines else 'no message'}")
