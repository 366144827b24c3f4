"""The one Jinja environment of the report: undefined names are errors, everything is escaped."""

from __future__ import annotations

import json
from functools import cache
from importlib import resources

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from symgen.report.mathml import math


@cache
def environment() -> Environment:
    """Templates of symgen/templates, also from inside a wheel."""
    made = Environment(
        loader=PackageLoader("symgen", "templates"),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.globals["math"] = math
    return made


def render(template: str, **values: object) -> str:
    return environment().get_template(template).render(**values)


def style_sheet() -> Markup:
    """Colours and drawings, then the page, then plots of many dots."""
    return Markup(asset("drawing.css") + asset("style.css") + asset("scatter.css"))


def asset(name: str) -> str:
    """A style sheet or script that goes into the page as it is."""
    return resources.files("symgen").joinpath("templates", "report", name).read_text(encoding="utf-8")


def script_json(value: object) -> Markup:
    """JSON that may stand inside a script element whatever the names in it are."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))
