"""Templates of the bench: C and C++ that is compiled beside the generated code."""

from __future__ import annotations

from importlib import resources
from typing import Any

import jinja2


def template(name: str) -> str:
    """The text of a file in templates/bench."""
    return (resources.files("symgen") / "templates" / "bench" / name).read_text(encoding="utf-8")


def render(text: str, **values: Any) -> str:
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(text).render(**values)
