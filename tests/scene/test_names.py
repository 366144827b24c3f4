"""Names become identifiers that a C compiler takes, no two alike."""

from __future__ import annotations

import re

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from symgen.scene.names import MAX_LENGTH, RESERVED, identifier, sanitise

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@given(st.lists(st.text(max_size=90)))
@example(["0:", "0::"])
def test_any_names_become_different_identifiers(names: list[str]) -> None:
    result = sanitise(names)
    assert list(result) == list(dict.fromkeys(names))
    assert len({text.lower() for text in result.values()}) == len(result)
    for text in result.values():
        assert IDENTIFIER.fullmatch(text)
        assert text not in RESERVED
        assert "__" not in text
        assert not re.match("_[A-Z]", text)
        assert len(text) <= MAX_LENGTH + 1
    assert sanitise(names) == result


@given(st.lists(st.from_regex(r"[a-z][a-z0-9]{0,8}", fullmatch=True), unique=True))
def test_good_names_stay(names: list[str]) -> None:
    assert all(result == name for name, result in sanitise(names).items() if name not in RESERVED)


@pytest.mark.parametrize(
    ("name", "text"),
    [("double", "double_"), ("template", "template_"), ("y1", "y1_"), ("1st", "_1st"), ("é", "e"), ("a b", "a_b"),
     ("x; system(\"rm\")", "x_system_rm_"), ("a*/b", "a_b"), ("\n", "x"), ("日本", "x"), ("_X", "x_X"), ("__a", "x_a")],
)  # fmt: skip
def test_single_names(name: str, text: str) -> None:
    assert identifier(name) == text


def test_collisions_are_numbered_and_good_names_win() -> None:
    assert sanitise(["a b", "a-b", "a_b"]) == {"a b": "a_b_2", "a-b": "a_b_3", "a_b": "a_b"}
    assert sanitise(["Link", "link"]) == {"Link": "Link", "link": "link_2"}
    assert sanitise(["q"], taken=["q"]) == {"q": "q_2"}
    long = "a" * 200
    assert len(set(sanitise([long, long + "b"]).values())) == 2
