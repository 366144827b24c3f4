"""Measurements that take no time, in place of the real ones."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, replace
from typing import Any

import pytest

from symgen.errors import CertificateError, NotSupportedError, ToolError
from symgen.report.shell import Place, page
from symgen.scene.model import Scene
from symgen.site import join
from symgen.site.measures import MEASURES, Measure, Say
from symgen.validation.result import NOT_INSTALLED
from tests.report import pages

HERE = __name__


def validation(scene: Scene, say: Say, *, states: int = 10) -> dict[str, Any]:
    say("comparing")
    result = pages.result_for(scene)
    return replace(result, states=states, rows=tuple(row for row in result.rows if "<b>" not in row.quantity)).to_json()


def without_pinocchio(scene: Scene, say: Say) -> dict[str, Any]:
    return {**validation(scene, say), "skipped": [{"check": "pinocchio", "reason": NOT_INSTALLED}]}


def failing(scene: Scene, say: Say) -> dict[str, Any]:
    return pages.result_for(scene, failing=scene.name == "cart_pole").to_json()


def refusing(scene: Scene, say: Say) -> dict[str, Any]:
    raise NotSupportedError("no simulator has\nsuch a joint")


def without_tool(scene: Scene, say: Say) -> dict[str, Any]:
    raise ToolError("no C compiler")


def without_package(scene: Scene, say: Say) -> dict[str, Any]:
    import no_such_package_anywhere  # type: ignore[import-not-found]  # noqa: F401

    return {}


def breaking(*_given: object) -> dict[str, Any]:
    raise ZeroDivisionError("a bug")


def uncertified(scene: Scene, say: Say) -> dict[str, Any]:
    raise CertificateError("a function is not the function")


def dying(scene: Scene, say: Say) -> dict[str, Any]:
    os._exit(7)


def without_number(scene: Scene, say: Say) -> dict[str, Any]:
    return {"rows": [float("nan")]}


def sleeping(scene: Scene, say: Say) -> dict[str, Any]:
    time.sleep(600)
    return {}


def hard(say: Say) -> dict[str, Any]:
    say("hard")
    return {"cases": [{"passed": True, "findings": [{"passed": True}, {"passed": True}]}, {"passed": True}]}


def harder(say: Say) -> dict[str, Any]:
    return {"cases": [{"passed": False, "findings": [{"passed": True}, {"passed": False}]}]}


def hard_page(data: dict[str, Any], place: Place) -> str:
    return page("report/base.html.j2", f"{len(data['cases'])} hard cases", (), place)


@dataclass(frozen=True)
class Put:
    """Puts a function of this module in the place of a measurement."""

    patch: pytest.MonkeyPatch

    def __call__(self, id: str, function: str, **changes: Any) -> None:
        row = Measure(id, MEASURES[id].title, HERE, function, **changes)
        self.patch.setitem(MEASURES, id, row)
        kinds = [("Hard cases", "hard.html", HERE, "hard_page")]
        self.patch.setattr(join, "_kinds", lambda: kinds)
