"""Reading pages in tests: as XML (they are written so that both kinds of parser agree), and what they hold."""

from __future__ import annotations

import html.entities
import re
from dataclasses import replace
from fractions import Fraction
from html.parser import HTMLParser
from xml.etree.ElementTree import Element

from defusedxml.ElementTree import fromstring

from symgen.scene.model import Body, Frame, Joint, Output, Scene
from symgen.validation.result import Refinement, Row, Skip, Trajectory, ValidationResult

VOID = {"meta", "br", "hr", "img", "input", "link", "area", "base", "col", "embed", "source", "track", "wbr"}


class Balance(HTMLParser):
    """What an HTML parser sees: every element closed in order, ids used once."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.wrong: list[str] = []
        self.ids: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._note(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._note(tag, attrs)

    def _note(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            self.attributes.append((tag, name, value or ""))
            if name == "id":
                self.ids.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data: str) -> None:
        if not self.open or self.open[-1] not in ("script", "style"):
            self.text.append(data)


def read_html(page: str) -> Balance:
    parser = Balance()
    parser.feed(page)
    parser.close()
    return parser


def read_xml(page: str) -> Element:
    """The page as XML: scripts and styles emptied, names of characters resolved."""
    body = re.sub(r"(<(script|style)[^>]*>).*?(</\2>)", r"\1\3", page, flags=re.S)
    body = body.removeprefix("<!DOCTYPE html>")

    def character(match: re.Match[str]) -> str:
        name = match[1]
        return match[0] if name in ("amp", "lt", "gt", "quot", "apos") else html.entities.html5[f"{name};"]

    return fromstring(re.sub(r"&([a-zA-Z]+);", character, body))


def result_for(scene: Scene, failing: bool = False) -> ValidationResult:
    """A validation result with a row of every kind."""
    times = tuple(k / 20 for k in range(21))
    trajectory = Trajectory(
        (0.1,), (0.2,), times, tuple((0.1 + t * t,) for t in times), tuple(1.0 + 1e-13 * t for t in times), ("swing",),
        (
            Refinement("kinematic tree", "RK44", (0.02, 0.01, 0.005), (1e-6, 6e-8, 4e-9), 3.98, 1e-12, 4),
            Refinement("redundant bodies", "Trap", (0.02, 0.01, 0.005), (1e-3, 2.5e-4, 6e-5), float("nan"), 1e-11, 2),
        ),
    )  # fmt: skip
    rows = (
        Row("same state", "mass_matrix", 1e-15, 1e-12, "", "Pinocchio"),
        Row("constraints", "Ψ(x) = 0", 0.0, 0.0, "", "identity"),
        Row("same state", "bias_force <b>", float("nan") if failing else 2e-15, 1e-12, "note & more", "Pinocchio"),
    )
    skips = (Skip("trajectory <i>", "the simulator has no such joint & says so"),)
    versions = {"pinocchio": "4.1.0"}
    return ValidationResult(scene.name, scene.sha256, ("pinocchio",), 10, 1, rows, skips, trajectory, versions)


HOSTILE = "</script><img src=x onerror=alert(1)>\"'&<b>"


def hostile_scene() -> Scene:
    """Names that try to leave the text they stand in."""
    mass = Fraction(1)
    inertia = (Fraction(1, 10),) * 3 + (Fraction(0),) * 3
    body = Body(f"arm{HOSTILE}", mass, (Fraction(0), Fraction(0), Fraction(-1)), inertia)
    joint = Joint(
        f"swing{HOSTILE}", "revolute", "ground", body.name, axis=(Fraction(3, 5), Fraction(0), Fraction(4, 5))
    )
    frame = Frame(f"tip{HOSTILE}", body.name)
    scene = Scene(
        "hostile", (body,), (joint,), frames=(frame,), outputs=(Output("mass_matrix", ("mass_matrix",)),),
        source=f"file{HOSTILE}.yaml", notes=(f"a note {HOSTILE}",),
    )  # fmt: skip
    return replace(scene, sha256="0" * 64)
