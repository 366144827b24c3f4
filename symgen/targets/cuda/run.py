"""The CUDA of an artifact, compiled by nvcc and called on NumPy arrays: for checks and for trying things out.

Every call takes its arrays to the device and back; programs that care for speed keep them there.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

from symgen.artifact.compiler import cache_folder
from symgen.artifact.function import CompiledFunction
from symgen.artifact.load import Artifact, Loaded
from symgen.errors import SceneError, ToolError
from symgen.targets.c.signatures import SHARED
from symgen.targets.c.templates import render

FLAGS = ("-O3", "-arch=native")
SHIM = "symgen-shim.cu"
ALWAYS = ("-shared", "-Xcompiler", "-fPIC")


@dataclass(frozen=True)
class Toolkit:
    """A compiler of CUDA and what it needs to be told."""

    nvcc: str
    flags: tuple[str, ...] = ()


def find_toolkit() -> Toolkit | None:
    """$NVCC, nvcc on the PATH, that of $CUDA_HOME or /usr/local/cuda, or that of PyPI's ``nvidia-cuda-nvcc``."""
    named = os.environ.get("NVCC") or shutil.which("nvcc")
    if named:
        return Toolkit(named)
    roots = [Path(os.environ["CUDA_HOME"])] if os.environ.get("CUDA_HOME") else []
    roots += [Path("/usr/local/cuda")]
    roots += sorted((root for path in sys.path if path for root in Path(path).glob("nvidia/cu*")), reverse=True)
    for root in roots:
        nvcc = root / "bin" / "nvcc"
        if nvcc.is_file():
            return Toolkit(str(nvcc), (f"-L{root / 'lib'}",) if (root / "lib").is_dir() else ())
    return None


def load_cuda(
    artifact: Artifact, toolkit: Toolkit | None = None, flags: Sequence[str] = FLAGS, cache: str | Path | None = None
) -> Loaded:
    """The functions of an artifact that run on a device, called like those of `Artifact.load`, with one dt for all.

    Raises ToolError without nvcc, when it fails, and when a call fails (no device, no memory); SceneError where the
    artifact has no CUDA.
    """
    toolkit = toolkit or find_toolkit()
    if toolkit is None:
        raise ToolError("no CUDA compiler found (nvcc): install a CUDA toolkit, or pip install nvidia-cuda-nvcc")
    manifest = artifact.manifest
    if "cuda" not in manifest:
        raise SceneError("there is no CUDA in this artifact (targets)", str(artifact.directory))
    files = [*manifest["cuda"]["headers"], *manifest["cuda"]["sources"]]
    texts = {name: (artifact.directory / name).read_text(encoding="utf-8") for name in files}
    texts[SHIM] = shim_text(manifest)
    command = [toolkit.nvcc, *toolkit.flags, *ALWAYS, *flags]
    library = _library(manifest["name"], texts, [*manifest["cuda"]["sources"], SHIM], command, cache_folder(cache))
    return functions_of(manifest, library)


def functions_of(manifest: Mapping[str, Any], library: Path) -> Loaded:
    """The functions of a library made of an artifact's CUDA and `shim_text`."""
    try:
        handle = ctypes.CDLL(str(library))
    except OSError as error:
        raise ToolError(f"cannot load {library}: {error}") from None
    defaults = [value for parameter in manifest["parameters"] for value in parameter["default"]]
    functions = {}
    for row in manifest["functions"]:
        if _launches(row):
            entry = _Checked(row["name"], getattr(handle, _shim_symbol(row)))
            functions[row["name"]] = CompiledFunction(row, entry, defaults)
    return Loaded(functions, library)


class _Checked:
    """A function of the library whose errors are raised."""

    def __init__(self, name: str, entry: Any) -> None:
        self.name = name
        self.entry = entry
        self.restype: Any = None
        self.argtypes: Sequence[Any] = ()

    def __call__(self, *arguments: Any) -> None:
        self.entry.restype, self.entry.argtypes = ctypes.c_int, list(self.argtypes)
        error = self.entry(*arguments)
        if error:
            raise ToolError(f"{self.name}: error {error} of CUDA (a cudaError_t)")


def _launches(function: Mapping[str, Any]) -> Mapping[str, str]:
    """Form → host function."""
    found: Mapping[str, str] = function.get("cuda", {}).get("launch", {})
    return found


def _shim_symbol(function: Mapping[str, Any]) -> str:
    return f"shim_{next(iter(_launches(function).values()))}"


def shim_text(manifest: Mapping[str, Any]) -> str:
    """CUDA with a function for every one of the artifact that runs over states, as `CompiledFunction` calls it."""
    rows = [_shim_row(manifest, row) for row in manifest["functions"] if _launches(row)]
    real = manifest["options"]["precision"]
    return render("cuda/shim.cu.j2", header=manifest["cuda"]["headers"][0], real=real, functions=rows)


def _shim_row(manifest: Mapping[str, Any], row: Mapping[str, Any]) -> dict[str, Any]:
    real, inputs, outputs = row["precision"], row["inputs"], row["outputs"]
    arguments, sent = ["size_t states"], []
    for k, port in enumerate(inputs):
        arguments += [f"const {real} *in_{k}", f"size_t step_{k}"]
        if port["shape"]:
            sent.append({"number": k, "size": prod(port["shape"]), "shared": port["name"] in SHARED})
    fetched = [
        {"number": len(inputs) + k, "size": prod(port["shape"]), "to": f"out_{k}"} for k, port in enumerate(outputs)
    ]
    calls = []
    place = next((k for k, port in enumerate(inputs) if port["name"] == "p"), None)
    for form, own in (("cuda_p", True), ("cuda", False)):
        if form in _launches(row):
            passed = ["states"]
            for k, port in enumerate(inputs):
                shared = port["name"] == "p" and not own
                passed.append(f"in_{k}" if shared else f"at[{k}]" if port["shape"] else f"in_{k}[0]")
            passed += [f"at[{port['number']}]" for port in fetched]
            passed += ["0", "0"] if row["cuda"]["failed"] else ["0"]
            text = f"{_launches(row)[form]}({', '.join(passed)})"
            calls.append({"when": f"step_{place}" if own else "", "text": text})
    return {
        "symbol": _shim_symbol(row),
        "arguments": [*arguments, *(f"{real} *out_{k}" for k in range(len(outputs)))],
        "count": len(inputs) + len(outputs),
        "sent": sent,
        "fetched": fetched,
        "one_for_all": [k for k, port in enumerate(inputs) if not port["shape"]],
        "calls": calls,
    }


def _library(name: str, texts: Mapping[str, str], sources: Sequence[str], command: Sequence[str], cache: Path) -> Path:
    """Compiled once, kept by content."""
    digest = hashlib.sha256(repr((sorted(texts.items()), list(command))).encode()).hexdigest()[:32]
    library = cache / f"{name}-cuda-{digest}.so"
    if library.exists():
        return library
    with tempfile.TemporaryDirectory(prefix="build-", dir=cache) as scratch:
        for file, text in texts.items():
            (Path(scratch) / file).write_text(text, encoding="utf-8")
        made = Path(scratch) / "made.so"
        try:
            ran = subprocess.run(
                [*command, "-o", made, *sources], cwd=scratch, capture_output=True, text=True, check=False
            )
        except OSError as error:
            raise ToolError(f"cannot run {command[0]}: {error.strerror}") from None
        if ran.returncode:
            lines = [line for line in ran.stderr.splitlines() if "error" in line] or ran.stderr.splitlines()
            raise ToolError(f"{command[0]} could not compile {name}: {lines[0] if lines else 'no message'}")
        os.replace(made, library)
    return library
