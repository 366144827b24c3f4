"""What ``symgen show`` prints: functions from a tree or a system to text, or to plain data for ``--json``."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from symgen.catalogue import CATALOGUE, split_row
from symgen.errors import NotSupportedError, SceneError
from symgen.savings import savings
from symgen.scene.document import clean
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import GROUND, Joint, Scene
from symgen.scene.outputs import function_name
from symgen.scene.schema import did_you_mean
from symgen.topology.graph import cycles
from symgen.topology.tree import Tree, TreeBody

if TYPE_CHECKING:
    from symgen.natural.entities import Entity
    from symgen.system import System


MAX_MATRIX = 24
"""Path matrices of more bodies than this are left to ``--json``."""


def width(text: str) -> int:
    """Columns a terminal needs: combining marks (ẋ as x + dot) take none, wide characters two."""
    return sum(0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def table(header: Sequence[str], rows: Iterable[Sequence[object]], right: Sequence[int] = ()) -> str:
    """Aligned columns under a ruled header; the columns in ``right`` are flush right."""
    cells = [list(header), *([str(cell) for cell in row] for row in rows)]
    widths = [max(width(row[k]) for row in cells) for k in range(len(header))]

    def line(row: Sequence[str]) -> str:
        padded = []
        for k, cell in enumerate(row):
            space = " " * (widths[k] - width(cell))
            padded.append(space + cell if k in right else cell + space)
        return "  ".join(padded).rstrip()

    rule = "  ".join("─" * w for w in widths)
    return "\n".join([line(cells[0]), rule, *map(line, cells[1:])])


def number(value: Fraction) -> str:
    """An exact number for reading: a decimal of up to six digits or a small fraction, else ``≈`` and a rounded one."""
    short = f"{float(value):.6g}"
    if Fraction(short) == value:
        return short
    return str(value) if max(abs(value.numerator), value.denominator) < 100 else f"≈{short}"


def vector(values: Iterable[Fraction]) -> str:
    return "[" + ", ".join(number(Fraction(value)) for value in values) + "]"


def graph_tree(tree: Tree) -> str:
    """The spanning tree with bodies as nodes and joints on the branches; cut joints below it."""
    lines = [GROUND]

    def branch(bodies: Sequence[TreeBody], indent: str) -> Iterable[tuple[TreeBody, str, str]]:
        for position, body in enumerate(bodies):
            last = position == len(bodies) - 1
            yield body, indent + ("└─ " if last else "├─ "), indent + ("   " if last else "│  ")

    roots = [body for body in tree.bodies if body.parent < 0]
    stack = list(reversed(list(branch(roots, ""))))
    while stack:
        body, head, indent = stack.pop()
        welded = [part.name for part, _ in body.parts if part.name != body.name]
        note = f"  (with {', '.join(welded)})" if welded else ""
        lines.append(f"{head}{body.joint.name} ({body.joint.type}) → {body.name}{note}")
        children = [tree.bodies[k] for k in tree.children[body.index]]
        stack.extend(reversed(list(branch(children, indent))))
    lines += [f"cut: {joint.name} ({joint.type}) {joint.parent} ╌╌ {joint.child}" for joint in tree.cut_joints]
    return "\n".join(lines)


def _span(start: int, size: int, letter: str) -> str:
    return f"{letter}{start}" if size == 1 else f"{letter}{start}…{start + size - 1}"


def coordinate(body: TreeBody, letter: str) -> str:
    """``q3``, ``q3…5``, or for a joint coupled to another ``-2·q3 + 0.5``."""
    place = _span(body.q, body.nq, "q") if letter == "q" else _span(body.v, body.nv, "v")
    if body.coupling is None:
        return place
    factor, offset = body.coupling.multiplier, body.coupling.offset if letter == "q" else Fraction(0)
    scaled = place if factor == 1 else f"{number(factor)}·{place}"
    return f"{scaled} {'+' if offset > 0 else '-'} {number(abs(offset))}" if offset else scaled


def _axis(joint: Joint) -> str:
    axes = [vector(axis) for axis in (joint.axis, joint.axis2) if axis is not None]
    pitch = [f"pitch {number(joint.pitch)} m/rad"] if joint.pitch is not None else []
    return " ".join(axes + pitch) or "–"


def joint_table(tree: Tree) -> str:
    """Tree joints in coordinate order: what each connects and which entries of q and v are its own."""
    rows = []
    for body in tree.bodies:
        joint = body.joint
        parent = tree.bodies[body.parent].name if body.parent >= 0 else GROUND
        motion = (coordinate(body, "q"), coordinate(body, "v"))
        rows.append((body.index + 1, joint.name, joint.type, f"{parent} → {body.name}", _axis(joint), *motion))
    return table(("#", "joint", "type", "parent → child", "axis", "q", "v"), rows, right=(0,))


def labelled_matrix(matrix: Sequence[Sequence[int]], tree: Tree) -> str:
    """A bodies × edges matrix; the columns are the joints' numbers in the joint table."""
    if len(tree.bodies) > MAX_MATRIX:
        return f"{len(tree.bodies)} × {len(tree.bodies)}, too wide to print: see --json"
    header = ["", *(str(body.index + 1) for body in tree.bodies)]
    rows = [[body.name, *(str(entry) for entry in row)] for body, row in zip(tree.bodies, matrix, strict=True)]
    return table(header, rows, right=range(1, len(header)))


