"""The one Jinja environment of the report: undefined names are errors, everything is escaped."""

from __future__ import annotations

from functools import cache
from importlib import resources

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup


@cache
def environment() -> Environment:
    """Templates of symgen/templates, also from inside a wheel."""
    return Environment(
        loader=PackageLoader("symgen", "templates"),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def render(template: str, **values: object) -> str:
    return environment().get_template(template).render(**values)


def style_sheet() -> Markup:
    """Colours and drawings, then the page."""
    return Markup(asset("drawing.css") + asset("style.css"))


def asset(name: str) -> str:
    """A style sheet or script that goes into the page as it is."""
    return resources.files("symgen").joinpath("templates", "report", name).read_text(encoding="utf-8")
