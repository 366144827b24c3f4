"""Pages as PDF, by a headless Chromium."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from symgen.console import Progress
from symgen.errors import ToolError
from symgen.site.folders import BOOK, CODE_PAGE, PDF

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
SECONDS = 300


def find_browser() -> str:
    """The Chromium that CHROME names, or one on PATH. Raises ToolError when there is none."""
    wanted = os.environ.get("CHROME")
    if wanted:
        found = shutil.which(wanted)
        if found is None:
            raise ToolError(f"CHROME names '{wanted}', which is no program")
        return found
    for name in BROWSERS:
        if (found := shutil.which(name)) is not None:
            return found
    raise ToolError(f"printing needs Chromium: none of {', '.join(BROWSERS)} is on PATH (CHROME=… names another)")


def print_pages(browser: str, out: Path, progress: Progress, jobs: int = 1) -> list[Path]:
    """Print every page of a site into its folder pdf; where the PDFs are. Raises ToolError when the browser fails."""
    pages = [*sorted(out.glob("*.html")), *sorted([*out.glob(f"*/{BOOK}"), *out.glob(f"*/{CODE_PAGE}")])]
    targets = {path: out / PDF / pdf_name(path.relative_to(out)) for path in pages}
    (out / PDF).mkdir(exist_ok=True)
    with ThreadPoolExecutor(jobs) as pool:
        printed = {pool.submit(print_page, browser, path, target): target for path, target in targets.items()}
        try:
            for done, future in enumerate(as_completed(printed)):
                progress(done, len(pages), f"print {printed[future].name}")
                future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
    return list(targets.values())


def pdf_name(page: Path) -> str:
    """``fig1/index.html`` → fig1.pdf, ``fig1/code.html`` → fig1-code.pdf, ``index.html`` → index.pdf."""
    scene = page.parent.name
    if scene and page.stem == "index":
        return f"{scene}.pdf"
    return f"{scene}-{page.stem}.pdf" if scene else f"{page.stem}.pdf"


def print_page(browser: str, page: Path, target: Path) -> None:
    """One page; the PDF appears complete or not at all. Raises ToolError."""
    with tempfile.TemporaryDirectory(prefix="symgen-print-") as folder:
        made = Path(folder) / "page.pdf"
        command = [browser, "--headless", *_sandbox(), "--disable-gpu", "--no-first-run", "--disable-extensions"]
        command += [f"--user-data-dir={folder}/profile", "--no-pdf-header-footer", f"--print-to-pdf={made}"]
        try:
            ran = subprocess.run(
                [*command, page.resolve().as_uri()], capture_output=True, text=True, errors="replace", check=False,
                timeout=SECONDS, stdin=subprocess.DEVNULL,
            )  # fmt: skip
        except (OSError, subprocess.TimeoutExpired) as error:
            raise ToolError(f"{Path(browser).name} could not print {page.name}: {error}") from None
        if not made.is_file() or made.stat().st_size == 0:
            said = ran.stderr.strip().splitlines()
            raise ToolError(f"{Path(browser).name} could not print {page.name}: {said[-1] if said else ran.returncode}")
        beside = target.with_name(f".{target.name}.{os.getpid()}")
        shutil.copyfile(made, beside)
        beside.replace(target)


def _sandbox() -> Sequence[str]:
    """Chromium refuses to run as root in its sandbox."""
    return ("--no-sandbox",) if hasattr(os, "geteuid") and os.geteuid() == 0 else ()
