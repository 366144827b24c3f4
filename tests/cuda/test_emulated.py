"""Kernels, on the host: the bits of the C functions in every form and for every kind of state."""

from __future__ import annotations

import ctypes
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

import symgen
from symgen.artifact import Artifact
from symgen.errors import ToolError
from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port
from symgen.scene.load import load
from symgen.scene.model import Parameter
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request
from symgen.targets.cuda import emit_cuda
from symgen.targets.cuda.run import SHIM, functions_of, load_cuda, shim_text
from tests.cuda.emulated import FORMS, Both, compile_emulated
from tests.targets.batches import programs
from tests.targets.programs import all_programs, info

EXAMPLES = Path(__file__).parents[2] / "examples"
VARIANTS = [
    pytest.param({}, "gcc", "g++"),
    pytest.param({"precision": "float", "status": True}, "clang", "clang++"),
    pytest.param({"trigonometry": "libm", "status": True}, "gcc", "g++", marks=pytest.mark.slow),
    pytest.param({"status": True}, "clang", "clang++", marks=pytest.mark.slow),
    pytest.param({"precision": "float"}, "gcc", "g++", marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("options", "cc", "cxx"), VARIANTS, ids=str)
def test_bits_of_the_c_functions(options: dict[str, Any], cc: str, cxx: str, tmp_path: Path) -> None:
    if which(cc) is None or which(cxx) is None:
        pytest.skip(f"no {cc} or {cxx}")
    both = Both(programs(), tmp_path, cc, cxx, **options)
    for scalar, function in zip(both.emitted.functions, both.cuda.functions, strict=True):
        for form in FORMS:
            rows, status = both.caller.scalar(scalar, form.endswith("_p"))
            found, failed = both.launch(function, form)
            assert failed == status
            for a, b in zip(found, rows, strict=True):
                same = (a.view(np.uint8) == b.view(np.uint8)).reshape(*a.shape, -1).all(-1)
                assert (same | (np.isnan(a) & np.isnan(b))).all(), (function.name, form)
                assert not np.isnan(a).all()


def test_no_states_and_too_many(tmp_path: Path) -> None:
    both = Both(programs()[:1], tmp_path, "gcc", "g++")
    entry = both.handle[both.cuda.functions[0].launches["cuda"]]
    nothing = [ctypes.c_void_p(0)] * 3
    p = (ctypes.c_double * 4)()
    assert entry(ctypes.c_size_t(0), ctypes.c_void_p(0), p, *nothing[:2]) == 0
    assert entry(ctypes.c_size_t(1 << 60), ctypes.c_void_p(0), p, *nothing[:2]) == 1


def test_parameters_beyond_the_arguments_of_a_kernel_come_per_state() -> None:
    many = replace(info(), parameters=(Parameter("stiffness", (Fraction(1),) * 481, "N/m", 0),))
    g = Graph()
    q, p = g.inputs("q", 1), g.inputs("p", 481)
    ports = (Port("q", (1,)), Port("p", (481,)))
    program = extract(g, "force", ports, (Port("y", ()),), [[q[0] * p[480]]])
    free = extract(g, "square", ports[:1], (Port("y", ()),), [[q[0] * q[0]]])
    emitted = emit_cuda("demo", [program, free], many)
    assert [set(function.launches) for function in emitted.functions] == [
        {"cuda_p", "cuda_soa_p"},
        {"cuda", "cuda_soa"},
    ]
    assert (
        any("one p for all states" in note for note in emitted.notes)
        and "struct parameters" not in emitted.files["demo.cu"]
    )


def test_functions_without_a_state_are_for_other_kernels() -> None:
    emitted = emit_cuda("demo", all_programs(), info())
    named = {function.program.name: function for function in emitted.functions}
    assert named["natural_mass_matrix"].launches == {}
    assert "demo_natural_mass_matrix(const Symgen0 &Mn)" in emitted.files["demo.cuh"]
    assert "demo_natural_mass_matrix" not in emitted.files["demo.cu"]
    assert "constraints" not in named and any("constraints" in note for note in emitted.notes)


def test_an_artifact_is_called_with_arrays(tmp_path: Path) -> None:
    """The whole way, with memory of the host in place of that of a device."""
    scene = load(EXAMPLES / "gripper.scene.yaml")
    outputs = parse_outputs("mass_matrix,forward_dynamics,integrate")
    artifact = symgen.generate(request(scene, outputs, targets=("c", "cuda")), tmp_path / "out")
    folder = artifact.directory
    (folder / SHIM).write_text(shim_text(artifact.manifest), encoding="utf-8")
    library = compile_emulated(folder, [*artifact.manifest["cuda"]["sources"], SHIM], "g++")
    device, host = functions_of(artifact.manifest, library), artifact.load(flags=["-O1", "-ffp-contract=off"])
    assert set(device) == {"mass_matrix", "forward_dynamics", "integrate"}
    nq, nv = artifact.manifest["nq"], artifact.manifest["nv"]
    rng = np.random.default_rng(1)
    q, v, tau = rng.uniform(-1, 1, (200, nq)), rng.uniform(-1, 1, nv), rng.uniform(-1, 1, (200, nv))
    for name, arguments in {"mass_matrix": (q,), "forward_dynamics": (q, v, tau), "integrate": (q, v, 0.1)}.items():
        assert np.array_equal(getattr(device, name)(*arguments), getattr(host, name)(*arguments)), name
    assert device.mass_matrix(q[0]).shape == (nv, nv)
    with pytest.raises(ToolError, match="integrate: error 1 of CUDA"):
        device.integrate(q, v, np.full(200, 0.1))


def test_errors_of_cuda_are_raised(tmp_path: Path) -> None:
    artifact = symgen.generate(
        request(load(EXAMPLES / "double_pendulum.scene.yaml"), parse_outputs("mass_matrix"), targets=("cuda",)),
        tmp_path / "out",
    )
    assert artifact.manifest["sources"] == [] and artifact.manifest["functions"][0]["symbol"] is None
    assert sorted(p.name for p in artifact.directory.iterdir()) == [
        "double_pendulum.cu",
        "double_pendulum.cuh",
        "manifest.json",
    ]
    folder = artifact.directory
    broken = re.sub(r"cudaGetLastError\(\)", "700", (folder / "double_pendulum.cu").read_text(encoding="utf-8"))
    (tmp_path / "broken.cu").write_text(broken, encoding="utf-8")
    (tmp_path / "double_pendulum.cuh").write_bytes((folder / "double_pendulum.cuh").read_bytes())
    (tmp_path / SHIM).write_text(shim_text(artifact.manifest), encoding="utf-8")
    functions = functions_of(artifact.manifest, compile_emulated(tmp_path, ["broken.cu", SHIM], "g++"))
    with pytest.raises(ToolError, match="mass_matrix: error 700 of CUDA"):
        functions.mass_matrix([0, 0])


def test_without_a_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symgen.targets.cuda.run.find_toolkit", lambda: None)
    with pytest.raises(ToolError, match="pip install nvidia-cuda-nvcc"):
        load_cuda(Artifact(tmp_path))