def cut_joint_text(scene: Scene, tree: Tree) -> str:
    """One line per loop: its joints, the one that is cut, and whether symgen chose it."""
    lines = []
    for loop, joint in zip(cycles(scene), tree.cut_joints, strict=True):
        why = "as the scene asks" if joint.cut else "chosen: fewest closure equations, then last in the scene"
        equations = 6 - JOINT_TYPES[joint.type].nv
        lines.append(f"loop {' – '.join(loop)}: cut at {joint.name} ({why}; {equations} closure equations in space)")
    return "\n".join(lines)


def entity_table(entities: Iterable[Entity], tree: Tree) -> str:
    """Natural coordinates: who shares each point and vector, where it is, and its rows of x."""

    def owner(index: int) -> str:
        return GROUND if index < 0 else tree.bodies[index].name

    rows = []
    for entity in entities:
        place = "constant" if entity.start is None else _span(entity.start, entity.size, "x")
        bodies = ", ".join(owner(index) for index in sorted(entity.local)) or owner(entity.home)
        local = vector(entity.local[entity.home]) if entity.home in entity.local else "–"
        rows.append((entity.label, entity.kind, bodies, local, place))
    return table(("name", "kind", "shared by", "in the first one's frame", "rows"), rows)


def plan_rows(system: System) -> list[dict[str, Any]]:
    """Every plan of every function asked for, with its operations; the chosen one is marked."""
    rows = []
    for output in system.outputs:
        name = function_name(output.name)
        for choice in system.plans(output.name):
            row: dict[str, Any] = {"function": name, "plan": choice.plan, "operations": None, "flops": None}
            if choice.counts is not None:
                c = choice.counts
                row["operations"] = {"add": c.add, "mul": c.mul, "div": c.div, "sqrt": c.sqrt, "sincos": c.sincos}
                row["flops"] = c.flops
            rows.append({**row, "chosen": choice.chosen, "why": choice.why})
    return rows


def plan_table(system: System) -> str:
    rows = []
    previous = ""
    for row in plan_rows(system):
        name = row["function"] if row["function"] != previous else ""
        previous = row["function"]
        mark = "●" if row["chosen"] else ""
        counted = (*row["operations"].values(), row["flops"]) if row["operations"] else ("–",) * 6
        rows.append((name, mark, row["plan"], *counted, row["why"]))
    header = ("function", "", "plan", "add", "mul", "div", "sqrt", "sincos", "flops", "why")
    return table(header, rows, right=range(3, 9))


def saving_rows(system: System) -> list[dict[str, Any]]:
    """What each restriction of the scene saves, as plain data."""
    return [
        {"restriction": s.restriction, "flops": s.flops, "without": s.without, "saved": s.saved, "why": s.why or None}
        for s in savings(system)
    ]


def saving_table(system: System) -> str:
    """The same as text: flops of all functions together."""
    rows = []
    for row in saving_rows(system):
        numbers = ("–" if row[key] is None else row[key] for key in ("flops", "without", "saved"))
        rows.append((row["restriction"], *numbers, row["why"] or ""))
    if not rows:
        return ""
    header = ("restriction", "flops", "without it", "saved", "why")
    columns = len(header) if any(row[-1] for row in rows) else len(header) - 1
    return table(header[:columns], [row[:columns] for row in rows], right=(1, 2, 3))


def _derived(scene: Scene) -> tuple[System, str]:
    """The derived system, and why it has no functions (a closed loop is shown, but not derived)."""
    from symgen.system import derive

    system = derive(scene)
    try:
        system.require_tree()
    except NotSupportedError as error:
        return system, str(error)
    return system, ""


def _section(title: str, body: str) -> str:
    return f"{title}\n{body}" if body else ""


def as_text(scene: Scene) -> str:
    """Everything ``symgen show`` says about a scene."""
    system, refusal = _derived(scene)
    tree, natural = system.tree, system.natural
    constraints = f"nc = {natural.nc} constraint{'' if natural.nc == 1 else 's'}"
    if scene.runtime_origins:
        constraints = "constraints only where joint origins are constant"
    sizes = (
        f"{len(tree.bodies)} moving bod{'y' if len(tree.bodies) == 1 else 'ies'}, nq = {tree.nq}, nv = {tree.nv}, "
        f"nn = {natural.nn} natural coordinates{' (planar)' if natural.plane else ''}, {constraints}"
    )
    notes = [*scene.notes, *([refusal] if refusal else [])]
    sections = [
        f"{scene.name}: {sizes}",
        _section("Graph", graph_tree(tree)),
        _section("Joints", joint_table(tree)),
        _section("Loops", cut_joint_text(scene, tree)),
        _section("Path matrix π", labelled_matrix(tree.path_matrix.tolist(), tree)),
        _section("Secondary path matrix π*", labelled_matrix(tree.secondary_path_matrix.tolist(), tree)),
        _section("Natural coordinates", entity_table(natural.entities, tree)),
        "" if refusal else _section("Plans (● chosen)", plan_table(system)),
        "" if refusal else _section("What restrictions save, all functions together", saving_table(system)),
        _section("Notes", "\n".join(f"- {note}" for note in notes)),
    ]
    return "\n\n".join(section for section in sections if section)


