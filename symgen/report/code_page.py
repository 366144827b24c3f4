"""The page of a scene's code: every function whole, with the equation that defines it, what it was proven by, what its
phases compute, and where it comes from."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from markupsafe import Markup

from symgen.report import tables
from symgen.report.c_source import Code, Source, code
from symgen.report.definitions import FunctionWords, about, function_words
from symgen.report.highlight import Linker, highlighted
from symgen.report.mathml import math
from symgen.report.phases import PHASES, split_heading
from symgen.report.shell import Place, page
from symgen.report.tables import Table, bound, scientific
from symgen.report.words import thousands
from symgen.scene.outputs import function_name
from symgen.system import System

FUNCTION_LINES = 1500
"""Lines of a function that are printed at most."""
OPEN_LINES = 60
"""Functions up to so long are shown unfolded."""
SECTIONS = (
    ("overview", "Overview"),
    ("compile", "How to compile it"),
    ("functions", "Functions"),
    ("header", "Header"),
    ("rest", "What the functions share"),
    ("certificates", "Certificates"),
    ("manifest", "Provenance"),
)


@dataclass(frozen=True)
class PhaseRow:
    """A kind of phase of a function. ``places``: (body, address of its comment)."""

    id: str
    kind: str
    sentence: str
    formula: Markup
    places: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class FunctionView:
    """A function as the page shows it."""

    name: str
    symbol: str
    summary: str
    definition: str
    """Address of its equation."""
    formulas: tuple[tuple[Markup, str], ...]
    facts: tuple[tuple[str, str | Markup], ...]
    phases: tuple[PhaseRow, ...]
    listing: Markup | None
    note: str
    open: bool
    lines: int
    others: tuple[str, ...]


def code_page(system: System, directory: Path, manifest: Mapping[str, Any], place: Place, book_href: str) -> str:
    """The page as text. ``directory``, ``manifest``: of the artifact; ``book_href``: address of the scene's page."""
    found = code(directory, manifest)
    views = function_views(system, found, manifest, book_href)
    title = f"{system.scene.name}: generated code"
    return page(
        "report/code.html.j2", title, SECTIONS, place,
        scene=system.scene, book=book_href, functions=views, counts=_counts(manifest),
        methods=[(letter, method) for method, letter in tables.methods(manifest).items()],
        headers=[(source.file, len(source.lines), highlighted(source)) for source in found.headers],
        rest=[(_piece_title(source), highlighted(source)) for source in found.rest],
        commands=commands(manifest), provenance=provenance(system, manifest), files=files(manifest),
    )  # fmt: skip


def function_views(
    system: System, found: Code, manifest: Mapping[str, Any], book: str, most: int = FUNCTION_LINES
) -> list[FunctionView]:
    """Every function of the manifest."""
    outputs = {function_name(output.name): output for output in system.outputs}
    link, letters = linker(manifest, book), tables.methods(manifest)
    made = []
    for row in manifest["functions"]:
        output = outputs.get(row["name"])
        words = function_words(output, system) if output is not None else None
        view = _view(row, words, found.functions.get(row["name"]), link, book, most)
        made.append(replace(view, facts=tuple(_facts(row, letters))))
    return made


def _counts(manifest: Mapping[str, Any]) -> Table:
    """The functions' table with links."""
    table = tables.functions(manifest)
    rows = [(Markup('<a href="#f-{}">{}</a>').format(name, name), *rest) for name, *rest in table.rows]
    return replace(table, rows=tuple(rows))


def _view(
    row: Mapping[str, Any], words: FunctionWords | None, source: Source | None, link: Linker, book: str, most: int
) -> FunctionView:
    name = str(row["name"])
    formulas = tuple((math(d.formula), about(of)) for of, d in words.rows) if words else ()
    shown, left = source.cut(most) if source is not None else (None, 0)
    phases, anchors = _phases(name, shown) if shown is not None else ((), {})
    others = tuple(str(row[key]) for key in row if key.endswith("_symbol") and row[key])
    return FunctionView(
        name=name,
        symbol=str(row["symbol"] or row["casadi_file"] or name),
        summary=words.summary if words else "",
        definition=f"{book}#def-{name}",
        formulas=formulas,
        facts=(),
        phases=phases,
        listing=highlighted(shown, link, anchors) if shown is not None else None,
        note=f"{left} more lines are in the file." if left else "",
        open=shown is not None and len(shown.lines) <= OPEN_LINES,
        lines=len(source.lines) if source is not None else 0,
        others=others,
    )


def _facts(row: Mapping[str, Any], letters: Mapping[str, str]) -> list[tuple[str, str | Markup]]:
    operations, certificate = row["operations"], row["certificate"]
    counted = [
        f"{thousands(operations[key])} {key}" for key in ("add", "mul", "div", "sqrt", "sincos") if operations[key]
    ]
    doubt = scientific(certificate["failure_probability"])
    letter = letters[certificate["method"]]
    proof = Markup('{} by <a href="#method-{}">method {}</a> at {} points, wrong with a probability below {}')
    return [
        ("from", ", ".join(_port(port) for port in row["inputs"]) or "nothing"),
        ("to", ", ".join(_port(port) for port in row["outputs"])),
        ("plan", f"{row['plan']}{', in loops' if row.get('code') == 'loops' else ''}"),
        ("operations", ", ".join(counted) or "none"),
        ("certified", proof.format(certificate["checked_against"], letter, letter, certificate["points"], doubt)),
    ]


