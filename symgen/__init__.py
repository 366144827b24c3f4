"""Equations of motion of multibody systems, as certified C and CasADi functions.

The way from a scene to numbers::

    scene = symgen.load("rrpr.scene.yaml")
    system = symgen.derive(scene)
    artifact = symgen.generate(scene, "out/")
    f = artifact.load()
    motion = symgen.simulate(scene, t_end=10)
"""

from symgen.interrupt import guard

guard()  # before the imports that take a while

# ruff: noqa: E402
from symgen.artifact import Artifact
from symgen.generate import generate
from symgen.scene.builder import SceneBuilder
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.simulate import simulate
from symgen.system import System, derive
from symgen.version import VERSION as __version__

__all__ = ["Artifact", "Scene", "SceneBuilder", "System", "__version__", "derive", "generate", "load", "simulate"]