def as_json(scene: Scene) -> dict[str, Any]:
    """The same as plain data; matrices as lists of rows."""
    system, refusal = _derived(scene)
    tree, natural = system.tree, system.natural
    return {
        "name": scene.name,
        "nq": tree.nq,
        "nv": tree.nv,
        "nn": natural.nn,
        "nc": natural.nc,
        "joints": [
            {
                "name": body.joint.name,
                "type": body.joint.type,
                "parent": tree.bodies[body.parent].name if body.parent >= 0 else GROUND,
                "child": body.name,
                "q": [body.q, body.nq],
                "v": [body.v, body.nv],
                "coupling": body.coupling
                and {"multiplier": float(body.coupling.multiplier), "offset": float(body.coupling.offset)},
            }
            for body in tree.bodies
        ],
        "path_matrix": tree.path_matrix.tolist(),
        "secondary_path_matrix": tree.secondary_path_matrix.tolist(),
        "loops": [
            {"joints": list(loop), "cut": joint.name, "forced": joint.cut}
            for loop, joint in zip(cycles(scene), tree.cut_joints, strict=True)
        ],
        "natural_coordinates": [
            {"name": e.label, "kind": e.kind, "rows": None if e.start is None else [e.start, e.size]}
            for e in natural.entities
        ],
        "plans": [] if refusal else plan_rows(system),
        "restrictions": [] if refusal else saving_rows(system),
        "notes": list(scene.notes),
        "not_supported": refusal or None,
    }


EQUATIONS = ("natural_coordinates", "velocity_transformation", "mass_matrix", "bias_force")
"""What ``--equations`` prints when no name is given; with the paper's symbols, R and its rate."""
PAPER_EQUATIONS = ("velocity_transformation", "velocity_transformation_rate")


def equation_row(name: str, outputs: Iterable[str]) -> str:
    """A catalogue row by its own name or by that of its output: ``R``, ``Rdot``, ``M``, ``Psi``; or one of ``outputs``.

    Raises SceneError for what is none of these.
    """
    by_output = {output: row for row, facts in CATALOGUE.items() for output, _, _ in facts.outputs}
    known = [*CATALOGUE, *by_output, *outputs]
    if name not in known and split_row(name)[0] not in CATALOGUE:
        meant = did_you_mean(name, known) or f"; known: {', '.join(by_output)} and the names of outputs"
        raise SceneError(f"unknown equation {clean(name)!r}{meant}", "--equations")
    return by_output.get(name, name)


def equations(scene: Scene, names: Sequence[str], symbols: str, style: str) -> dict[str, str]:
    """Row → its equation as text or LaTeX, derived with SymPy. No names: the ones people ask for first."""
    from symgen.targets.sympy import equations as written

    system, refusal = _derived(scene)
    if refusal:
        raise NotSupportedError(refusal)
    asked = [output.name for output in system.outputs]
    usual = PAPER_EQUATIONS if symbols == "paper" else EQUATIONS
    wanted = [equation_row(name, asked) for name in names] or usual
    return {row: written(system, (row,), symbols=symbols, format=style) for row in wanted}


def manifest_text(manifest: Mapping[str, Any], directory: str) -> str:
    """What ``symgen generate`` says when it is done: the functions, their cost, and what vouches for them."""
    rows = []
    methods: list[str] = []
    for function in manifest["functions"]:
        operations, certificate = function["operations"], function["certificate"]
        flops = sum(operations[key] for key in ("add", "mul", "div", "sqrt"))
        if certificate["method"] not in methods:
            methods.append(certificate["method"])
        proof = (
            certificate["checked_against"],
            certificate["points"],
            f"{certificate['failure_probability']:.0e}",
            f"[{methods.index(certificate['method']) + 1}]",
        )
        rows.append((function["name"], function["plan"], flops, operations["sincos"], *proof))
    header = ("function", "plan", "flops", "sincos", "certified against", "points", "doubt", "by")
    certified = f"{len(rows)} function{'' if len(rows) == 1 else 's'}"
    written = [*manifest["headers"], *manifest["sources"], "manifest.json"]
    written[-1:-1] = [file for kind in ("headers", "sources") for file in manifest.get("cuda", {}).get(kind, ())]
    written += [f"{manifest['name']}.casadi/"] if any(f["casadi_file"] for f in manifest["functions"]) else []
    return "\n".join(
        [
            table(header, rows, right=(2, 3, 5, 6)),
            "",
            *(f"[{number}] {method}" for number, method in enumerate(methods, 1)),
            f"{manifest['name']}: {certified} certified; {', '.join(written)} in {directory}",
        ]
    )
