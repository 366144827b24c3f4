"""The one Jinja environment of the C target: layout only, undefined names are errors."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined


@cache
def environment() -> Environment:
    """Templates of symgen/templates, also from inside a wheel."""
    return Environment(
        loader=PackageLoader("symgen", "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # the output is C; every name and comment is made safe before it gets here
    )


def render(template: str, **values: object) -> str:
    return environment().get_template(template).render(**values)
