"""What a user installs: the wheel, built from the sdist, in a fresh environment and an empty folder."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ("symgen", "templates", "validation")

pytestmark = pytest.mark.slow


def run(command: list[str], cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)


def succeed(command: list[str], cwd: Path) -> str:
    ran = run(command, cwd)
    assert ran.returncode == 0, f"{command}\n{ran.stdout}\n{ran.stderr}"
    return ran.stdout


@pytest.fixture(scope="module")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist and the wheel made from it."""
    pytest.importorskip("build")
    pytest.importorskip("hatchling")
    out = tmp_path_factory.mktemp("dist")
    succeed([sys.executable, "-m", "build", "--no-isolation", "--outdir", str(out), str(ROOT)], out)
    return out


@pytest.fixture(scope="module")
def python(dist: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of a fresh environment with the wheel; its dependencies are this environment's."""
    place = tmp_path_factory.mktemp("fresh")
    succeed([sys.executable, "-m", "venv", "--without-pip", str(place / "venv")], place)
    python = place / "venv/bin/python"
    # A plain path line: packages are found there, but the .pth of the editable symgen is not read.
    site = Path(succeed([str(python), "-c", "import site; print(site.getsitepackages()[0])"], place).strip())
    site.joinpath("dependencies.pth").write_text(sysconfig.get_paths()["purelib"] + "\n")
    wheel = next(dist.glob("*.whl"))
    install = ["-m", "pip", "--python", str(python), "install", "--quiet", "--no-deps", "--no-index", str(wheel)]
    succeed([sys.executable, *install], place)
    return python


def tracked() -> list[str]:
    """Every file that must travel, by its path inside the package."""
    listed = run(["git", "ls-files", "--", *SHIPPED], ROOT)
    if listed.returncode:
        pytest.skip("not a git checkout")
    names = [name for name in listed.stdout.splitlines() if not (ROOT / name).is_symlink() and (ROOT / name).exists()]
    return [name if name.startswith("symgen/") else f"symgen/{name}" for name in names]


def test_wheel_holds_every_file_once(dist: Path) -> None:
    with zipfile.ZipFile(next(dist.glob("*.whl"))) as wheel:
        names = wheel.namelist()
    assert len(names) == len(set(names))
    assert set(tracked()) <= set(names)
    top = {name.split("/")[0] for name in names}
    assert top == {"symgen", "symgen-0.1.0.dist-info"}
    assert not [name for name in names if name.endswith((".pyc", ".so", ".o"))]


def test_sdist_holds_what_a_packager_needs(dist: Path) -> None:
    with tarfile.open(next(dist.glob("*.tar.gz"))) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "Makefile", "LICENSE", "LICENSE-0BSD", "README.md", "requirements/lock.txt"} <= names
    assert set(tracked()) <= names


def test_installed_command_generates_in_an_empty_folder(python: Path, tmp_path: Path) -> None:
    where = succeed([str(python), "-c", "import symgen; print(symgen.__file__)"], tmp_path).strip()
    assert Path(where).is_relative_to(python.parents[1])
    scene = tmp_path / "pendulum.scene.yaml"
    scene.write_bytes((ROOT / "examples/pendulum.scene.yaml").read_bytes())
    symgen = str(python.parent / "symgen")
    assert succeed([symgen, "--version"], tmp_path).startswith("symgen ")
    assert "pendulum" in succeed([symgen, "show", scene.name], tmp_path)
    succeed([symgen, "generate", scene.name, "-o", "out"], tmp_path)
    assert (tmp_path / "out/pendulum.c").exists()
    assert (tmp_path / "out/manifest.json").exists()
    succeed([symgen, "report", scene.name, "-o", "site", "--with", "motion"], tmp_path)
    assert (tmp_path / "site/index.html").exists() and (tmp_path / "site/pendulum/index.html").exists()
    assert (tmp_path / "site/data/pendulum/motion.json").exists()
    succeed([str(python), "-c", "import symgen.validation"], tmp_path)


def test_the_same_bytes_as_from_the_checkout(python: Path, tmp_path: Path) -> None:
    """Generated code does not depend on where symgen runs or on the hash seed."""
    scene = str(ROOT / "examples/fig1.scene.yaml")
    for name, interpreter, seed in (("a", str(python), "1"), ("b", sys.executable, "2")):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        environment.pop("PYTHONPATH", None)
        command = [interpreter, "-m", "symgen", "generate", scene, "-o", name, "--target", "c"]
        ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stderr
    files = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert files == sorted(path.name for path in (tmp_path / "b").iterdir())
    for file in files:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes(), file
