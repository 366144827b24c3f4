"""CUDA files compiled for the host, where threads run in turn."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from symgen.program.instructions import Program
from symgen.targets.c import emit_c
from symgen.targets.c.signatures import returns_status
from symgen.targets.cuda import CudaFunction, EmittedCuda, emit_cuda
from tests.targets.batches import Caller
from tests.targets.programs import compile_library, info, write_files

EMULATE = Path(__file__).parent / "emulate.h"
STRICT = ("-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
FORMS = ("cuda", "cuda_p", "cuda_soa", "cuda_soa_p")
SPECIAL = (1e9, -0.0, float("nan"), 0.0, 1.5707963267948966, 3e5, float("-inf"), 34.55751918948772, -1e-30, 1e4, 40.0)


def write_cuda(cuda: EmittedCuda, folder: Path) -> None:
    for name, text in cuda.files.items():
        (folder / name).write_text(text, encoding="utf-8")


def compile_emulated(folder: Path, sources: Sequence[str], cxx: str) -> Path:
    """A shared library of ``sources``, compiled without a warning."""
    library = folder / "emulated.so"
    command = [cxx, *STRICT, "-O1", "-ffp-contract=off", "-x", "c++", "-include", str(EMULATE), *sources]
    command += ["-fPIC", "-shared", "-o", str(library)]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert ran.returncode == 0 and not ran.stderr, ran.stderr
    return library


class Both:
    """The C functions and the CUDA ones of the same programs, on the same states."""

    def __init__(self, programs: Sequence[Program], folder: Path, cc: str, cxx: str, **options: Any) -> None:
        self.emitted, self.cuda = (
            emit_c("demo", programs, info(**options)),
            emit_cuda("demo", programs, info(**options)),
        )
        write_files(self.emitted, folder)
        write_cuda(self.cuda, folder)
        handle = compile_library(folder, self.emitted.sources, cc)
        self.caller = Caller(self.emitted, handle, 300, q=SPECIAL, p=(0.1, -2.0))
        self.handle = ctypes.CDLL(str(compile_emulated(folder, self.cuda.sources, cxx)))

    def launch(self, function: CudaFunction, form: str) -> tuple[list[Any], int]:
        failed = ctypes.c_int(0)
        status = returns_status(function.program, self.cuda.info.options.status)
        extra = [ctypes.byref(failed)] if status else []

        def entry(*arguments: Any) -> int:
            assert self.handle[function.launches[form]](*arguments, *extra, ctypes.c_void_p(0)) == 0
            return failed.value

        return self.caller.run(function, entry, form.endswith("_p"), "soa" in form)
