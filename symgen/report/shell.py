"""What every page has: the style, scripts allowed by their hashes, the way around the site."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.environment import asset, render, style_sheet
from symgen.version import VERSION

Link = tuple[str, str]
"""Text, and a relative address."""


@dataclass(frozen=True)
class Place:
    """Where a page stands in a site. A page that stands alone has no links."""

    links: tuple[Link, ...] = ()
    """What the site has; one can go there from any page."""
    here: str = ""
    """The text of the link that is this page."""
    pages: tuple[Link, ...] = ()
    """The pages of the scene that this is about, and which of them this is."""
    page: str = ""
    before: Link | None = None
    """The scenes next to this one."""
    after: Link | None = None


ALONE = Place()
_THEME = "theme.js"
_DARK = re.compile(r"@media screen and \(prefers-color-scheme: ?dark\)\s*\{\s*:root\s*\{([^}]*)\}\s*\}")
_NAVIGATION = re.compile(r"<!-- site -->.*?<!-- /site -->", re.S)


def page(
    template: str,
    title: str,
    sections: Sequence[tuple[str, str]] = (),
    place: Place = ALONE,
    scripts: Sequence[str] = (),
    **values: object,
) -> str:
    """A page as text. ``template`` extends report/base.html.j2; ``sections``: (id, title) of the contents; ``scripts``:
    files beside the templates, each run once at the end of the page. No other script can run, nothing is loaded."""
    theme, *texts = (Markup(asset(name)) for name in (_THEME, *scripts))
    hashes = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in (theme, *texts)]
    style = style_sheet() + Markup(asset("site.css"))
    return render(
        template, title=title, sections=sections, place=place, theme=theme, scripts=texts, hashes=hashes,
        style=style + themes(style), running_title=css_string(title), navigation=navigation(place),
        version=VERSION, **values,
    )  # fmt: skip


def themes(style: str) -> Markup:
    """Rules by which the reader's choice of light or dark goes before the system's, from a style sheet's colours."""
    dark = [row.strip() for block in _DARK.findall(style) for row in block.split(";") if row.strip()]
    plain = _DARK.sub("", style)
    light = []
    for row in dark:
        name = row.partition(":")[0]
        first = re.search(rf"[{{;\s]{re.escape(name)}:([^;}}]*)", plain)
        if first is not None:
            light.append(f"{name}:{first[1]}")
    rules = f":root[data-theme=light]{{color-scheme:light;{';'.join(light)}}}"
    rules += f":root[data-theme=dark]{{color-scheme:dark;{';'.join(dark)}}}"
    return Markup(f"@media screen{{{rules}}}\n")


def css_string(text: str) -> Markup:
    """A string of a style sheet, whatever is in it."""
    return Markup('"' + "".join(c if c.isalnum() and c.isascii() else f"\\{ord(c):x} " for c in text) + '"')


def navigation(place: Place) -> Markup:
    """The way around, between marks by which `relink` finds it."""
    inner = render("report/navigation.html.j2", place=place).strip() if place.links else ""
    return Markup(f"<!-- site -->{inner}<!-- /site -->")


def relink(text: str, place: Place) -> str:
    """A page of a site with the way around put in anew."""
    return _NAVIGATION.sub(lambda _: str(navigation(place)), text, count=1)
