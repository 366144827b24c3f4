"""Whatever is in a file: a Scene, or one line. Never a traceback of anything else."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from symgen.errors import SymgenError
from symgen.scene.load import load
from symgen.scene.model import Scene
from tests.scene.test_bad_scenes import GOOD as SCENE
from tests.scene.test_urdf import GOOD as MODEL

SNIPPETS = [
    "-1", "0", "1e400", ".nan", "true", "null", "''", "[]", "{}", "[0,0,0]", "{a: 1}", "&a", "*a", "!!str",
    "<<", "\t", "\x00", "é", "---", "...", "? ", "- ", "|", "%", "@", "ground", "floating", "helical",
    "cut: true", "<a>", "</robot>", "&lt;", '"', "\u2028", "\r\n", "link1", "mass", "#", "9" * 500,
]  # fmt: skip

edits = st.lists(
    st.tuples(st.integers(0, 2000), st.integers(0, 15), st.sampled_from(SNIPPETS) | st.text(max_size=3)),
    min_size=1,
    max_size=4,
)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from([SCENE, MODEL]), edits)
def test_a_damaged_file_ends_in_one_line(text: str, changes: list[tuple[int, int, str]]) -> None:
    for start, length, snippet in changes:
        at = start % len(text)
        text = text[:at] + snippet + text[at + length :]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.scene.yaml"
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        try:
            assert isinstance(load(path), Scene)
        except SymgenError as error:
            assert str(error).isprintable()
            assert str(error).startswith("damaged.scene.yaml")
            assert len(str(error)) < 500
