"""The frontier: what is beaten, what ties, and that something is always left."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import given
from hypothesis import strategies as st

from symgen.bench.frontier import BEATEN, BEST, TIE, beats, order, standings


@dataclass(frozen=True)
class Dot:
    ns_median: float
    error: float


def test_faster_and_finer_ones_are_left() -> None:
    dots = [Dot(10, 1e-16), Dot(5, 1e-7), Dot(20, 1e-16), Dot(6, 1e-6), Dot(30, 1e-17)]
    assert [s.verdict for s in standings(dots)] == [BEST, BEST, BEATEN, BEATEN, BEST]
    assert [s.by for s in standings(dots)] == [None, None, 0, 1, None]
    assert order(dots) == [1, 0, 4]


def test_noise_makes_ties() -> None:
    dots = [Dot(10, 1e-16), Dot(10.2, 1e-16), Dot(10.4, 1e-16)]
    assert [s.verdict for s in standings(dots)] == [BEST, TIE, BEATEN]
    assert standings(dots)[1].by == 0


def test_a_little_less_error_is_not_worth_time() -> None:
    assert [s.verdict for s in standings([Dot(10, 1.05e-16), Dot(20, 1e-16)])] == [BEST, BEATEN]
    assert [s.verdict for s in standings([Dot(10, 1.2e-16), Dot(20, 1e-16)])] == [BEST, BEST]


def test_exact_results() -> None:
    assert beats(Dot(1, 0.0), Dot(2, 0.0))
    assert not beats(Dot(2, 0.0), Dot(1, 0.0))
    assert beats(Dot(1, 0.0), Dot(1, 1e-17))


dots = st.builds(Dot, st.floats(1, 2), st.floats(1e-16, 3e-16))


@given(st.lists(dots, min_size=1, max_size=12))
def test_something_is_always_left(points: list[Dot]) -> None:
    verdicts = standings(points)
    assert any(s.verdict == BEST for s in verdicts)
    kept = [points[k] for k in order(points)]
    for point, standing in zip(points, verdicts, strict=True):
        assert standing.verdict or any(beats(other, point) for other in points)
    assert not any(beats(x, y) for x in kept for y in kept)
