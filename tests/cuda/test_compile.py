"""CUDA files through the compilers that are here: nvcc where there is a toolkit, clang to PTX without one."""

from __future__ import annotations

import subprocess
from functools import cache
from pathlib import Path
from shutil import which

import pytest

from symgen.targets.cuda import emit_cuda
from symgen.targets.cuda.run import find_toolkit
from tests.cuda.emulated import write_cuda
from tests.targets.batches import programs
from tests.targets.programs import all_programs, info

HEADER = Path(__file__).parent / "without_toolkit.h"
ARCHITECTURE = "sm_70"
CLANG = ("clang++", "-x", "cuda", "--cuda-device-only", f"--cuda-gpu-arch={ARCHITECTURE}", "-nocudainc", "-nocudalib")
CLANG += ("-std=c++11", "-O2", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-Wno-unknown-cuda-version")
CLANG += ("-S",)


@cache
def clang_makes_ptx() -> bool:
    if which("clang++") is None:
        return False
    ran = subprocess.run(
        [*CLANG, "-include", str(HEADER), "-o", "-", "-"], input="", capture_output=True, text=True, check=False
    )
    return ran.returncode == 0


@pytest.mark.parametrize("precision", ["double", "float"])
def test_clang_makes_ptx_without_a_toolkit(precision: str, tmp_path: Path) -> None:
    """Every function and kernel is code that a device can have: no memory of the host, no exceptions."""
    if not clang_makes_ptx():
        pytest.skip("no clang that makes PTX")
    emitted = emit_cuda("demo", all_programs(), info(precision=precision, status=True))
    write_cuda(emitted, tmp_path)
    command = [*CLANG, "-include", str(HEADER), "demo.cu", "-o", "demo.ptx"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0 and not ran.stderr, ran.stderr
    ptx = (tmp_path / "demo.ptx").read_text(encoding="utf-8")
    entries = [line for line in ptx.splitlines() if ".entry" in line]
    kernels = emitted.files["demo.cu"].count("__global__")
    assert len(entries) == kernels > 5
    assert f".target {ARCHITECTURE}" in ptx and (".f64" in ptx) == (precision == "double")


@pytest.mark.parametrize("precision", ["double", pytest.param("float", marks=pytest.mark.slow)])
def test_nvcc_compiles_silently(precision: str, tmp_path: Path) -> None:
    toolkit = find_toolkit()
    if toolkit is None:
        pytest.skip("no nvcc")
    emitted = emit_cuda("demo", programs(), info(precision=precision, status=True))
    write_cuda(emitted, tmp_path)
    command = [toolkit.nvcc, *toolkit.flags, "-O3", "-Werror", "all-warnings", "-Xptxas", "-v"]
    command += ["-cubin", "-arch=sm_90", "demo.cu", "-o", "demo.cubin"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert "warning" not in ran.stderr and "registers" in ran.stderr
    spills = [line for line in ran.stderr.splitlines() if "spill" in line]
    assert spills and all("0 bytes spill stores" in line for line in spills)


@pytest.mark.parametrize("cc", ["gcc", "clang"])
def test_the_launches_can_be_called_from_c(cc: str, tmp_path: Path) -> None:
    """Also beside the header of the C functions, in any order, and of the other precision."""
    if which(cc) is None:
        pytest.skip(f"no {cc}")
    from symgen.targets.c import emit_c

    for precision, folder in (("double", "d"), ("float", "f")):
        (tmp_path / folder).mkdir()
        write_cuda(emit_cuda("demo", programs(), info(precision=precision)), tmp_path / folder)
    (tmp_path / "demo.h").write_text(emit_c("demo", programs(), info()).files["demo.h"], encoding="utf-8")
    text = '#include "d/demo.cuh"\n#include "demo.h"\n#include "f/demo.cuh"\n'
    text += (
        "int main(void) { return demo_mass_matrix_cuda(0, 0, 0, 0, 0) + demo_wide_cuda_f32(0, 0, 0, 0, 0, 0, 0); }\n"
    )
    (tmp_path / "use.c").write_text(text, encoding="utf-8")
    command = [cc, "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "use.c"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
