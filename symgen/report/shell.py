"""What every page has: the style, scripts allowed by their hashes, the way around the site."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.environment import asset, render, style_sheet
from symgen.version import VERSION


@dataclass(frozen=True)
class Place:
    """Where a page stands in a site. ``links``: (text, relative address) of the pages one can go to from here;
    ``here``: the text of the one that this is. A page that stands alone has none."""

    links: tuple[tuple[str, str], ...] = ()
    here: str = ""


ALONE = Place()


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
    texts = [Markup(asset(name)) for name in scripts]
    hashes = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in texts]
    return render(
        template, title=title, sections=sections, place=place, scripts=texts, hashes=hashes, style=style_sheet(),
        version=VERSION, **values,
    )  # fmt: skip