def _port(port: Mapping[str, Any]) -> str:
    shape = " × ".join(str(n) for n in port["shape"])
    return f"{port['name']} ({', '.join(part for part in (shape, port['unit']) if part)})"


def _phases(name: str, source: Source) -> tuple[tuple[PhaseRow, ...], dict[int, tuple[str, str]]]:
    """Kinds of phases in the order they come, and the anchors of their comments."""
    kinds: dict[str, list[tuple[str, str]]] = {}
    anchors: dict[int, tuple[str, str]] = {}
    for k, heading in enumerate(source.headings()):
        kind, body = split_heading(heading.text)
        if kind not in PHASES:
            continue
        own = f"p-{name}-{k + 1}"
        row = f"ph-{name}-{list(kinds).index(kind) + 1 if kind in kinds else len(kinds) + 1}"
        kinds.setdefault(kind, []).append((body, f"#{own}"))
        anchors[heading.line] = (own, f"#{row}")
    rows = []
    for k, (kind, places) in enumerate(kinds.items()):
        phase = PHASES[kind]
        formula = math(phase.formula) if phase.formula else Markup("")
        rows.append(PhaseRow(f"ph-{name}-{k + 1}", kind, phase.sentence, formula, tuple(places)))
    return tuple(rows), anchors


_VARIABLE = re.compile(r"(cos|sin)_q(\d+)|([qv])\[(\d+)\]")


def linker(manifest: Mapping[str, Any], book: str) -> Linker:
    """Names in the C that stand for something of a joint: its cosine and sine, its entries of q and v."""
    owner: dict[tuple[str, int], str] = {}
    for joint in manifest["joints"]:
        for letter in "qv":
            start, size = joint[letter]
            for k in range(start, start + size):
                owner.setdefault((letter, k), joint["name"])
    places = {joint["name"]: k for k, joint in enumerate(manifest["joints"])}
    symbols = {row["symbol"]: row["name"] for row in manifest["functions"] if row["symbol"]}

    def link(text: str) -> tuple[str, str]:
        match = _VARIABLE.fullmatch(text)
        if match is None:
            return (f"#f-{symbols[text]}", "to the function") if text in symbols else ("", "")
        letter, index = (match[3], int(match[4])) if match[3] else ("q", int(match[2]))
        joint = owner.get((letter, index))
        if joint is None:
            return "", ""
        what = {"cos": "cosine of ", "sin": "sine of ", "q": "position of ", "v": "velocity of "}[match[1] or letter]
        return f"{book}#joint-{places[joint] + 1}", what + joint

    return link


def _piece_title(source: Source) -> str:
    last = source.first + len(source.lines) - 1
    return f"{source.file}, lines {source.first} to {last}"


def commands(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(what for, command)."""
    if not manifest["sources"]:
        return []
    sources = " ".join(manifest["sources"])
    library = f"lib{manifest['name']}.so"
    return [
        ("an object to link with", f"cc -std=c99 -O3 -c {sources}"),
        ("a shared library", f"cc -std=c99 -O3 -fPIC -shared {sources} -lm -o {library}"),
        ("for this processor alone", f"cc -std=c99 -O3 -march=native -c {sources}"),
    ]


def files(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(name, what it is)."""
    found = [(name, "declarations, with inputs, outputs and units") for name in manifest["headers"]]
    found += [(name, "C without dependencies but libm") for name in manifest["sources"]]
    casadi = [row["casadi_file"] for row in manifest["functions"] if row["casadi_file"]]
    if casadi:
        found.append((f"{manifest['name']}.casadi/", f"{len(casadi)} CasADi functions"))
    return [*found, ("manifest.json", "what is on this page, for programs")]


def provenance(system: System, manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    found = [
        ("scene", system.scene.source or system.scene.name),
        ("SHA-256 of its meaning", manifest["scene_sha256"] or "none"),
        ("symgen", manifest["symgen"]),
        ("licence of the code", manifest["licence"]),
    ]
    for name, value in manifest["options"].items():
        found.append((name.replace("_", " "), option_words(name, value)))
    return found


def option_words(name: str, value: object) -> str:
    """An option's value for reading."""
    if value is None and name == "code":
        return "straight lines or loops, whichever runs faster"
    if value is None or value in ("", []):
        return "none"
    if name == "snap":
        return f"mounting angles to within {bound(float(str(value)))} rad"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(map(str, value))
    return scientific(value) if isinstance(value, float) else str(value)


__all__ = ["FunctionView", "Table", "code_page", "function_views"]
