"""On a device, where there is one: the numbers of the C functions, and NaN where they have none."""

from __future__ import annotations

import ctypes
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symgen
from symgen.errors import ToolError
from symgen.scene.load import load
from symgen.scene.outputs import parse_outputs
from symgen.scene.request import request
from symgen.targets.cuda.run import find_toolkit, load_cuda

EXAMPLES = Path(__file__).parents[2] / "examples"


@cache
def has_device() -> bool:
    """Asked of the driver; a driver without a device says so."""
    try:
        driver = ctypes.CDLL("libcuda.so.1")
    except OSError:
        return False
    count = ctypes.c_int(0)
    return driver.cuInit(0) == 0 and driver.cuDeviceGetCount(ctypes.byref(count)) == 0 and count.value > 0


needs_device = pytest.mark.skipif(not has_device() or find_toolkit() is None, reason="no CUDA device, or no nvcc")


@needs_device
@pytest.mark.parametrize(("precision", "tolerance"), [("double", 1e-12), ("float", 2e-4)])
@pytest.mark.parametrize("scene", ["panda", "gripper", "free_body"])
def test_numbers_of_the_c_functions(scene: str, precision: str, tolerance: float, tmp_path: Path) -> None:
    outputs = parse_outputs("mass_matrix,inverse_dynamics,forward_dynamics,integrate")
    asked = request(load(EXAMPLES / f"{scene}.scene.yaml"), outputs, precision, ("c", "cuda"))
    asked = replace(asked, options=replace(asked.options, status=True))
    artifact = symgen.generate(asked, tmp_path / "out")
    host, device = artifact.load(), load_cuda(artifact, cache=tmp_path)
    rng = np.random.default_rng(1)
    sizes = {"q": artifact.manifest["nq"], "v": artifact.manifest["nv"]}
    for row in artifact.manifest["functions"]:
        given: dict[str, Any] = {
            port["name"]: rng.uniform(-1, 1, (1000, *port["shape"])) if port["shape"] else 0.1
            for port in row["inputs"]
            if port["name"] != "p"
        }
        far = given["q"].copy()
        far[7, -1], far[11, -1] = 1e7, np.nan
        for q in (given["q"], far):
            arguments = {**given, "q": q}
            a, b = getattr(device, row["name"])(**arguments), getattr(host, row["name"])(**arguments)
            assert a.shape == b.shape and (np.isnan(a) == np.isnan(b)).all(), row["name"]
            assert np.nanmax(np.abs(a - b)) <= tolerance * np.nanmax(np.abs(b)), row["name"]
    assert sizes["q"] and sizes["v"]


@pytest.mark.skipif(has_device() or find_toolkit() is None, reason="a CUDA device, or no nvcc")
def test_without_a_device_it_is_said(tmp_path: Path) -> None:
    scene = request(load(EXAMPLES / "pendulum.scene.yaml"), parse_outputs("mass_matrix"), targets=("cuda",))
    artifact = symgen.generate(scene, tmp_path / "out")
    functions = load_cuda(artifact, flags=("-O1", "-arch=sm_80"), cache=tmp_path)
    with pytest.raises(ToolError, match="mass_matrix: error"):
        functions.mass_matrix([0.0])
