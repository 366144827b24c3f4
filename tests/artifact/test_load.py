"""Artifacts compiled and called from NumPy."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

from symgen.artifact import RELEASE_FLAGS, Artifact, Loaded, compiler, find_compiler
from symgen.errors import SceneError, ToolError
from symgen.program.evaluate import evaluate
from tests.artifact.conftest import build
from tests.targets.programs import PARAMETERS, all_programs, arm
from tests.targets.test_random import MathNumbers

pytestmark = pytest.mark.skipif(which("cc") is None and which("gcc") is None, reason="no C compiler")
DEFAULTS = [float(value) for parameter in PARAMETERS for value in parameter.default]
Make = Callable[..., Artifact]


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory, cache: Path) -> Loaded:
    return build(tmp_path_factory.mktemp("artifact") / "out").load(cache=cache)


def reference(name: str, **inputs: Any) -> list[Any]:
    """Outputs of a program in Python floats, as arrays of their shapes."""
    program = next(program for program in all_programs() if program.name == name)
    flat = {key: np.atleast_1d(value).ravel().tolist() for key, value in inputs.items()}
    values = evaluate(program, MathNumbers(), flat)
    return [np.reshape(values[port.name], port.shape) for port in program.outputs]


def test_single_state(loaded: Loaded) -> None:
    q = np.array([0.3, 0.4])
    mass = loaded.mass_matrix(q)
    assert mass.shape == (2, 2) and mass.dtype == np.float64
    assert np.allclose(mass, reference("mass_matrix", q=q, p=DEFAULTS)[0], rtol=1e-14)


def test_several_outputs_and_scalars(loaded: Loaded) -> None:
    state = {"q": [0.5, 0.4], "v": [1, 2], "tau": [0.1, 0.2], "p": [1, 2, 3, 4]}
    a, f = loaded.forward_dynamics(**state)
    expected = reference("forward_dynamics", **state)
    assert np.allclose(a, expected[0], rtol=1e-14) and np.shape(f) == () and np.isclose(f, expected[1], rtol=1e-14)


def test_batches_are_the_states_one_by_one(loaded: Loaded) -> None:
    rng = np.random.default_rng(0)
    q, v, p = rng.normal(size=(7, 2)), rng.normal(size=(7, 2)), rng.normal(size=(7, 4))
    together = loaded.integrate(q, v, 0.01)
    assert together.shape == (7, 4)
    assert all(np.array_equal(together[i], loaded.integrate(q[i], v[i], 0.01)) for i in range(7))
    own = loaded.mass_matrix(q, p)
    assert all(np.array_equal(own[i], loaded.mass_matrix(q[i], p[i])) for i in range(7))
    assert np.array_equal(loaded.mass_matrix(q[0], p)[3], loaded.mass_matrix(q[0], p[3]))
    steps = np.linspace(0, 1, 7)
    assert np.array_equal(loaded.integrate(q, v[0], steps)[5], loaded.integrate(q[5], v[0], steps[5]))
    assert loaded.mass_matrix(np.empty((0, 2))).shape == (0, 2, 2)


@pytest.mark.parametrize("precision", ["double", "float"])
def test_batches_of_the_artifact_are_used(precision: str, make_artifact: Make, cache: Path) -> None:
    """The functions over vectors give what single states give; shared and own parameters, steps and few states too."""
    functions = make_artifact("vectors", batch=True, precision=precision).load(cache=cache)
    close = {"rtol": 1e-13 if precision == "double" else 2e-5, "atol": 1e-15 if precision == "double" else 1e-6}
    rng = np.random.default_rng(2)
    q, v, p = (rng.uniform(0.5, 1.5, size=(21, k)) for k in (2, 2, 4))
    for own in (p[0], p):
        mass = functions.mass_matrix(q, own)
        assert all(
            np.allclose(mass[i], functions.mass_matrix(q[i], p[i if own is p else 0]), **close) for i in range(21)
        )
    for steps in (0.25, np.linspace(0, 1, 21)):
        after = functions.integrate(q, v, steps)
        single = [functions.integrate(q[i], v[i], np.broadcast_to(steps, 21)[i]) for i in range(21)]
        assert np.allclose(after, single, **close)
    assert np.allclose(functions.integrate(q, v[0], 0.25)[20], functions.integrate(q[20], v[0], 0.25), **close)
    assert functions.mass_matrix(q[:3]).shape == (3, 2, 2)


def test_no_inputs(loaded: Loaded) -> None:
    assert np.allclose(loaded.natural_mass_matrix().ravel(), np.arange(16) / 3)


def test_any_memory_layout(loaded: Loaded) -> None:
    rng = np.random.default_rng(1)
    q = rng.normal(size=(2, 5)).T
    assert not q.flags.c_contiguous
    assert np.array_equal(loaded.mass_matrix(q), loaded.mass_matrix(q.copy()))
    assert np.array_equal(loaded.mass_matrix(q[::-2]), loaded.mass_matrix(q[::-2].copy()))
    assert np.array_equal(loaded.mass_matrix(np.array([1, 2], np.int8)), loaded.mass_matrix([1.0, 2.0]))


@pytest.mark.parametrize(
    ("arguments", "named", "error", "fragment"),
    [
        (([0.1],), {}, ValueError, r"q must be \(2,\) or \(N, 2\), not \(1,\)"),
        ((0.1,), {}, ValueError, r"not \(\)"),
        ((np.zeros((2, 3)),), {}, ValueError, r"not \(2, 3\)"),
        ((np.zeros((1, 1, 2)),), {}, ValueError, r"not \(1, 1, 2\)"),
        ((["a", "b"],), {}, ValueError, "no array of real numbers"),
        (([1j, 2],), {}, ValueError, "no array of real numbers"),
        (([[1, 2], [3]],), {}, ValueError, "no array of real numbers"),
        ((None,), {}, ValueError, "no array of real numbers"),
        ((), {}, TypeError, "needs q"),
        (([1, 2], [1, 2, 3, 4], 5), {}, TypeError, "takes 2 arguments, not 3"),
        (([1, 2],), {"q": [1, 2]}, TypeError, "a second argument q"),
        (([1, 2],), {"v": [1, 2]}, TypeError, "unknown argument v"),
        ((np.zeros((3, 2)), np.zeros((4, 4))), {}, ValueError, "q is for 3 states, p for 4"),
    ],
)
def test_wrong_arguments(loaded: Loaded, arguments: Any, named: Any, error: Any, fragment: str) -> None:
    with pytest.raises(error, match=fragment):
        loaded.mass_matrix(*arguments, **named)


def test_describes_itself(loaded: Loaded) -> None:
    names = ["mass_matrix", "forward_dynamics", "integrate", "gravity_force", "potential_energy", "inverse_dynamics"]
    assert list(loaded) == [*names, "natural_mass_matrix"]
    assert "mass_matrix" in loaded and "mass_matrix" in dir(loaded)
    assert loaded.mass_matrix.inputs == ("q", "p") and loaded.mass_matrix.outputs == ("M",)
    text = loaded.mass_matrix.__doc__
    assert text is not None and "M: 2 × 2, kg·m²" in text and "literal" in text
    with pytest.raises(AttributeError, match="no function nothing; there are: mass_matrix"):
        _ = loaded.nothing


@pytest.mark.parametrize(
    "options", [{"precision": "float"}, {"status": True, "batch": True}, {"trigonometry": "libm"}], ids=str
)
def test_variants(options: dict[str, Any], make_artifact: Make, cache: Path) -> None:
    functions = make_artifact(**options).load(cache=cache)
    single = options.get("precision") == "float"
    a, _ = functions.forward_dynamics([0.5, 0.4], [1, 2], [0.1, 0.2], [1, 2, 3, 4])
    expected = reference("forward_dynamics", q=[0.5, 0.4], v=[1, 2], tau=[0.1, 0.2], p=[1, 2, 3, 4])
    assert a.dtype == (np.float32 if single else np.float64)
    assert np.allclose(a, expected[0], rtol=1e-5 if single else 1e-13)
    a, _ = functions.forward_dynamics([[0.5, 0.4], [10, 10]], [1, 2], [0.1, 0.2], [1, 2, 3, 4])
    assert np.isfinite(a[0]).all() and np.isnan(a[1]).all()


def test_compiled_once_by_content(make_artifact: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = tmp_path / "cache"
    first = make_artifact("a").load(cache=cache)
    made = first.library.stat().st_mtime_ns

    def refuse(*args: Any, **named: Any) -> Any:
        raise AssertionError("compiled again")

    with monkeypatch.context() as context:
        context.setattr(compiler.tempfile, "TemporaryDirectory", refuse)
        assert make_artifact("b").load(cache=cache).library == first.library
    assert first.library.stat().st_mtime_ns == made
    others = [
        make_artifact("c", trigonometry="libm").load(cache=cache),
        make_artifact("a").load(cache=cache, flags=["-O1"]),
    ]
    assert len({first.library, *(other.library for other in others)}) == 3
    assert sorted(path.suffix for path in cache.iterdir()) == [".so"] * 3  # nothing else is left


def test_parallel_processes(make_artifact: Make, tmp_path: Path) -> None:
    """Several at once with an empty cache: all get a working library, one is kept."""
    artifact = make_artifact()
    code = (
        "import sys; from symgen.artifact import Artifact;"
        "print(Artifact(sys.argv[1]).load(cache=sys.argv[2], flags=['-O0']).mass_matrix([1, 2]).tolist())"
    )
    command = [sys.executable, "-c", code, str(artifact.directory), str(tmp_path / "cache")]

    def run(_: int) -> str:
        root = str(Path(__file__).parents[2])
        ran = subprocess.run(
            command, capture_output=True, text=True, check=True, cwd=root, env={**os.environ, "PYTHONPATH": root}
        )
        return ran.stdout

    with ThreadPoolExecutor(3) as pool:
        shown = list(pool.map(run, range(3)))
    assert len(set(shown)) == 1 and len(list((tmp_path / "cache").iterdir())) == 1


def test_default_cache_follows_the_environment(
    make_artifact: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    library = make_artifact().load(flags=["-O0"]).library
    assert library.parent == tmp_path / "xdg" / "symgen"
    assert stat.S_IMODE(library.parent.stat().st_mode) == 0o700
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert compiler.cache_folder() == tmp_path / "home" / ".cache" / "symgen"


def test_cache_that_cannot_be_written(make_artifact: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert make_artifact().load(flags=["-O0"]).mass_matrix([1, 2]).shape == (2, 2)
    with pytest.raises(ToolError, match="cannot keep compiled code"):
        make_artifact().load(cache=tmp_path / "file" / "x")


def test_finding_a_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("CC", raising=False)
    assert find_compiler() in ("cc", "gcc", "clang")
    monkeypatch.setenv("CC", "gcc -m64")
    assert find_compiler() == "gcc -m64"
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(ToolError, match=r"\$CC: no C compiler 'no-such-compiler'"):
        find_compiler()
    assert find_compiler("gcc") == "gcc"
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ToolError, match="apt install gcc"):
        find_compiler()


def test_compiler_that_fails(make_artifact: Make, tmp_path: Path) -> None:
    artifact = make_artifact()
    source = artifact.directory / "demo.c"
    source.write_text(source.read_text().replace("const double t1", "const double 1t"))
    with pytest.raises(ToolError, match="could not compile demo") as caught:
        artifact.load(cache=tmp_path / "cache", flags=["-O0"])
    assert "\n" not in str(caught.value)
    assert list((tmp_path / "cache").iterdir()) == []


def test_march_native_is_left_out_where_it_is_unknown(
    make_artifact: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "-march=native" in RELEASE_FLAGS
    wrapper = tmp_path / "mycc"
    wrapper.write_text('#!/bin/sh\nfor a; do [ "$a" = -march=native ] && exit 1; done\nexec gcc "$@"\n')
    wrapper.chmod(0o755)
    assert make_artifact().load(cc=str(wrapper), cache=tmp_path / "cache").mass_matrix([1, 2]).shape == (2, 2)


def test_damaged_artifacts(make_artifact: Make, tmp_path: Path, cache: Path) -> None:
    with pytest.raises(SceneError, match="no artifact here"):
        _ = Artifact(tmp_path / "none").manifest
    artifact = make_artifact()
    manifest = artifact.manifest
    path = artifact.directory / "manifest.json"
    for text, fragment in (("{", "not a manifest"), ("[]", "format 1"), ('{"format": 2}', "format 1")):
        path.write_text(text)
        with pytest.raises(SceneError, match=fragment):
            _ = Artifact(artifact.directory).manifest
    path.write_text(json.dumps({**manifest, "sources": ["../demo.c"]}))
    with pytest.raises(SceneError, match="not a file of an artifact"):
        Artifact(artifact.directory).load(cache=cache)
    path.write_text(json.dumps({**manifest, "sources": []}))
    with pytest.raises(SceneError, match="no C in this artifact"):
        Artifact(artifact.directory).load(cache=cache)
    path.write_text(json.dumps(manifest))
    (artifact.directory / "demo.c").unlink()
    with pytest.raises(SceneError, match="not readable"):
        Artifact(artifact.directory).load(cache=cache)


def test_agrees_with_the_text_read_back(loaded: Loaded) -> None:
    """The compiled binary is the certified text: same values as its read-back in Python floats."""
    from symgen.targets.c import emit_c, read_back
    from tests.targets.programs import info

    read = read_back(emit_c("demo", [arm()], info())).functions["mass_matrix"]
    q, p = [0.3, -0.7], [1.0, 2.0, 3.0, 4.0]
    values = read.evaluate(MathNumbers(), {"q": q, "p": p})["M"]
    assert np.allclose(loaded.mass_matrix(q, p).ravel(), values, rtol=1e-14)
