"""What the mechanism drawing is made of: shapes fixed in bodies, and where the bodies stand. No mathematics here."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Shape:
    """One thing to draw, in the frame of a body (−1: ground axes)."""

    kind: str
    """``face`` (flat, lit, seen from its front only), ``glass`` (the same, translucent), ``sheet`` (flat, seen from
    both sides), ``hull`` (outline of its points in the picture, translucent), ``line``, ``arrow``, ``dot`` (a basic
    point), ``ball``, ``com``, ``spring``."""
    body: int
    points: tuple[Point, ...]
    colour: str
    """``#rrggbb`` for what is lit; else the name of a class of the style sheet."""
    size: float = 0.0
    """Radius of a ball in m; width of a line, radius of a dot in pixels."""
    lift: float = 0.0
    """Moved towards the viewer by this much (m) when shapes are sorted by depth."""
    end: int | None = None
    """The body of the last point, where that is another (springs)."""


@dataclass(frozen=True)
class Label:
    """Text beside a point; ``r3`` and ``u3`` are set as mathematics."""

    body: int
    point: Point
    text: str
    kind: str
    """``point``, ``vector``, ``joint``."""


@dataclass(frozen=True)
class Rod:
    """A body's rod as a line, for small pictures."""

    body: int
    start: Point
    end: Point
    name: str = ""
    """What stands at its end; empty where nothing with a name does."""


@dataclass(frozen=True)
class Motion:
    """An elementary motion of a joint, for the script that moves the drawing."""

    kind: str
    """``turn`` or ``slide``."""
    axis: Point
    slider: int
    """Which of the drawing's coordinates moves it."""
    factor: float = 1.0
    offset: float = 0.0
    """How far it is at coordinate x: factor · x + offset."""


@dataclass(frozen=True)
class Frame:
    """Where a body stands: its joint frame in its parent, what its joint does, and the pose that follows."""

    parent: int
    origin_rotation: tuple[Point, ...]
    origin: Point
    motions: tuple[Motion, ...]
    rotation: tuple[Point, ...]
    """Rows of the body's rotation to ground axes in the drawn position."""
    position: Point


@dataclass(frozen=True)
class Slider:
    """A joint coordinate that a reader may move."""

    label: str
    unit: str
    low: float
    high: float
    value: float


@dataclass(frozen=True)
class Drawing:
    """A mechanism ready to be seen from any side."""

    title: str
    shapes: tuple[Shape, ...]
    labels: tuple[Label, ...]
    frames: tuple[Frame, ...]
    sliders: tuple[Slider, ...]
    centre: Point
    radius: float
    """Of the ball about ``centre`` that holds the mechanism."""
    up: Point
    gravity: Point | None
    """Direction of gravity, None where there is none."""
    normal: Point | None
    """Planar scenes: the normal of the plane, towards the viewer."""
    description: str
    """The drawing in words."""
    rods: tuple[Rod, ...] = ()
