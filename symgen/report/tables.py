"""The tables of a report as data: what stands in every cell, nothing about how it looks."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from symgen import show
from symgen.natural.entities import Entity
from symgen.report.words import NO_BREAK, direction, exact, minus, parent_name, ten_to, thousands, triple
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import GROUND
from symgen.system import System
from symgen.validation.result import Row, ValidationResult

POSITIONS = {
    "planar": ("x", "y", "angle"),
    "cylindrical": ("angle", "slide"),
    "universal": ("first angle", "second angle"),
    "spherical": ("qx", "qy", "qz", "qw"),
    "floating": ("x", "y", "z", "qx", "qy", "qz", "qw"),
}
VELOCITIES = {
    **POSITIONS,
    "spherical": ("ωx", "ωy", "ωz"),
    "floating": ("vx", "vy", "vz", "ωx", "ωy", "ωz"),
}


SHORT_NAME = 6
"""Joints with longer names head the columns of path matrices by their numbers."""


@dataclass(frozen=True)
class Table:
    """``numeric``: columns set flush right; the first column of every row is its heading."""

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: frozenset[int] = frozenset()
    groups: tuple[tuple[str, int], ...] = ()
    """(heading, first row) of groups of rows; empty when there are none."""
    ids: tuple[str, ...] = ()
    """Of the rows, where others link to them."""


def scientific(value: float) -> str:
    """``3.2 × 10⁻¹⁴``; zero and numbers that are none as they are."""
    if value == 0:
        return "0"
    if not math.isfinite(value):
        return {math.inf: "∞", -math.inf: "−∞"}.get(value, "not a number")
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    if -3 <= int(exponent) <= 3:
        return minus(f"{value:.2g}") if abs(value) < 100 else thousands(value)
    return ten_to(minus(mantissa), int(exponent))


def bound(value: float) -> str:
    """``10⁻¹²``, ``5.0 × 10⁻¹²``: as a criterion is written."""
    return scientific(value).removeprefix(f"1.0{NO_BREAK}×{NO_BREAK}")


def label_html(label: str) -> Markup:
    """``r3``, ``u2_1`` as mathematics."""
    letter, _, superscript = label[1:].partition("_")
    parts = Markup("<i>{}</i>").format(label[0])
    if letter:
        parts += Markup("<sub>{}</sub>").format(letter)
    return parts + (Markup("<sup>{}</sup>").format(superscript) if superscript else Markup(""))


def entity_html(entity: Entity) -> Markup:
    return label_html(entity.label) if entity.kind != "angle" else Markup("<i>φ</i> of {}").format(entity.label[4:])


def bodies(system: System) -> Table:
    rows = []
    for body in system.tree.bodies:
        for part, _ in body.parts:
            inertia = [exact(x) for x in part.inertia]
            name = part.name if part.name == body.name else f"{part.name}, fixed to {body.name}"
            rows.append((str(body.index + 1), name, exact(part.mass), triple(part.com), *inertia))
    header = ("no.", "body", "mass", "centre of mass", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")
    caption = "Bodies: kg, m, kg m²; inertia about the centre of mass in body axes (matrix entries)"
    return Table(caption, header, tuple(rows), frozenset({2, 4, 5, 6, 7, 8, 9}))


def _span(start: int, size: int, letter: str) -> Markup:
    if size == 0:
        return Markup("–")
    last = Markup(" … <i>{}</i><sub>{}</sub>").format(letter, start + size - 1) if size > 1 else Markup("")
    return Markup("<i>{}</i><sub>{}</sub>").format(letter, start) + last


def _indexed(text: str) -> Markup:
    """``20·q1 − 0.2`` with its index below."""
    return Markup("").join(
        Markup("<i>{}</i><sub>{}</sub>").format(part[0], part[1:]) if k % 2 else Markup("{}").format(part)
        for k, part in enumerate(re.split(r"([qv]\d+)", text))
    )


def joints(system: System) -> Table:
    rows = []
    for body in system.tree.bodies:
        joint = body.joint
        axes = [direction(axis) for axis in (joint.axis, joint.axis2) if axis is not None]
        pitch = [f"pitch {exact(joint.pitch)} m/rad"] if joint.pitch is not None else []
        kind = f"{joint.type} ({JOINT_TYPES[joint.type].letter})"
        between = f"{parent_name(system, body)} → {body.name}"
        place = triple(joint.origin.translation)
        q: str | Markup = _span(body.q, body.nq, "q")
        v: str | Markup = _span(body.v, body.nv, "v")
        if body.coupling is not None:
            q, v = (_indexed(minus(show.coordinate(body, letter))) for letter in "qv")
        rows.append((str(body.index + 1), joint.name, kind, between, ", ".join(axes + pitch) or "–", place, q, v))
    header = ("no.", "joint", "type", "parent → child", "axis, joint frame", "origin in the parent, m", "q", "v")
    ids = tuple(f"joint-{k + 1}" for k in range(len(rows)))
    return Table("Joints of the tree in coordinate order", header, tuple(rows), ids=ids)


def coordinates(system: System) -> Table:
    """Every entry of q beside the entry of v of the same joint."""
    rows: list[tuple[str, ...]] = []
    base = system.scene.options.base_velocity
    for body in system.tree.bodies:
        if body.coupling is not None:
            continue  # it has none of its own
        joint, kind = body.joint, JOINT_TYPES[body.joint.type]
        positions = POSITIONS.get(joint.type, ("angle" if kind.q_units == ("rad",) else "displacement",))
        velocities = VELOCITIES.get(joint.type, ("rate",))
        for k in range(max(body.nq, body.nv)):
            left = (_span(body.q + k, 1, "q"), positions[k], kind.q_units[k]) if k < body.nq else ("", "", "")
            right = (_span(body.v + k, 1, "v"), velocities[k], kind.v_units[k]) if k < body.nv else ("", "", "")
            rows.append((joint.name if k == 0 else "", *left, *right))
    axes = {"world": "ground axes", "body": "body axes", "mixed": "ground axes (v) and body axes (ω)"}[base]
    floating = any(body.joint.type == "floating" for body in system.tree.bodies)
    caption = "Positions q and velocities v" + (f"; the floating body's velocities are in {axes}" if floating else "")
    header = ("joint", "q", "meaning", "unit", "v", "meaning", "unit")
    return Table(caption, header, tuple(rows))


def entities(system: System) -> Table:
    natural, tree = system.natural, system.tree
    rows = []
    for k, entity in enumerate(natural.entities):
        places = [
            Markup("{}&nbsp;{}").format(GROUND if home < 0 else tree.bodies[home].name, triple(local))
            for home, local in sorted(entity.local.items())
        ]
        mass = [tree.bodies[body].name for body, carriers in enumerate(natural.carriers) if k in carriers]
        where = "constant" if entity.start is None else _span(entity.start, entity.size, "x")
        joint = tree.bodies[entity.joint].joint.name if entity.joint is not None else "–"
        fixed = Markup(", ").join(places) if places else Markup("–")
        rows.append((entity_html(entity), entity.kind, joint, fixed, ", ".join(mass) or "–", where))
    header = ("name", "kind", "of joint", "fixed in (local coordinates)", "carries mass of", "rows of x")
    return Table("Natural coordinates, shared by the bodies they are fixed in", header, tuple(rows))


def constraints(system: System) -> Table:
    """Ψ(x) = 0 by body or joint: what each row keeps as it is."""
    kinds = {"length": "lengths", "angle": "angles", "tie": "ties", "joint": "joint"}
    found: dict[tuple[str, str], list[Markup]] = {}
    for constraint in system.natural.constraints:
        owner, _, text = constraint.name.rpartition(": ")
        found.setdefault((owner, kinds.get(constraint.kind, constraint.kind)), []).append(
            expression_html(_TIED.sub(r"\1 (its place among the carriers)", text))
        )
    rows = tuple(
        (owner, kind, str(len(texts)), Markup(", ").join(dict.fromkeys(texts)))
        for (owner, kind), texts in found.items()
    )
    caption = "Constraints Ψ(x) = 0: what stays constant (n1, n2, m, n: directions fixed in the bodies of a joint)"
    return Table(caption, ("body or joint", "kind", "rows", "what stays constant"), rows, frozenset({2}))


_TIED = re.compile(r"(.*) tied \[\d+\]")
_LABEL = re.compile(r"([ru]\d+(?:_\d+)?)")


def expression_html(text: str) -> Markup:
    """``u2·(r3-r2)`` with its labels as mathematics."""
    parts = _LABEL.split(text)
    return Markup("").join(label_html(part) if k % 2 else minus(part) for k, part in enumerate(parts))


def carriers(system: System) -> Table:
    natural = system.natural
    rows = []
    for body, chosen in enumerate(natural.carriers):
        names = Markup(", ").join(entity_html(natural.entities[k]) for k in chosen)
        rows.append((system.tree.bodies[body].name, names, f"{natural.conditions[body]:.3g}"))
    header = ("body", "carried by", "condition number of W")
    return Table("Which natural coordinates carry each body's mass", header, tuple(rows), frozenset({2}))


def path_matrix(system: System, secondary: bool) -> Table:
    matrix = (system.secondary_path_matrix if secondary else system.path_matrix).tolist()
    names = [body.name for body in system.tree.bodies]
    joints_named = [body.joint.name for body in system.tree.bodies]
    short = all(len(name) <= SHORT_NAME for name in joints_named)
    header = ("", *(joints_named if short else [str(k + 1) for k in range(len(names))]))
    rows = tuple((name, *(minus(str(x)) for x in row)) for name, row in zip(names, matrix, strict=True))
    caption = "π*: minus the edges from joint to body" if secondary else "π: +1 leaves the body, −1 enters it"
    caption += "" if short else " (joints by their numbers)"
    return Table(caption, header, rows, frozenset(range(1, len(names) + 1)))


def plans(rows: Sequence[Mapping[str, Any]]) -> Table:
    """From `symgen.show.plan_rows`."""
    body, previous = [], ""
    for row in rows:
        name = row["function"] if row["function"] != previous else ""
        previous = row["function"]
        operations = row["operations"]
        counts = tuple(thousands(n) for n in operations.values()) if operations else ("–",) * 5
        cost = thousands(row["flops"]) if operations else ""
        flops = Markup("<strong>{}</strong>").format(cost) if row["chosen"] else cost
        plan = Markup("<strong>{}</strong> (chosen)").format(row["plan"]) if row["chosen"] else row["plan"]
        body.append((name, plan, *counts, flops if operations else "–", _why(row)))
    header = ("function", "plan", "add", "mul", "div", "sqrt", "sincos", "flops", "why")
    return Table("Operations of every plan", header, tuple(body), frozenset(range(2, 8)))


_EXPLAINED = re.compile(
    r"(?P<why>fewest operations|[\d.]+ times the cost(?:, not weighed at this size)?|the chosen one is free|free too): "
    r"(?P<plan>.*)"
)


def _why(row: Mapping[str, Any]) -> str:
    """Why a plan was taken or not, without what the plan is (that stands once above the table)."""
    found = _EXPLAINED.fullmatch(str(row["why"]))
    return found["why"] if found else str(row["why"])


def plan_families(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, str]]:
    """(plan, what it is) of the plans in the table, where their reasons say so."""
    found: dict[str, str] = {}
    for row in rows:
        match = _EXPLAINED.fullmatch(str(row["why"]))
        if match:
            found.setdefault(row["plan"], match["plan"])
    return list(found.items())


def functions(manifest: Mapping[str, Any]) -> Table:
    rows = []
    for row in manifest["functions"]:
        inputs = ", ".join(_port(port) for port in row["inputs"]) or "–"
        outputs = ", ".join(_port(port) for port in row["outputs"])
        operations = row["operations"]
        flops = sum(operations[key] for key in ("add", "mul", "div", "sqrt"))
        rows.append((row["name"], inputs, outputs, row["plan"], thousands(flops), str(operations["sincos"])))
    header = ("function", "inputs", "outputs", "plan", "flops", "sincos")
    caption = "Generated functions; flops and sincos pairs as the emitted code performs them"
    return Table(caption, header, tuple(rows), frozenset({4, 5}))


def _port(port: Mapping[str, Any]) -> str:
    shape = " × ".join(str(n) for n in port["shape"])
    return f"{port['name']} ({shape})" if shape else str(port["name"])


def methods(manifest: Mapping[str, Any]) -> dict[str, str]:
    """How functions were certified, under a letter each: {method: letter}."""
    found: dict[str, str] = {}
    for row in manifest["functions"]:
        letter = chr(ord("A") + len(found)) if len(found) < 26 else str(len(found))
        found.setdefault(row["certificate"]["method"], letter)
    return found


def certificates(manifest: Mapping[str, Any]) -> Table:
    letters = methods(manifest)
    rows = []
    for row in manifest["functions"]:
        c = row["certificate"]
        doubt = scientific(c["failure_probability"])
        rows.append((row["name"], letters[c["method"]], c["checked_against"], str(c["points"]), doubt))
    header = ("function", "method", "checked against", "points", "doubt")
    return Table(
        "One certificate per function; doubt: probability of an error at most", header, tuple(rows), frozenset({3, 4})
    )


def parameters(system: System) -> Table:
    rows = []
    for p in system.scene.parameters:
        values = ", ".join(exact(x) for x in p.default)
        rows.append((p.name, _span(p.start, p.size, "p"), values, p.unit))
    return Table("Run-time parameters", ("name", "entries of p", "default", "unit"), tuple(rows))


def validation(result: ValidationResult) -> Table:
    """Rows of one check together, in the order the checks were first made."""
    by_check: dict[str, list[Row]] = {}
    for row in result.rows:
        by_check.setdefault(row.check, []).append(row)
    rows: list[tuple[str, ...]] = []
    groups = []
    for check, members in by_check.items():
        groups.append((check, len(rows)))
        for row in members:
            criterion = f"≤ {bound(row.criterion)}"
            rows.append((row.quantity, scientific(row.value), criterion, verdict(row), note(row)))
    header = ("check", "value", "criterion", "verdict", "compared with")
    return Table("Checks", header, tuple(rows), frozenset({1, 2}), tuple(groups))


def note(row: Row) -> str:
    return "; ".join(text for text in (row.source, row.note) if text)


def verdict(row: Row) -> Markup:
    """Words and a mark, not colour alone."""
    if row.passed:
        return Markup('<span class="pass">✓ pass</span>')
    return Markup('<span class="fail">✗ fail</span>')


def skipped(result: ValidationResult) -> Table:
    rows = tuple((skip.check, skip.reason) for skip in result.skipped)
    return Table("Checks that were not made", ("check", "why"), rows)


def cut_joints(system: System) -> list[str]:
    return show.cut_joint_text(system.scene, system.tree).splitlines()
