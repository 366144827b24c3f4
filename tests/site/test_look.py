"""Colours: readable in both schemes, whoever chooses; what the style sheets promise to readers."""

from __future__ import annotations

import re

import pytest

from symgen.report.environment import asset, style_sheet
from symgen.report.shell import ALONE, Place, css_string, navigation, relink, themes

STYLE = str(style_sheet()) + asset("site.css")
TEXT = ("ink", "muted", "accent", "pass", "fail", "vector")
GROUNDS = ("ground", "paper", "soft")
CURVES = tuple(f"s{k}" for k in range(7))


def colours(scheme: str) -> dict[str, str]:
    """Variable → colour, as a page chooses it whose reader chose."""
    block = re.search(rf":root\[data-theme={scheme}\]{{(.*?)}}", str(themes(STYLE)))
    assert block is not None
    return dict(re.findall(r"--([a-z0-9-]+):(#[0-9a-f]{3,6})", block[1]))


def luminance(colour: str) -> float:
    digits = colour.removeprefix("#")
    digits = "".join(2 * digit for digit in digits) if len(digits) == 3 else digits
    parts = [int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)]
    linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(first: str, second: str) -> float:
    high, low = sorted((luminance(first), luminance(second)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_can_be_read(scheme: str) -> None:
    """WCAG 2.2: 4.5 for text, 3 for lines and marks."""
    found = colours(scheme)
    for name in TEXT:
        for ground in GROUNDS:
            assert contrast(found[name], found[ground]) >= 4.5, (scheme, name, ground)
    for name in CURVES:
        assert contrast(found[name], found["paper"]) >= 3.0, (scheme, name)


def test_contrast_is_what_the_standard_says() -> None:
    assert contrast("#000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#767676", "#fff") == pytest.approx(4.54, abs=0.01)


def test_the_system_and_the_reader_choose_the_same_colours() -> None:
    """Both dark schemes are one; every colour that dark changes has its light one."""
    dark = re.search(r"@media screen and \(prefers-color-scheme:dark\){:root{(.*?)}", STYLE, re.S)
    assert dark is not None
    assert set(re.findall(r"--([a-z0-9-]+):", dark[1])) == set(colours("dark")) == set(colours("light"))
    assert dict(re.findall(r"--([a-z0-9-]+):(#[0-9a-f]+)", dark[1])) == colours("dark")


def test_one_dark_scheme_for_all_style_sheets() -> None:
    """Colours by name only: what is set elsewhere for dark readers would not follow their own choice."""
    assert STYLE.count("prefers-color-scheme") == 1


def test_motion_and_print_are_thought_of() -> None:
    assert "prefers-reduced-motion" in STYLE and "size:A4" in STYLE


def test_strings_of_style_sheets_hold_anything() -> None:
    text = css_string('</style><script>"\\\n}')
    assert re.fullmatch(r'"[A-Za-z0-9\\ ]*"', text)
    decoded = re.sub(r"\\([0-9a-f]+) ", lambda m: chr(int(m[1], 16)), str(text)[1:-1])
    assert decoded == '</style><script>"\\\n}'


def test_links_are_put_in_anew() -> None:
    place = Place(
        (("A & B", "../a.html"),), "", (("Equations", "index.html"),), "Equations", ("<x>", "../x/index.html")
    )
    text = f"before {navigation(ALONE)} after"
    there = relink(text, place)
    assert "A &amp; B" in there and "&lt;x&gt;" in there and there.count("<!-- site -->") == 1
    assert relink(there, ALONE) == text
    assert relink(r"\1 no marks", place) == r"\1 no marks"
