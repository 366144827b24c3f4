"""The command line's manners: exit status, one line per error, no traceback, quiet in a pipe."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from symgen import cli

SCENE = """\
name: pendulum
bodies:
  - {name: rod, mass: 2, com: [0, 0, -0.5], inertia: [0.2, 0.2, 0.01, 0, 0, 0]}
joints:
  - {name: hinge, type: revolute, parent: ground, child: rod, axis: [0, 1, 0]}
outputs: [mass_matrix, forward_dynamics]
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "pendulum.scene.yaml"
    path.write_text(SCENE)
    return path


def start(*arguments: str, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "symgen", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env={**os.environ, **environment},
    )


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["nonsense"], "No such command 'nonsense'"),
        (["show"], "Missing argument 'SCENE'"),
        (["show", "x", "--format", "pdf"], "'pdf' is not one of"),
        (["show", "x", "--format", "latex"], "are about --equations"),
        (["show", "x", "--symbols", "paper"], "are about --equations"),
        (["generate", "x"], "Missing option '-o'"),
        (["generate", "x", "-o", "y", "--target", ","], "the list is empty"),
        (["validate", "x", "--states", "0"], "0 is not in the range"),
        (["bench", "x", "--wrong"], "--wrong"),
    ],
)
def test_wrong_usage_is_one_line_and_exit_2(
    arguments: list[str], fragment: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("symgen: ")
    assert captured.err.count("\n") == 1
    assert fragment in captured.err


@pytest.mark.parametrize("command", [["show"], ["generate", "-o", "out"], ["validate"], ["bench"]])
def test_bad_input_is_one_line_and_exit_2(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("broken.scene.yaml").write_text("name: x\nbodies: 3\njoints: []\n")
    assert cli.run([*command, "broken.scene.yaml"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("symgen: broken.scene.yaml:2")
    assert captured.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == [tmp_path / "broken.scene.yaml"]


def test_error_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["show", "--json", str(tmp_path / "none.yaml")]) == 2
    captured = capsys.readouterr()
    answer = json.loads(captured.out)
    assert answer["exit_status"] == 2
    assert captured.err == f"symgen: {answer['error']}\n"


def test_unexpected_exception_is_one_line(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def explode(_path: str) -> None:
        raise RuntimeError("two\nlines \x1b[31m")

    monkeypatch.delenv("SYMGEN_DEBUG", raising=False)
    monkeypatch.setattr(cli, "load_scene", explode)
    assert cli.run(["show", str(scene)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(r"symgen: unexpected RuntimeError: two lines \x1b[31m; ")
    assert "report it" in error
    assert error.count("\n") == 1
    monkeypatch.setenv("SYMGEN_DEBUG", "1")
    with pytest.raises(RuntimeError):
        cli.run(["show", str(scene)])


def test_interrupt_exits_130(scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(_path: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "load_scene", interrupt)
    assert cli.run(["show", str(scene)]) == 130
    assert capsys.readouterr().err.strip() == "symgen: interrupted"


def test_ctrl_c_in_a_real_process_leaves_no_traceback(scene: Path) -> None:
    code = (
        "import sys; from symgen import cli; print('ready', flush=True);"
        f"sys.exit(cli.run(['validate', {str(scene)!r}, '--states', '1000000']))"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=120)
    assert out == ""
    assert error.strip() == "symgen: interrupted"  # click ends the line of the ^C first
    assert process.returncode == 130


@pytest.mark.parametrize("module", ["symgen", "symgen.validation.benchmarks"])
def test_ctrl_c_during_imports_leaves_no_traceback(module: str, tmp_path: Path) -> None:
    """The first import of the package ends as Ctrl-C would end it."""
    (tmp_path / "sympy.py").write_text("raise KeyboardInterrupt\n")
    (tmp_path / "numpy.py").write_text("raise KeyboardInterrupt\n")
    paths = os.pathsep.join([str(tmp_path), str(Path(cli.__file__).parents[1])])
    process = subprocess.run(
        [sys.executable, "-m", module, "--help"],
        capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": paths},
    )  # fmt: skip
    assert (process.returncode, process.stdout, process.stderr) == (130, "", "symgen: interrupted\n")


def test_a_closed_pipe_is_not_an_error(scene: Path) -> None:
    process = start("show", "--json", str(scene))
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    error = process.stderr.read()
    process.wait(timeout=60)
    assert error == ""
    assert process.returncode == 141


def test_a_terminal_without_greek_still_shows(scene: Path) -> None:
    process = start("show", str(scene), PYTHONIOENCODING="latin-1")
    out, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    assert "\\u03c0" in out


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["--version"]) == 0
    assert capsys.readouterr().out.startswith("symgen ")
    assert cli.run(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(command in text for command in ("show", "generate", "validate", "bench"))


def test_help_does_not_load_the_algebra() -> None:
    code = (
        "import sys; from symgen import cli; cli.run(['--help']);sys.exit(bool({'sympy', 'casadi'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=False).returncode == 0
