"""Artifacts of hand-made programs, without the rest of symgen."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from symgen.artifact import Artifact, FunctionRecord, build_manifest, manifest_text, write_artifact
from symgen.targets.c import emit_c
from tests.targets.programs import all_programs, info

CERTIFICATE = {"method": "none", "checked_against": "nothing", "points": 0, "failure_probability": 1.0}


def build(folder: Path, **options: Any) -> Artifact:
    facts = info(**options)
    emitted = emit_c("demo", all_programs(), facts)
    records = [FunctionRecord(program, CERTIFICATE) for program in all_programs()]
    manifest = build_manifest("demo", facts, records, emitted)
    write_artifact(folder, {**emitted.files, "manifest.json": manifest_text(manifest)})
    return Artifact(folder)


@pytest.fixture
def make_artifact(tmp_path: Path) -> Callable[..., Artifact]:
    return lambda name="out", **options: build(tmp_path / name, **options)


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One cache of compiled libraries per test file."""
    return tmp_path_factory.mktemp("cache")
