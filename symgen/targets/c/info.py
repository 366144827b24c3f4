"""What the C target must know of a scene beside its programs."""

from __future__ import annotations

from dataclasses import dataclass, field

from symgen.scene.model import Mimic, Options, Parameter


@dataclass(frozen=True)
class JointRow:
    """A joint as the manifest lists it; ``q`` and ``v`` are (start, size), of a joint that mimics its master's."""

    name: str
    type: str
    q: tuple[int, int]
    v: tuple[int, int]
    limits: tuple[tuple[str, float], ...] = ()
    """What the scene or model says of limits: lower, upper, velocity, effort."""
    mimic: Mimic | None = None


@dataclass(frozen=True)
class Info:
    """Facts for headers, examples and the manifest. ``notes`` are lines printed in the header."""

    nq: int
    nv: int
    joints: tuple[JointRow, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    options: Options = field(default_factory=Options)
    scene_sha256: str = ""
    version: str = "0"
    notes: tuple[str, ...] = ()

    @property
    def parameter_count(self) -> int:
        return sum(parameter.size for parameter in self.parameters)
