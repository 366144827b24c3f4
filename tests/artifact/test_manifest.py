"""manifest.json: exactly the keys of the interface, the same bytes every time."""

from __future__ import annotations

import json
from collections.abc import Callable

from symgen.artifact import Artifact, FunctionRecord, build_manifest, manifest_text
from symgen.targets.c import emit_c
from tests.targets.programs import all_programs, arm, info

WORDS = "format name scene_sha256 symgen options licence sources headers nq nv joints parameters functions"
BATCH_WORDS = ("batch_p_symbol", "soa_symbol", "soa_p_symbol")
"""Only where there are such functions."""
FUNCTION_WORDS = "name symbol batch_symbol precision casadi_file inputs outputs operations plan certificate"


def test_keys_are_those_of_the_interface(make_artifact: Callable[..., Artifact]) -> None:
    manifest = make_artifact(batch=True).manifest
    assert list(manifest) == WORDS.split()
    assert manifest["format"] == 1 and manifest["licence"] == "0BSD"
    assert all(list(row) == ["name", "type", "q", "v"] for row in manifest["joints"])
    assert all(list(row) == ["name", "unit", "default", "start", "size"] for row in manifest["parameters"])
    for row in manifest["functions"]:
        assert [word for word in row if word not in BATCH_WORDS] == FUNCTION_WORDS.split()
        assert all(word in row for word in BATCH_WORDS) == (row["batch_symbol"] is not None)
        assert all(list(port) == ["name", "shape", "unit"] for port in row["inputs"] + row["outputs"])
        assert list(row["operations"]) == ["add", "mul", "div", "sqrt", "sincos"]
        assert list(row["certificate"]) == ["method", "checked_against", "points", "failure_probability"]


def test_values(make_artifact: Callable[..., Artifact]) -> None:
    manifest = make_artifact(batch=True, precision="float").manifest
    assert manifest["sources"] == ["demo.c", "demo_batch.c"] and manifest["headers"] == ["demo.h"]
    first = manifest["functions"][0]
    assert first["symbol"] == "demo_mass_matrix_f32" and first["batch_symbol"] == "demo_mass_matrix_batch_f32"
    assert first["outputs"] == [{"name": "M", "shape": [2, 2], "unit": "kg·m²"}]
    assert first["operations"]["sincos"] == 2 and first["plan"] == "literal"
    assert manifest["parameters"][1]["default"] == [0.1, 0.0, 1 / 3]
    names = [row["name"] for row in manifest["functions"]]
    assert (
        "constraints" not in names and manifest["functions"][names.index("natural_mass_matrix")]["batch_symbol"] is None
    )
    assert manifest["options"]["snap"] == 1e-6 and manifest["options"]["targets"] == ["c", "casadi"]


def test_only_what_is_there_is_named(make_artifact: Callable[..., Artifact]) -> None:
    manifest = make_artifact().manifest
    assert all(list(row) == FUNCTION_WORDS.split() for row in manifest["functions"]) and "cuda" not in manifest
    first = make_artifact("b", batch=True, precision="float").manifest["functions"][0]
    assert [first[word] for word in BATCH_WORDS] == [
        f"demo_mass_matrix_{form}_f32" for form in ("batch_p", "soa", "soa_p")
    ]


def test_same_bytes(make_artifact: Callable[..., Artifact]) -> None:
    texts = [(make_artifact(name).directory / "manifest.json").read_bytes() for name in ("a", "b")]
    assert texts[0] == texts[1] and texts[0].endswith(b"}\n")
    assert json.loads(texts[0])


def test_without_c() -> None:
    """Only CasADi asked for: functions have a file and no symbol."""
    record = FunctionRecord(arm(), {"method": "x"}, "demo.casadi/mass_matrix.casadi")
    manifest = build_manifest("demo", info(), [record])
    assert manifest["sources"] == [] and manifest["functions"][0]["symbol"] is None
    assert manifest["functions"][0]["casadi_file"] == "demo.casadi/mass_matrix.casadi"
    assert json.loads(manifest_text(manifest)) == manifest


def test_a_function_left_out_of_the_c_is_left_out() -> None:
    emitted = emit_c("demo", all_programs(), info())
    manifest = build_manifest("demo", info(), [FunctionRecord(p, {}) for p in all_programs()], emitted)
    assert {row["name"] for row in manifest["functions"]} == {f.program.name for f in emitted.functions}
