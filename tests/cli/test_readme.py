"""The README's example is run and its output compared; ``--update`` writes what it prints now."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SCENE, SCRIPT = "double_pendulum.scene.yaml", "run.py"


def run(command: str, folder: Path) -> str:
    """Output of one of the README's commands, the symgen and python of this environment first on the PATH."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(folder / "cache")}
    words = command.split()
    arguments = [sys.executable, *(["-m", "symgen", *words[1:]] if words[0] == "symgen" else words[1:])]
    ran = subprocess.run(arguments, cwd=folder, env=environment, capture_output=True, encoding="utf-8", check=False)
    assert ran.returncode == 0, ran.stderr
    assert ran.stderr == ""
    return ran.stdout


def settled(text: str) -> str:
    """Without the doubts of certificates: they hang on primes drawn from every byte that was emitted."""
    return re.sub(r"\de-\d+(?=  \[)", "…", text)


def c_function(text: str, start: str) -> str:
    """From the line ``start`` to the closing brace."""
    begin = text.index(start)
    return text[begin : text.index("\n}\n", begin) + 3]


def test_the_example_prints_what_the_readme_says(tmp_path: Path, update: bool) -> None:
    text = README.read_text(encoding="utf-8")
    blocks = [(match.group(1), match.group(2)) for match in BLOCK.finditer(text)]
    (scene,) = (body for kind, body in blocks if kind == "yaml")
    (script,) = (body for kind, body in blocks if kind == "python")
    (tmp_path / SCENE).write_text(scene)
    (tmp_path / SCRIPT).write_text(script)
    fresh = text
    for kind, body in blocks:
        if kind == "console":
            command = body.splitlines()[0].removeprefix("$ ")
            new = f"$ {command}\n{run(command, tmp_path)}"
        elif kind == "c":
            new = c_function((tmp_path / "out/double_pendulum.c").read_text(), body.splitlines()[0])
        else:
            continue
        fresh = fresh.replace(f"```{kind}\n{body}```", f"```{kind}\n{new}```", 1)
    if update:
        README.write_text(fresh, encoding="utf-8")
    assert settled(fresh) == settled(text) or update


def test_the_scene_reference_is_true(tmp_path: Path) -> None:
    """Its first scene and its Python run as printed."""
    blocks = [(match.group(1), match.group(2)) for match in BLOCK.finditer((ROOT / "docs/scene.md").read_text("utf-8"))]
    scene = next(body for kind, body in blocks if kind == "yaml")
    (script,) = (body for kind, body in blocks if kind == "python")
    (tmp_path / "a.scene.yaml").write_text(scene)
    (tmp_path / SCRIPT).write_text(script + "print(f.mass_matrix([0.0]))\n")
    assert "double_pendulum: 4 functions certified" in run("symgen generate a.scene.yaml -o a", tmp_path)
    assert run(f"python {SCRIPT}", tmp_path) == "[[0.4]]\n"


def test_the_page_on_use_is_true(tmp_path: Path) -> None:
    """Its scene is generated, its C compiled and run, its Python run; what they print stands on the page."""
    text = (ROOT / "docs/use.md").read_text("utf-8")
    blocks = [(match.group(1), match.group(2)) for match in BLOCK.finditer(text)]
    (scene,) = (body for kind, body in blocks if kind == "yaml")
    (program,) = (body for kind, body in blocks if kind == "c")
    (console,) = (body for kind, body in blocks if kind == "console")
    compile_it, run_it, printed = console.splitlines()
    (tmp_path / "crane.scene.yaml").write_text(scene)
    (tmp_path / "swing.c").write_text(program)
    (tmp_path / SCRIPT).write_text("".join(body for kind, body in blocks if kind == "python"))
    run("symgen generate crane.scene.yaml -o crane", tmp_path)
    subprocess.run([*compile_it.split()[1:], "-Wall", "-Wextra", "-Werror"], cwd=tmp_path, check=True)
    swung = subprocess.run([tmp_path / run_it.split()[1]], capture_output=True, encoding="utf-8", check=True)
    assert swung.stdout == f"{printed}\n"
    first, second, *_ = run(f"python {SCRIPT}", tmp_path).splitlines()
    assert f"prints `{first}`" in text
    assert second.endswith("(2, 4)")


@pytest.mark.parametrize("page", [README, *sorted((ROOT / "docs").glob("*.md"))], ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8")):
        assert "://" in target or (page.parent / target).exists(), target
