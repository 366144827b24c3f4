"""The page of a bench, the section of a scene's page, and the page of the peers, from results made by hand."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from symgen.bench import BenchResult, FunctionFacts, Row, write_files
from symgen.bench.page import bench_page
from symgen.bench.variant import PRINTED, STRIPPED, Left, is_ours
from symgen.report.labels import Box, Spot, place
from symgen.report.measured import speed
from symgen.report.peers import peers_page
from symgen.report.scatter import Dot, Level, Stairs, bands_of, scatter
from symgen.report.strips import Strip, strips

EVIL = "<script>alert(1)</script>"


def row(peer: str, ns: float, error: float, function: str = "mass_matrix", instructions: float | None = 100.0) -> Row:
    own = is_ours(peer)
    batch = peer.endswith(("batch", "soa"))
    real = "float" if "float" in peer else "double"
    return Row(
        peer, function, ns * 0.99, ns, instructions, 40, 500, 0.1, 0.01, error, error / 3, 1.5, real, "composite", own,
        batch,
    )  # fmt: skip


ROWS = (
    row("symgen", 30.0, 3e-16),
    row("symgen batch", 12.0, 3e-16),
    row("symgen float", 20.0, 2e-7),
    row("symgen plan: composite, inertia as given", 30.5, 3.2e-16),
    row("pinocchio", 300.0, 4e-16, instructions=1000.0),
    row("mujoco", 25.0, 2e-15, instructions=90.0),
    row(EVIL, 40.0, 1e-16),
)


@pytest.fixture
def result() -> BenchResult:
    facts = (
        FunctionFacts("mass_matrix", "composite", 40, 3, 5.0, 90.0),
        FunctionFacts("empty", "literal", 0, 0, 1.0, None),
    )
    return BenchResult(
        f"arm{EVIL}", 3, 3, "a processor", "cc 12", "-O3", "-O3 -march=haswell", 256, 101, 256, "ball arithmetic",
        facts,
        ROWS, (Left("adam", "", "not installed: pip install adam"),), ("times: in turn",), {"pinocchio": "pin 4.1.0"},
    )  # fmt: skip


def test_a_result_comes_back_from_its_json(result: BenchResult) -> None:
    data = json.loads(json.dumps(result.to_json()))
    assert BenchResult.from_json(data) == result
    standings = {found["peer"]: found["standing"] for found in data["frontier"]["mass_matrix"]}
    assert standings == {
        "symgen float": "frontier", "mujoco": "frontier", "symgen": "frontier", "symgen batch": "frontier",
        "symgen plan: composite, inertia as given": "tie", EVIL: "frontier",
    }  # fmt: skip


def test_text_and_markdown_have_the_frontier(result: BenchResult) -> None:
    text, lines = result.to_text(), result.frontier_markdown().splitlines()
    assert re.search(r"symgen plan: composite, inertia as given \* +1 +30\.5 +1\.02", text)
    assert re.search(r"symgen batch +256 +12\.0 +0\.40", text)
    assert "pinocchio" not in text[text.index("worth having") : text.index("instructions (× ours)")]
    assert len({line.count("|") for line in lines}) == 1
    assert "frontier" in result.to_csv().splitlines()[1]


def test_the_page_stands_alone_and_escapes(result: BenchResult, tmp_path: Path) -> None:
    write_files(result, report=tmp_path / "bench.html")
    page = (tmp_path / "bench.html").read_text()
    assert page == bench_page(result)
    assert EVIL not in page
    assert not re.search(r'(src|href)="(?!#)', page)
    assert page.count('class="plot scatter"') > 1
    for title in ("Speed against error", "Programs worth having", "Beside other programs", "How it was measured"):
        assert title in page
    assert "within the noise of symgen" in page
    assert "u of double" in page


def test_the_section_shows_every_program_as_a_dot(result: BenchResult) -> None:
    values = speed.values(result.to_json())
    figures = values["figures"]
    assert isinstance(figures, list)
    assert [figure["function"] for figure in figures] == ["mass_matrix"]
    drawing = ElementTree.fromstring(str(figures[0]["drawing"]))
    told = [title.text or "" for title in drawing.iter("{http://www.w3.org/2000/svg}title")]
    assert sorted(text.partition(": ")[0] for text in told if not text.startswith("symgen plan")) == sorted(
        row.peer for row in ROWS if "plan" not in row.peer
    )
    assert len(told) == len(ROWS)
    assert "0.8 times" in str(values["lead"])


def test_peers_page_says_where_others_are_ahead(result: BenchResult) -> None:
    clean = replace(result, scene="arm", rows=ROWS[:-1])
    page = peers_page([clean.to_json()])
    assert "symgen is slower in one of them, and needs more instructions in one of them." in page
    ahead = page[page.index('id="losses"') : page.index('id="ratios"')]
    assert "mujoco" in ahead
    assert "0.83" in ahead
    assert "0.90" in ahead
    assert "pinocchio" not in ahead
    assert "pin 4.1.0" in page
    assert "all scenes" in page
    assert EVIL not in peers_page([result.to_json()])


def test_peers_page_without_peers(result: BenchResult) -> None:
    alone = replace(result, rows=ROWS[:4])
    for results in ([], [alone.to_json()]):
        assert "No other program was measured" in peers_page(results)


def test_the_axis_breaks_where_nothing_is() -> None:
    levels = (Level(1.1e-16, "u"), Level(6e-8, "u"))
    dots = [Dot(1, 1e-16, "a", ""), Dot(2, 1e-15, "b", ""), Dot(1, 1e-7, "c", "")]
    low, high = bands_of(dots, levels, 20, 400)
    assert low.holds(1.1e-16)
    assert high.holds(6e-8)
    assert not low.holds(1e-12)
    assert low.end > high.start
    assert len(bands_of(dots[:2], levels, 20, 400)) == 1
    assert "<path" in scatter(dots, "t", "x", "y", levels, [Stairs(((1, 1e-7), (1, 1e-16)))])


def test_exact_results_have_a_place() -> None:
    drawing = scatter([Dot(1, 0.0, "exact", ""), Dot(3, 1e-16, "other", "")], "t", "x", "y")
    assert "nan" not in drawing
    assert "inf" not in drawing
    assert scatter([], "t", "x", "y") == ""
    assert strips([], "t", "x") == ""


def test_labels_hide_neither_dots_nor_each_other() -> None:
    spots = [Spot(100 + 3 * k, 100 + 2 * k, f"program {k}") for k in range(8)]
    frame = Box(0, 0, 400, 250)
    labels = [label for label in place(spots, frame) if label is not None]
    assert len(labels) >= 6
    boxes = []
    for label in labels:
        width = 6.1 * len(label.text)
        left = {"start": label.x, "end": label.x - width, "middle": label.x - width / 2}[label.anchor]
        boxes.append(Box(left, label.y - 9, left + width, label.y + 2))
    assert not any(one.meets(other) for k, one in enumerate(boxes) for other in boxes[:k])
    assert not any(box.meets(Box(s.x - 3, s.y - 3, s.x + 3, s.y + 3)) for box in boxes for s in spots)


def test_where_there_is_no_room_a_label_is_left_out() -> None:
    assert place([Spot(5, 5, "a rather long name")], Box(0, 0, 20, 20)) == [None]


def test_ratios_at_the_same_place_stand_apart() -> None:
    drawing = str(strips([Strip("a", ((2.0, "x"), (2.0, "y"), (2.0, "z")), 0, "circle")], "t", "x"))
    assert len(set(re.findall(r'cy="([\d.]+)"', drawing))) == 3


def test_what_is_left_out_is_said_where_it_is_counted(result: BenchResult) -> None:
    assert "springs" not in speed.functions_table(result).caption
    assert "without springs and dampers" in speed.functions_table(replace(result, notes=(STRIPPED,))).caption


def test_our_expressions_by_another_printer_are_no_peer(result: BenchResult) -> None:
    """Neither where the fastest other program is told, nor on the page of the peers; of older data too."""
    found = replace(result, scene="arm", rows=(*ROWS[:-1], row(PRINTED, 15.0, 1e-16)))
    data = found.to_json()
    data["rows"] = [{**line, "own": False} if line["peer"] == PRINTED else line for line in data["rows"]]
    best = BenchResult.from_json(data).fastest_other("mass_matrix")
    assert best is not None and best.peer == "mujoco"
    assert "takes 0.8 times" in speed.lead(BenchResult.from_json(data))
    page = peers_page([data])
    assert PRINTED not in page and "two other programs" in page
    assert PRINTED in BenchResult.from_json(data).peers
