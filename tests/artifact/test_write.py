"""Files arrive all together or not at all, and nobody else's are touched."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from symgen.artifact import write_artifact
from symgen.artifact.staging import STAGING
from symgen.errors import SceneError

AS_ROOT = hasattr(os, "geteuid") and os.geteuid() == 0


def files(*names: str, text: str = "1", casadi: str | None = None) -> dict[str, str | bytes]:
    """An artifact whose sources are ``names``."""
    functions = [{"casadi_file": casadi}]
    manifest = {"format": 1, "sources": list(names), "headers": ["demo.h"], "functions": functions}
    result: dict[str, str | bytes] = dict.fromkeys([*names, "demo.h", "main.c", "CMakeLists.txt"], text)
    if casadi:
        result[casadi] = b"\x00" + text.encode()
    return {**result, "manifest.json": json.dumps(manifest)}


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def as_bytes(written: dict[str, str | bytes]) -> dict[str, bytes]:
    return {name: text.encode() if isinstance(text, str) else text for name, text in sorted(written.items())}


def test_new_folder(tmp_path: Path) -> None:
    made = files("demo.c", casadi="demo.casadi/f.casadi")
    assert write_artifact(tmp_path / "a" / "out", made) == tmp_path / "a" / "out"
    assert contents(tmp_path / "a") == {f"out/{name}": text for name, text in as_bytes(made).items()}


def test_replaces_its_own_and_leaves_others(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_artifact(out, files("demo.c", "demo_1.c", casadi="demo.casadi/f.casadi"))
    (out / "mine.txt").write_text("mine")
    (out / "build").mkdir()
    (out / "build" / "x.o").write_text("x")
    new = files("demo.c", text="2")
    write_artifact(out, new)
    assert contents(out) == {**as_bytes(new), "mine.txt": b"mine", "build/x.o": b"x"}
    assert not (out / "demo.casadi").exists()


def test_a_folder_of_ours_with_foreign_files_is_kept(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_artifact(out, files("demo.c", casadi="demo.casadi/f.casadi"))
    (out / "demo.casadi" / "notes").write_text("n")
    write_artifact(out, files("demo.c"))
    assert (out / "demo.casadi" / "notes").read_text() == "n" and not (out / "demo.casadi" / "f.casadi").exists()


def test_foreign_file_in_the_way(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "main.c").write_text("mine")
    with pytest.raises(SceneError, match=r"main\.c: exists and was not made by symgen"):
        write_artifact(out, files("demo.c"))
    assert contents(out) == {"main.c": b"mine"}


def test_manifest_of_another_program_protects_nothing(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "manifest.json").write_text("{}")
    with pytest.raises(SceneError, match=r"manifest\.json: exists and was not made by symgen"):
        write_artifact(out, files("demo.c"))


def test_a_manifest_cannot_reach_outside(tmp_path: Path) -> None:
    """An old manifest is a file like any other: what it lists outside the folder is left alone."""
    outside = tmp_path / "outside.c"
    outside.write_text("keep")
    out = tmp_path / "out"
    write_artifact(out, files("demo.c"))
    listed = json.loads((out / "manifest.json").read_text())
    listed["sources"] += ["../outside.c", str(outside)]
    (out / "manifest.json").write_text(json.dumps(listed))
    write_artifact(out, files("demo.c"))
    assert outside.read_text() == "keep"


def test_wrong_targets(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("folder")
    (tmp_path / "dangling").symlink_to("nowhere")
    for name, fragment in (
        ("file", "is a file"),
        ("link", "symbolic link"),
        ("dangling", "symbolic link"),
        ("file/below", "cannot write here"),
    ):
        with pytest.raises(SceneError, match=fragment) as caught:
            write_artifact(tmp_path / name, files("demo.c"))
        assert "\n" not in str(caught.value) and str(tmp_path / name) in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["dangling", "file", "folder", "link"]


@pytest.mark.skipif(AS_ROOT, reason="root may write anywhere")
def test_read_only_folders(tmp_path: Path) -> None:
    folder = tmp_path / "closed"
    folder.mkdir(mode=0o500)
    for target in (folder, folder / "new"):
        with pytest.raises(SceneError, match=r"may not be written|cannot write"):
            write_artifact(target, files("demo.c"))


def test_a_folder_that_may_not_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As above, for whoever runs the tests as root."""
    monkeypatch.setattr(os, "access", lambda *args: False)
    with pytest.raises(SceneError, match="may not be written to"):
        write_artifact(tmp_path, files("demo.c"))


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError(28, "No space left on device")])
@pytest.mark.parametrize("after", range(9))
def test_interruption_leaves_the_old_output(
    after: int, error: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever move is the one that fails."""
    out = tmp_path / "out"
    write_artifact(out, files("demo.c", "demo_1.c"))
    before = contents(out)
    moves = 0
    rename = Path.rename

    def failing(self: Path, target: Path) -> Path:
        nonlocal moves
        moves += 1
        if moves == after + 1:
            raise error
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises((SceneError, KeyboardInterrupt)):
        write_artifact(out, files("demo.c", "demo_2.c", text="2"))
    monkeypatch.undo()
    assert moves > after
    assert contents(out) == before


def test_interruption_while_writing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: Path, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(SceneError, match="No space left"):
        write_artifact(tmp_path / "out", files("demo.c"))
    assert list(tmp_path.iterdir()) == []


def test_left_overs_of_a_killed_run_go(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_artifact(out, files("demo.c"))
    (out / f"{STAGING}abc").mkdir()
    write_artifact(out, files("demo.c"))
    assert not list(out.glob(f"{STAGING}*"))


@pytest.mark.parametrize("name", ["../x.c", "/x.c", "", "a//b", "a/../../b", "a\\b"])
def test_paths_stay_inside(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not a path inside"):
        write_artifact(tmp_path / "out", {**files("demo.c"), name: "x"})
    assert list(tmp_path.iterdir()) == []
