"""One page per scene: facts gathered from every room, laid out by templates/report."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from symgen import show
from symgen.errors import NotSupportedError, SceneError
from symgen.report import derivation, motion_plots, tables, words
from symgen.report import measured as measurements
from symgen.report.c_source import code
from symgen.report.camera import render as render_drawing
from symgen.report.code_page import function_views
from symgen.report.drawing import Drawing
from symgen.report.equations import equations
from symgen.report.live import drawing_json
from symgen.report.mechanism import display_words, draw
from symgen.report.player import player
from symgen.report.plots import Bar, bar_chart
from symgen.report.rank import constraint_rank
from symgen.report.shell import ALONE, Place, page
from symgen.report.sketch import body_colour
from symgen.report.topology_graph import topology_graph
from symgen.scene.document import clean
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import Scene
from symgen.scene.outputs import function_name
from symgen.system import System, derive
from symgen.validation.result import ValidationResult
from symgen.version import VERSION

if TYPE_CHECKING:
    from symgen.artifact import Artifact

SECTIONS = (
    ("problem", "Problem"),
    ("mechanism", "Mechanism"),
    ("topology", "Topology"),
    ("natural", "Natural coordinates"),
    ("equations", "Equations"),
    ("operations", "Operation counts"),
    ("code", "Generated code"),
    ("certificates", "Certificates"),
    ("validation", "Validation"),
    ("parameters", "Parameters"),
    ("provenance", "Provenance"),
)
CODE_LINES = 200
"""Lines of a function on a page that stands alone."""
MAX_MATRIX = 40
"""Bodies up to which path matrices are printed."""


NO_DRAWING = Markup("")


@dataclass(frozen=True)
class IndexEntry:
    """What the index says of a scene. ``report``: its page, None when there is none."""

    name: str
    report: Path | None
    summary: str
    verdict: str
    passed: bool | None
    """None: nothing was checked."""
    drawing: Markup = NO_DRAWING


@dataclass(frozen=True)
class _Subject:
    """What a page is about."""

    system: System
    drawing: Drawing
    picture: Markup
    refusal: str
    """Why the scene has no functions; empty when it has."""
    result: ValidationResult | None
    measured: Mapping[str, Any]
    place: Place
    code: str
    """Address of the page of the code; empty where it stands on this page."""


def write_report(
    path: str | Path,
    scene: Scene,
    validation_result: ValidationResult | None = None,
    artifact: Artifact | None = None,
    measured: Mapping[str, Any] = MappingProxyType({}),
    place: Place = ALONE,
    *,
    code_href: str = "",
    system: System | None = None,
) -> IndexEntry:
    """Write the page of a scene and return its line of the index.

    ``measured``: section (see `symgen.report.measured`) → its data.

    ``code_href``: address of the page of the code (`symgen.report.code_page`), where there is one; else all functions
    stand on this page.

    ``system``: the scene derived, where that is done already.

    ``artifact``: what `symgen.generate` made of the scene; without it the functions are generated in a temporary
    folder. Scenes with closed loops get a page without functions. The bytes depend on the arguments alone.
    Raises SceneError when the page cannot be written.
    """
    path = Path(path)
    system = derive(scene) if system is None else system
    drawing = draw(system)
    picture = render_drawing(drawing)
    subject = _Subject(system, drawing, picture, _refusal(system), validation_result, measured, place, code_href)
    if subject.refusal:
        text = _render(subject, None, None)
    elif artifact is not None:
        text = _render(subject, artifact.directory, artifact.manifest)
    else:
        from symgen.generate import generate

        with tempfile.TemporaryDirectory(prefix="symgen-report-") as folder:
            made = generate(scene, Path(folder) / "artifact", system=system)
            text = _render(subject, made.directory, made.manifest)
    write_text(path, text)
    return _entry(path, subject)


def write_text(path: Path, text: str) -> None:
    """The whole file or nothing; a link stays a link, a device a device. SceneError where it cannot be written."""
    beside = path
    try:
        place = Path(os.path.realpath(path))
        if place.exists() and not place.is_file():
            place.write_text(text, encoding="utf-8")
            return
        place.parent.mkdir(parents=True, exist_ok=True)
        beside = place.with_name(f".{place.name[:200]}.{os.getpid()}")
        beside.write_text(text, encoding="utf-8")
        beside.replace(place)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"cannot write the report: {reason}", clean(str(path), 300)) from None
    finally:
        if beside != path:
            with contextlib.suppress(OSError):
                beside.unlink(missing_ok=True)


def _refusal(system: System) -> str:
    """Why a scene gets a page without functions; empty when it has them."""
    try:
        system.require_tree()
    except NotSupportedError:
        cut = words.listed([joint.name for joint in system.tree.cut_joints])
        return f"Functions of mechanisms with closed loops are not derived yet; the open tree, cut at {cut}, is shown."
    return ""


def _render(subject: _Subject, directory: Path | None, manifest: Mapping[str, Any] | None) -> str:
    """The page as text."""
    system, refusal, result = subject.system, subject.refusal, subject.result
    units = [unit for body in system.tree.bodies for unit in JOINT_TYPES[body.joint.type].q_units]
    values: dict[str, Any] = {
        "measured": measurements.values(subject.measured),
        "scene": system.scene,
        "refusal": refusal,
        "manifest": manifest,
        "badge": _badge(result, refusal),
        "facts": _facts(system, manifest),
        "parameters": tables.parameters(system),
        "provenance": _provenance(system, result),
    }
    values |= _problem(system) | _mechanism(subject) | _topology(system) | _natural(system)
    values |= _equations(system, refusal, manifest, subject.code)
    values |= _operations(system, refusal) | _motion(subject, values["measured"])
    values |= _code(system, directory, manifest, subject.code)
    values |= motion_plots.validation_values(result, refusal, units)
    title, sections = f"{system.scene.name}: equations of motion", _sections(subject)
    scripts = ("mechanism.js", *(("motion.js",) if "motion" in subject.measured else ()))
    return page("report/page.html.j2", title, sections, subject.place, scripts, **values)


OF_FUNCTIONS = ("operations", "code", "certificates", "validation")
"""Sections of what a scene without functions has not."""


def _sections(subject: _Subject) -> list[tuple[str, str]]:
    """What was measured stands behind the validation."""
    after = 1 + [name for name, _ in SECTIONS].index("validation")
    found = [*SECTIONS[:after], *measurements.present(subject.measured), *SECTIONS[after:]]
    return [(name, title) for name, title in found if not subject.refusal or name not in OF_FUNCTIONS]


def _badge(result: ValidationResult | None, refusal: str) -> Markup:
    if refusal:
        return Markup('<span class="badge">topology only</span>')
    if result is None or not result.rows:
        return Markup('<span class="badge">not validated</span>')
    text, style = verdict(result)
    return Markup('<span class="badge {}">{}</span>').format(style, text)


def verdict(result: ValidationResult) -> tuple[str, str]:
    """Text, with the simulators that were missing, and the class it is set in."""
    missing = f", {words.listed(result.missing)} not installed" if result.missing else ""
    if result.passed:
        return f"✓ {words.counted(len(result.rows), 'check')} passed{missing}", "pass"
    return f"✗ {len(result.failures())} of {len(result.rows)} checks failed{missing}", "fail"


def _facts(system: System, manifest: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    tree, natural = system.tree, system.natural
    found = [
        ("moving bodies", str(len(tree.bodies))),
        ("degrees of freedom" if not tree.cut_joints else "tree velocities", str(tree.nv)),
        ("natural coordinates", str(natural.nn)),
    ]
    if not system.scene.runtime_origins:
        found.append(("constraints", str(natural.nc)))
    if manifest:
        found.append(("certified functions", str(len(manifest["functions"]))))
    return found


def _problem(system: System) -> dict[str, object]:
    scene = system.scene
    sentences = [(joint.name, words.joint_sentence(joint, joint.parent, joint.child)) for joint in scene.joints]
    return {
        "introduction": words.introduction(system),
        "joint_sentences": sentences,
        "force_sentences": words.force_sentences(scene),
        "asked": [(function_name(output.name), output.name) for output in system.outputs],
        "limited": any(joint.limits for joint in scene.joints),
        "bodies": tables.bodies(system),
    }


def _mechanism(subject: _Subject) -> dict[str, object]:
    return {
        "mechanism": subject.picture,
        "mechanism_data": drawing_json(subject.drawing),
        "mechanism_caption": display_words(subject.system),
        "legend": [(body.name, body_colour(body.index)) for body in subject.system.tree.bodies],
    }


def _motion(subject: _Subject, measured: Mapping[str, Mapping[str, Any]]) -> dict[str, object]:
    if "motion" not in measured:
        return {"motion_data": "", "motion_points": [], "motion_stills": []}
    made = player(subject.drawing, subject.measured["motion"], measured["motion"]["speed"])
    return {"motion_data": made.data, "motion_points": made.points, "motion_stills": made.stills}


def _topology(system: System) -> dict[str, object]:
    types = dict.fromkeys(joint.type for joint in system.scene.joints)
    letters = [f"{JOINT_TYPES[name].letter} {name}" for name in types if JOINT_TYPES[name].letter]
    small = len(system.tree.bodies) <= MAX_MATRIX
    return {
        "graph": topology_graph(system),
        "letters": ", ".join(letters),
        "cut_joints": tables.cut_joints(system),
        "joints": tables.joints(system),
        "coordinates": tables.coordinates(system),
        "path_matrix": tables.path_matrix(system, secondary=False) if small else None,
        "secondary_path_matrix": tables.path_matrix(system, secondary=True) if small else None,
    }


def _natural(system: System) -> dict[str, object]:
    return {
        "nullity": _nullity(system),
        "entities": tables.entities(system),
        "carriers": tables.carriers(system),
        "constraints": tables.constraints(system),
    }


def _nullity(system: System) -> Markup:
    """How many coordinates there are, how many conditions, and what is left to move."""
    natural, nv = system.natural, system.tree.nv
    plane = " The mechanism is planar: points have two coordinates." if natural.plane is not None else ""
    if system.scene.runtime_origins:
        return Markup(
            f"{natural.nn} natural coordinates x. Where joints stand is given at run time, so the conditions between "
            f"them are not written out here; they leave {words.counted(nv, 'degree')} of freedom.{plane}"
        )
    rank = constraint_rank(system)
    nullity = natural.nn - rank
    freedom = "degrees of freedom" if not system.tree.cut_joints else "velocities of the open tree"
    end = f"{'equal to' if nullity == nv else 'not equal to'} the number of {freedom}, {nv}"
    if system.tree.coupled:
        own = sum(body.nv for body in system.tree.bodies)
        says = "the number of" if own == nullity else "and not the number of"
        end = f"{says} velocities that the joints have; {own - nv} of them follow others, which leaves {nv} to choose"
    constraints = f"{natural.nc} constraint{'' if natural.nc == 1 else 's'}"
    return Markup(
        f"{natural.nn} natural coordinates x satisfy {constraints} Ψ(x) = 0. The Jacobian Ψ<sub>x</sub> "
        f"has rank {rank} at a random configuration (exact, in a prime field), so its nullity is "
        f"{natural.nn} − {rank} = {nullity}, {end}.{plane}"
    )


def _operations(system: System, refusal: str) -> dict[str, object]:
    if refusal:
        return {"plans": None, "plan_families": [], "plan_chart": ""}
    rows = show.plan_rows(system)
    groups: dict[str, list[Bar]] = {}
    for row in rows:
        if row["flops"]:
            groups.setdefault(row["function"], []).append(Bar(row["plan"], row["flops"], row["chosen"]))
    several = [(name, bars) for name, bars in groups.items() if len(bars) > 1]
    chart = bar_chart(several, "Operations of every plan, by function", "flops") if several else ""
    return {
        "plans": tables.plans(rows),
        "plan_families": tables.plan_families(rows),
        "plan_chart": chart,
    }


def _equations(system: System, refusal: str, manifest: Mapping[str, Any] | None, code: str) -> dict[str, object]:
    """``code``: address of the page of the code; empty where functions stand on this one."""
    if refusal:
        return {"equations": []}
    found, scene, natural = list(equations(system)), system.scene, system.natural
    numbers = derivation.numbered(found)
    own = derivation.FIRST + sum(not number.count(".") for number in numbers.values())
    functions = {row["name"] for row in (manifest or {"functions": []})["functions"]}
    wanted = {*(equation.row for equation in found), *functions}
    return {
        "equations": found,
        "numbers": numbers,
        "definitions": derivation.functions(system, own),
        "symbols": derivation.letters(system),
        "blocks": derivation.blocks(system),
        "code_links": {name: f"{code}#f-{name}" if name in functions else "" for name in wanted},
        "natural": natural,
        "nv": system.tree.nv,
        "planar": natural.plane is not None,
        "conditions": natural.nc if not scene.runtime_origins else 0,
        "besides": derivation.besides(system),
        "motion_equation": derivation.motion_equation(system),
        "set_apart": derivation.set_apart(system),
        "couplings": derivation.couplings(system),
    }


def _code(system: System, directory: Path | None, manifest: Mapping[str, Any] | None, page: str) -> dict[str, object]:
    """``page``: address of the page of the code; without one the functions stand here, long ones cut."""
    if directory is None or not manifest:
        empty: dict[str, object] = {"methods": [], "views": [], "code_page": "", "function_names": []}
        return {"functions": None, "certificates": None, **empty}
    views = [] if page else function_views(system, code(directory, manifest), manifest, "", CODE_LINES)
    return {
        "functions": tables.functions(manifest),
        "function_names": [row["name"] for row in manifest["functions"]],
        "certificates": tables.certificates(manifest),
        "methods": [(letter, method) for method, letter in tables.methods(manifest).items()],
        "views": views,
        "code_page": page,
    }


def _provenance(system: System, result: ValidationResult | None) -> list[tuple[str, str]]:
    scene, options = system.scene, system.scene.options
    found = [
        ("scene", scene.source or scene.name),
        ("SHA-256 of its meaning", scene.sha256 or "none"),
        ("symgen", VERSION),
        ("precision", options.precision),
        ("sine and cosine", options.trigonometry),
        ("velocity of floating bodies", options.base_velocity),
    ]
    if result is not None:
        found += [(f"{name}, simulator", version) for name, version in sorted(result.versions.items())]
        found.append(("random states", f"{result.states}, seed {result.seed}"))
    return found


def _entry(path: Path, subject: _Subject) -> IndexEntry:
    system, result = subject.system, subject.result
    functions = words.counted(len({function_name(output.name) for output in system.outputs}), "function")
    summary = words.introduction(system)[0]
    if subject.refusal:
        text, passed = "topology only: closed loops are not derived", None
    elif result is None or not result.rows:
        text, passed = "not validated", None
    else:
        text, passed = verdict(result)[0], result.passed
    if not subject.refusal:
        summary += f" {functions[0].upper()}{functions[1:]}."
    return IndexEntry(system.scene.name, path, summary, text, passed, subject.picture)
