"""What a validation found: rows with a criterion each, trajectories for plots, and what was skipped and why."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field

NOT_INSTALLED = "it is not installed"
"""Why a simulator was not compared with."""


@dataclass(frozen=True)
class Row:
    """One check. It passed when ``value`` ≤ ``criterion`` (a NaN never does)."""

    check: str
    """Which group it belongs to (``same state``, ``velocity transformation``, …)."""
    quantity: str
    value: float
    criterion: float
    note: str = ""
    source: str = ""
    """What it was compared with: a simulator, a book equation, an identity."""

    @property
    def passed(self) -> bool:
        return bool(self.value <= self.criterion)


@dataclass(frozen=True)
class Skip:
    """A check that could not be made, and why."""

    check: str
    reason: str


@dataclass(frozen=True)
class Refinement:
    """Error of a simulator against the reference as its step shrinks; maximum over bodies and sample times."""

    formulation: str
    solver: str
    steps: tuple[float, ...]
    """Step sizes in s, each half the one before."""
    errors: tuple[float, ...]
    """m, and entries of rotation matrices."""
    order: float
    """Observed on the two finest differences between runs (it does not know the reference)."""
    extrapolated: float
    """Error left after Richardson extrapolation."""
    expected_order: int


@dataclass(frozen=True)
class Trajectory:
    """The reference motion from our forward dynamics, and the simulators' errors."""

    initial_q: tuple[float, ...]
    initial_v: tuple[float, ...]
    times: tuple[float, ...]
    q: tuple[tuple[float, ...], ...]
    """One row of joint positions per time."""
    energy: tuple[float, ...]
    """Total energy along it in J (empty when the functions do not offer it)."""
    coordinates: tuple[str, ...]
    """A name per column of q."""
    refinements: tuple[Refinement, ...] = ()


@dataclass(frozen=True)
class ValidationResult:
    scene: str
    scene_sha256: str
    against: tuple[str, ...]
    states: int
    seed: int
    rows: tuple[Row, ...]
    skipped: tuple[Skip, ...] = ()
    trajectory: Trajectory | None = None
    versions: dict[str, str] = field(default_factory=dict)
    """Simulators used and their versions."""

    @property
    def passed(self) -> bool:
        """True when something was checked and every check passed."""
        return bool(self.rows) and all(row.passed for row in self.rows)

    @property
    def missing(self) -> tuple[str, ...]:
        """Simulators that nothing was compared with, as they are not installed."""
        return tuple(skip.check.capitalize() for skip in self.skipped if skip.reason == NOT_INSTALLED)

    def failures(self) -> tuple[Row, ...]:
        return tuple(row for row in self.rows if not row.passed)

    def worst(self, source: str) -> Row | None:
        """The row of a source (by the start of its name) that comes nearest to its criterion."""
        rows = [row for row in self.rows if row.source.startswith(source)]
        return max(rows, key=lambda row: row.value / row.criterion if row.criterion else row.value, default=None)

    def to_json(self) -> dict[str, object]:
        """Plain data; numbers that JSON lacks (NaN, infinity) become strings."""
        data = asdict(self)
        for plain, row in zip(data["rows"], self.rows, strict=True):
            plain["passed"] = row.passed
        data["passed"] = self.passed
        cleaned = _clean(data)
        assert isinstance(cleaned, dict)
        return cleaned

    def to_text(self, width: int = 0) -> str:
        """Plain text for a terminal; ``width`` > 0 cuts the notes to fit."""
        return render_table(self, width)


def _clean(value: object) -> object:
    if isinstance(value, dict):
        return {str(key): _clean(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else str(float(value))
    return value


def render_row(row: Row, quantity: int) -> str:
    tail = "; ".join(text for text in (row.source, row.note) if text)
    limit = "(recorded)" if math.isinf(row.criterion) else f"≤ {row.criterion:8.1e}"
    return (
        f"    {'ok  ' if row.passed else 'FAIL'} {row.quantity:<{quantity}}  {row.value:8.1e} {limit}  {tail}".rstrip()
    )


def render_table(result: ValidationResult, width: int = 0) -> str:
    """Rows grouped by check, then what was skipped, then the verdict."""
    peers = ", ".join(result.against)
    lines = [f"{result.scene}: validation against {peers} ({result.states} states, seed {result.seed})"]
    quantity = max((len(row.quantity) for row in result.rows), default=0)
    for group in dict.fromkeys(row.check for row in result.rows):
        lines.append(f"  {group}")
        for row in result.rows:
            if row.check == group:
                line = render_row(row, quantity)
                lines.append(line if not width or len(line) <= width else line[: width - 1] + "…")
    lines.extend(f"  skipped: {skip.check}: {skip.reason}" for skip in result.skipped)
    failed = len(result.failures())
    verdict = f"{len(result.rows)} checks passed" if result.passed else f"{failed} of {len(result.rows)} checks FAILED"
    lines.append(f"  {verdict}" if result.rows else "  nothing was checked")
    return "\n".join(lines)
