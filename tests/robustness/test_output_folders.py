"""Output folders: killed, interrupted, full, shared, not what they seem. The old output stays, or the new one comes."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import symgen
from symgen.artifact import Artifact, write_artifact
from symgen.artifact.staging import STAGING, recover
from symgen.cli import Ended, _end
from symgen.errors import SceneError, ToolError
from tests.robustness.folders import SOURCES, contents, in_child, version, version_in

RENAMES = 2 * (SOURCES + 4) + 3
ROOT = Path(__file__).parent.parent.parent


def on_call(function: str, n: int, act: Callable[[], object]) -> None:
    """From now on, ``act`` is done before the n-th call of a method of Path."""
    calls = 0
    original = getattr(Path, function)

    def counting(self: Path, *args: Any, **named: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == n + 1:
            act()
        return original(self, *args, **named)

    setattr(Path, function, counting)


def kill(number: int) -> None:
    os.kill(os.getpid(), number)


def scratch(folder: Path) -> list[Path]:
    return list(folder.rglob(f"{STAGING}*"))


@pytest.mark.parametrize("old", [0, 1])
def test_a_kill_between_any_two_moves_is_undone(old: int, tmp_path: Path) -> None:
    """Half of it is seen by whoever reads next, half by whoever writes next."""
    seen = set()
    for n in range(RENAMES):
        out = tmp_path / f"out{n}"
        write_artifact(out, version(old))

        def killed(n: int = n, out: Path = out) -> None:
            on_call("rename", n, lambda: kill(signal.SIGKILL))
            write_artifact(out, version(old + 1))

        dead = in_child(killed) == signal.SIGKILL
        seen.add(dead)
        assert dead == bool(scratch(tmp_path))
        if n % 2:
            assert version_in(out) == (old if dead else old + 1)
            continue
        write_artifact(out, version(old + 2))
        assert version_in(out) == old + 2
    assert seen == {True, False}, "the last kill is too late for every move"


def test_foreign_files_live_through_a_kill(tmp_path: Path) -> None:
    """The user's main.c in a folder for CasADi alone, say."""
    out = tmp_path / "out"
    write_artifact(out, {name: text for name, text in version(0).items() if name != "main.c"})
    (out / "main.c").write_text("mine")
    new = {name: text for name, text in version(2).items() if name in ("demo.h", "manifest.json")}

    def killed() -> None:
        on_call("rename", SOURCES + 4, lambda: kill(signal.SIGKILL))
        write_artifact(out, new)

    before = contents(out)
    assert in_child(killed) == signal.SIGKILL
    write_artifact(out / "other", version(0))
    assert (out / "main.c").exists() or scratch(out)
    recover(out)
    assert {name: text for name, text in contents(out).items() if not name.startswith("other")} == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize(("function", "after"), [("write_bytes", 3), ("mkdir", 2), ("rename", 3), ("rename", 20)])
