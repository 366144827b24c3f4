"""The artifact: generated files on disk, described by their manifest, compiled and loaded."""

from symgen.artifact.compiler import RELEASE_FLAGS, find_compiler
from symgen.artifact.load import Artifact, Loaded
from symgen.artifact.manifest import FunctionRecord, build_manifest, manifest_text
from symgen.artifact.write import check_target, write_artifact

__all__ = [
    "RELEASE_FLAGS",
    "Artifact",
    "FunctionRecord",
    "Loaded",
    "build_manifest",
    "check_target",
    "find_compiler",
    "manifest_text",
    "write_artifact",
]
