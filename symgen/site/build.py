"""Building a site: generate, measure what is asked for and not stored, write pages, join them."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from symgen.console import Progress
from symgen.errors import SceneError
from symgen.report.environment import environment
from symgen.scene.document import clean
from symgen.scene.load import load
from symgen.scene.model import Scene
from symgen.site import tasks
from symgen.site.folders import CODE, check_site, folder_name, opened
from symgen.site.join import join, site_records
from symgen.site.measures import DEFAULT, MEASURES, Say, measure
from symgen.site.pages import Card, can_be_shown, make_pages, read_cards, write_card
from symgen.site.result import Line, SiteResult
from symgen.site.store import (
    Key,
    Record,
    code_digest,
    read_record,
    record_path,
    scene_key,
    site_key,
    verdicts,
    write_record,
)
from symgen.site.tasks import Outcome, Task
from symgen.site.tools import installed

HEAVY = ("symgen.targets.sympy", "symgen.targets.casadi")
"""Imported when functions are generated and equations written."""


@dataclass(frozen=True)
class Settings:
    """``measures``: ids of `symgen.site.measures.MEASURES`; ``effort``: quick or full; ``jobs``: processes at once;
    ``fresh``: measure again what is stored; ``pdf``: print the pages too."""

    measures: tuple[str, ...] = DEFAULT
    effort: str = "quick"
    jobs: int = 1
    fresh: bool = False
    pdf: bool = False


Then = Callable[[Outcome], Sequence[Task]]
"""What can start because of an outcome."""


@dataclass(frozen=True)
class Subject:
    """A scene of this run, and its folder in the site."""

    scene: Scene
    folder: str
    closed: bool
    """It has closed loops, so there are no functions to generate or to measure."""


def build_site(
    scenes: Sequence[Scene | str | Path], out: str | Path, settings: Settings | None = None,
    progress: Progress | None = None,
) -> SiteResult:  # fmt: skip
    """Make or extend the site of reports in the folder ``out``.

    All scenes are read before anything is written. Measurements are stored under ``out``/data and used again while
    symgen's version, the scene, the generated C and the settings are the same. Raises SceneError for a bad scene, two
    scenes of one name or a folder with other files, ToolError where pages cannot be printed, NotSupportedError for a
    scene that symgen cannot read; what cannot be measured is said in the result. An interrupt ends the measuring;
    pages are written of what there is, then KeyboardInterrupt goes on.
    """
    from symgen.site.pdf import find_browser, print_pages

    settings, out = settings or Settings(), Path(out)
    subjects = read_all(scenes)
    check_site(out)
    browser = find_browser() if settings.pdf else None
    with opened(out):
        run = _Run(out, settings, subjects, progress)
        run.go()
        pdfs = print_pages(browser, out, run.note, settings.jobs) if browser else ()
        return run.result(tuple(pdfs))


def read_all(scenes: Sequence[Scene | str | Path]) -> list[Subject]:
    """Load and derive all scenes. Raises SceneError for the first that is wrong, and for two of one name."""
    from symgen.system import derive

    found: dict[str, Subject] = {}
    places: dict[str, str] = {}
    for given in scenes:
        scene = given if isinstance(given, Scene) else load(given)
        system = derive(scene)
        for output in system.outputs:
            system.require(output)
        folder = folder_name(scene.name)
        place = clean(scene.name) if isinstance(given, Scene) else clean(str(given), 300)
        if folder.lower() in found:
            other = places[folder.lower()]
            if not isinstance(given, Scene) and os.path.realpath(given) == os.path.realpath(other):
                raise SceneError("is given twice", place)
            raise SceneError(f"'{clean(scene.name)}' is the name of {other} too", place)
        places[folder.lower()] = place
        found[folder.lower()] = Subject(scene, folder, bool(system.tree.cut_joints))
    return list(found.values())


def prepare() -> None:
    """What every process would do again, before they are forked: imports, and the templates of pages."""
    for module in HEAVY:
        importlib.import_module(module)
    for name in environment().list_templates(filter_func=lambda name: name.startswith("report/")):
        if name.endswith(".j2"):
            environment().get_template(name)


@dataclass
class _Run:
    """One run: what waits for what, and what became of it."""

    out: Path
    settings: Settings
    subjects: list[Subject]
    progress: Progress | None
    lines: list[Line] = field(default_factory=list)
    waiting: dict[str, int] = field(default_factory=dict)
    """Scene → measurements that its page waits for."""
    after: dict[str, Then] = field(default_factory=dict)
    """Task → what follows from its outcome."""
    total: int = 0
    finished: int = 0

    def go(self) -> None:
        prepare()
        first = [t for subject in self.subjects for t in self._begin(subject)] + self._about_symgen()
        try:
            tasks.run(self._counted(first), self.settings.jobs, self._done, self._say)
        except KeyboardInterrupt:
            for subject in self.subjects:
                if self.waiting.get(subject.folder):
                    tasks.outcome_of(partial(_pages, subject, self.out), _silent)
            join(self.out)
            raise
        join(self.out)

    def note(self, done: int, total: int, what: str) -> None:
        if self.progress is not None:
            self.progress(done, total, what)

    def result(self, pdfs: tuple[Path, ...]) -> SiteResult:
        folders = {subject.folder for subject in self.subjects}
        cards = [card for card in read_cards(self.out) if card.folder in folders]
        scenes = tuple((card.name, card.verdict, card.passed) for card in cards)
        order = {subject.scene.name: k for k, subject in enumerate(self.subjects)}
        ids = [row.title for row in MEASURES.values()]
        lines = sorted(self.lines, key=lambda line: (order.get(line.scene, len(order)), ids.index(line.what)))
        return SiteResult(self.out / "index.html", scenes, tuple(lines), pdfs, tuple(self._failures()))

    def _failures(self) -> list[str]:
        """What failed among the measurements of this run that are about symgen as a whole."""
        found = []
        for id, record in site_records(self.out).items():
            checks, failed = verdicts(record.data)
            if id in self.settings.measures and failed:
                found.append(f"{MEASURES[id].title.lower()}: {failed} of {checks} checks failed")
        return found

    def _counted(self, new: Sequence[Task]) -> Sequence[Task]:
        self.total += len(new)
        return new

    def _say(self, task: Task, what: str) -> None:
        self.note(self.finished, self.total, f"{task.name}, {what}" if what else task.name)

    def _done(self, task: Task, outcome: Outcome) -> Sequence[Task]:
        self.finished += 1
        new = self._counted(self.after.pop(task.name)(outcome))
        self.note(self.finished, self.total, task.name)
        return new

    def _task(self, name: str, call: Callable[[Say], Any], then: Then, alone: bool = False) -> Task:
        self.after[name] = then
        return Task(name, call, alone)

    def _begin(self, subject: Subject) -> list[Task]:
        if subject.closed:
            return self._page(subject)
        call = partial(_generate, subject.scene, self.out / subject.folder / CODE)
        return [self._task(f"{subject.scene.name}: generate", call, partial(self._generated, subject))]

    def _generated(self, subject: Subject, outcome: Outcome) -> list[Task]:
        """Measurements that are not stored, or the page where there are none."""
        if outcome.refused or outcome.failed:
            write_card(self.out, _unmade(subject, outcome))
            return []
        key = scene_key(subject.scene.sha256, outcome.value)
        new = self._measure_all(key, subject)
        self.waiting[subject.folder] = len(new)
        return new or self._page(subject)

    def _about_symgen(self) -> list[Task]:
        return self._measure_all(site_key(), None)

    def _measure_all(self, key: Key, subject: Subject | None) -> list[Task]:
        """What is asked for of a scene (None: of symgen as a whole); what is stored of something else is noted."""
        name, folder = (subject.scene.name, subject.folder) if subject else ("", "")
        found: list[Task] = []
        for id, row in MEASURES.items():
            if row.of_scenes is not (subject is not None):
                continue
            if id in self.settings.measures:
                found += self._measure(id, key, subject)
                continue
            stored = read_record(record_path(self.out, folder, id))
            if stored is not None and stored.measured and stored.key != key:
                self.lines.append(Line(name, row.title, "outdated"))
        return found

    def _measure(self, id: str, key: Key, subject: Subject | None) -> list[Task]:
        row, effort = MEASURES[id], self.settings.effort
        scene, folder = (subject.scene, subject.folder) if subject else (None, "")
        path = record_path(self.out, folder, id)
        stored = read_record(path)
        empty = Record(id, key, effort, dict(row.settings(effort)), tools=installed(row.tools))
        name = scene.name if scene else ""
        serves = stored is not None and stored.serves(empty) and can_be_shown(stored)
        if serves and not self.settings.fresh:
            self.lines.append(Line(name, row.title, "stored"))
            return []
        keep = stored is not None and stored.measured and stored.key == key
        broke = None if keep else (path, empty)
        then = partial(self._measured, subject, Line(name, row.title, "measured"), broke)
        title = f"{name}: {row.title.lower()}" if name else row.title.lower()
        return [self._task(title, partial(_measure, scene, path, empty, keep), then, row.alone)]

    def _measured(
        self, subject: Subject | None, line: Line, broke: tuple[Path, Record] | None, outcome: Outcome
    ) -> list[Task]:
        """``broke``: where it is stored that the process itself broke."""
        if outcome.failed and broke is not None:
            write_record(broke[0], replace(broke[1], failed=outcome.failed))
        inner = outcome.value if isinstance(outcome.value, Outcome) else outcome
        reason = inner.refused or inner.failed
        state = "refused" if inner.refused else "failed" if inner.failed else "measured"
        self.lines.append(Line(line.scene, line.what, state, reason))
        if subject is None:
            return []
        self.waiting[subject.folder] -= 1
        return self._page(subject) if not self.waiting[subject.folder] else []

    def _page(self, subject: Subject) -> list[Task]:
        self.waiting[subject.folder] = 0
        call = partial(_pages, subject, self.out)
        return [self._task(f"{subject.scene.name}: page", call, partial(self._written, subject))]

    def _written(self, subject: Subject, outcome: Outcome) -> list[Task]:
        if outcome.refused or outcome.failed:
            write_card(self.out, _unmade(subject, outcome))
        join(self.out)  # a long run can be looked at
        return []


def _silent(_what: str) -> None:
    pass


def _generate(scene: Scene, folder: Path, say: Say) -> str:
    from symgen.generate import generate

    generate(scene, folder, progress=lambda done, total, what: say(what))
    return code_digest(folder)


def _measure(scene: Scene | None, path: Path, empty: Record, keep: bool, say: Say) -> Outcome:
    """Measure and store. What broke is stored too, unless that would go over a measurement that still counts."""
    started = sum(os.times()[:4])
    outcome = tasks.outcome_of(lambda told: measure(empty.id, scene, empty.effort, told), say)
    spent = round(sum(os.times()[:4]) - started, 3)
    record = replace(empty, data=outcome.value, refused=outcome.refused, failed=outcome.failed, cpu_seconds=spent)
    if record.measured or not keep:
        write_record(path, record)
    return Outcome(None, outcome.refused, outcome.failed)


def _pages(subject: Subject, out: Path, _say: Say) -> None:
    card = make_pages(subject.scene, out, subject.folder)
    write_card(out, card)


def _unmade(subject: Subject, outcome: Outcome) -> Card:
    """The card of a scene that got no page in this run."""
    reason = outcome.refused or outcome.failed
    return Card(subject.scene.name, subject.folder, "It could not be made.", f"✗ {reason}", False, "", ())
