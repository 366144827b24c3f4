"""Damaged MJCF files end in a scene or in one line, in bounded time."""

from __future__ import annotations

import random
import re
import time
from pathlib import Path

import pytest

from symgen.errors import NotSupportedError, SceneError
from symgen.scene.load import load
from tests.conventions.robots import MJCF
from tests.scene.test_mjcf import ARM, CHAIN, EVERYTHING

pytest.importorskip("mujoco")

SEEDS = [MJCF, *(f"<mujoco>{text}</mujoco>" for text in (EVERYTHING, CHAIN, ARM))]
VALUES = (
    "nan", "inf", "-1", "0", "1e999", "1e308", "1e-320", "0x10", "", "1 2", "１", "n" * 5000, "ground", "world",
    "/dev/zero", "&quot;", "&amp;", "&#10;", "*/", "%s", "../..", "1e6", "free", "ball", "0 0 0", "1 1 1 1 1 1 1",
)  # fmt: skip
SECONDS = 20.0
"""Far more than any takes alone; the tests share the machine."""


def damaged(rng: random.Random) -> str:
    """An attribute changed, an element repeated or dropped, a character replaced; one to four times."""
    text = rng.choice(SEEDS)
    for _ in range(rng.randint(1, 4)):
        kind = rng.randrange(6)
        pattern = r'(?<==")[^"]*' if kind < 4 else r"<[^<>]*/>"
        found = rng.choice(list(re.finditer(pattern, text)) or [re.compile("").match(text)])
        assert found is not None
        if kind == 5:
            place = rng.randrange(len(text))
            text = text[:place] + chr(rng.randrange(1, 300)) + text[place + 1 :]
            continue
        words = [rng.choice(VALUES) if rng.random() < 0.5 else word for word in found[0].split()]
        new = found[0] * rng.choice((0, 2)) if kind == 4 else " ".join(words) if kind else rng.choice(VALUES)
        text = text[: found.start()] + new + text[found.end() :]
    return text


def check(path: Path, seed: int) -> str:
    path.write_text(damaged(random.Random(seed)), encoding="utf-8", errors="replace")
    begun = time.perf_counter()
    try:
        load(path)
    except (SceneError, NotSupportedError) as error:
        assert str(error).isprintable()
        assert len(str(error)) < 700
        assert not re.search("broke down|failed|not done", str(error)), error
        return "refused"
    finally:
        assert time.perf_counter() - begun < SECONDS
    return "read"


@pytest.mark.parametrize("seed", range(6))
def test_a_few(tmp_path: Path, seed: int) -> None:
    check(tmp_path / "m.xml", seed)


@pytest.mark.slow
def test_many(tmp_path: Path) -> None:
    outcomes = [check(tmp_path / "m.xml", seed) for seed in range(100, 250)]
    assert outcomes.count("read") > 5
    assert outcomes.count("refused") > 20