def test_signals_leave_one_version_and_no_debris(number: int, function: str, after: int, tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_artifact(out, version(0))

    def ended() -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        for other in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(other, _end)
        on_call(function, after, lambda: kill(number))
        with pytest.raises((KeyboardInterrupt, Ended)):
            write_artifact(out, version(1))

    assert in_child(ended) == 0
    assert not scratch(tmp_path)
    assert version_in(out) == (1 if function == "rename" else 0)  # the moves are finished first


def test_a_kill_while_a_new_folder_is_made(tmp_path: Path) -> None:
    def killed() -> None:
        on_call("write_bytes", 5, lambda: kill(signal.SIGKILL))
        write_artifact(tmp_path / "out", version(0))

    assert in_child(killed) == signal.SIGKILL
    assert not (tmp_path / "out").exists() and len(scratch(tmp_path)) == 1
    (tmp_path / f"{STAGING}notes").mkdir()
    (tmp_path / f"{STAGING}notes" / "mine").write_text("mine")
    write_artifact(tmp_path / "beside", version(0))
    assert [path.name for path in scratch(tmp_path)] == [f"{STAGING}notes"], "ours gone, somebody else's kept"


def test_interruption_leaves_no_empty_parents(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: Path, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(SceneError, match="No space left"):
        write_artifact(tmp_path / "a" / "b" / "out", version(0))
    assert list(tmp_path.iterdir()) == []


def test_a_limit_on_file_size(tmp_path: Path) -> None:
    """As a full disk: the kernel refuses, not a mock."""
    out = tmp_path / "out"
    write_artifact(out, version(0))

    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        with pytest.raises(SceneError, match="cannot write here: File too large"):
            write_artifact(out, {**version(1), "demo.h": "x" * 5000})

    assert in_child(full) == 0
    assert version_in(out) == 0


def test_writers_and_readers_at_once(tmp_path: Path) -> None:
    out = tmp_path / "out"
    until = time.monotonic() + 1.0

    def writing(first: int) -> Callable[[], None]:
        def work() -> None:
            k = first
            while time.monotonic() < until:
                write_artifact(out, version(k))
                k += 3

        return work

    children = []
    for first in (0, 1, 2):
        child = os.fork()
        if child == 0:
            status = 1
            try:
                writing(first)()
                status = 0
            finally:
                os._exit(status)
        children.append(child)
    while not out.exists():
        time.sleep(0.001)
    read = set()
    while time.monotonic() < until:
        read.add(Artifact(out).manifest["name"])
    assert len(read) > 3
    assert [os.waitpid(child, 0)[1] for child in children] == [0, 0, 0]
    version_in(out)
    assert not scratch(tmp_path)


def test_links_and_folders_in_the_way(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "f.casadi").write_text("keep")
    out = tmp_path / "out"
    write_artifact(out, version(1))
    (out / "demo.casadi" / "f.casadi").unlink()
    (out / "demo.casadi").rmdir()
    (out / "demo.casadi").symlink_to(elsewhere)
    with pytest.raises(SceneError, match=r"demo\.casadi: is in the way of a folder"):
        write_artifact(out, version(3))
    write_artifact(out, version(2))
    assert (elsewhere / "f.casadi").read_text() == "keep"
    (out / "main.c").unlink()
    (out / "main.c").mkdir()
    (out / "main.c" / "notes").write_text("keep")
    (out / "demo_12.c").symlink_to(tmp_path / "nowhere")
    with pytest.raises(SceneError, match="exists and was not made by symgen"):
        write_artifact(out, version(3))
    assert (out / "main.c" / "notes").read_text() == "keep" and (out / "demo_12.c").is_symlink()


@pytest.mark.parametrize(
    "name", ["a" * 300, "a\0b", "a\nb/\0", "\ud800", "file/below", "file/far/below", "loop/below"], ids=ascii
)
def test_places_that_cannot_be(name: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "loop").symlink_to("loop")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(SceneError) as caught:
        write_artifact(os.path.join(tmp_path, name), version(0))
    assert str(caught.value).isprintable()
    assert sorted(tmp_path.iterdir()) == before


# -- the command ---------------------------------------------------------------------------------------------------

SCENE = ROOT / "examples" / "double_pendulum.scene.yaml"


def command(*arguments: str, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "symgen", *arguments],
        cwd=ROOT, env={**os.environ, **environment}, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def test_the_place_is_looked_at_before_anything_is_derived(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["symgen.generate"], "derive", lambda scene: pytest.fail("derived"))
    (tmp_path / "file").write_text("x")
    with pytest.raises(SceneError, match="is a file; a folder is needed"):
        symgen.generate(SCENE, tmp_path / "file")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("seconds", [0.6, 0.9, 1.2, 1.5, 2.0, 3.0])
def test_the_command_ended_at_any_moment(number: int, seconds: float, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert command("generate", str(SCENE), "-o", str(out), "--outputs", "mass_matrix").wait() == 0
    before = contents(out)
    process = command("generate", str(SCENE), "-o", str(out), "--outputs", "bias_force", TMPDIR=str(tmp_path))
    time.sleep(seconds)
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    if process.returncode == 0:
        return
    expected = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGKILL: -9}[signal.Signals(number)]
    if process.returncode == expected and number != signal.SIGKILL:
        assert said.strip().count("\n") == 0 and not scratch(tmp_path)  # click begins a new line after ^C
        assert [path.name for path in tmp_path.iterdir()] == ["out"]
    after = Artifact(out).manifest["functions"][0]["name"]
    assert after == "bias_force" or contents(out) == before


def test_no_home_to_keep_compiled_code_in(tmp_path: Path) -> None:
    """It is kept for the process, and gone with it."""
    out, temporary = tmp_path / "out", tmp_path / "tmp"
    temporary.mkdir()
    write = f"import symgen; f = symgen.generate({str(SCENE)!r}, {str(out)!r}).load(flags=['-O0'])"
    program = f"{write}; print(f.mass_matrix([0, 0])[1, 1], f.library)"
    home = {"HOME": "/dev/null", "XDG_CACHE_HOME": "", "TMPDIR": str(temporary)}
    ran = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env={**os.environ, **home},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.stderr == "" and ran.stdout.startswith(f"0.16 {temporary}/symgen-")
    assert list(temporary.iterdir()) == []


# -- reports ---------------------------------------------------------------------------------------------------------


def test_a_report_is_written_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The old page stays when the new one cannot be written; a link leads where it led, a device is none of ours."""
    from symgen.report.page import write_text

    page, link = tmp_path / "page.html", tmp_path / "link.html"
    write_text(page, "old")
    link.symlink_to(page)
    write_text(link, "linked")
    write_text(Path(os.devnull), "x" * 100)
    assert link.is_symlink() and page.read_text() == "linked" and not Path(os.devnull).is_file()

    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        with pytest.raises(SceneError, match="cannot write the report: File too large"):
            write_text(page, "x" * 5000)

    assert in_child(full) == 0
    for name in ("folder", "a\0b", "page.html/below"):
        (tmp_path / "folder").mkdir(exist_ok=True)
        with pytest.raises(SceneError, match="cannot write the report"):
            write_text(tmp_path / name, "x")
    assert page.read_text() == "linked" and len(list(tmp_path.iterdir())) == 3


def test_casadi_without_space_is_said(tmp_path: Path) -> None:
    def full() -> None:
        scene = symgen.load(SCENE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        with pytest.raises(ToolError, match="CasADi cannot save"):
            symgen.generate(scene, tmp_path / "out")

    assert in_child(full) == 0
    assert list(tmp_path.iterdir()) == []
