"""Compiling what the bench measures, each file once: objects are kept by a hash of all that went into them."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import shlex
import shutil
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from symgen.artifact.compiler import find_compiler
from symgen.bench.variant import Unit
from symgen.errors import ToolError

SHARED = ("-O3", "-ffp-contract=fast", "-fno-math-errno")
NATIVE = (*SHARED, "-march=native")
"""What is timed; the same for every variant."""
COUNTED_X86 = (*SHARED, "-march=haswell")
"""What instructions are counted in: valgrind does not know AVX-512."""
STANDARD = {"c": ("-std=gnu99",), "c++": ("-std=c++17", "-DNDEBUG")}
LIMIT_S = 300.0
"""A file that takes longer to compile is given up."""


@dataclass(frozen=True)
class Compiled:
    path: Path
    seconds: float
    """CPU time of the compiler when it was made."""
    text_bytes: int | None
    """Bytes of machine code (sections .text*), None where that is not known."""


class CompileError(Exception):
    """One file does not compile, or not in time: the variant is left out and the reason said."""


@dataclass(frozen=True)
class Workshop:
    folder: Path
    """Where objects are kept."""
    cc: str
    cxx: str | None
    limit_s: float = LIMIT_S
    say: Callable[[str], None] = lambda what: None

    def counted_flags(self) -> tuple[str, ...]:
        return COUNTED_X86 if platform.machine().lower() in ("x86_64", "amd64") else SHARED

    def compiler(self, language: str) -> str:
        """Raises CompileError where there is none."""
        if language == "c":
            return self.cc
        if self.cxx is None:
            raise CompileError("no C++ compiler")
        return self.cxx

    def compile(self, unit: Unit, flags: Sequence[str]) -> Compiled:
        """The object of a file; CompileError where it cannot be made."""
        words = [*STANDARD[unit.language], *flags, *unit.flags, *(f"-I{path}" for path in unit.includes)]
        return self._made(unit, [*words, "-c"], "object", ())

    def program(self, unit: Unit, flags: Sequence[str], link: Sequence[str]) -> Compiled:
        """An executable of one file."""
        words = [*STANDARD[unit.language], *flags, *unit.flags, *(f"-I{path}" for path in unit.includes)]
        return self._made(unit, words, "program", link)

    def _made(self, unit: Unit, words: Sequence[str], kind: str, link: Sequence[str]) -> Compiled:
        compiler = unit.compiler or self.compiler(unit.language)
        digest = hashlib.sha256()
        version = compiler_version(compiler)
        for part in (kind, version, *words, *link, unit.text, *(t for header in unit.headers for t in header)):
            digest.update(f"{len(part)}:{part}".encode())
        place = self.folder / "objects" / f"{unit.name}-{digest.hexdigest()[:24]}"
        made, note = place / ("unit.o" if kind == "object" else unit.name), place / "made.json"
        if note.exists():
            found = json.loads(note.read_text())
            if "error" not in found:
                return Compiled(made, found["seconds"], found["text"])
            if found.get("limit", self.limit_s) >= self.limit_s:
                raise CompileError(found["error"])
        self.say(f"compiling {unit.name} ({'C++' if unit.language == 'c++' else 'C'})")
        place.mkdir(parents=True, exist_ok=True)
        suffix = "cpp" if unit.language == "c++" else "c"
        file = f"{unit.name}.{suffix}"  # a file may include itself by its name
        (place / file).write_text(unit.text)
        for name, text in unit.headers:
            (place / name).write_text(text)
        try:
            command = [*shlex.split(compiler), *words, file, *link, "-o", made.name]
            seconds = self._run(command, place, unit.limited)
        except CompileError as error:
            limit = {"limit": self.limit_s} if "CPU seconds" in str(error) else {}
            note.write_text(json.dumps({"error": str(error), **limit}))
            raise
        note.write_text(json.dumps({"seconds": seconds, "text": text_bytes(made) if kind == "object" else None}))
        return self._made(unit, words, kind, link)

    def _run(self, command: Sequence[str], place: Path, limited: bool = False) -> float:
        """CPU seconds of a compiler; politely where it takes minutes and gigabytes. The limit is on its CPU time, so
        that it does not depend on what else the machine does."""
        nice = "nice " if shutil.which("nice") and not limited else ""
        limit = f"ulimit -t {int(self.limit_s)}; " if limited else ""
        shell = f"{limit}exec {nice}{shlex.join(command)}"
        before = os.times()
        ran = subprocess.run(
            ["sh", "-c", shell], cwd=place, capture_output=True, text=True, errors="replace", check=False
        )
        after = os.times()
        seconds = after.children_user + after.children_system - before.children_user - before.children_system
        if ran.returncode and limited and seconds >= self.limit_s - 1:
            raise CompileError(f"did not compile in {self.limit_s:.0f} CPU seconds")
        if ran.returncode:
            told = ("error", "undefined reference", "multiple definition")
            lines = [line for line in ran.stderr.splitlines() if any(word in line for word in told)]
            raise CompileError(f"does not compile: {lines[0].strip()[:200] if lines else 'no message'}")
        return seconds

    def link(self, objects: Sequence[Path], words: Sequence[str], binary: Path, cxx: bool) -> Path:
        """An executable of objects."""
        compiler = self.compiler("c++" if cxx else "c")
        command = [*shlex.split(compiler), *map(str, objects), *words, "-lm", "-o", binary.name]
        self._run(command, binary.parent)
        return binary


def compiler_version(compiler: str) -> str:
    ran = subprocess.run([*shlex.split(compiler), "--version"], capture_output=True, text=True, check=False)
    return ran.stdout.splitlines()[0] if ran.stdout else compiler


def find_cxx() -> str | None:
    for name in (os.environ.get("CXX"), "c++", "g++", "clang++"):
        if name and shutil.which(shlex.split(name)[0]):
            return name
    return None


def open_workshop(folder: Path, limit_s: float = LIMIT_S, say: Callable[[str], None] = lambda what: None) -> Workshop:
    """Raises ToolError where there is no C compiler or the folder cannot be used."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ToolError(f"cannot keep compiled code in {folder}: {error.strerror}") from None
    return Workshop(folder.resolve(), find_compiler(), find_cxx(), limit_s, say)


def text_bytes(path: Path) -> int | None:
    """Machine code in an object, by binutils' `size`."""
    if shutil.which("size") is None:
        return None
    ran = subprocess.run(["size", "-A", str(path)], capture_output=True, text=True, check=False)
    found = re.findall(r"^\.text\S*\s+(\d+)", ran.stdout, re.MULTILINE)
    return sum(map(int, found)) if found else None
