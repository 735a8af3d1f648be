"""Printing a page with an installed browser."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

from desim_warehouse.errors import ReportError, reason

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
"""Commands to look for, in this order."""
_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-pdf-header-footer",
)
_PATIENCE = 300
"""Seconds that printing may take."""


def find_browser() -> str:
    """The Chromium or Chrome to use; raises ReportError where there is none."""
    for name in BROWSERS:
        found = shutil.which(name)
        if found:
            return found
    raise ReportError(
        "PDF needs Chromium or Chrome, and none is installed (looked for "
        f"{', '.join(BROWSERS)}); install one, or print report.html from any browser"
    )


def print_pdf(page: str, path: Path) -> None:
    """Print a page to a PDF file, with a browser profile of its own that is thrown away."""
    browser = find_browser()
    with tempfile.TemporaryDirectory(prefix="desim-report-", ignore_cleanup_errors=True) as place:
        source, made = Path(place) / "report.html", Path(place) / "report.pdf"
        source.write_text(page, encoding="utf-8")
        command = [browser, *_FLAGS, f"--user-data-dir={place}/profile", f"--print-to-pdf={made}", source.as_uri()]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE, check=False)  # noqa: S603 - a browser of our own choice
        except (OSError, subprocess.TimeoutExpired) as error:
            raise ReportError(f"{browser}: cannot print the report ({reason(error)})") from error
        if not made.is_file():
            last = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
            raise ReportError(f"{browser}: no PDF came out ({last})")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(made, path)
        except OSError as error:
            raise ReportError(f"{path}: cannot be written ({reason(error)})") from error
