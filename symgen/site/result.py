"""What a run of `symgen report` came to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Line:
    """What became of one measurement."""

    scene: str
    """Empty for what is about symgen as a whole."""
    what: str
    state: str
    """measured, stored, refused, failed, or outdated: what is stored is of another scene, other code or another
    symgen, and is not shown."""
    reason: str = ""


@dataclass(frozen=True)
class SiteResult:
    index: Path
    scenes: tuple[tuple[str, str, bool | None], ...]
    """Name, verdict, and whether its checks passed (None: none were made)."""
    lines: tuple[Line, ...]
    pdfs: tuple[Path, ...] = ()
    failures: tuple[str, ...] = ()
    """Checks that failed and are about symgen as a whole."""

    @property
    def passed(self) -> bool:
        broke = any(line.state == "failed" and not line.scene for line in self.lines)
        return not self.failures and not broke and all(passed is not False for _, _, passed in self.scenes)

    def to_json(self) -> dict[str, object]:
        return {
            "index": str(self.index),
            "passed": self.passed,
            "scenes": [{"name": name, "verdict": verdict, "passed": passed} for name, verdict, passed in self.scenes],
            "measurements": [
                {"scene": line.scene, "what": line.what, "state": line.state, "reason": line.reason}
                for line in self.lines
            ],
            "failures": list(self.failures),
            "pdf": [str(path) for path in self.pdfs],
        }

    def to_text(self) -> str:
        """A line per scene, what could not be measured, and the verdict."""
        width = max((len(name) for name, _, _ in self.scenes), default=0)
        lines = [f"{name:<{width}}  {verdict}" for name, verdict, _ in self.scenes]
        lines += [f"not measured: {_subject(line)}: {line.reason}" for line in self.lines if line.state == "refused"]
        outdated = [_subject(line) for line in self.lines if line.state == "outdated"]
        if outdated:
            lines.append(f"not shown, as what was measured has changed since: {'; '.join(outdated)}")
        lines += [f"FAILED: {_subject(line)}: {line.reason}" for line in self.lines if line.state == "failed"]
        lines += [f"FAILED: {failure}" for failure in self.failures]
        counted = {state: sum(line.state == state for line in self.lines) for state in ("measured", "stored")}
        lines.append(f"{counted['measured']} measured, {counted['stored']} taken from what is stored")
        if self.pdfs:
            lines.append(f"{len(self.pdfs)} pages as PDF in {self.pdfs[0].parent}")
        return "\n".join([*lines, f"report: {self.index}"])


def _subject(line: Line) -> str:
    return f"{line.scene}, {line.what.lower()}" if line.scene else line.what.lower()
